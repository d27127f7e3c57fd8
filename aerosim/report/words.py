"""What a run was, in words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from aerosim.report.source import Source


def how_flown(source: Source) -> str:
    """How a run was flown, in one sentence: lines, height, speed, air, camera, mode, aids, faults."""
    s = source.scenario
    flight, camera = s.flight, s.frame_camera
    if flight.replay is None:
        above = "mean terrain" if flight.height_above == "mean_terrain" else "ellipsoid"
        how = (
            f"at {flight.height_m:g} m above the {above}, {flight.airspeed_m_s:g} m/s true, by {s.aircraft.model}"
        )
        how += ", steered by word of mouth" if flight.pilot == "navigator" else ""
    else:
        file = flight.replay if isinstance(flight.replay, str) else flight.replay.file
        how = f"of the trajectory {Path(file).name}"
    return (
        f"{source.count(source.lines)} lines {how}; {_air(s.air)}; camera {camera.focal_mm:g} mm, "
        f"{camera.format_mm[0]:g} x {camera.format_mm[1]:g} mm; mode {s.control.mode}"
        f"{_aided(s)}."
    )


def _aided(s: Any) -> str:
    """What aids the estimator, and which devices have declared faults."""
    aided = f" aided by {s.estimation.aiding}" if s.estimation.aiding != "none" else ""
    faulty = [name for name, device in (("rows", s.ccd_rows), ("mount", s.mount)) if device.faults is not None]
    return aided + (f"; faults declared of the {' and the '.join(faulty)}" if faulty else "")


def _air(air: Any) -> str:
    """Wind and turbulence in a few words."""
    wind: Any = air.wind
    steady = hasattr(wind, "speed_m_s")
    words = [f"wind {wind.speed_m_s:g} m/s from {wind.from_deg:g} deg" if steady else "wind by height"]
    slow, rough = air.slow_wind, air.turbulence
    if slow.model == "mesoscale":
        words.append(f"mesoscale wind ({slow.change_100km_m_s:g} m/s over 100 km)")
    elif slow.sigma_m_s:
        words.append(f"slow wind {slow.sigma_m_s:g} m/s")
    if rough.model == "mil_f_8785c":
        words.append(f"turbulence by MIL-F-8785C, {rough.severity or 'as set'}")
    elif rough.sigma_m_s:
        words.append(f"turbulence {rough.sigma_m_s:g} m/s (sigma, {rough.model.replace('_', ' ')})")
    for name, given in (("single gusts", air.gusts), ("thermals", air.thermals or air.thermal_field)):
        if given:
            words.append(name)
    return ", ".join(words)
