"""How long a plan takes: a hundred lines over an area on the terrain that ships, forecast and counted."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

from aerosim.forecast.planner import plan_file

LIMIT_S = 1.0
LINES = 100
ROUNDS = 5
AREA = "latitude_deg,longitude_deg\n36.485,-84.38\n36.485,-84.12\n36.575,-84.12\n36.575,-84.38\n"
SETTINGS: dict[str, Any] = {
    "name": "hundred",
    "terrain": {"source": "pine_mountain"},
    "air": {"wind": {"speed_m_s": 8, "from_deg": 300}},
    "flight": {"height_m": 1180},
    "frame_camera": {"format_mm": [60, 22], "min_interval_s": 0.5},
}


def seconds(file: Path) -> tuple[float, int, int]:
    """Wall time of one plan (s), its lines and photos."""
    started = time.perf_counter()
    found = plan_file(file, SETTINGS, {}).figures
    return time.perf_counter() - started, found["flight"]["lines"], found["photos"]["count"]


def main() -> None:
    """Print the time a hundred lines take as a ratio to the limit: the quickest of a few, the first compiles."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "area.csv"
        file.write_text(AREA)
        _, lines, photos = seconds(file)
        taken = min(seconds(file)[0] for _ in range(ROUNDS)) * LINES / lines
    print(f"plan of {lines} lines, {photos} photos: {taken:.2f} s for {LINES}, {taken / LIMIT_S:.2f} of the limit")


if __name__ == "__main__":
    main()
