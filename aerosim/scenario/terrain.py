"""Section `terrain`: which land is flown over."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from aerosim.scenario.section import Section

DATUMS = ("file", "ellipsoidal", "egm96", "egm2008")


def kind_of(value: Any) -> str | None:
    """Tag of a union of a word and a section."""
    if isinstance(value, str):
        return "<word>"
    return "<section>" if isinstance(value, (dict, Section)) else None


class TerrainFiles(Section):
    """The user's own terrain: two GeoTIFF files, relative to the scenario file."""

    orthophoto: str = Field(min_length=1, description="orthophoto, GeoTIFF with a coordinate reference system")
    elevation: str = Field(min_length=1, description="elevation model, GeoTIFF, heights in m")


class Undulation(Section):
    """A constant undulation of the geoid."""

    undulation_m: float = Field(
        ge=-120, le=120, description="geoid above the ellipsoid, added to the file's orthometric heights"
    )


class CloudShadows(Section):
    """Shadows of clouds that move over the ground, as the rows see them."""

    cover_pct: float = Field(default=50.0, gt=0, lt=100, description="share of the ground that lies in shadow")
    cell_m: float = Field(
        default=800.0, ge=50, le=50000, description="mean length of shadows and of gaps on a line at half cover"
    )
    speed_m_s: float = Field(default=8.0, ge=0, le=100, description="how fast they move over the ground")
    from_deg: float = Field(default=270.0, ge=0, le=360, description="where they come from, clockwise from north")
    darkness_pct: float = Field(default=60.0, ge=0, le=100, description="of the light that a shadow takes")


class Terrain(Section):
    """Orthophoto and elevation model."""

    source: Annotated[
        Annotated[str, Tag("<word>"), Field(min_length=1)] | Annotated[TerrainFiles, Tag("<section>")],
        Discriminator(
            kind_of,
            custom_error_type="aerosim",
            custom_error_message="wrong value",
            custom_error_context={
                "problems": (
                    (
                        "",
                        "is neither a name nor a pair of files",
                        "allowed: the name of a shipped terrain, or {orthophoto: FILE, elevation: FILE}",
                    ),
                )
            },
        ),
    ] = Field(description="shipped terrain by name, or {orthophoto: FILE, elevation: FILE}")
    vertical_datum: Annotated[
        Annotated[Literal["file", "ellipsoidal", "egm96", "egm2008"], Tag("<word>")]
        | Annotated[Undulation, Tag("<section>")],
        Discriminator(
            kind_of,
            custom_error_type="aerosim",
            custom_error_message="wrong value",
            custom_error_context={
                "problems": (
                    (
                        "",
                        "is no vertical datum",
                        f"allowed: {', '.join(DATUMS)}, or {{undulation_m: NUMBER}}",
                    ),
                )
            },
        ),
    ] = Field(
        default="file",
        description="what the elevations are above: as the file says, or stated here; never guessed",
    )
    relief_factor: float = Field(
        default=1.0,
        ge=0,
        le=10,
        description="heights above the elevation file's mean are multiplied by it; 0: flat land at that mean",
    )
    outside: Literal["fail", "mask"] = Field(
        default="fail", description="leaving the raster on a line: fail ends the run, mask goes on without data"
    )
    cloud_shadows: CloudShadows | None = Field(default=None, description="moving shadows of clouds; null: none")
