"""What a scenario's mode observes with."""

from __future__ import annotations

from aerosim.estimation.fixed_point import N_MAX, drift_filter, n_filter
from aerosim.estimation.integer_strips import IntegerRecogniser
from aerosim.estimation.motion import MotionEstimator
from aerosim.estimation.observer import Observer, RowObserver, ToldObserver
from aerosim.estimation.strips import StripRecogniser
from aerosim.estimation.tracking.tracker import Tracker
from aerosim.scenario.build.aiding import TOLD
from aerosim.scenario.build.devices import motion_of, strips_of
from aerosim.scenario.build.tracking import tracker_of
from aerosim.scenario.scenario import Scenario


def observer_of(scenario: Scenario, vh: float, height: float, level: float) -> Observer:
    """Observer of the scenario's mode.

    vh: planned, 1/s; height: planned above the mean land, m; level: pitch that the mount was set to, rad.
    Raises InputError.
    """
    if scenario.control.mode == "best":
        return Tracker(tracker_of(scenario, vh, height, level))
    rows = _row_observer(scenario, vh)
    return ToldObserver(rows) if scenario.control.mode in TOLD else rows


def check_arithmetic(scenario: Scenario, vh: float) -> None:
    """Whether the words of the fixed-point instrument hold what is planned.  vh: 1/s.  Raises InputError."""
    if scenario.estimation.arithmetic == "real":
        return
    strips, motion = strips_of(scenario, vh), motion_of(scenario)
    last = strips.search[1] * strips.planned_n
    if last > N_MAX:
        problem = f"integer counts exposures in 16 bits, up to {N_MAX}, and {last:.0f} are searched"
        raise scenario.error("estimation.arithmetic", problem, "a longer ccd_rows.period_s, or real")
    if max(motion.gamma_drift or 0.0, motion.gamma_vh or 0.0) >= 2.0:  # of a table; others are checked before
        raise scenario.error("estimation.table", "gamma of 2 and more does not go with arithmetic: integer")


def _row_observer(scenario: Scenario, vh: float) -> RowObserver:
    strips, motion = strips_of(scenario, vh), motion_of(scenario)
    if scenario.estimation.arithmetic == "real":
        return RowObserver(StripRecogniser(strips), MotionEstimator(motion))
    check_arithmetic(scenario, vh)
    filters = drift_filter(motion.sigma_drift**2, motion.series), n_filter(motion.series)
    return RowObserver(IntegerRecogniser(strips), MotionEstimator(motion, filters))
