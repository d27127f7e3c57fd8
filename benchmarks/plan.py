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


def seconds(file: Path) -> tuple[float, float, int, int]:
    """Wall and processor time of one plan (s), its lines and photos."""
    started, busy = time.perf_counter(), time.process_time()
    found = plan_file(file, SETTINGS, {}).figures
    wall, processor = time.perf_counter() - started, time.process_time() - busy
    return wall, processor, found["flight"]["lines"], found["photos"]["count"]


def main() -> None:
    """Print the time a hundred lines take as a ratio to the limit: the quickest of a few, the first compiles."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "area.csv"
        file.write_text(AREA)
        _, _, lines, photos = seconds(file)
        wall, processor, _, _ = min(seconds(file) for _ in range(ROUNDS))
    wall, processor = (each * LINES / lines for each in (wall, processor))
    print(
        f"plan of {lines} lines, {photos} photos: {wall:.2f} s for {LINES} ({processor:.2f} s of processor), "
        f"{wall / LIMIT_S:.2f} of the limit"
    )


if __name__ == "__main__":
    main()
