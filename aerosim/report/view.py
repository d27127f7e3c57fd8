"""run.rrd: a run for the rerun viewer, written in whole columns, with the layout it is looked at in."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from aerosim.report.rowview import LABEL_RGB, fixed, log_rows, log_surfaces, mad_view, rows_view
from aerosim.report.scene import (
    CAMERA_RGB,
    KM,
    LINE_RGB,
    PATH_RGB,
    POSE_PERIOD,
    SEEN_RGB,
    SHOT_RGB,
    Scene,
    aircraft_mesh,
    camera_attitude,
    land_mesh,
    quaternions,
    subdivided,
    upright,
)
from aerosim.report.source import Source, middle, open_source

TIMELINE = "sim_time"
SERIES_PERIOD = 0.1
SKY_RGB = (24, 28, 36)
BLACK, BLUE, ORANGE, GREEN = (150, 150, 150), (60, 150, 230), (230, 159, 0), (0, 158, 115)


def at(t_s: NDArray[Any]) -> list[rr.TimeColumn]:
    """The one time index of everything that moves, s of the simulation."""
    return [rr.TimeColumn(TIMELINE, duration=np.asarray(t_s, float))]


def _every(source: Source, period: float) -> NDArray[np.int64]:
    """Rows of the telemetry about a period (s) apart, the last among them."""
    t = source.telemetry["t_s"]
    step = max(1, round(period / float(np.median(np.diff(t))))) if len(t) > 1 else 1
    return np.unique(np.r_[np.arange(0, len(t), step), len(t) - 1])


def _log_land(rec: rr.RecordingStream, scene: Scene) -> None:
    fixed(rec, "world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    mesh = land_mesh(scene)
    if mesh:
        fixed(rec, "world/land", rr.Mesh3D(**mesh))
    width = rr.Radius.ui_points(1.6)
    lines = [scene.draped(np.linspace(a, b, 200)) for a, b in scene.source.lines_g]
    fixed(rec, "world/lines", rr.LineStrips3D(lines, radii=width, colors=LINE_RGB))
    starts = [line[0] for line in lines]
    names = [f"line {name}" for name in scene.source.line_names]
    fixed(
        rec,
        "world/lines/starts",
        rr.Points3D(starts, radii=rr.Radius.ui_points(4.0), labels=names, show_labels=True, colors=LABEL_RGB),
    )
    path = scene.source.path_g
    if len(path) > 1:
        thin = path[:: max(1, len(path) // 3000)]
        strip = [scene.local(*thin.T)]
        fixed(rec, "world/path", rr.LineStrips3D(strip, radii=width, colors=PATH_RGB))


def _log_flight(rec: rr.RecordingStream, scene: Scene) -> None:
    """Aircraft and camera follow the recorded pose."""
    source, tel = scene.source, scene.source.telemetry
    keep = _every(source, POSE_PERIOD)
    place, turn = scene.local(*source.path_g[keep].T), scene.convergence
    angles = [np.radians(tel[name])[keep] for name in ("heading_deg", "pitch_deg", "roll_deg")]
    aircraft = quaternions(angles[0], angles[1], angles[2], turn)
    fixed(rec, "world/aircraft", rr.Mesh3D(**aircraft_mesh(KM * float(np.clip(scene.size / 22.0, 150, 1400)))))
    camera = quaternions(*camera_attitude(source, keep), turn)
    # a frame that goes with the aircraft and stays level: where the second view looks from
    chase = upright(np.radians(tel["track_deg"])[keep] - turn)
    times = at(tel["t_s"][keep])
    for entity, quaternion in (("world/aircraft", aircraft), ("world/camera", camera), ("world/chase", chase)):
        rec.send_columns(entity, times, rr.Transform3D.columns(translation=place, quaternion=quaternion))
        fixed(rec, entity, rr.TransformAxes3D(0.0))
    optics = source.scenario.frame_camera
    along, across = optics.format_mm
    fixed(
        rec,
        "world/camera",
        # c has x to the front edge and y to the right: in the picture, right is y and down is -x
        rr.Pinhole(
            width=across, height=along, focal_length=optics.focal_mm, camera_xyz=rr.ViewCoordinates.URF,
            image_plane_distance=0.98 * KM * middle(tel["agl_m"], 3000.0), color=CAMERA_RGB, line_width=-1.5,
        ))  # fmt: skip


def _log_photos(rec: rr.RecordingStream, scene: Scene) -> None:
    """Each footprint at its time: all up to now, and the last one."""
    corners, whole = scene.source.footprints_g, scene.source.whole_footprints
    if not whole.any():
        return
    outlines = [scene.draped(subdivided(each)) for each in corners[whole]]
    times = at(scene.source.photos["t_s"][whole])
    for entity, colour, width in (("world/photos/all", SEEN_RGB, 1.0), ("world/photos/last", SHOT_RGB, 3.0)):
        rec.send_columns(entity, times, rr.LineStrips3D.columns(strips=[[o] for o in outlines]))
        style = rr.LineStrips3D.from_fields(colors=colour, radii=rr.Radius.ui_points(width))
        fixed(rec, entity, style)


def _series(
    rec: rr.RecordingStream, entity: str, t_s: NDArray[Any], y: Any, name: str, colour: tuple[int, int, int],
    *, points: bool = False,
) -> set[str]:  # fmt: skip
    """One named curve, broken where it is not a number, or points.  Returns its plot, or nothing."""
    y = np.asarray(y, float)
    known = np.isfinite(y)
    if not known.any():
        return set()
    if points:
        t_s, y = t_s[known], y[known]
    # a time without a value breaks the curve (and, unlike NaN, equals itself when files are compared)
    column = rr.Scalars.columns(scalars=y[np.isfinite(y)]).partition(np.isfinite(y).astype(np.int64))
    rec.send_columns(entity, at(t_s), column)
    look = (
        rr.SeriesPoints(colors=colour, names=name, markers="circle", marker_sizes=2.5)
        if points
        else rr.SeriesLines(colors=colour, names=name, widths=1.5)
    )
    fixed(rec, entity, look)
    return {entity.split("/")[1]}


def _log_series(rec: rr.RecordingStream, source: Source) -> set[str]:
    """All time series.  Returns the plots that have something to show."""
    tel, strips, shots = source.telemetry, source.matches, source.photos
    keep = _every(source, SERIES_PERIOD)
    t = tel["t_s"][keep]
    plots: set[str] = set()
    for name, scale in (("drift", 1.0), ("crab", 1.0), ("vh", 1e3)):
        unit = "per_s" if name == "vh" else "deg"
        plots |= _series(rec, f"plots/{name}/true", t, scale * tel[f"{name}_true_{unit}"][keep], "true", BLACK)
        plots |= _series(
            rec, f"plots/{name}/estimated", t, scale * tel[f"{name}_est_{unit}"][keep], "estimated", BLUE
        )
    plots |= _series(rec, "plots/mount/yaw", t, tel["mount_yaw_deg"][keep], "mount yaw", ORANGE)
    if source.count(strips):
        good = strips["accepted"].astype(bool)
        middle = (strips["t_row1_s"] + strips["t_row2_s"])[good] / 2.0
        plots |= _series(
            rec, "plots/vh/strip", middle, 1e3 * strips["vh_per_s"][good], "strip", ORANGE, points=True
        )
    if source.count(shots):
        plots |= _series(
            rec, "plots/end_lap/photo", shots["t_s"], shots["end_lap_pct"], "end lap", GREEN, points=True
        )
        wanted = np.full(2, source.scenario.control.end_lap_pct)
        plots |= _series(rec, "plots/end_lap/wanted", tel["t_s"][[0, -1]], wanted, "wanted", BLACK)
    return plots


def _range(source: Source, names: tuple[str, ...], scale: float = 1.0) -> Any:
    """Range of y of what happens on the lines."""
    on = source.telemetry["line"] >= 0
    values = np.concatenate([np.asarray(source.telemetry[name][on], float) for name in names]) * scale
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    low, high = np.percentile(values, [0.1, 99.9])
    pad = 0.15 * (high - low) + 1e-3
    return rrb.ScalarAxis(range=(low - pad, high + pad))


def _series_views(source: Source, found: set[str]) -> list[Any]:
    if not found:
        return []
    wanted = (
        ("drift", "Drift [deg]", ("drift_true_deg", "drift_est_deg"), 1.0),
        ("crab", "Crab [deg]", ("crab_true_deg", "crab_est_deg"), 1.0),
        ("vh", "v/h [mrad/s]", ("vh_true_per_s", "vh_est_per_s"), 1e3),
        ("mount", "Mount yaw [deg]", ("mount_yaw_deg",), 1.0),
        ("end_lap", "End lap [%]", (), 1.0),
    )
    end = float(source.telemetry["t_s"][-1])
    whole = rrb.TimeRange(rrb.TimeRangeBoundary.absolute(seconds=0.0), rrb.TimeRangeBoundary.absolute(seconds=end))
    return [
        rrb.TimeSeriesView(
            origin=f"/plots/{name}",
            name=title,
            axis_x=rrb.TimeAxis(view_range=whole),
            axis_y=_range(source, columns, scale) if columns else None,
            plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop, visible=name in ("drift", "crab", "vh")),
        )
        for name, title, columns, scale in wanted
        if name in found
    ]  # fmt: skip


def _scene_view(scene: Scene, name: str, chase: bool) -> rrb.Spatial3DView:
    """The whole flight from one side, or the aircraft from behind, turning with it."""
    if chase:
        origin, target, eye = "/world/chase", np.array([0.0, 0.0, -0.9]), np.array([-7.5, -3.5, 3.8])
    else:
        heights = scene.source.path_g[:, 2]
        up = 0.4 * KM * (middle(heights, scene.ground) - scene.ground)
        origin, target = "/world", np.array([0.0, 0.0, up])
        # from the side of the long edge, so that the lines lie across the view
        wide = scene.bounds[2] - scene.bounds[0] >= scene.bounds[3] - scene.bounds[1]
        eye = target + KM * scene.size * np.array([0.0, -0.50, 0.33] if wide else [-0.50, 0.0, 0.33])
    up_to_now = rrb.VisibleTimeRanges(
        timeline=TIMELINE,
        start=rrb.TimeRangeBoundary.infinite(),
        end=rrb.TimeRangeBoundary.cursor_relative(seconds=0.0),
    )
    return rrb.Spatial3DView(
        origin=origin,
        contents="/world/**",
        name=name,
        background=rrb.Background(color=SKY_RGB),
        line_grid=rrb.LineGrid3D(visible=False),
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital, position=eye, look_target=target, eye_up=(0, 0, 1)
        ),
        overrides={"world/photos/all": up_to_now},
    )


def _layout(scene: Scene, series: set[str], rows: Any, surfaces: Any) -> rrb.Blueprint:
    scenes = [_scene_view(scene, "Flight", chase=False)]
    if len(scene.source.path_g) > 1:
        scenes.append(_scene_view(scene, "Aircraft", chase=True))
    left: list[Any] = [rrb.Tabs(*scenes, active_tab=0)]
    below = [view for view in (rows, surfaces) if view is not None]
    if below:
        left.append(rrb.Horizontal(*below, column_shares=[1.5, 1.0][: len(below)]))
    columns = [rrb.Vertical(*left, row_shares=[1.7, 1.0][: len(left)])]
    plots = _series_views(scene.source, series)
    if plots:
        columns.append(rrb.Vertical(*plots))
    return rrb.Blueprint(
        rrb.Horizontal(*columns, column_shares=[2.1, 1.0][: len(columns)]),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed", playback_speed=10.0),
        collapse_panels=True,
        auto_views=False,
    )


def _log_run(rec: rr.RecordingStream, source: Source) -> rrb.Blueprint:
    """Everything that is drawn of a run.  Returns the layout for what there is."""
    scene = Scene(source)
    _log_land(rec, scene)
    _log_photos(rec, scene)
    plots: set[str] = set()
    height = 0.0
    if source.count(source.telemetry) > 1:
        _log_flight(rec, scene)
        plots = _log_series(rec, source)
        height = log_rows(rec, source)
    low, high, shifts = log_surfaces(rec, source)
    return _layout(
        scene,
        plots,
        rows_view(source, height) if height else None,
        mad_view(low, high, shifts) if shifts else None,
    )


def write_rrd(run_dir: Path) -> Path:
    """Write run.rrd of a run, whole or not at all.  Returns its path.

    Raises InputError for a directory that is no run, OSError where it cannot be written.
    """
    source = open_source(run_dir)
    identity = f"{source.scenario.name}-{source.scenario.seed}"
    file, part = run_dir / "run.rrd", run_dir / f".run.{os.getpid()}.rrd"
    # without the stream's own properties, which hold the wall clock: the same run gives the same file
    rec = rr.RecordingStream("aerosim", recording_id=identity, send_properties=False)
    # not rec.save(): a full disk ends its writing thread without a word, and disconnect() then waits for ever
    stream = rr.binary_stream(rec)
    try:
        rec.send_blueprint(_log_run(rec, source))
        part.write_bytes(stream.read() or b"")
        rec.disconnect()
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
    return file
