"""Checks between sections that need no terrain and no aircraft."""

from __future__ import annotations

from math import asin, cos, floor, radians, sin, sqrt
from typing import TYPE_CHECKING

from aerosim.scenario.replay import unused

if TYPE_CHECKING:
    from aerosim.scenario.flight import Line
    from aerosim.scenario.scenario import Scenario

Problem = tuple[str, str, str]

LINE_MIN_M = 500.0
"""A shorter line ends before a first strip is recognised (13 s, 900 m, from 3000 m), and is a slip of the pen."""
WIND_SHARE = 0.8
"""Of the airspeed: in a stronger wind a line across it asks for a drift of more than 53 deg."""
SEARCH_MIN, SEARCH_MAX = 2, 20000
"""Exposures: nearest and farthest at which a strip is looked for."""
EARTH_RADIUS_M = 6371008.8
# a period written with six digits (0.0583333 s for 7 steps of 120 Hz) is meant as whole steps
_STEP_TOLERANCE = 1e-5


def whole_steps(period: float, step: float) -> int | None:
    """Number of steps in a period, both s, at least 1; None if it is no whole number."""
    number = round(period / step)
    return number if number >= 1 and abs(period / step - number) <= _STEP_TOLERANCE * number else None


def line_length(line: Line) -> float:
    """Length of a line on the mean sphere, m: good to 0.5 %, for checks of sense only."""
    (lat1, lon1), (lat2, lon2) = line.start_deg, line.end_deg
    half_lat, half_lon = radians(lat2 - lat1) / 2, radians(lon2 - lon1) / 2
    chord = sin(half_lat) ** 2 + cos(radians(lat1)) * cos(radians(lat2)) * sin(half_lon) ** 2
    return 2 * EARTH_RADIUS_M * asin(min(1.0, sqrt(chord)))


def period_problem(key: str, period: float, step: float, of: str) -> list[Problem]:
    """A period that is no whole number of steps, both s; of: what these steps are."""
    if whole_steps(period, step) is not None:
        return []
    below = floor(period / step)
    near = [n * step for n in (below, below + 1) if n >= 1]
    allowed = " or ".join(f"{value:.6g}" for value in near)
    return [(key, f"{period:g} s is no whole number of {of}", f"nearest: {allowed}")]


def _periods(scenario: Scenario) -> list[Problem]:
    step = 1.0 / scenario.aircraft.step_rate_hz
    steps = f"steps of {scenario.aircraft.step_rate_hz} Hz"
    rows = scenario.ccd_rows.period_s
    out = period_problem("ccd_rows.period_s", rows, step, steps)
    out += period_problem("record.period_s", scenario.record.period_s, step, steps)
    if not out and scenario.estimation.strip_period_s is not None:
        exact = (whole_steps(rows, step) or 1) * step
        out += period_problem(
            "estimation.strip_period_s", scenario.estimation.strip_period_s, exact, f"row exposures of {rows:g} s"
        )
    return out


def _lines(scenario: Scenario) -> list[Problem]:
    out = []
    for i, line in enumerate(scenario.flight.lines or ()):
        key, length = f"flight.lines.{i}", line_length(line)
        if line.start_deg == line.end_deg:
            out.append((f"{key}.end_deg", "line ends where it starts", "another point than start_deg"))
        elif length < LINE_MIN_M:
            out.append((f"{key}.end_deg", f"line is only {length:.0f} m long", f"at least {LINE_MIN_M:.0f} m"))
    return out


def _search(scenario: Scenario, height: float) -> list[Problem]:
    """The exposures searched for a strip, from the planned n = d H/(f dt V) (Schmelovsky 1988, equation 1)."""
    rows, flight = scenario.ccd_rows, scenario.flight
    planned = rows.spacing_px * height / (rows.focal_px * rows.period_s * flight.airspeed_m_s)
    low, high = (part * planned for part in scenario.estimation.search_n)
    if low < SEARCH_MIN:
        most = rows.period_s * low / SEARCH_MIN
        problem = f"the rows see the same ground after {planned:.3g} exposures: too few for a search"
        return [("ccd_rows.period_s", problem, f"at most {most:.3g}")]
    if high > SEARCH_MAX:
        problem = f"the rows see the same ground after {planned:.0f} exposures: too many"
        return [("ccd_rows.period_s", problem, f"at least {rows.period_s * high / SEARCH_MAX:.3g}")]
    return []


def _end_lap(scenario: Scenario, height: float) -> list[Problem]:
    camera, control = scenario.frame_camera, scenario.control
    footprint = height * camera.format_mm[0] / camera.focal_mm
    most = 100 * (1 - camera.min_interval_s * scenario.flight.airspeed_m_s / footprint)
    if control.end_lap_pct <= most:
        return []
    interval = (1 - control.end_lap_pct / 100) * footprint / scenario.flight.airspeed_m_s
    problem = (
        f"{control.end_lap_pct:g} % needs a photo each {interval:.3g} s, faster than frame_camera.min_interval_s"
    )
    return [("control.end_lap_pct", problem, f"at most {most:.4g}" if most > 0 else "a shorter min_interval_s")]


def _wind(scenario: Scenario) -> list[Problem]:
    speed, limit = getattr(scenario.air.wind, "speed_m_s", 0.0), WIND_SHARE * scenario.flight.airspeed_m_s
    if speed <= limit:
        return []
    problem = f"{speed:g} m/s is too much for an airspeed of {scenario.flight.airspeed_m_s:g} m/s"
    return [("air.wind.speed_m_s", problem, f"at most {limit:.4g}")]


def _arithmetic(scenario: Scenario) -> list[Problem]:
    """What the fixed-point instrument of 1988 cannot do."""
    est, rows = scenario.estimation, scenario.ccd_rows
    if est.arithmetic == "real":
        return []
    if scenario.control.mode != "schmelovsky_1988":
        problem = f"integer is the instrument of 1988, control.mode is {scenario.control.mode}"
        return [("estimation.arithmetic", problem, "real, or control.mode: schmelovsky_1988")]
    beside = "with estimation.arithmetic: integer"
    out: list[Problem] = []
    if est.subpixel:
        out.append(("estimation.subpixel", f"true does not go {beside}", "false"))
    if est.strip_period_s is not None:
        out.append(("estimation.strip_period_s", f"only one strip at a time goes {beside}", "null"))
    if rows.bits > 8:
        out.append(("ccd_rows.bits", f"{rows.bits} is too much {beside}", "at most 8"))
    if rows.pixels_px > 128:
        out.append(("ccd_rows.pixels_px", f"{rows.pixels_px} is too much {beside}", "at most 128"))
    for key, gamma in (("estimation.crab.gamma", est.crab.gamma), ("estimation.vh.gamma", est.vh.gamma)):
        if gamma is not None and gamma >= 2.0:
            out.append((key, f"{gamma:g} is too much {beside}", "less than 2"))
    return out


def _best(scenario: Scenario) -> list[Problem]:
    """What mode best does in one way only."""
    est, rows = scenario.estimation, scenario.ccd_rows
    if scenario.control.mode != "best":
        if est.distortion is None:
            return []
        problem = f"{est.distortion:g} is for control.mode best, which here is {scenario.control.mode}"
        return [("estimation.distortion", problem, "null")]
    beside = "with control.mode: best"
    out: list[Problem] = []
    if est.distortion is not None and est.distortion < rows.least_distortion:
        problem = f"{est.distortion:g} folds the picture at the rows' ends"
        out.append(("estimation.distortion", problem, f"at least {rows.least_distortion:.3g}"))
    if rows.mounted_on != "camera":
        out.append(("ccd_rows.mounted_on", f"{rows.mounted_on} does not go {beside}", "camera"))
    if rows.extension != "imaged":
        out.append(("ccd_rows.extension", f"{rows.extension} does not go {beside}", "imaged"))
    if est.strip_period_s is None:
        out.append(("estimation.strip_period_s", f"one strip at a time does not go {beside}", "a period"))
    if not est.subpixel:
        out.append(("estimation.subpixel", f"false does not go {beside}", "true"))
    if not est.mean_subtracted:
        out.append(("estimation.mean_subtracted", f"false does not go {beside}", "true"))
    if est.table is not None:
        out.append(("estimation.table", f"a table does not go {beside}, which learns its noise", "null"))
    for key, gamma in (("estimation.crab.gamma", est.crab.gamma), ("estimation.vh.gamma", est.vh.gamma)):
        if gamma is not None:
            out.append((key, f"{gamma:g} does not go {beside}, whose filters have no such number", "null"))
    return out


def problems(scenario: Scenario) -> list[Problem]:
    """All that does not fit together: key, problem, what is allowed."""
    out = _periods(scenario) + _lines(scenario) + _arithmetic(scenario) + _best(scenario)
    if scenario.flight.replay is not None:  # height and speed are those of the file
        return out + unused(scenario)
    out += _wind(scenario)
    if scenario.flight.height_above == "mean_terrain":  # else the height above ground is not known yet
        out += _search(scenario, scenario.flight.height_m) + _end_lap(scenario, scenario.flight.height_m)
    return out
