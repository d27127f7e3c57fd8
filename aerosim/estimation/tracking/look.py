"""One look for a strip in its window: trough, fit, and what speaks against it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from aerosim.estimation.mad import FLAT, RIVAL, Trough, judge
from aerosim.estimation.tracking.edges import common
from aerosim.estimation.tracking.fine import Fine, fine
from aerosim.estimation.tracking.window import FLAT_GREY, moments, surface
from aerosim.frames import Array
from aerosim.signals import Grey, Reason

SD_MU_MOST, SD_EDGES_MOST = 0.12, 0.08  # px, a weaker trough is refused
RMS_MOST = 0.6  # of the contrast: most that row I may leave unexplained
CLEAN = 0.12  # of the contrast: what sound rows over flat land leave
VALLEY_PX, VALLEY, VALLEY_EDGES = 0.035, 3.0, 2.0  # a trough so long, so many times longer than wide: stripes
TURNED = 0.02  # rad, from which on a turned row is stretched by a tenth of a pixel
TURNED_MOST = 0.1  # rad, with which edges are still sure
FLAT_EDGES, RIVAL_EDGES = 1.35, 1.25  # see `mad.judge`; edges are noisier than grey values


class View(NamedTuple):
    """A strip of row I (u + 2 j,), the ring of row II (ring, u) and the weights of the pixels of both.

    edges: whether the values are edges, and not grey.
    """

    row1: Grey
    rows2: Grey
    weights1: Grey
    weights: Grey
    edges: bool = False


class Where(NamedTuple):
    """Window of a strip.  begin, end: first and last exposure; centre, half: shifts, px.

    slants: rad, turns of the camera that are looked for beside the known one.  complete: no more will be seen.
    tolerance: px, a trough need not be sharper: tilts that nobody tells move the strip by much more.
    """

    begin: int
    end: int
    centre: int
    half: int
    slants: tuple[float, ...]
    complete: bool
    tolerance: float = 0.0


class Looked(NamedTuple):
    """What a look has found.  found: MAD surface; trough: with its reason, mu from the middle of row I;
    left: share of the contrast that is left unexplained, infinite without a fit.
    """

    found: Grey
    trough: Trough
    left: float = np.inf

    @property
    def accepted(self) -> bool:
        """Whether nothing speaks against it."""
        return self.trough.reason is Reason.ACCEPTED

    @property
    def clean(self) -> bool:
        """Whether the two rows show the same and nothing else."""
        return self.accepted and self.left <= CLEAN


def look(
    view: View,
    where: Where,
    turn: Callable[[int], float],
    crab: Callable[[int, float], float],
    steps_per_px: float,
    bow: Array,
) -> Looked:
    """Look for a strip.

    turn: of the camera from row I to an exposure, rad.  crab: tangent of the angle of the track that an exposure
    and a shift (px) mean: while the pixels of a turned row come by one after the other, the ground moves aside.
    steps_per_px, bow: see `fine`.
    """
    contrast = _contrast(view)
    known = turn((where.begin + where.end) // 2)
    bounds = (FLAT_EDGES, RIVAL_EDGES) if view.edges else (FLAT, RIVAL)
    looks = []
    for slant in where.slants:
        found = surface(
            view.row1, view.rows2, view.weights, where.begin, where.end - where.begin + 1, where.centre,
            where.half, (known + slant) * steps_per_px, bow,
        )  # fmt: skip
        if contrast <= FLAT_GREY:
            return Looked(found, Trough(np.nan, np.nan, np.nan, Reason.DEGENERATE))
        looks.append((found, judge(found, steps_per_px, where.complete, *bounds), slant))
    found, trough, slant = min(looks, key=lambda each: (each[1].reason is not Reason.ACCEPTED, each[1].value))
    trough = trough._replace(mu=trough.mu + where.centre)
    if trough.reason is not Reason.ACCEPTED:
        return Looked(found, trough)
    step = where.begin + int(trough.step)
    turned = turn(step) + slant
    stretch = turned * crab(step, trough.mu) if abs(turned) > TURNED else 0.0
    best = _fit(view, step, trough.mu, turned * steps_per_px, stretch, steps_per_px, bow)
    left = best.rms / contrast
    reason = _against(best, left, view.edges, where.tolerance)
    if view.edges and abs(turned) > TURNED_MOST:
        reason = Reason.WEAK
    if reason is not Reason.ACCEPTED:
        return Looked(found, trough._replace(reason=reason), left)
    return Looked(found, trough._replace(step=best.step - where.begin, mu=best.mu), left)


def _contrast(view: View) -> float:
    margin = (len(view.row1) - view.rows2.shape[1]) // 2
    return float(moments(view.row1[margin : len(view.row1) - margin], view.weights)[1])


def _fit(view: View, step: int, mu: float, slope: float, stretch: float, steps_per_px: float, bow: Array) -> Fine:
    row1, weights = view.row1, view.weights
    if view.edges:
        weights = common(row1, view.rows2, weights, step, int(mu), slope, bow)
    if not view.weights1.all():
        row1 = np.where(view.weights1 > 0.0, row1, np.float32(np.nan))
    return Fine(*fine(row1, view.rows2, weights, step, mu, slope, bow, steps_per_px, stretch))


def _against(best: Fine, left: float, edges: bool, tolerance: float) -> Reason:
    weak, valley = (SD_EDGES_MOST, VALLEY_EDGES) if edges else (SD_MU_MOST, VALLEY)
    if not best.ok or best.sd_mu > max(weak, tolerance):
        return Reason.WEAK
    if best.sd_most > max(VALLEY_PX, valley * best.sd_least, tolerance):
        return Reason.AMBIGUOUS
    return Reason.UNLIKE if left > RMS_MOST else Reason.ACCEPTED
