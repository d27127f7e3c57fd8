"""A scenario text to be broken, one place at a time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from aerosim.errors import InputError
from aerosim.scenario import load

GOOD = """\
name: try
terrain:
  source: pine_mountain
air:
  wind: {speed_m_s: 10, from_deg: 0}
flight:
  height_m: 3000
  airspeed_m_s: 69.44
  lines:
    - start_deg: [36.52, -84.38]
      end_deg: [36.52, -84.12]
"""


@pytest.fixture
def good() -> str:
    return GOOD


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str | bytes], Path]:
    def write_file(text: str | bytes) -> Path:
        file = tmp_path / "try.yaml"
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return file

    return write_file


@pytest.fixture
def refused(write: Callable[[str | bytes], Path], tmp_path: Path) -> Callable[[str | bytes], str]:
    """The line that a text is refused with, without the folder's name."""

    def message(text: str | bytes) -> str:
        with pytest.raises(InputError) as caught:
            load(write(text))
        line = str(caught.value)
        assert "\n" not in line
        return line.replace(f"{tmp_path}/", "")

    return message
