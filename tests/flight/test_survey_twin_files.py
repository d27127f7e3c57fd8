from __future__ import annotations

import importlib
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest


@pytest.fixture
def maker(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    if not (folder.parent / "make_survey_twin.py").is_file():
        pytest.fail("the script that makes the survey twin ships beside it")
    monkeypatch.syspath_prepend(str(folder.parent))
    return folder


def test_model_is_what_the_script_writes(maker: Path) -> None:
    script = importlib.import_module("make_survey_twin")
    assert (maker / "survey_twin.xml").read_text(encoding="utf-8") == script.model_xml()
    assert (maker / "limits.yaml").read_text(encoding="utf-8") == script.limits_yaml()


def test_readme_shows_what_the_model_does(maker: Path) -> None:
    # Words to the letter; numbers within the last digit shown, which another processor may round the other way.
    number = re.compile(r"-?\d+\.?\d*")
    written = (maker / "README.md").read_text(encoding="utf-8")
    made = importlib.import_module("survey_twin_readme").readme()
    assert number.sub("#", written) == number.sub("#", made)
    found = [float(text) for text in number.findall(made)]
    assert [float(text) for text in number.findall(written)] == pytest.approx(found, rel=2e-3, abs=0.011)


def test_coefficients_are_those_of_the_source(folder: Path) -> None:
    # Typed again from the source's list, not from the script's table.
    expected = {
        "X": [-0.0488, 0.223, 1.659],
        "Y": [-0.6, -0.2, 0.4, 0.15],
        "Z": [-0.360, -5.66, -19.97, -0.608],
        "ROLL": [-0.08, -0.5, 0.06, -0.15, 0.015],
        "PITCH": [0.040, -1.31, -34.2, -1.74],
        "YAW": [0.1, -0.06, -0.18, -0.001, -0.125],
    }
    root = ET.parse(folder / "survey_twin.xml").getroot()
    for axis in root.iter("axis"):
        values = [float(value.text or "nan") for value in axis.iter("value")]
        assert values == expected.pop(axis.attrib["name"])
    assert not expected
