"""The loop: one scenario flown, from the air to the photos, in the order of the physics."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable
from math import radians
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from aerosim.control.law import camera_command
from aerosim.errors import RunFailure
from aerosim.flight.guidance import Phase
from aerosim.flight.interface import FlightSource, fresh, patience
from aerosim.metrics.footprint import Ground
from aerosim.metrics.photos import photo_table
from aerosim.metrics.strips import strip_table
from aerosim.metrics.summary import Wanted, summarise
from aerosim.record import Record, Run, telemetry_sha256
from aerosim.recorder import Recorder, telemetry_columns
from aerosim.rundir import Staging, write_run
from aerosim.scenario import Scenario
from aerosim.scenario.build import Mission, build, camera_of, input_files
from aerosim.signals import Reason
from aerosim.truth import Shot
from aerosim.world.ground import below

journal = logging.getLogger("aerosim")

ROOM = 32_000_000  # bytes: an hour's tables
SURVEYING = (Phase.RUN_IN, Phase.LINE)
LEVEL = radians(5.0)
WATCH_S = 2.0  # simulated

Progress = Callable[[float, float], None]


class Flown(NamedTuple):
    """How a flight ended.  duration: simulated, s; wall, fdm_wall: of all and of JSBSim, s."""

    status: str
    reason: str
    duration: float
    wall: float
    fdm_wall: float


def fly(m: Mission, log: Recorder, progress: Progress | None = None) -> Flown:
    """Fly a mission to the end of its last line and record it.

    progress: told (simulated s, planned s) every few simulated seconds.  The record in `log` is good up to the
    moment of whatever ends the flight early: RunFailure (returned as status failed) or KeyboardInterrupt.
    """
    started = time.perf_counter()
    status, reason = "done", ""
    try:
        _loop(m, log, progress)
    except RunFailure as failure:
        status, reason = "failed", str(failure)
    except KeyboardInterrupt:
        status, reason = "interrupted", "interrupted by the user"
    except SystemError as error:
        # compiled code that returns while an interrupt is pending is told off for it
        if not isinstance(error.__cause__ or error.__context__, KeyboardInterrupt):
            raise
        status, reason = "interrupted", "interrupted by the user"
    return Flown(status, reason, log.duration, time.perf_counter() - started, log.fdm_wall)


def _loop(m: Mission, log: Recorder, progress: Progress | None) -> None:
    flight, mount, rows, camera, observer = m.flight, m.mount, m.rows, m.camera, m.observer
    surveying, yaw_read, step, watched = False, 0.0, 0, 0.0
    estimate = observer.now()
    command = camera_command(m.control, estimate)
    while True:
        # one instant at which a device has its turn
        t = step * m.dt
        line, aircraft = flight.line, flight.state()
        sees, records = step % m.rows_every == 0, step % m.record_every == 0
        until = min(m.rows_every - step % m.rows_every, m.record_every - step % m.record_every)

        # the crew switches the camera system on with level wings before a line, and off behind it
        wanted = flight.phase in SURVEYING and (surveying or abs(aircraft.roll) < LEVEL)
        if wanted != surveying:
            surveying = wanted
            log.decided(observer.switch(t))

        if sees or records:
            spot = m.ground.around(aircraft.lat, aircraft.lon, rows.reach(aircraft.height), t)
            under = below(spot, aircraft.heading, *m.footprint)
            if aircraft.height <= under.nadir:
                raise RunFailure(f"the aircraft hit the ground at {t:.2f} s, {under.nadir:.0f} m high")
        if sees:
            observer.feel(m.aids.read(aircraft, under.footprint, mount.yaw))
        if sees and surveying:
            opens = observer.opens()
            if opens:
                rows.new_cycle()
            exposure = rows.expose(mount.pose(aircraft, turned=m.rows_turn), spot, opens or log.keeps_signals)
            if exposure.missing and line >= 0 and m.outside_fails:
                raise RunFailure(
                    f"line {line} left the terrain at {t:.1f} s ({exposure.missing} pixels are blind)"
                )
            reading = mount.read(t)
            log.decided(observer.see(exposure, reading))
            log.exposure(exposure)
            yaw_read = reading.yaw
        if sees or records:
            believed = observer.now()
            if believed is not estimate:
                estimate, command = believed, camera_command(m.control, believed, command.mount_yaw)
            camera.step(t, line, command, until * m.dt)
        if camera.due(t):
            log.shot(camera.expose(aircraft, mount))
        if records:
            log.sample(aircraft, flight.air, mount.yaw, yaw_read, estimate, under, line, flight.cross_track)
        if flight.done:
            return

        # the world moves on to the next such instant
        steps = max(1, min(until, camera.steps_to_next(t)))
        mount.advance(command.mount_yaw if surveying else 0.0, steps)
        before = time.perf_counter()
        flight.advance(steps)
        log.fdm_wall += time.perf_counter() - before
        step += steps
        if t >= watched:
            watched = t + WATCH_S
            _watch(t, m.duration, progress)


def _watch(t: float, planned: float, progress: Progress | None) -> None:
    """Tell the progress; give up a flight that does not find its lines."""
    if progress is not None:
        progress(t, planned)
    if t > patience(planned):
        raise RunFailure(f"the lines were not flown within {t:.0f} s (planned: {planned:.0f} s)")


def simulate(scenario: Scenario, progress: Progress | None = None, flights: FlightSource = fresh) -> Record:
    """Fly a scenario and put its tables together; nothing is written.

    flights: where its flight comes from, by default flown now.  Raises InputError for a scenario that cannot be
    flown.  A flight that fails or is interrupted gives a record up to there, with its status and reason.
    """
    mission = build(scenario, flights)
    plan = mission.flight.plan
    journal.info("%s, seed %d, mode %s", scenario.name, scenario.seed, scenario.control.mode)
    journal.info("terrain %s", mission.terrain.orthophoto_file.path)
    journal.info("%d lines at %.0f m, planned %.0f s", len(plan.lines), plan.height, mission.duration)
    log = Recorder(scenario.record.rrd, scenario.ccd_rows.bits)
    flown = fly(mission, log, progress)
    journal.info("%s after %.1f s flown in %.2f s %s", flown.status, flown.duration, flown.wall, flown.reason)
    accepted = sum(match.reason is Reason.ACCEPTED for match, _ in log.strips)
    journal.info("%d of %d strips accepted, %d photos", accepted, len(log.strips), len(log.shots))
    return tables(scenario, mission, log, flown)


def tables(scenario: Scenario, m: Mission, log: Recorder, flown: Flown) -> Record:
    """Record of a flight: its columns and its summary."""
    samples = log.samples()
    telemetry = telemetry_columns(samples)
    matches = strip_table(log.strips, samples, m.motion)
    try:
        photos = _photos(scenario, m, log.shots)
    except RunFailure as failure:  # the relief under the photos cannot be read any more
        flown = flown._replace(status="failed", reason=f"{flown.reason} {failure}".strip())
        photos = _photos(scenario, m, [])
    plan = m.flight.plan
    wanted = Wanted(plan.height, plan.airspeed, scenario.control.end_lap_pct, scenario.record.exclude_first_s)
    columns = {
        name: np.asarray(column, object) if isinstance(column, list) else column for name, column in photos.items()
    }
    rows, surfaces = log.signals()
    summary = {
        "status": flown.status,
        "seed": scenario.seed,
        "telemetry_sha256": telemetry_sha256(telemetry),
        **summarise(telemetry, matches, columns, wanted),
        "speed": {
            "wall_s": flown.wall,
            "fdm_wall_s": flown.fdm_wall,
            "real_time_factor": flown.duration / flown.wall if flown.wall > 0.0 else None,
        },
    }
    inputs = {
        "orthophoto": m.terrain.orthophoto_file.path,
        "elevation": m.terrain.elevation_file.path,
        **input_files(scenario),
    }
    return Record(
        scenario,
        flown.status,
        flown.reason,
        telemetry,
        matches,
        columns,
        m.route.columns(),
        summary,
        rows,
        surfaces,
        inputs,
    )


def _photos(scenario: Scenario, m: Mission, shots: list[Shot]) -> dict[str, Any]:
    """Columns of photos.parquet."""
    return photo_table(
        shots,
        camera_of(scenario),
        scenario.frame_camera.exposure_s,
        Ground(m.terrain.grid, m.terrain.elevation()),
        wanted_end_lap=scenario.control.end_lap_pct / 100.0,
    )


def run(
    scenario: Scenario,
    out: Path | None = None,
    *,
    overwrite: bool = False,
    progress: Progress | None = None,
    flights: FlightSource = fresh,
) -> Run:
    """Fly a scenario and write its run directory, by default runs/<name>/<seed>.

    flights: where its flight comes from, by default flown now.
    Raises InputError with nothing left behind; RunFailure (its `path` is the directory) with the record up to
    there; KeyboardInterrupt likewise.  An earlier run is replaced only with `overwrite`, and only by a good one.
    """
    out = Path(out) if out is not None else Path("runs") / scenario.name / str(scenario.seed)
    staging = Staging(out, overwrite, ROOM)
    try:
        record = simulate(scenario, progress, flights)
    except BaseException:
        staging.discard()
        raise
    return write_run(record, staging, _draw)


def _draw(scenario: Scenario, path: Path) -> None:
    """What is drawn of a run: report.html and run.rrd, as far as the scenario wants them."""
    if scenario.record.report:
        from aerosim.report.page import write_report

        write_report(path)
    if scenario.record.rrd:
        from aerosim.report.view import write_rrd

        write_rrd(path)


class _Callable(ModuleType):
    """The import system binds this module to `aerosim.simulate`, the name of the public function: it is both."""

    def __call__(
        self, scenario: Scenario, progress: Progress | None = None, flights: FlightSource = fresh
    ) -> Record:
        """The same as the function `simulate`."""
        return simulate(scenario, progress, flights)


sys.modules[__name__].__class__ = _Callable
