from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="session")
def vectors() -> dict[str, Any]:
    """Numbers of the project's study of the 1988 paper, from plain arithmetic on its equations."""
    text = (Path(__file__).parent.parent / "data" / "control_vectors.json").read_text()
    return dict(json.loads(text))
