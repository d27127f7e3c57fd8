"""How long a newcomer waits: `aerosim --help`, and the memory that a flight of half an hour needs."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HELP_LIMIT_S = 0.5
MEMORY_LIMIT_MB = 700.0
ROUNDS = 7
# four lines of 20 km: half an hour
LONG = """
name: long
terrain: {source: pine_mountain}
air: {wind: {speed_m_s: 10, from_deg: 0}, slow_wind: {sigma_m_s: 0.5}, turbulence: {sigma_m_s: 0.35}}
flight:
  lines:
    - {start_deg: [36.52, -84.38], end_deg: [36.52, -84.155]}
    - {start_deg: [36.54, -84.155], end_deg: [36.54, -84.38]}
    - {start_deg: [36.52, -84.38], end_deg: [36.52, -84.155]}
    - {start_deg: [36.54, -84.155], end_deg: [36.54, -84.38]}
"""


def aerosim(*args: str) -> list[str]:
    """Command line of the program."""
    return [sys.executable, "-m", "aerosim", *args]


def help_seconds() -> float:
    """Wall time of `aerosim --help`, the median of several, s."""
    times = []
    for _ in range(ROUNDS):
        started = time.perf_counter()
        subprocess.run(aerosim("--help"), check=True, capture_output=True)
        times.append(time.perf_counter() - started)
    return statistics.median(times)


def peak_memory() -> tuple[float, float]:
    """Peak memory (MB) of a run of half an hour with report and recording, and its simulated time (s)."""
    import psutil

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "long.yaml"
        file.write_text(LONG)
        process = psutil.Popen(
            aerosim("run", str(file), "--out", str(Path(folder) / "run"), "-q"),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        peak = 0.0
        while process.poll() is None:
            try:
                peak = max(peak, process.memory_info().rss / 1e6)
            except psutil.NoSuchProcess:
                break
            time.sleep(0.01)
        if process.returncode != 0:
            raise SystemExit(f"the long run ended with {process.returncode}")
        from aerosim.record import open_run

        return peak, float(open_run(Path(folder) / "run").summary["flight"]["duration_s"])


def main() -> None:
    """Print both as ratios to their limits."""
    seconds = help_seconds()
    print(f"aerosim --help: {seconds:.2f} s, {seconds / HELP_LIMIT_S:.2f} of the limit")
    peak, duration = peak_memory()
    print(f"peak memory, {duration / 60:.0f} min flown: {peak:.0f} MB, {peak / MEMORY_LIMIT_MB:.2f} of the limit")


if __name__ == "__main__":
    main()
