"""Which devices a mode and its aiding need, and which of them nothing would read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aerosim.scenario.checks import Problem, period_problem

if TYPE_CHECKING:
    from aerosim.scenario.scenario import Scenario


def unaided(scenario: Scenario) -> list[Problem]:
    """Devices that are missing, or given to a mode that does not use them: key, problem, what is allowed."""
    return _inertial(scenario) + _satellites(scenario)


def _inertial(scenario: Scenario) -> list[Problem]:
    aiding, mode, navigation = scenario.estimation.aiding, scenario.control.mode, scenario.navigation
    if aiding == "none":
        lead = scenario.control.yaw_lead_s
        if lead == 0.0:
            return []
        problem = "is a feed-forward of a gyro, and there is none"
        return [("control.yaw_lead_s", problem, "allowed: 0, or estimation.aiding: gyro, bank, imu")]
    key = "estimation.aiding"
    if mode != "best":
        return [(key, f"{aiding} needs control.mode best, which here is {mode}", "allowed: none")]
    if navigation is None or navigation.imu is None:
        missing = "navigation" if navigation is None else "navigation.imu"
        return [(key, f"{aiding} needs navigation.imu, and {missing} is null", "allowed: none, or navigation.imu")]
    rows, period = scenario.ccd_rows.period_s, navigation.imu.period_s
    if abs(period - rows) > 1e-6 * rows:
        return [("navigation.imu.period_s", "the unit is read at each exposure of the rows", f"allowed: {rows:g}")]
    return []


def _satellites(scenario: Scenario) -> list[Problem]:
    mode, navigation = scenario.control.mode, scenario.navigation
    devices = {name: getattr(navigation, name, None) for name in ("gnss", "ins")}
    if mode != "gnss_ins":
        problem = "is read in control.mode gnss_ins only in this version"
        return [
            (f"navigation.{name}", problem, "allowed: null, or control.mode: gnss_ins")
            for name, device in devices.items()
            if device is not None
        ]
    if missing := [f"navigation.{name}" for name, device in devices.items() if device is None]:
        return [("control.mode", f"gnss_ins needs {' and '.join(missing)}, null here", "allowed: another mode")]
    rows = scenario.ccd_rows.period_s
    of = f"row exposures of {rows:g} s"
    return [
        problem
        for name, device in devices.items()
        if device is not None
        for problem in period_problem(f"navigation.{name}.period_s", device.period_s, rows, of)
    ]
