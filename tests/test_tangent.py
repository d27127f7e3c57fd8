"""The tangent plane: against pyproj's orthographic and geodesic, and relief against the raster itself."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planned import place, write_land
from pyproj import Geod, Transformer

from aerosim.errors import InputError
from aerosim.raster import sample
from aerosim.tangent import TangentPlane, relief_on

GEOD = Geod(ellps="WGS84")


@given(st.floats(-80.0, 80.0), st.floats(-180.0, 180.0), st.floats(0.0, 50e3), st.floats(0.0, 6.28))
def test_there_and_back_and_true_to_length(lat: float, lon: float, away: float, azimuth: float) -> None:
    plane = TangentPlane(math.radians(lat), math.radians(lon))
    point = away * np.array([math.sin(azimuth), math.cos(azimuth)])
    back = plane.to_geodetic(point)
    assert plane.to_plane(back) == pytest.approx(point, abs=1e-6)
    found_azimuth, _, length = GEOD.inv(lon, lat, math.degrees(back[1]), math.degrees(back[0]))
    # short radially by (d/R)^2 / 6 over the whole way, R >= 6335 km, and by the ellipsoid's own curvature
    assert length == pytest.approx(away, rel=1.2 * (away / 6.335e6) ** 2 / 6.0, abs=1e-4)
    if away > 100.0:
        turned = math.remainder(math.radians(found_azimuth) - azimuth, 2.0 * math.pi)
        assert abs(turned) < 1e-6 + 2e-9 * away / 100.0


def test_it_is_the_ellipsoidal_orthographic_projection() -> None:
    other = Transformer.from_crs("EPSG:4326", "+proj=ortho +lat_0=36.5 +lon_0=-87 +ellps=WGS84", always_xy=True)
    points = np.array([[36.7, -87.3], [36.2, -86.6], [36.5, -87.0]])
    assert TangentPlane(math.radians(36.5), math.radians(-87.0)).to_plane(np.radians(points)) == pytest.approx(
        np.column_stack(other.transform(points[:, 1], points[:, 0])), abs=1e-5
    )


def test_relief_is_the_rasters(tmp_path: Path) -> None:
    terrain = write_land(tmp_path, lambda x, y: 500.0 + 200.0 * np.sin(x / 2e3) * np.cos(y / 3e3))
    plane = TangentPlane(*place(0.0, 0.0))
    window = relief_on(plane, (-25e3, -8e3, 25e3, 8e3), terrain.grid, terrain.elevation, 50.0)
    assert window.bounds[0] == -25e3
    assert window.bounds[3] == 8e3
    rng = np.random.default_rng(1)
    points = np.column_stack([rng.uniform(-25e3, 25e3, 500), rng.uniform(-8e3, 8e3, 500)])
    lat, lon = np.moveaxis(plane.to_geodetic(points), -1, 0)
    e, n = terrain.grid.from_geodetic(lat, lon)
    direct = sample(terrain.elevation().covering(e.min(), n.min(), e.max(), n.max()), e, n)
    # bilinear twice: a cell's sag, 50^2/8 of the curvature 200/2000^2 + 200/3000^2, both times
    assert sample(window, *points.T) == pytest.approx(direct, abs=2.2 * 50.0**2 / 8 * 7.3e-5)


def test_places_off_the_map_have_no_relief(tmp_path: Path) -> None:
    terrain = write_land(tmp_path, lambda x, y: 0.0 * x, half_east=2e3, half_north=2e3)
    far = relief_on(TangentPlane(1.2, 2.0), (-1e3, -1e3, 1e3, 1e3), terrain.grid, terrain.elevation, 50.0)
    assert np.isnan(far.values).all()
    with pytest.raises(InputError, match="empty piece"):
        relief_on(TangentPlane(*place(0.0, 0.0)), (0.0, 0.0, 0.0, 5.0), terrain.grid, terrain.elevation, 50.0)
