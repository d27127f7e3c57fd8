"""The table over height: read, interpolated, refused with the line; and how a scenario names it."""

# ruff: noqa: E501  (tables of messages, one a line)

from __future__ import annotations

from pathlib import Path

import pytest
from flights import scenario as short

from aerosim.errors import InputError
from aerosim.scenario import Scenario, from_mapping, load, parse_setting, to_yaml
from aerosim.scenario.build import input_files, with_table
from aerosim.scenario.disturbances import at_height, read_table

GOOD = """\
rows:
  - height_agl_m: 1000
    crab: {walk_deg2_per_s: 0.3, sigma_deg: 4}
    vh: {walk_pct2_per_s: 1.0, sigma_pct: 6, gamma: 0.02}
  - height_agl_m: 3000
    crab: {walk_deg2_per_s: 0.1, sigma_deg: 2}
    vh: {walk_pct2_per_s: 0.5, sigma_pct: 3, gamma: 0.04}
"""


def written(folder: Path, text: str = GOOD) -> Path:
    file = folder / "table.yaml"
    file.write_text(text)
    return file


def names_it(folder: Path, more: str = "", mode: str = "pipelined") -> Path:
    written(folder)
    file = folder / "flight.yaml"
    file.write_text(
        "name: tabled\nterrain: {source: pine_mountain}\n"
        "flight: {lines: [{start_deg: [36.52, -84.38], end_deg: [36.52, -84.3]}]}\n"
        f"control: {{mode: {mode}}}\nestimation:\n  table: table.yaml\n{more}"
    )
    return file


@pytest.mark.parametrize(
    ("height", "walk", "sigma", "gamma"),
    [
        (1000.0, 0.3, 4.0, 0.02),
        (3000.0, 0.1, 2.0, 0.04),
        (1500.0, 0.25, 3.5, 0.025),  # linear between
        (200.0, 0.3, 4.0, 0.02),  # the nearest beyond the ends
        (9000.0, 0.1, 2.0, 0.04),
    ],
)
def test_linear_between_rows_constant_beyond(
    tmp_path: Path, height: float, walk: float, sigma: float, gamma: float
) -> None:
    found = at_height(read_table(written(tmp_path)), height)
    assert found.crab.walk_deg2_per_s == pytest.approx(walk)
    assert found.crab.sigma_deg == pytest.approx(sigma)
    assert found.crab.gamma is None
    assert found.vh.gamma == pytest.approx(gamma)
    assert found.vh.sigma_pct == pytest.approx(1.5 * sigma)


def test_a_single_row_holds_everywhere(tmp_path: Path) -> None:
    table = read_table(written(tmp_path, GOOD[: GOOD.index("  - height_agl_m: 3000")]))
    assert at_height(table, 1.0) == at_height(table, 5000.0) == (table.rows[0].crab, table.rows[0].vh)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("height_agl_m: 3000", "height_agl_m: 900", ":5: rows.1.height_agl_m: 900 follows 1000 (heights in ascending order)"),
        ("height_agl_m: 3000", "height_agl_m: 1000", ":5: rows.1.height_agl_m: 1000 follows 1000"),
        ("gamma: 0.04", "gamma: null", ":7: rows.1.vh.gamma: a number in some rows and null in others"),
        ("sigma_deg: 2", "sigma_deg: 0", ":6: rows.1.crab.sigma_deg: 0 is out of range (allowed: more than 0"),
        ("sigma_deg: 2", "sigma: 2", ":6: rows.1.crab.sigma: unknown key, without its unit (did you mean sigma_deg?)"),
        ("    vh: {walk_pct2_per_s: 1.0, sigma_pct: 6, gamma: 0.02}\n", "", ":2: rows.0.vh: is missing (filter of v/h)"),
        ("rows:", "lines:", ":1: lines: unknown key"),
        ("rows:", "- rows", "table.yaml:2"),
        (GOOD, "", ": is empty (a table of disturbances; `aerosim tune` writes one)"),
        (GOOD, "rows: []", ":1: rows: has 0 values (allowed: at least 1)"),
        (GOOD, "- 3", ":1: is not a table of disturbances"),
    ],
)  # fmt: skip
def test_bad_tables_are_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_table(written(tmp_path, GOOD.replace(old, new)))
    assert message in str(caught.value)
    assert "table.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_scenario_names_it_from_its_own_folder(tmp_path: Path) -> None:
    scenario = load(names_it(tmp_path))
    assert scenario.estimation.table == str(tmp_path / "table.yaml")
    assert input_files(scenario)["disturbances"] == tmp_path / "table.yaml"
    found = with_table(scenario, 2000.0)
    assert found.estimation.crab.walk_deg2_per_s == pytest.approx(0.2)
    assert found.estimation.vh.gamma == pytest.approx(0.03)
    assert scenario.estimation.crab.walk_deg2_per_s == 0.225  # what is recorded is the table's name
    plain = short()
    assert with_table(plain, 2000.0) is plain


@pytest.mark.parametrize("mode", ["pipelined", "schmelovsky_1988"])
def test_the_resolved_scenario_is_read_again(tmp_path: Path, mode: str) -> None:
    scenario = load(names_it(tmp_path, mode=mode))
    again = tmp_path / "again" / "scenario.yaml"
    again.parent.mkdir()
    again.write_text(to_yaml(scenario))
    assert load(again) == scenario
    assert with_table(load(again), 1000.0).estimation.vh.gamma == 0.02
    # the printed gamma of the mode gives way to the table's
    assert scenario.estimation.crab.gamma is None


@pytest.mark.parametrize(
    ("more", "line"),
    [
        ("  crab: {sigma_deg: 4}\n", ":7: estimation.crab.sigma_deg: is given besides table (one of the two)"),
        ("  vh: {gamma: 0.1}\n", ":7: estimation.vh.gamma: is given besides table"),
        (
            "  vh:\n    sigma_pct: 5\n    walk_pct2_per_s: 2\n",
            ":9: estimation.vh.walk_pct2_per_s: is given besides",
        ),
    ],
)
def test_keys_of_the_table_are_not_given_twice(tmp_path: Path, more: str, line: str) -> None:
    with pytest.raises(InputError) as caught:
        load(names_it(tmp_path, more))
    assert line in str(caught.value)


def test_a_table_that_is_not_there(tmp_path: Path) -> None:
    scenario: Scenario = load(names_it(tmp_path), [parse_setting("estimation.table=none.yaml")])
    with pytest.raises(InputError, match=r"--set estimation.table: no such file: .*none.yaml \(a table that"):
        with_table(scenario, 1000.0)


def integer(**sections: dict[str, object]) -> dict[str, object]:
    base: dict[str, object] = {
        "name": "whole",
        "terrain": {"source": "pine_mountain"},
        "flight": {"lines": [{"start_deg": [36.52, -84.38], "end_deg": [36.52, -84.3]}]},
        "control": {"mode": "schmelovsky_1988"},
        "estimation": {"arithmetic": "integer"},
    }
    for key, values in sections.items():
        base[key] = {**base.get(key, {}), **values}  # type: ignore[dict-item]
    return base


def test_integer_arithmetic_is_the_mode_of_1988() -> None:
    assert from_mapping(integer()).estimation.arithmetic == "integer"
    assert from_mapping(integer(ccd_rows={"mounted_on": "camera", "bits": 6, "pixels_px": 128}))


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        ({"control": {"mode": "pipelined"}}, "estimation.arithmetic: integer is the instrument of 1988, control.mode is pipelined (real, or control.mode: schmelovsky_1988)"),
        ({"estimation": {"subpixel": True}}, "estimation.subpixel: true does not go with estimation.arithmetic: integer (false)"),
        ({"estimation": {"strip_period_s": 1.0}}, "estimation.strip_period_s: only one strip at a time goes with"),
        ({"estimation": {"crab": {"gamma": 2.0}}}, "estimation.crab.gamma: 2 is too much with"),
        ({"estimation": {"vh": {"gamma": 3.5}}}, "estimation.vh.gamma: 3.5 is too much with"),
        ({"ccd_rows": {"bits": 10}}, "ccd_rows.bits: 10 is too much with estimation.arithmetic: integer (at most 8)"),
        ({"ccd_rows": {"pixels_px": 129}}, "ccd_rows.pixels_px: 129 is too much with estimation.arithmetic: integer (at most 128)"),
        ({"estimation": {"arithmetic": "whole"}}, "estimation.arithmetic: 'whole' is not known (allowed: real, integer)"),
    ],
)  # fmt: skip
def test_what_integer_arithmetic_cannot_do(sections: dict[str, dict[str, object]], message: str) -> None:
    with pytest.raises(InputError) as caught:
        from_mapping(integer(**sections))
    assert message in str(caught.value)
