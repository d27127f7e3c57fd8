"""Collects a run while it flies, and turns it into the columns of the run directory."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.frames import Array, wrap_pi
from aerosim.signals import MotionEstimate, RowExposure, StripMatch, StripUse
from aerosim.truth import AircraftState, AirState, Below, Shot

Columns = dict[str, NDArray[Any]]
BLOCK = 4096
RAW = (
    "t", "lat", "lon", "height", "v_north", "v_east", "v_down", "roll", "pitch", "heading",
    "p", "q", "r", "airspeed",
    "wind_north", "wind_east", "wind_down", "gust_u", "gust_v", "gust_w", "gust_p", "gust_q", "gust_r",
    "mount_yaw", "drift_est", "vh_est", "yaw_read", "nadir", "footprint", "strip", "line", "cross_track",
)  # fmt: skip


class Samples(NamedTuple):
    """Raw samples in SI and rad, each (n,): the names of RAW."""

    values: dict[str, Array]

    def __getattr__(self, name: str) -> Array:
        """A column by its name."""
        try:
            return self.values[name]
        except KeyError as error:
            raise AttributeError(name) from error


class Recorder:
    """Everything that a run leaves behind, kept in memory: about 10 MB for half an hour."""

    def __init__(self, keep_signals: bool, bits: int = 16) -> None:
        """keep_signals: rows (grey values of so many bits) and MAD surfaces too, for the viewer."""
        self._grey = np.uint8 if bits <= 8 else np.uint16
        self._split = 1
        self.keeps_signals = keep_signals
        self._sampled = array("d")  # row by row; an array of numpy's takes longer to be given a row
        self.strips: list[tuple[StripMatch, StripUse]] = []
        self.shots: list[Shot] = []
        self.fdm_wall = 0.0
        self._rows: list[NDArray[Any]] = []
        self._row_t: list[float] = []

    def sample(
        self,
        aircraft: AircraftState,
        air: AirState,
        mount_yaw: float,
        yaw_read: float,
        estimate: MotionEstimate,
        below: Below,
        line: int,
        cross_track: float,
    ) -> None:
        """One row of telemetry."""
        self._sampled.extend(
            (*aircraft, *air, mount_yaw, estimate.drift, estimate.vh, yaw_read, *below, line, cross_track)
        )

    @property
    def duration(self) -> float:
        """Time of the last sample, s."""
        return self._sampled[-len(RAW)] if self._sampled else 0.0

    def exposure(self, exposure: RowExposure) -> None:
        """Both rows as read."""
        if self.keeps_signals:
            k, self._split = len(self._row_t) % BLOCK, len(exposure.row1)
            if k == 0:
                self._rows.append(np.empty((BLOCK, self._split + len(exposure.row2)), self._grey))
            self._rows[-1][k, : self._split] = exposure.row1
            self._rows[-1][k, self._split :] = exposure.row2
            self._row_t.append(exposure.t)

    def decided(self, strips: Iterable[tuple[StripMatch, StripUse]]) -> None:
        """Strips and what the filters made of them."""
        for match, use in strips:
            self.strips.append((match if self.keeps_signals else match._replace(surface=match.surface[:0]), use))

    def shot(self, shot: Shot) -> None:
        """A photo."""
        self.shots.append(shot)

    def signals(self) -> tuple[Columns, Columns]:
        """Columns of rows.parquet (one row per exposure) and mad.parquet (one per strip), empty if not kept.

        mad_grey: the strip's surface, row by row, its first row at first_n, its first column at first_mu_px;
        infinite where it was not formed.
        """
        if not self.keeps_signals:
            return {}, {}
        grey = np.concatenate(self._rows)[: len(self._row_t)] if self._rows else np.empty((0, 2), self._grey)
        surfaces = np.empty(len(self.strips), object)
        surfaces[:] = [m.surface.ravel() for m, _ in self.strips]
        rows: Columns = {
            "t_s": np.array(self._row_t, float),
            "row1_grey": grey[:, : self._split],
            "row2_grey": grey[:, self._split :],
        }
        mad: Columns = {
            "strip": np.array([m.strip for m, _ in self.strips], np.int64),
            "first_n": np.array([m.first_n for m, _ in self.strips], np.int64),
            "steps": np.array([len(m.surface) for m, _ in self.strips], np.int64),
            "first_mu_px": np.array([m.centre - m.surface.shape[1] // 2 for m, _ in self.strips], np.int64),
            "shifts": np.array([m.surface.shape[1] for m, _ in self.strips], np.int64),
            "mad_grey": surfaces,
        }
        return rows, mad

    def samples(self) -> Samples:
        """The telemetry so far."""
        table = np.array(self._sampled).reshape(-1, len(RAW))
        return Samples(dict(zip(RAW, table.T, strict=True)))


def telemetry_columns(s: Samples) -> Columns:
    """telemetry.parquet, in the order of the contract.  Values that are not known are NaN."""
    track = np.arctan2(s.v_east, s.v_north)
    drift = wrap_pi(track - s.heading)
    speed = np.hypot(s.v_north, s.v_east)
    return {
        "t_s": s.t,
        "lat_deg": np.degrees(s.lat),
        "lon_deg": np.degrees(s.lon),
        "height_m": s.height,
        "agl_m": s.height - s.nadir,
        "v_north_m_s": s.v_north,
        "v_east_m_s": s.v_east,
        "v_down_m_s": s.v_down,
        "roll_deg": np.degrees(s.roll),
        "pitch_deg": np.degrees(s.pitch),
        "heading_deg": np.degrees(np.mod(s.heading, 2.0 * np.pi)),
        "p_deg_s": np.degrees(s.p),
        "q_deg_s": np.degrees(s.q),
        "r_deg_s": np.degrees(s.r),
        "track_deg": np.degrees(np.mod(track, 2.0 * np.pi)),
        "airspeed_m_s": s.airspeed,
        "wind_north_m_s": s.wind_north,
        "wind_east_m_s": s.wind_east,
        "wind_down_m_s": s.wind_down,
        "gust_u_m_s": s.gust_u,
        "gust_v_m_s": s.gust_v,
        "gust_w_m_s": s.gust_w,
        "mount_yaw_deg": np.degrees(s.mount_yaw),
        "drift_true_deg": np.degrees(drift),
        "drift_est_deg": np.degrees(s.drift_est),
        "crab_true_deg": np.degrees(wrap_pi(drift - s.mount_yaw)),
        "crab_est_deg": np.degrees(s.drift_est - s.yaw_read),
        "vh_true_per_s": speed / (s.height - s.footprint),
        "vh_est_per_s": s.vh_est,
        "line": s.line.astype(np.int64),
        "cross_track_m": s.cross_track,
    }
