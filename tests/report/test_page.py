"""report.html: one file, the summary's figures in it, and no crash over what a failed run lacks."""

from __future__ import annotations

import base64
import json
import re
import shutil
from collections.abc import Callable
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerosim.errors import InputError
from aerosim.report.page import write_report
from aerosim.report.plots import thin

# names of XML vocabularies: nothing is fetched from there
NAMESPACES = {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}


class Page(HTMLParser):
    """Text, tags and attributes of a page, and whether every tag was closed in order."""

    VOID = frozenset({"meta", "img", "br"})

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.words: list[str] = []
        self._open: list[str] = []
        self.feed(html)
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in self.VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def html(run_dir: Path) -> str:
    return write_report(run_dir).read_text(encoding="utf-8")


def _change_summary(run: Path, path: str, value: Any) -> None:
    summary = json.loads((run / "summary.json").read_text())
    section = summary
    *parts, last = path.split(".", 1) if not path.startswith("notes.") else ("notes", path[6:])
    for part in parts:
        section = section.setdefault(part, {})
    section[last] = value
    (run / "summary.json").write_text(json.dumps(summary))


def _cut(run: Path, rows: dict[str, int]) -> None:
    for name, count in rows.items():
        file = run / f"{name}.parquet"
        pq.write_table(pq.read_table(file).slice(0, count), file)


def test_one_file_that_needs_nothing_else(html: str, run_dir: Path) -> None:
    assert {*re.findall(r"\w+://[^\s\"'<>]+", html)} <= NAMESPACES
    page = Page(html)
    assert "script" not in page.tags
    assert "link" not in page.tags
    for tag, name, value in page.attributes:
        if name in ("src", "href", "xlink:href"):
            assert value.startswith(("data:", "#")), (tag, name, value[:50])
    assert "@import" not in html
    assert "url(" not in re.sub(r"url\(#[\w-]+\)", "", html)
    assert len(html) < 3_000_000


def test_ids_of_the_plots_point_at_one_thing_each(html: str) -> None:
    # four plots share one page: a clip path of the same name with another shape would cut the wrong curve
    shapes: dict[str, set[str]] = {}
    for name, shape in re.findall(r'<clipPath id="([\w-]+)">\s*(.*?)\s*</clipPath>', html, re.S):
        shapes.setdefault(name, set()).add(shape)
    assert shapes
    assert all(len(found) == 1 for found in shapes.values())
    assert {*re.findall(r"url\(#([\w-]+)\)", html)} <= set(shapes)


def test_figures_of_the_summary_with_units(html: str) -> None:
    text = Page(html).text
    for found in (
        "8.31 deg",
        "0.88 deg",
        "2.50 deg",
        "88.5 %",
        "60.12 %",
        "0.30 px",
        "1.25 m",
        "33.0 x real time",
    ):
        assert found in text
    assert "no neighbouring line overlaps" in text  # the reason of the one null
    assert "Expectations met: 2 of 2" in text
    assert "1.2.3" in text  # of the manifest


def test_purpose_is_text_not_markup(html: str) -> None:
    assert "report <with a bracket & an ampersand>." in Page(html).text
    assert "<with" not in html


def test_four_plots_and_a_map(html: str, run_dir: Path) -> None:
    from PIL import Image

    page = Page(html)
    assert page.tags.count("svg") == 4
    (picture,) = (value for tag, name, value in page.attributes if (tag, name) == ("img", "src"))
    image = Image.open(BytesIO(base64.b64decode(picture.removeprefix("data:image/jpeg;base64,"))))
    assert image.width == 1500
    for label in (
        "drift [deg]",
        "crab [deg]",
        "v/h [mrad/s]",
        "end lap [%]",
        "tilt [deg]",
        "blur [px]",
        "time [s]",
    ):
        assert label in page.text
    verdicts = pq.read_table(run_dir / "photos.parquet")["verdict"].to_pylist()
    assert f"ok {verdicts.count('ok')}, end_lap {verdicts.count('end_lap')}." in page.text
    for reason in ("accepted", "border_mu", "ambiguous", "degenerate", "timeout"):
        count = pq.read_table(run_dir / "matches.parquet")["reason"].to_pylist().count(reason)
        assert count
        assert f"{reason} ({count})" in page.text


def test_unmet_expectation(fresh_run: Callable[[], Path]) -> None:
    run = fresh_run()
    _change_summary(run, "crab.residual_rms_deg", 3.0)
    text = Page(write_report(run).read_text()).text
    assert "Expectations not met: 1 of 2" in text
    assert "crab.residual_rms_deg is 3, above max 2.1" in text


def test_failed_run_with_little_in_it(fresh_run: Callable[[], Path]) -> None:
    run = fresh_run()
    _change_summary(run, "status", "failed")
    _change_summary(run, "notes.status", "the aircraft was lost: roll of 95 deg")
    for section in ("crab", "vh", "photos"):
        _change_summary(run, section, {})
    (run / "manifest.json").unlink()
    _cut(run, {"telemetry": 40, "matches": 0, "photos": 0})
    text = Page(write_report(run).read_text()).text
    assert "did not end as planned: failed" in text
    assert "the aircraft was lost: roll of 95 deg" in text
    assert text.count("Nothing was recorded to draw here.") == 2  # photos, strips
    assert "was not measured" in text


@pytest.mark.parametrize("rows", [0, 1])
def test_next_to_no_telemetry(fresh_run: Callable[[], Path], rows: int) -> None:
    run = fresh_run()
    _cut(run, {"telemetry": rows, "matches": 0, "photos": 0})
    assert Page(write_report(run).read_text()).text.count("Nothing was recorded to draw here.") == 4


def test_no_accepted_strip_and_no_end_lap(fresh_run: Callable[[], Path]) -> None:
    run = fresh_run()
    strips = pq.read_table(run / "matches.parquet")
    kept = strips.filter(np.logical_not(strips["accepted"].to_numpy(zero_copy_only=False)))
    pq.write_table(kept, run / "matches.parquet")
    _cut(run, {"photos": 1})
    page = Page(write_report(run).read_text())
    assert page.tags.count("svg") == 4


def test_tables_that_are_not_there_and_land_that_is_gone(fresh_run: Callable[[], Path]) -> None:
    run = fresh_run()
    (run / "photos.parquet").unlink()
    (run / "matches.parquet").write_bytes(b"cut short")
    (run / "orthophoto.tif").unlink()
    text = Page(write_report(run).read_text()).text
    assert "photos.parquet cannot be read" in text
    assert "matches.parquet cannot be read" in text
    assert "The land is not shown" in text


def test_not_a_run(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no run directory"):
        write_report(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_same_run_gives_the_same_report(run_dir: Path, html: str, tmp_path: Path) -> None:
    # the terrain's paths are absolute, so the copy draws the same land
    copy = tmp_path / "copy"
    shutil.copytree(run_dir, copy)
    assert write_report(copy).read_text(encoding="utf-8") == html


@given(
    arrays(float, st.integers(1, 700), elements=st.floats(-1e6, 1e6) | st.just(np.nan)),
    st.integers(20, 200),
)
def test_thinning_keeps_the_peaks(y: np.ndarray, most: int) -> None:
    t = np.arange(len(y), dtype=float)
    kept_t, kept_y = thin(t, y, most)
    assert (np.diff(kept_t) > 0).all()
    np.testing.assert_array_equal(kept_y, y[kept_t.astype(int)])
    # a piece holds at least 2 n / most samples, two of which stay, and the last sample
    assert len(kept_t) <= max(most + 1, 2 * most)
    size = -(-2 * len(y) // most)
    whole = y[: len(y) // size * size] if size >= 4 else y
    if np.isfinite(whole).any():
        assert np.nanmax(kept_y) >= np.nanmax(whole)
        assert np.nanmin(kept_y) <= np.nanmin(whole)
