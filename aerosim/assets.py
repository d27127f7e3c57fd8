"""Files that ship with the package: aircraft, terrain, scenarios, found by name."""

from __future__ import annotations

from pathlib import Path


def folder(kind: str) -> Path:
    """Folder of a kind of shipped files: inside the wheel, or beside the package in a checkout."""
    package = Path(__file__).resolve().parent
    for root in (package / "_data", package.parent):
        if (root / kind).is_dir():
            return root / kind
    raise FileNotFoundError(f"the installation has no folder {kind!r}")
