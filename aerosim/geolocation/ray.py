"""A bent ray over the ellipsoid, compiled: where it is after so many metres, where it comes to a height.

In the vertical plane of a ray its distance from the tangent at the camera is the `drop`, towards denser air.
nodes: (4, NODES) scratch, rows s (m along the tangent), drop (m), its slope and height (m, on a sphere that
osculates the ellipsoid in the ray's azimuth; for the steps and first guesses only).  down: (3,) unit, e,
perpendicular to the tangent.
"""

from __future__ import annotations

import numpy as np

from aerosim.frames import WGS84_A, WGS84_E2, WGS84_F, Array
from aerosim.geolocation.compiled import kernel

NODES = 640
STEPS = 4  # from the camera to the lowest ground; the rule is of fourth order: below 1e-4 of the drop
LONGEST_STEP = 12_000.0
# The layers' lapse rate breaks here (11 km of geopotential height): steps end at it.
TROPOPAUSE = 11019.1
TABLE_LOW, TABLE_STEP = -2000.0, 25.0


@kernel
def geodetic(x: float, y: float, z: float) -> tuple[float, float, float]:  # pragma: no cover - compiled
    """Sine and cosine of the latitude, and the height (m), of a point in e.

    Bowring (1976), one step: below 1e-6 m from 12 km below to 80 km above the ellipsoid.
    """
    b = WGS84_A * (1.0 - WGS84_F)
    across = np.sqrt(x * x + y * y)
    sine, cosine = z * WGS84_A, across * b
    length = 1.0 / np.sqrt(sine * sine + cosine * cosine)
    sine, cosine = sine * length, cosine * length
    up = z + WGS84_E2 / (1.0 - WGS84_E2) * b * sine * sine * sine
    out = across - WGS84_E2 * WGS84_A * cosine * cosine * cosine
    length = 1.0 / np.sqrt(up * up + out * out)
    sine, cosine = up * length, out * length
    return sine, cosine, across * cosine + z * sine - WGS84_A * np.sqrt(1.0 - WGS84_E2 * sine * sine)


@kernel
def up_at(x: float, y: float, sine: float, cosine: float) -> tuple[float, float, float]:  # pragma: no cover
    """The ellipsoid's normal in e, at the longitude of x, y."""
    across = np.sqrt(x * x + y * y)
    if across == 0.0:
        return cosine, 0.0, sine
    return cosine * x / across, cosine * y / across, sine


@kernel
def curvature(table: Array, height: float) -> float:  # pragma: no cover - compiled
    """-dn/dh / n, 1/m, of the tabled atmosphere."""
    at = (height - TABLE_LOW) / TABLE_STEP
    last = len(table) - 2
    i = min(max(int(at), 0), last)
    return float(table[i] + (min(max(at, 0.0), last + 1.0) - i) * (table[i + 1] - table[i]))


@kernel
def start(pos: Array, los: Array, down: Array) -> tuple[float, float, float]:  # pragma: no cover - compiled
    """Height of the camera, cosine of the ray with the normal there, radius of curvature in its azimuth.

    Fills `down`.
    """
    sine, cosine, height = geodetic(pos[0], pos[1], pos[2])
    ux, uy, uz = up_at(pos[0], pos[1], sine, cosine)
    rise = los[0] * ux + los[1] * uy + los[2] * uz
    level = np.sqrt(max(1.0 - rise * rise, 0.0))
    w2 = 1.0 - WGS84_E2 * sine * sine
    normal = WGS84_A / np.sqrt(w2)
    meridian = normal * (1.0 - WGS84_E2) / w2
    if level < 1e-9:
        down[0], down[1], down[2] = 0.0, 0.0, 0.0
        return height, rise, np.sqrt(normal * meridian)
    down[0] = (rise * los[0] - ux) / level
    down[1] = (rise * los[1] - uy) / level
    down[2] = (rise * los[2] - uz) / level
    east = 0.0
    if cosine > 0.0:
        east = (los[1] * ux - los[0] * uy) / cosine / level
    return height, rise, 1.0 / (east * east / normal + (1.0 - east * east) / meridian)


@kernel
def _reach(r0: float, rise: float, stop: float, top: float) -> float:  # pragma: no cover - compiled
    """Straight distance to the sphere `stop` on the way down, else to `top` on the way up; 0: never there.

    All are radii, m.
    """
    low2 = (r0 * r0) * (1.0 - rise * rise)
    if rise < 0.0 and stop * stop > low2:
        # the near root, without the difference of two long numbers
        return float((r0 - stop) * (r0 + stop) / (-r0 * rise + np.sqrt(stop * stop - low2)))
    if top * top < low2 or (rise >= 0.0 and r0 > top):
        return 0.0
    return float(-r0 * rise + np.sqrt(top * top - low2))


@kernel
def bend(
    height: float, rise: float, radius: float, table: Array, stop: float, top: float, nodes: Array
) -> int:  # pragma: no cover - compiled
    """Follow a ray down to the height `stop`, or up again through `top`; fills nodes, returns their number.

    0 when it starts at or below `stop` or never comes down to `top`.
    """
    r0, level = radius + height, np.sqrt(max(1.0 - rise * rise, 0.0))
    if height <= stop:
        return 0
    far = _reach(r0, rise, radius + stop, radius + top)
    if far <= 0.0 and table[0] == 0.0:
        return 0
    if far <= 0.0:  # bending may bring it down: as far as its lowest point, and as far again
        if rise >= 0.0:
            return 0
        far = -2.0 * r0 * rise
    step = max(min(max(far / STEPS, 50.0), LONGEST_STEP), far / (NODES - 80))
    s, drop, slope, h = 0.0, 0.0, 0.0, height
    k = curvature(table, h) * level
    nodes[0, 0], nodes[1, 0], nodes[2, 0], nodes[3, 0] = s, drop, slope, h
    for n in range(1, NODES):
        ds = step
        fall = (s + r0 * rise) / (radius + h)
        breaks = h > TROPOPAUSE + 5.0 and h + fall * ds < TROPOPAUSE
        if breaks:
            ds = (TROPOPAUSE - h) / fall
        half = 0.5 * ds
        drop_half = drop + slope * half + 0.5 * k * half * half
        up, out = r0 + (s + half) * rise - drop_half * level, (s + half) * level + drop_half * rise
        r = np.sqrt(up * up + out * out)
        k_half = curvature(table, r - radius) * r0 * level / r
        s += ds
        drop += slope * ds + (k + 2.0 * k_half) * ds * ds / 6.0
        up, out = r0 + s * rise - drop * level, s * level + drop * rise
        r = np.sqrt(up * up + out * out)
        before, h = h, r - radius
        # at a break the table has one value above and one below
        k_end = curvature(table, h + 50.0 if breaks else h) * r0 * level / r
        slope += (k + 4.0 * k_half + k_end) * ds / 6.0
        k = curvature(table, h - 50.0) * r0 * level / r if breaks else k_end
        nodes[0, n], nodes[1, n], nodes[2, n], nodes[3, n] = s, drop, slope, h
        if h < stop or (h > top and h > before):
            return n + 1
    return NODES


@kernel
def dropped(nodes: Array, count: int, s: float) -> tuple[float, float]:  # pragma: no cover - compiled
    """Drop (m) and its slope at s m along the tangent: cubic between the nodes."""
    i = 0
    while i < count - 2 and nodes[0, i + 1] < s:
        i += 1
    ds = nodes[0, i + 1] - nodes[0, i]
    t = (s - nodes[0, i]) / ds
    d0, d1, m0, m1 = nodes[1, i], nodes[1, i + 1], nodes[2, i] * ds, nodes[2, i + 1] * ds
    a, b = 2.0 * (d0 - d1) + m0 + m1, 3.0 * (d1 - d0) - 2.0 * m0 - m1
    return ((a * t + b) * t + m0) * t + d0, ((3.0 * a * t + 2.0 * b) * t + m0) / ds


@kernel
def passes(
    nodes: Array, count: int, height: float, first: int, falling: bool
) -> tuple[float, int]:  # pragma: no cover - compiled
    """As `come_to`, to within the metre or so that heights between nodes are off."""
    for i in range(first, count - 1):
        h0, h1 = nodes[3, i], nodes[3, i + 1]
        if (falling and h0 > height >= h1) or (not falling and h0 <= height < h1):
            return nodes[0, i] + (nodes[0, i + 1] - nodes[0, i]) * (height - h0) / (h1 - h0), i
    return np.nan, -1


@kernel
def come_to(
    pos: Array, los: Array, down: Array, nodes: Array, count: int, height: float, first: int, falling: bool
) -> tuple[float, int]:  # pragma: no cover - compiled
    """Distance s (m) at which a ray passes an ellipsoidal height downwards or upwards, from node `first` on.

    Returns s and the node before it; NaN and -1 if it does not.
    """
    for i in range(first, count - 1):
        h0, h1 = nodes[3, i], nodes[3, i + 1]
        if (falling and h0 > height >= h1) or (not falling and h0 <= height < h1):
            s0, s1 = nodes[0, i], nodes[0, i + 1]
            s = s0 + (s1 - s0) * (height - h0) / (h1 - h0)
            for _ in range(30):
                drop, slope = dropped(nodes, count, s)
                x = pos[0] + s * los[0] + drop * down[0]
                y = pos[1] + s * los[1] + drop * down[1]
                z = pos[2] + s * los[2] + drop * down[2]
                sine, cosine, h = geodetic(x, y, z)
                ux, uy, uz = up_at(x, y, sine, cosine)
                rate = (
                    (los[0] + slope * down[0]) * ux
                    + (los[1] + slope * down[1]) * uy
                    + (los[2] + slope * down[2]) * uz
                )
                if rate == 0.0:
                    return np.nan, -1
                move = (height - h) / rate
                s += move
                if abs(move) < 1e-7:
                    return s, i
            return np.nan, -1
    return np.nan, -1
