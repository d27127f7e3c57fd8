"""The tables that the shipped aircraft are made of, and what makes them: they lie beside the aircraft."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from aerosim import assets
from aerosim.flight.aircraft import Aircraft

ROOT = assets.folder("aircraft")
sys.path.insert(0, str(ROOT))

import make  # noqa: E402
from maker import flights, judges, linear, readme  # noqa: E402

__all__ = ["ROOT", "TABLES", "aircraft", "flights", "folder_of", "judges", "linear", "make", "readme"]

TABLES: dict[str, Any] = {table.name: table for table in make.TABLES}
RATE_HZ = 120.0


def folder_of(name: str) -> Path:
    return ROOT / name


def aircraft(name: str, fuel_kg: float | None = None) -> Aircraft:
    return Aircraft(folder_of(name), RATE_HZ, fuel_kg)
