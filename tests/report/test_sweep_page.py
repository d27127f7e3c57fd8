"""A sweep's report: its numbers are the table's, what failed is told, nothing is fetched."""

from __future__ import annotations

import re
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from sweep_tables import directory, noise

from aerosim.errors import InputError
from aerosim.report.sweep_view import axis, told, with_limits, word
from aerosim.sweep.reporting import axes_of, write_report
from aerosim.sweep.stats import means, paired
from aerosim.sweep.vary import Range

WIND, ROUGH, MODE = "air.wind.speed_m_s", "air.turbulence.sigma_m_s", "control.mode"
CRAB, VH, LAP = "crab.residual_rms_deg", "vh.error_rms_pct", "photos.end_lap_error_rms_pct"
MODES = ("fixed", "schmelovsky_1988", "pipelined")
LOST = {(n, s): f"aircraft lost after {10.5 * s} s" for n in (15, 16, 17) for s in (2, 5)}


def crab(point: Mapping[str, Any], seed: int) -> float:
    size = {"fixed": 0.7, "schmelovsky_1988": 0.1, "pipelined": 0.03}[point.get(MODE, "pipelined")]
    own = zlib.crc32(repr(sorted(point.items())).encode())
    rough = 0.5 * point.get(ROUGH, 0.0)
    return 1.0 + size * point.get(WIND, 10) + rough + 0.2 * noise("air", seed) + 0.02 * noise("own", seed, own)


def vh(point: Mapping[str, Any], seed: int) -> float | None:
    return None if point.get(MODE) == "fixed" else 0.3 + 0.02 * noise("vh", seed)


METRICS = {
    CRAB: crab,
    VH: vh,
    LAP: lambda point, seed: 1.0 + crab(point, seed) / 3.0,
    "photos.out_of_tolerance": lambda point, seed: int(2.0 * crab(point, seed)),
    "flight.roll_rms_deg": lambda point, seed: 0.2 + 0.1 * noise("roll", seed),
}


def text_of(html: str) -> str:
    return " ".join(re.sub(r"<[^>]*>", " ", re.sub(r"<(style|svg).*?</\1>", " ", html, flags=re.S)).split())


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished sweep: three winds, two turbulences, three modes, six seeds, some of them lost."""
    out = tmp_path_factory.mktemp("sweep") / "with blanks"
    directory(out, {WIND: (0, 10, 20), ROUGH: (0, 0.7), MODE: MODES}, 6, METRICS, LOST)
    return out


@pytest.fixture(scope="module")
def html(swept: Path) -> str:
    return write_report(swept, status="Done.").read_text(encoding="utf-8")


def test_one_file_without_scripts_or_links(html: str, swept: Path) -> None:
    assert "<script" not in html.lower()
    assert not re.search(r"(src|href)\s*=\s*[\"'](?!#|data:)", html.replace("xlink:href", "href"))
    assert "url(http" not in html
    assert {file.name for file in swept.iterdir()} == {"sweep.yaml", "runs.parquet", "report.html"}


def test_what_was_varied_and_what_became_of_it(html: str) -> None:
    text = text_of(html)
    assert "102 of 108 runs done, 6 failed" in text
    assert "Done." in text
    assert "18 points" in text
    for words in (f"{WIND} wind speed [m/s] 0, 10, 20", f"{MODE} control mode fixed, schmelovsky_1988, pipelined"):
        assert words in text
    assert "Made up &lt;here&gt; &amp; now." in html


def test_failed_runs_are_told_by_reason(html: str) -> None:
    """Six runs with one reason, whose times differ, and the values at which they failed."""
    row = "aircraft lost after 21.0 s (with other numbers in other runs) 6 wind speed 20 m/s; "
    assert row + "turbulence sigma 0.7 m/s; control mode fixed, schmelovsky_1988, pipelined" in text_of(html)
    assert html.count("2 failed") > 6  # in the plots and in the tables


def test_numbers_are_those_of_the_statistics(html: str, swept: Path) -> None:
    table, keys = pq.read_table(swept / "runs.parquet"), (WIND, ROUGH, MODE)
    text = text_of(html)
    for m in means(table, CRAB, keys):
        shown = with_limits(m.mean, m.half_width, 2)
        left = " 2 failed" if m.failed else ""
        assert f"{m.values[WIND]} {m.values[ROUGH]:g} {m.values[MODE]} {shown} {m.seeds}{left}" in text
    for d in paired(table, CRAB, MODE, "pipelined", "schmelovsky_1988", keys):
        shown = with_limits(d.mean, d.half_width, 2)
        where = f"{d.values[WIND]} {d.values[ROUGH]:g}"
        assert f"pipelined less schmelovsky_1988 {where} {shown} {d.standard_error:.2g}" in text
    low = min(means(table, "flight.roll_rms_deg", keys), key=lambda m: m.mean)
    assert f"Roll, rms deg {with_limits(low.mean, low.half_width, 2)}" in text


def test_what_has_no_value_is_said(html: str) -> None:
    section = html[html.index("<h2>v/h") : html.index("<h2>End lap")]
    text = text_of(section)
    assert "Main effects without control mode fixed: no value there." in text
    assert "0 0 fixed – 0 6 without value" in text


def test_plots_draw_the_means(html: str, swept: Path) -> None:
    """Markers of the first plot stand where the means are: heights on the page are linear in them."""
    section = html[html.index("<h2>Crab, rms") :]
    svg = section[section.index("<svg") : section.index("</svg>")]
    assert svg.count("fill-opacity: 0.18") >= 6  # a band for each mode in each panel
    panel = svg[svg.index('id="axes_1"') : svg.index('id="axes_2"')]
    heights = [float(y) for y in re.findall(r'<use [^>]*y="([\d.]+)"[^>]*stroke: #0072b2', panel, re.I)][:3]
    table = pq.read_table(swept / "runs.parquet")
    fixed = [
        m.mean
        for m in means(table, CRAB, (WIND, ROUGH, MODE))
        if m.values[ROUGH] == 0 and m.values[MODE] == "fixed"
    ]
    assert len(heights) == 3
    slope = np.diff(heights) / np.diff(fixed)
    assert slope[0] == pytest.approx(slope[1], rel=1e-3)
    assert slope[0] < 0.0  # upwards on the page


def test_every_part_has_its_label(html: str) -> None:
    for words in (
        "wind speed [m/s]",
        "crab, rms [deg]",
        "turbulence sigma 0.7 m/s",
        "pipelined less schmelovsky_1988",
    ):
        assert words in html
    assert html.count("<figure>") == html.count("<figcaption>") == html.count('role="img" aria-label=') == 11


@pytest.mark.parametrize(
    ("vary", "settings", "words"),
    [
        ({MODE: MODES}, {}, "schmelovsky_1988 less fixed"),
        ({WIND: tuple(range(0, 20, 2))}, {}, "2 m/s less 0 m/s"),
        (
            {WIND: Range(0, 20), ROUGH: Range(0, 1.5)},
            {"sampling": "latin_hypercube", "samples": 12},
            "over the whole",
        ),
        ({WIND: (0, 5, 9), MODE: MODES}, {"sampling": "list"}, "A sample, not all combinations."),
        ({WIND: (5,)}, {}, "Means at all points"),
        ({"air.gusts": ([], [{"start_s": 5, "duration_s": 3, "down_m_s": 2}])}, {}, "air gusts"),
        ({WIND: (0, 9), ROUGH: (0, 1), "flight.height_m": (2500, 3000), MODE: MODES[1:]}, {}, "flight height"),
    ],
)
def test_sweeps_of_all_kinds(tmp_path: Path, vary: dict[str, Any], settings: dict[str, Any], words: str) -> None:
    spec = directory(tmp_path, vary, 3, {CRAB: crab}, {(0, 2): "lost"}, **settings)
    text = write_report(tmp_path, spec).read_text(encoding="utf-8")
    assert words in text
    assert "1 failed" in text


def test_one_seed_and_nothing_done(tmp_path: Path) -> None:
    directory(tmp_path / "one", {MODE: MODES}, 1, METRICS)
    assert "(one seed)" in write_report(tmp_path / "one").read_text(encoding="utf-8")
    dead = {(n, s): "no way" for n in range(3) for s in (1, 2)}
    directory(tmp_path / "dead", {MODE: MODES}, 2, METRICS, dead)
    text = text_of(write_report(tmp_path / "dead").read_text(encoding="utf-8"))
    assert "0 of 6 runs done, 6 failed" in text
    assert "no way" in text


def test_what_does_not_differ_is_said_instead_of_drawn(tmp_path: Path) -> None:
    """Of a metric that sees none of the keys."""
    metrics = {CRAB: lambda point, seed: 1.0 + 0.1 * noise("air", seed), VH: vh}
    directory(tmp_path, {MODE: MODES[1:], "control.fmc": (True, False)}, 2, metrics)
    html = write_report(tmp_path).read_text(encoding="utf-8")
    section = html[html.index("<h2>Crab") : html.index("<h2>v/h")]
    assert "None: false less true is 0 at every seed." in text_of(section)
    assert section.count("<figure>") == 1  # the means; neither differences nor effects


def test_differences_over_words_stand_beside_each_other(tmp_path: Path) -> None:
    directory(tmp_path, {MODE: MODES, "estimation.vh.gamma": (None, 0.05)}, 3, {CRAB: crab})
    html = write_report(tmp_path).read_text(encoding="utf-8")
    section = html[html.index("<h3>Differences") : html.index("<h3>Main effects")]
    assert "0.05 less null" in section
    heads = re.findall(r">\s*(fixed|schmelovsky_1988|pipelined)\s*<", section)
    assert heads == list(MODES)


def test_one_point_is_a_table(tmp_path: Path) -> None:
    directory(tmp_path, {WIND: (5,)}, 3, METRICS)
    html = write_report(tmp_path).read_text(encoding="utf-8")
    assert "<figure>" not in html
    assert "Least mean" not in html
    assert "1 point 3 seeds at each" in text_of(html)


def test_it_says_how_it_is_read(html: str, tmp_path: Path) -> None:
    assert all(f"<dt>{term}</dt>" in html for term in ("Mean and band", "Paired difference", "Main effect"))
    directory(tmp_path, {WIND: Range(0, 20)}, 2, METRICS, sampling="latin_hypercube", samples=4)
    sample = write_report(tmp_path).read_text(encoding="utf-8")
    assert "<dt>Paired difference</dt>" not in sample
    assert "differences are paired" not in sample


def test_a_failed_point_leaves_no_value_of_its_own(tmp_path: Path) -> None:
    """One point that always fails: dashes and its count, no main effects, and the others as they are."""
    directory(tmp_path, {WIND: (0, 10), MODE: MODES}, 3, METRICS, {(5, s): "lost" for s in (1, 2, 3)})
    text = text_of(write_report(tmp_path).read_text(encoding="utf-8"))
    assert "10 pipelined – 0 3 failed" in text
    assert "Main effects are not known: no seed has a value at all points." in text


def test_no_sweep(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is no sweep"):
        write_report(tmp_path)


def test_axes_are_chosen_by_kind() -> None:
    assert axes_of({MODE: MODES, WIND: (0, 1)})[:3] == (WIND, MODE, "")
    assert axes_of({WIND: (0, 1), ROUGH: (0, 1, 2)})[:3] == (ROUGH, WIND, "")
    assert axes_of({WIND: range(20), ROUGH: range(9), MODE: MODES}) == (WIND, MODE, "", (ROUGH,))
    assert axes_of({MODE: MODES})[:2] == (MODE, "")


def test_words() -> None:
    assert word("air.turbulence.sigma_m_s") == "turbulence sigma"
    assert axis("flight.bank_max_deg") == "flight bank max [deg]"
    assert told(WIND, 10) == "10 m/s"
    assert told(WIND, 0.1817041234) == "0.1817 m/s"
    assert told(ROUGH, 0.35) == "0.35 m/s"
    assert [told("", value) for value in (None, True, False)] == ["null", "true", "false"]
    assert with_limits(1.23456, 0.0123, 2) == "1.235 ± 0.012"
    assert with_limits(123.456, 12.3, 2) == "123 ± 12"
    assert with_limits(float("nan"), float("nan"), 2) == "–"
    assert with_limits(1.5, float("nan"), 2) == "1.50 (one seed)"
    assert with_limits(3.0, 0.0, 0) == "3"
