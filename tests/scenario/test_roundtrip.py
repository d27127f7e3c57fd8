"""Scenario to YAML and back, whatever is in it."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from aerosim.scenario import from_mapping, load, shipped, to_yaml
from aerosim.scenario.emit import scalar
from aerosim.scenario.reader import parse

MODES = ["fixed", "ideal", "navigator", "pipelined", "schmelovsky_1988", "gnss_ins"]
small = st.floats(0, 0.2, allow_nan=False)
number = st.floats(allow_nan=False, allow_infinity=False)
latitude, longitude = st.floats(-80, 80), st.floats(-170, 170)
text = st.text(st.characters(exclude_categories=("Cs",)), max_size=30)


@st.composite
def scenarios(draw: Any) -> dict[str, Any]:
    """Scenario data within the limits."""
    lat, lon = draw(latitude), draw(longitude)
    limits = st.fixed_dictionaries({}, optional={"min": st.floats(-1e9, 0), "max": st.floats(0, 1e300)})
    paths = st.sampled_from(["crab.residual_rms_deg", "photos.count", "speed.wall_s"])
    return {
        "name": draw(st.from_regex(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,20}", fullmatch=True)),
        "purpose": draw(text),
        "verifies": draw(st.lists(text, max_size=3)),
        "seed": draw(st.integers(0, 2**53)),
        "terrain": {
            "source": draw(
                st.sampled_from(["pine_mountain", {"orthophoto": "/a: b #.tif", "elevation": "/'\"\\.tif"}])
            ),
            "vertical_datum": draw(st.sampled_from(["file", "egm96", {"undulation_m": 28.3}])),
        },
        "air": {
            "wind": {"speed_m_s": draw(st.floats(0, 50)), "from_deg": draw(st.floats(0, 360))},
            "slow_wind": {"sigma_m_s": draw(small)},
        },
        "flight": {
            "height_m": draw(st.floats(1000, 9000)),
            "lines": [{"start_deg": [lat, lon], "end_deg": [lat + draw(st.floats(0.01, 1)), lon]}],
        },
        "mount": {"faults": draw(st.none() | st.fixed_dictionaries({"encoder_bias_deg": st.floats(-9, 9)}))},
        "control": {"mode": draw(st.sampled_from(MODES))},
        "estimation": {"crab": {"gamma": draw(st.none() | small)}, "subpixel": draw(st.booleans())},
        "ccd_rows": {
            "exposure_s": draw(st.just("auto") | st.floats(1e-6, 0.05)),
            "noise_grey": draw(small),
            "faults": draw(
                st.none() | st.fixed_dictionaries({"dead_px": st.lists(st.integers(0, 95), max_size=3)})
            ),
        },
        "expect": {path: limit for path, limit in draw(st.dictionaries(paths, limits)).items() if limit},
    }


@settings(max_examples=150, deadline=None)
@given(data=scenarios(), comments=st.booleans())
def test_yaml_reloads_to_an_equal_scenario(data: dict[str, Any], comments: bool) -> None:
    scenario = from_mapping(data)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "resolved.yaml"
        file.write_text(to_yaml(scenario, comments=comments), encoding="utf-8")
        again = load(file)
    assert again == scenario
    assert again.model_dump() == scenario.model_dump()


@given(text | number | st.integers() | st.none() | st.booleans())
def test_scalars_read_as_they_were_written(value: Any) -> None:
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= 10**18:
        return  # longer than the reader takes for a whole number
    got = parse(f"[{scalar(value)}]", "x")[0][0]
    assert got == value
    # the other reader agrees on words, even on those that look like something else
    if isinstance(value, str):
        assert YAML(typ="safe", pure=True).load(f"[{scalar(value)}]") == [value]


@pytest.mark.parametrize(
    "word", ["off", "null", "true", "1e-3", "~", ".nan", "0x10", "1:30", "a: b", "# a", "- a", ""]
)
def test_words_that_look_like_values_stay_words(word: str) -> None:
    assert parse(scalar(word), "x")[0] == word


@pytest.mark.parametrize("name", shipped())
def test_shipped_scenarios_are_written_out_in_full(name: str, tmp_path: Path) -> None:
    scenario = load(name)
    text_out = to_yaml(scenario)
    file = tmp_path / "scenario.yaml"
    file.write_text(text_out)
    assert load(file) == scenario
    data, _ = parse(text_out, "x")
    assert data["ccd_rows"]["focal_px"] == 132.6
    assert data["frame_camera"]["min_interval_s"] == 2
    assert data["navigation"] is None
