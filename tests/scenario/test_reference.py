"""The schema and the reference page are those of the models."""

from __future__ import annotations

from pathlib import Path

import jsonschema
import pytest
from ruamel.yaml import YAML

from aerosim.assets import folder
from aerosim.scenario import load
from aerosim.scenario.fields import fields, stem, walk
from aerosim.scenario.reference import markdown, schema
from aerosim.scenario.scenario import Scenario
from aerosim.scenario.template import template

PAGE = Path(__file__).parents[2] / "docs" / "scenario.md"
# keys without a dimension, texts, switches and sections; all others carry a unit
BARE = """
schema name purpose verifies seed terrain source orthophoto elevation vertical_datum relief_factor outside
cloud_shadows air wind profile shear exponent slow_wind turbulence model severity exceedance spectrum gusts
thermals thermal_field thermals_drift aircraft flight replay height_above pilot navigator lines area
photos_beyond order file mount level ccd_rows mounted_on extension distortion faults blind_row bits estimation
arithmetic table mean_subtracted subpixel search_n gain crab vh gamma aiding control mode fmc frame_camera write
navigation gnss ins imu smooth p d record rrd report expect min max
"""


def test_the_page_is_current() -> None:
    assert PAGE.read_text(encoding="utf-8") == markdown()


def test_every_key_has_a_meaning_and_a_unit() -> None:
    for key, info in walk(Scenario):
        assert info.description, key
        name = key.rpartition(".")[2]
        assert (stem(name) != name) != (name in BARE.split()), f"{key} lacks its unit"


@pytest.mark.parametrize("file", sorted(folder("scenarios").glob("*.yaml")), ids=lambda file: file.stem)
def test_the_schema_accepts_what_ships(file: Path) -> None:
    jsonschema.Draft202012Validator.check_schema(schema())
    jsonschema.Draft202012Validator(schema()).validate(YAML(typ="safe").load(file))


def test_the_schema_refuses_what_the_loader_refuses() -> None:
    judge = jsonschema.Draft202012Validator(schema())
    good = {
        "name": "x",
        "terrain": {"source": "pine_mountain"},
        "flight": {"lines": [{"start_deg": [36.5, -84.3], "end_deg": [36.5, -84.1]}]},
    }
    assert judge.is_valid(good)
    for bad in (
        {"nam": "x"},
        {"seed": -1},
        {"flight": {**good["flight"], "height_m": 0}},
        {"flight": {"lines": []}},
        {"flight": {"lines": [{"start_deg": [36.5], "end_deg": [36.5, -84.1]}]}},
        {"air": {"wind": {"speed": 3}}},
        {"mount": {"level": "gimbal"}},
    ):
        assert not judge.is_valid({**good, **bad}), bad


def test_the_defaults_are_those_of_the_contract() -> None:
    """Numbers of the design's section 6, read off there, not from the models."""
    got = load("calm")
    # the twin's 540 kg stand in its limits.yaml: another aircraft has other tanks
    assert (got.aircraft.step_rate_hz, got.aircraft.fuel_kg) == (120, None)
    assert (got.flight.height_m, got.flight.airspeed_m_s, got.flight.run_in_s, got.flight.bank_max_deg) == (
        3000,
        69.44,
        60,
        20,
    )
    mount = got.mount
    assert (mount.yaw_limit_deg, mount.rate_limit_deg_s, mount.time_constant_s, mount.delay_s) == (
        30,
        10,
        0.1,
        0.05,
    )
    rows = got.ccd_rows
    assert (rows.period_s, rows.spacing_px, rows.focal_px, rows.pixels_px, rows.max_shift_px) == (
        0.05,
        39.7,
        132.6,
        96,
        7,
    )
    assert (rows.mounted_on, rows.extension, rows.exposure_s, rows.noise_grey, rows.bits) == (
        "camera",
        "imaged",
        "auto",
        1.5,
        8,
    )
    belief = got.estimation
    assert (belief.search_n, belief.strip_period_s, belief.gain) == ((0.6, 1.6), 1, "riccati")
    assert (belief.crab.walk_deg2_per_s, belief.crab.sigma_deg, belief.crab.gamma) == (0.225, 5, None)
    assert (belief.vh.walk_pct2_per_s, belief.vh.sigma_pct, belief.vh.gamma) == (0.5, 5, None)
    assert (got.control.mode, got.control.end_lap_pct, got.control.fmc) == ("pipelined", 60, True)
    camera = got.frame_camera
    assert (camera.focal_mm, camera.format_mm, camera.pixel_um, camera.exposure_s) == (152, (230, 230), 12, 0.003)
    assert (camera.min_interval_s, camera.shutter_delay_s, camera.write) == (2, 0.05, False)
    assert (got.record.period_s, got.record.exclude_first_s, got.record.rrd, got.record.report) == (
        0.05,
        60,
        True,
        True,
    )
    assert (got.air.slow_wind.time_constant_s, got.air.turbulence.length_m, got.air.shear.reference_agl_m) == (
        120,
        533.4,
        3000,
    )


def test_the_template_explains_every_section_and_loads(tmp_path: Path) -> None:
    text = template("survey")
    file = tmp_path / "survey.yaml"
    file.write_text(text)
    got = load(file)
    assert got.name == "survey"
    assert got.flight.lines == load("crosswind").flight.lines
    lines = text.splitlines()
    for section in fields([Scenario]):
        line = next(line for line in lines if line.startswith(f"{section}:"))
        assert " # " in line, section
