from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import pytest

from .made import TABLES, folder_of, make, readme

# Each set typed again from its source's list, not from the tables of the scripts, in the source's order.
SURVEY_TWIN = {
    "X": [-0.0488, 0.223, 1.659],
    "Y": [-0.6, -0.2, 0.4, 0.15],
    "Z": [-0.360, -5.66, -19.97, -0.608],
    "ROLL": [-0.08, -0.5, 0.06, -0.15, 0.015],
    "PITCH": [0.040, -1.31, -34.2, -1.74],
    "YAW": [0.1, -0.06, -0.18, -0.001, -0.125],
}
# The source's aileron rolls right, ours left: its two coefficients change sign.
BEECH_99 = {
    "X": [0.0249, 0.0526],
    "Y": [-0.59, -0.19, 0.39, 0.148],
    "Z": [1.0, 2.5, 8.1],
    "ROLL": [-0.13, -0.50, 0.14, -0.156, 0.0109],
    "PITCH": [0.05, -1.89, -9.1, -34.0, -2.0],
    "YAW": [0.080, 0.019, -0.197, 0.0012, -0.0772],
}
# Flaps up: without the terms in df.
BEAVER = {
    "X": [-0.03554, 0.00292, 5.459, -5.162, -0.6748, 0.03412, 0.1161, 0.1453],
    "Y": [-0.002226, -0.7678, -0.1240, 0.3666, -0.02956, 0.1158, 0.5238, -0.1600],
    "Z": [-0.05504, -5.578, 3.442, -2.988, -0.3980, -15.93, -0.1563],
    "ROLL": [0.0005910, -0.06180, -0.5045, 0.1695, -0.09917, 0.006934, -0.08269, -0.01406],
    "PITCH": [0.09448, -0.6028, -2.140, -15.56, -1.921, 0.6921, -0.3118, -0.07895],
    "YAW": [-0.003117, 0.006719, 0.1373, -0.1585, -0.1112, -0.003872, -0.08265, 0.1595, -0.003026],
}


@pytest.mark.parametrize("name", TABLES)
def test_files_are_what_the_script_writes(name: str) -> None:
    for path, text in make.files(TABLES[name]).items():
        assert (folder_of(name) / path).read_text(encoding="utf-8") == text


def same_but_for_the_last_digit(written: str, made: str) -> None:
    """Words to the letter; numbers within the last digit shown, which another processor may round otherwise."""
    number = re.compile(r"-?\d+\.?\d*")
    assert number.sub("#", written) == number.sub("#", made)
    found = [float(text) for text in number.findall(made)]
    assert [float(text) for text in number.findall(written)] == pytest.approx(found, rel=2e-3, abs=0.011)


@pytest.mark.parametrize("name", TABLES)
def test_readme_shows_what_the_model_does(name: str) -> None:
    written = (folder_of(name) / "README.md").read_text(encoding="utf-8")
    quick, _, _ = written.partition("\n## Lines in turbulence")
    same_but_for_the_last_digit(quick, readme.quick(folder_of(name), TABLES[name]))


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLES)
def test_readme_shows_how_the_model_flies_in_turbulence(name: str) -> None:
    written = (folder_of(name) / "README.md").read_text(encoding="utf-8")
    _, mark, rest = written.partition("\n## Lines in turbulence")
    same_but_for_the_last_digit(mark + rest, readme.lines_in_gusts(folder_of(name), TABLES[name]))


@pytest.mark.parametrize(
    ("name", "expected"), [("survey_twin", SURVEY_TWIN), ("beech_99", BEECH_99), ("beaver", BEAVER)]
)
def test_coefficients_are_those_of_the_source(name: str, expected: dict[str, list[float]]) -> None:
    root = ET.parse(folder_of(name) / f"{name}.xml").getroot()
    found = {
        axis.attrib["name"]: [float(value.text or "nan") for value in axis.iter("value")]
        for axis in root.iter("axis")
    }
    assert found == expected


def test_lift_of_the_beech_is_a_sum_of_its_own() -> None:
    root = ET.parse(folder_of("beech_99") / "beech_99.xml").getroot()
    (lift,) = (f for f in root.iter("function") if f.get("name") == "aero/lift-static")
    assert [float(value.text or "nan") for value in lift.iter("value")] == [0.201, 5.48, 0.60]


def test_every_coefficient_is_listed_with_its_source() -> None:
    for name, table in TABLES.items():
        text = (folder_of(name) / "README.md").read_text(encoding="utf-8")
        assert table.source in text
        rows = [line for line in text.splitlines() if re.match(r"\| C[XYZLDlmn][ ,|]", line)]
        assert len(rows) == len(table.terms)
