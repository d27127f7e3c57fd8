"""Land cover and its colours on a relief: forest, fields, clearings, water, roads, houses, light and shade."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import parcels
from noise import Field, band, ramp
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy import ndimage

Array = NDArray[np.float64]
Line = tuple[Array, Array]
Colour = NDArray[np.float32]

FOREST = ((58, 74, 42), (78, 92, 50), (44, 60, 40), (94, 100, 58))
FIELDS = (
    (118, 140, 74), (138, 152, 88), (104, 126, 66), (176, 168, 112), (196, 180, 128), (150, 118, 86),
    (126, 98, 74), (92, 120, 56), (74, 104, 50), (160, 158, 96), (112, 134, 84), (184, 172, 140),
)  # fmt: skip
CLEARED = ((132, 122, 84), (150, 132, 98), (108, 118, 70), (118, 106, 78), (92, 108, 60))
RELIEF = 1.35
SUN = (np.radians(315.0), np.radians(42.0))


@dataclass(frozen=True)
class Land:
    """Relief and its lines at the orthophoto's pixel.

    pixel: m; height, above_channel: (rows, cols), m; streams, roads, tracks, powerlines: lines (row, column) with
    widths in m; houses: (n, 2) row, column.
    """

    pixel: float
    height: Field
    above_channel: Field
    streams: list[Line]
    roads: list[Line]
    tracks: list[Line]
    powerlines: list[Line]
    houses: Array

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, cols = self.height.shape
        return rows, cols


def paint(land: Land) -> NDArray[np.uint8]:
    """The picture.  Returns (rows, cols, 3)."""
    slope, shade = _light(land)
    farm = _farmland(land, slope)
    wood = _forest(land, slope)
    colour = np.where(farm[..., None], _fields(land), wood)
    _rivers(land, colour)
    _ponds(land, colour, farm & (slope < 0.06))
    _draw_ways(land, colour, farm)
    texture = band(land.shape, land.pixel, 8.0, 45.0, 71, 0.3)
    grain = np.where(farm, 0.035, 0.06).astype(np.float32)
    colour *= (shade * (1.0 + grain * texture))[..., None]
    grey = colour @ np.array([0.299, 0.587, 0.114], np.float32)
    colour = 0.86 * colour + 0.14 * grey[..., None]
    haze = np.array([11.0, 12.0, 14.0], np.float32)
    return np.clip(colour * 1.1 + haze, 0, 255).astype(np.uint8)


def _light(land: Land) -> tuple[Field, Field]:
    """Slope (rad) of the relief, and brightness with small gullies and spurs that the model is too coarse for."""
    down, right = np.gradient(land.height, land.pixel)
    slope = np.arctan(np.hypot(down, right)).astype(np.float32)
    rough = ramp(slope, 0.05, 0.4) * 1.6 + 0.25
    fine = RELIEF * (land.height + rough * band(land.shape, land.pixel, 45.0, 260.0, 11, 1.3))
    down, right = np.gradient(fine, land.pixel)
    azimuth, altitude = SUN
    east, north = np.sin(azimuth) * np.cos(altitude), np.cos(azimuth) * np.cos(altitude)
    light = (-right * east + down * north + np.sin(altitude)) / np.sqrt(1.0 + down**2 + right**2)
    light = np.clip(light / np.sin(altitude), 0.0, None)
    # Open sky: ridges see more of it than valleys.
    open_sky = sum(land.height - ndimage.gaussian_filter(land.height, s) for s in (12, 40)) / 60.0
    bright = (0.34 + 0.66 * light**0.9) * (1.0 + 0.22 * np.tanh(open_sky))
    return slope, np.asarray(bright, np.float32)


def _farmland(land: Land, slope: Field) -> NDArray[np.bool_]:
    """Gentle ground near the valley bottoms, parcel by parcel, with woods left between."""
    patch = parcels.split(land.shape, land.pixel, 1500.0, (70.0, 340.0), 21)
    count = int(patch.max()) + 1
    size = np.maximum(np.bincount(patch.ravel(), minlength=count), 1)
    steep = np.bincount(patch.ravel(), slope.ravel(), count) / size
    above = np.bincount(patch.ravel(), land.above_channel.ravel(), count) / size
    wild = band(land.shape, land.pixel, 700.0, 5000.0, 22, 1.0)
    wild_mean = np.bincount(patch.ravel(), wild.ravel(), count) / size
    rng = np.random.default_rng(23)
    score = 1.75 - steep / 0.125 - above / 95.0 - 0.42 * wild_mean + rng.normal(0.0, 0.22, count)
    return np.asarray((score > 0.0)[patch])


def _fields(land: Land) -> Colour:
    """Crops, pastures, hay and ploughed land: one colour a parcel, uneven soil, hedges and field edges."""
    patch = parcels.split(land.shape, land.pixel, 1500.0, (70.0, 340.0), 21)
    rng = np.random.default_rng(24)
    count = int(patch.max()) + 1
    palette = np.array(FIELDS, np.float32)[rng.choice(len(FIELDS), count, p=_weights(len(FIELDS)))]
    palette *= rng.normal(1.0, 0.1, (count, 1)).astype(np.float32) * rng.normal(1.0, 0.025, (count, 3)).astype(
        np.float32
    )
    colour = palette[patch]
    soil = band(land.shape, land.pixel, 40.0, 420.0, 25, 0.9)
    unevenness = (rng.uniform(0.03, 0.12, count).astype(np.float32))[patch]
    colour *= (1.0 + unevenness * soil)[..., None]
    _tint(colour, (76, 92, 56), 0.5 * ramp(band(land.shape, land.pixel, 30.0, 260.0, 26, 0.8), 1.35, 1.8))
    rim = parcels.edges(patch)
    hedge = rim & (parcels.values(patch, 27) < 0.5) & (band(land.shape, land.pixel, 12.0, 300.0, 28, 0.6) > -0.5)
    hedge = ndimage.binary_dilation(hedge, iterations=1)
    _tint(colour, (52, 70, 42), 0.9 * ndimage.gaussian_filter(hedge.astype(np.float32), 0.6))
    _tint(colour, (176, 166, 132), 0.45 * (rim & ~hedge).astype(np.float32))
    trees = band(land.shape, land.pixel, 12.0, 40.0, 29, 0.2) > 3.1
    _tint(colour, (48, 66, 40), ndimage.gaussian_filter(trees.astype(np.float32), 0.7) * 1.3)
    return colour


def _weights(count: int) -> Array:
    """More grass than plough."""
    weights = np.ones(count)
    weights[:3] = 2.0
    return np.asarray(weights / weights.sum())


def _forest(land: Land, slope: Field) -> Colour:
    """Stands of different trees and ages, dark coves and light ridges, clearings, benches of old strip mines."""
    shape, pixel = land.shape, land.pixel
    down, right = np.gradient(ndimage.gaussian_filter(land.height, 12), pixel)
    north_facing = ramp((down / (0.15 + np.hypot(down, right))).astype(np.float32), -0.8, 0.8)
    kind = 0.9 * north_facing + 0.45 * band(shape, pixel, 120.0, 1800.0, 31, 1.2) - ramp(land.height, 450.0, 850.0)
    kind += 0.2 * band(shape, pixel, 45.0, 160.0, 32, 0.0)
    colour = np.empty((*shape, 3), np.float32)
    base = [np.array(c, np.float32) for c in FOREST]
    for k in range(3):
        colour[..., k] = np.interp(kind, (-1.6, -0.4, 0.6, 1.6), [base[i][k] for i in (3, 1, 0, 2)])
    colour *= (1.0 + 0.10 * band(shape, pixel, 45.0, 300.0, 33, 0.5))[..., None]
    stands = parcels.split(shape, pixel, 1100.0, (110.0, 700.0), 34)
    colour *= (0.86 + 0.28 * parcels.values(stands, 35))[..., None]
    _clear(land, slope, stands, colour)
    _benches(land, slope, colour)
    cove = ramp(30.0 - land.above_channel, 0.0, 30.0) * ramp(slope, 0.05, 0.2)
    colour *= (1.0 - 0.2 * cove)[..., None]
    crowns = band(shape, pixel, 9.0, 26.0, 36, 0.0)
    colour *= (1.0 + 0.09 * crowns)[..., None]
    return colour


def _clear(land: Land, slope: Field, stands: parcels.Labels, colour: Colour) -> None:
    """Stands cut lately: bare, or grown over to some degree, with ragged edges."""
    rng = np.random.default_rng(41)
    count = int(stands.max()) + 1
    palette = np.array(CLEARED, np.float32)[rng.integers(0, len(CLEARED), count)][stands]
    palette *= (1.0 + 0.12 * band(land.shape, land.pixel, 25.0, 250.0, 42, 0.7))[..., None]
    amount = (rng.uniform(0.35, 1.0, count) * (rng.random(count) < 0.15)).astype(np.float32)[stands]
    amount *= ramp(-slope, -0.55, -0.38)
    ragged = band(land.shape, land.pixel, 20.0, 200.0, 43, 0.8)
    cut = ndimage.gaussian_filter((amount > 0).astype(np.float32), 4.0) + 0.16 * ragged > 0.5
    _tint(colour, palette, ndimage.gaussian_filter(amount * cut, 1.0))


def _benches(land: Land, slope: Field, colour: Colour) -> None:
    """Contour strips of old coal mines on the steep slopes, each over a part of its level."""
    where = band(land.shape, land.pixel, 600.0, 4000.0, 51, 1.0)
    wander = 5.0 * band(land.shape, land.pixel, 150.0, 900.0, 52, 1.0)
    grown = band(land.shape, land.pixel, 40.0, 400.0, 53, 0.8)
    for level, phase in ((480.0, 1.0), (560.0, -1.0), (655.0, 1.0), (745.0, -1.0), (820.0, 1.0)):
        off = np.asarray((land.height + wander - level) / np.maximum(np.tan(slope), 0.05), np.float32)
        bare = (
            ramp(np.float32(24.0) - np.abs(off), 0.0, 10.0)
            * ramp(phase * where, 0.15, 0.6)
            * ramp(slope, 0.14, 0.25)
        )
        wall = (
            ramp(np.float32(12.0) - np.abs(off - np.float32(30.0)), 0.0, 8.0)
            * ramp(phase * where, 0.15, 0.6)
            * ramp(slope, 0.14, 0.25)
        )
        _tint(colour, (150, 138, 108), bare * (0.35 + 0.4 * ramp(grown, -1.0, 1.0)))
        _tint(colour, (36, 46, 34), 0.6 * wall)


def _rivers(land: Land, colour: Colour) -> None:
    """Trees along the water, then the water, wider the more of it there is."""
    small = [(points, width) for points, width in land.streams]
    bank = _mask(land.shape, land.pixel, [(p, np.where(w > 0.0, 3.2 * w + 14.0, 0.0)) for p, w in small])
    bank = ndimage.gaussian_filter(bank, 1.2) * (1.0 + 0.3 * band(land.shape, land.pixel, 15.0, 150.0, 61, 0.6))
    _tint(colour, (46, 64, 40), np.clip(0.85 * bank, 0.0, 0.9))
    wet = _mask(land.shape, land.pixel, [(p, w) for p, w in small if w.max() >= 7.0])
    bars = _mask(land.shape, land.pixel, [(p, w * 1.5) for p, w in small if w.max() >= 14.0])
    bar_noise = ramp(band(land.shape, land.pixel, 30.0, 300.0, 62, 0.8), 0.5, 1.2)
    _tint(colour, (178, 168, 140), 0.8 * ndimage.gaussian_filter(bars, 0.8) * bar_noise)
    _tint(colour, (58, 78, 84), 0.95 * ndimage.gaussian_filter(wet, 0.7))


def _ponds(land: Land, colour: Colour, where: NDArray[np.bool_]) -> None:
    """Farm ponds with a bank."""
    rng = np.random.default_rng(63)
    picture = Image.new("L", land.shape[::-1])
    draw = ImageDraw.Draw(picture)
    for place in rng.choice(np.flatnonzero(where), 90, replace=False):
        row, col = divmod(int(place), land.shape[1])
        a, b = rng.uniform(2.0, 9.0, 2)
        draw.ellipse((col - a, row - b, col + a, row + b), fill=255)
    pond = np.asarray(picture, np.float32) / 255.0
    _tint(colour, (150, 140, 110), 0.7 * ndimage.gaussian_filter(pond, 1.6))
    _tint(colour, (54, 76, 82), ndimage.gaussian_filter(pond, 0.6))


def _draw_ways(land: Land, colour: Colour, farm: NDArray[np.bool_]) -> None:
    """Power lines' aisles, tracks, roads with verges, houses with gardens."""
    aisle = ndimage.gaussian_filter(_mask(land.shape, land.pixel, land.powerlines), 0.8) * ~farm
    _tint(colour, (122, 128, 80), 0.75 * aisle)
    tracks = ndimage.gaussian_filter(_mask(land.shape, land.pixel, land.tracks), 0.6)
    _tint(colour, (168, 150, 118), 0.75 * tracks)
    verge = ndimage.gaussian_filter(_mask(land.shape, land.pixel, [(p, w + 22.0) for p, w in land.roads]), 1.5)
    _tint(colour, (126, 138, 88), 0.6 * verge)
    roads = ndimage.gaussian_filter(_mask(land.shape, land.pixel, land.roads), 0.55)
    _tint(colour, (184, 180, 172), 0.95 * roads)
    rng = np.random.default_rng(65)
    gardens, roofs = Image.new("L", land.shape[::-1]), Image.new("L", land.shape[::-1])
    on_gardens, on_roofs = ImageDraw.Draw(gardens), ImageDraw.Draw(roofs)
    for row, col in land.houses:
        big = rng.uniform(3.0, 6.5)
        on_gardens.ellipse((col - big, row - big, col + big, row + big), fill=255)
        a, b = rng.uniform(0.7, 1.8, 2) * (2.5 if rng.random() < 0.06 else 1.0)
        on_roofs.rectangle((col - a, row - b, col + a, row + b), fill=int(rng.integers(120, 256)))
    _tint(colour, (130, 146, 90), 0.6 * ndimage.gaussian_filter(np.asarray(gardens, np.float32) / 255.0, 1.0))
    _tint(colour, (214, 208, 204), ndimage.gaussian_filter(np.asarray(roofs, np.float32) / 255.0, 0.5))


def _mask(shape: tuple[int, int], pixel: float, lines: list[Line]) -> Field:
    """Lines as drawn at four times the area, 0 to 1.  Widths in m, one a point."""
    picture = Image.new("L", (2 * shape[1], 2 * shape[0]))
    draw = ImageDraw.Draw(picture)
    for points, widths in lines:
        xy = [(2.0 * c + 0.5, 2.0 * r + 0.5) for r, c in points]
        across = np.broadcast_to(np.asarray(widths, float), (len(xy),))
        for start, end, width in zip(xy[:-1], xy[1:], across[1:], strict=True):
            if width <= 0.0:
                continue
            draw.line([start, end], fill=255, width=max(1, round(2.0 * width / pixel)))
            half = width / pixel
            if half > 1.5:
                draw.ellipse((end[0] - half, end[1] - half, end[0] + half, end[1] + half), fill=255)
    small = picture.reduce(2)
    return np.asarray(small, np.float32) / 255.0


def _tint(colour: Colour, target: object, amount: Field) -> None:
    """Blends colour (rows, cols, 3) to another one by amount (rows, cols), in place."""
    part = np.clip(amount, 0.0, 1.0)[..., None]
    colour += (np.asarray(target, np.float32) - colour) * part
