"""End lap of a photo with the one before it, on the plane and on the relief."""

from __future__ import annotations

import numpy as np

from aerosim.frames import Array
from aerosim.metrics.footprint import Patch, View

# Rays along a column to find where the previous photo ends, and between the two around that place.
COLUMN_RAYS = 129
FINE_RAYS = 17


def end_lap(view: View, previous: View, mean_height: float) -> float:
    """End lap on the horizontal plane at the mean terrain height within this photo's footprint, 0 to 1.

    mean_height: ellipsoidal, m; the plane is tangent at this photo's foot.  Along the middle of the picture: of
    each photo front F, rear R and middle M on the plane, e from the previous M to this M:
    (F_previous - R) . e / ((F - R) . e).  A sideways shift or crab does not count.  NaN without such points.
    """
    depth = view.pose.height - mean_height
    front, rear, middle = _on_plane(view, view, depth)
    front_before, _, middle_before = _on_plane(previous, view, depth)
    along = (middle - middle_before)[:2]
    length = float((front - rear)[:2] @ along)
    if not length:
        return float("nan")
    return float((front_before - rear)[:2] @ along) / length


def _on_plane(view: View, frame: View, depth: float) -> Array:
    """Front, rear and middle of a photo on a plane, in another's frame n.  depth: of the plane below it, m.

    (3, 3), m; NaN for rays that do not meet it.
    """
    camera = view.camera
    row, col = camera.centre
    pixel = np.array([[-0.5, col], [camera.rows - 0.5, col], [row, col]])
    rays = camera.rays(pixel) @ (frame.mat_ne @ view.mat_ec).T
    centre = frame.mat_ne @ (view.pos_e - frame.pos_e)
    down = np.where(rays[:, 2] > 0.0, rays[:, 2], np.nan)
    return np.asarray(centre + rays * ((depth - centre[2]) / down)[:, None])


def end_lap_terrain(view: View, previous: View, patch: Patch) -> float:
    """End lap on the relief, 0 to 1: the least of the picture's left edge, middle and right edge.

    A column is followed over the ground from its rear to its front edge; s is the horizontal distance along the
    direction from the previous projection centre to this one; the column is covered up to the first ground point
    that the previous photo would show in front of its front edge: (s_there - s_rear) / (s_front - s_rear).
    NaN where the relief is not known.
    """
    camera = view.camera
    columns = (-0.5, float(camera.centre[1]), camera.cols - 0.5)
    return float(np.min([_column_lap(view, previous, patch, column) for column in columns]))


def _column_lap(view: View, previous: View, patch: Patch, column: float) -> float:
    """Lap of one column (px): 0 where it is not covered at all, 1 where it is covered to its end."""
    rows = np.linspace(view.camera.rows - 0.5, -0.5, COLUMN_RAYS)
    along, ahead = _follow(view, previous, patch, rows, column)
    if not (np.isfinite(along).all() and np.isfinite(ahead).all()):
        return float("nan")
    beyond = np.flatnonzero(ahead > 0.0)
    if not len(beyond):
        return 1.0
    first = int(beyond[0])
    if first == 0:
        return 0.0
    fine, ahead = _follow(view, previous, patch, np.linspace(rows[first - 1], rows[first], FINE_RAYS), column)
    k = int(np.flatnonzero(ahead > 0.0)[0])
    share = ahead[k - 1] / (ahead[k - 1] - ahead[k])
    there = fine[k - 1] + share * (fine[k] - fine[k - 1])
    return float((there - along[0]) / (along[-1] - along[0]))


def _follow(view: View, previous: View, patch: Patch, rows: Array, column: float) -> tuple[Array, Array]:
    """Ground under pixels of one column.  rows: (n,), px.

    Returns s, m, and how far each point lies in front of the previous photo's front edge, px.  (n,) each.
    """
    rays = view.rays_n(np.column_stack([rows, np.full(len(rows), column)]))
    offsets = patch.lengths(rays)[:, None] * rays
    moved = (view.mat_ne @ (view.pos_e - previous.pos_e))[:2]
    along = offsets[:, :2] @ moved / np.hypot(*moved)
    return along, -0.5 - previous.pixels_of(view.to_ecef(offsets))[:, 0]
