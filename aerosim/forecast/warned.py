"""What an experienced navigator would object to in a plan that can be flown."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from aerosim.scenario.area import Area
from aerosim.scenario.scenario import Scenario

SETTLE_S = 45.0  # from the start of a run-in until the first strips are recognised and the camera has turned
BLUR_PX = 0.5  # the cameras' makers' rule
TOLERANCE_PCT = 0.5  # of a side lap
FEW_PCT = 50.0  # of the strips of a line
BLIND_M = 2000.0  # half a minute; until then what was known is good enough
SEARCHING = ("fixed", "ideal")  # modes that need no rows


def warnings(scenario: Scenario, found: dict[str, Any]) -> list[str]:
    """Sentences, each with its line or place.  found: the forecast."""
    area = scenario.flight.area
    told = [*_fuel(found), *_motion(scenario, found), *_strips(scenario, found), *_photos(scenario, found)]
    told += [*_laps(found, area), *_coverage(found, area is not None)]
    return told


def _which(lines: list[dict[str, Any]], numbers: list[int]) -> str:
    """The lines of a warning, a few by name."""
    names = ", ".join(str(lines[number]["name"]) for number in numbers[:6])
    rest = f" and {len(numbers) - 6} more" if len(numbers) > 6 else ""
    return f"line{'s' if len(numbers) > 1 else ''} {names}{rest}"


def _fuel(found: dict[str, Any]) -> Iterator[str]:
    needed, carried = found["flight"]["fuel_needed_kg"], found["flight"]["fuel_kg"]
    if needed is not None and needed > carried:
        hours = carried / found["flight"]["fuel_flow_kg_h"]
        yield f"fuel of {carried:.4g} kg lasts {hours:.2g} h: the flight takes {needed:.4g} kg"


def _motion(scenario: Scenario, found: dict[str, Any]) -> Iterator[str]:
    lines, rows, mount = found["lines"], scenario.ccd_rows, scenario.mount
    spread = math.degrees(2.0 * scenario.air.slow_wind.sigma_m_s / scenario.flight.airspeed_m_s)
    largest = [abs(line["drift_deg"]) + spread for line in lines]
    if scenario.control.mode != "fixed":
        beyond = [k for k, drift in enumerate(largest) if drift > mount.yaw_limit_deg]
        if beyond:
            yield (
                f"{_which(lines, beyond)}: drift of up to {max(largest):.1f} deg, slow wind included, is beyond "
                f"the mount's {mount.yaw_limit_deg:g} deg: crab is left"
            )
    field = math.degrees(math.atan2(rows.max_shift_px, rows.spacing_px))
    beyond = [k for k, drift in enumerate(largest) if drift > field]
    if scenario.control.mode not in SEARCHING and beyond:
        rest = "is searched for on each line" if rows.mounted_on == "camera" else "is not seen"
        yield (
            f"{_which(lines, beyond)}: drift of up to {max(largest):.1f} deg, slow wind included, is beyond the "
            f"+-{field:.1f} deg that the rows see: it {rest}"
        )
    replay = scenario.flight.replay is not None  # it has the run-ins that it has
    if scenario.flight.run_in_s < SETTLE_S and scenario.control.mode != "fixed" and not replay:
        yield (
            f"run-in of {scenario.flight.run_in_s:g} s is shorter than the {SETTLE_S:g} s that the camera takes "
            f"to settle: the first photos of each line may be off"
        )


def _strips(scenario: Scenario, found: dict[str, Any]) -> Iterator[str]:
    """Land that the rows will not recognise."""
    if scenario.control.mode in SEARCHING:
        return
    lines = found["lines"]
    known = [k for k, line in enumerate(lines) if line["strips_accepted_pct"] is not None]
    few = [k for k in known if lines[k]["strips_accepted_pct"] < FEW_PCT]
    if few:
        least = min(lines[k]["strips_accepted_pct"] for k in few)
        yield f"{_which(lines, few)}: as few as {least:.0f} % of the strips will be recognised over this land"
    blind = [k for k in known if lines[k]["strips_blind_m"] >= BLIND_M]
    if blind:
        most = max(lines[k]["strips_blind_m"] for k in blind)
        yield f"{_which(lines, blind)}: hardly a strip will be recognised on {most / 1000.0:.1f} km in a row"


def _photos(scenario: Scenario, found: dict[str, Any]) -> Iterator[str]:
    lines, least = found["lines"], scenario.frame_camera.min_interval_s
    beyond = [k for k, line in enumerate(lines) if line["photos_outside_m"] > 0.0]
    if beyond:
        most = max(lines[k]["photos_outside_m"] for k in beyond)
        yield f"{_which(lines, beyond)}: photos reach up to {most:.0f} m beyond the terrain"
    blurred = [k for k, line in enumerate(lines) if line["blur_px"] > BLUR_PX]
    if blurred:
        most = max(lines[k]["blur_px"] for k in blurred)
        what = "left by forward-motion compensation over the relief" if scenario.control.fmc else "without FMC"
        yield f"{_which(lines, blurred)}: blur of {most:.2g} px {what} is above {BLUR_PX:g} px"
    slow = [k for k, line in enumerate(lines) if line["photo_interval_wanted_s"] < least]
    if slow:
        wanted = min(lines[k]["photo_interval_wanted_s"] for k in slow)
        lap = min(lines[k]["end_lap_pct"] for k in slow)
        yield (
            f"{_which(lines, slow)}: a photo each {wanted:.3g} s is wanted, the camera takes one each {least:g} s"
            f": end lap of {lap:.3g} %"
        )


def _laps(found: dict[str, Any], area: Area | None) -> Iterator[str]:
    if area is None:
        return
    mean = found["photos"]["side_lap_mean_pct"]
    if mean is not None and mean < area.side_lap_pct - TOLERANCE_PCT:
        yield f"side lap of {mean:.3g} % on average is below the {area.side_lap_pct:g} % asked for"
    known = [pair for pair in found["side_lap"] or () if pair["side_lap_min_pct"] is not None]
    short = [pair for pair in known if pair["side_lap_min_pct"] < area.side_lap_min_pct - TOLERANCE_PCT]
    if short:
        worst = min(short, key=lambda pair: float(pair["side_lap_min_pct"]))
        yield (
            f"lines {worst['lines']}: side lap of {worst['side_lap_min_pct']:.3g} % at latitude "
            f"{worst['min_lat_deg']:.5f}, longitude {worst['min_lon_deg']:.5f} deg is below the "
            f"{area.side_lap_min_pct:g} % that nothing was to fall below ({len(short)} of {len(known)} pairs do)"
        )


def _coverage(found: dict[str, Any], stereo: bool) -> Iterator[str]:
    seen = found["coverage"]
    if seen is None:
        return
    if seen["gaps"]:
        gap = seen["gaps"][0]
        yield (
            f"{seen['seen_0_pct']:.2g} % of the area is on no photo, the largest gap "
            f"of {gap['area_m2'] / 1e4:.3g} ha at latitude {gap['lat_deg']:.5f}, "
            f"longitude {gap['lon_deg']:.5f} deg"
        )
    if stereo and seen["seen_1_pct"] > 0.0:
        yield f"{seen['seen_1_pct']:.2g} % of the area is on one photo only: no stereo there"
    if seen["unknown_pct"] > 0.0:
        yield f"{seen['unknown_pct']:.2g} % of the area has no known height: not counted"
