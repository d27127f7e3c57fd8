"""The sections about causes and consistency: what they say of a summary, and of one that lacks them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from aerosim.report.page import write_report
from aerosim.report.residual import causes, consistency

CRAB = {"fast_yaw": 0.3, "lag": 0.8, "noise": 0.6, "convergence": 0.0, "mount": 0.0, "rest": -0.3}
VH = {"fast_speed": 0.0, "lag": 0.0, "relief": 3.0, "noise": 4.0, "convergence": 0.0, "rest": 0.0}
FOUND = {"strips": 240, "mean": 0.1, "variance": 2.5, "variance_min": 0.8, "variance_max": 1.25, "lag1": 0.4}


def summary(**changes: Any) -> dict[str, Any]:
    return {
        "crab": {"residual_rms_deg": 1.0, "split_deg": CRAB},
        "vh": {"error_rms_pct": 5.0, "split_pct": VH},
        "consistency": {"drift": FOUND | {"verdict": "over-confident"}, "vh": FOUND | {"verdict": "consistent"}},
        **changes,
    }


def text(html: str) -> str:
    return " ".join(re.sub(r"<[^>]+>", " ", html).split())


def cells(html: str, cause: str) -> list[str]:
    """Texts of the cells in the row of a cause."""
    row = next(row for row in re.findall(r"<tr>(.*?)</tr>", html) if f"<td>{cause}</td>" in row)
    return [text(cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]


def test_each_part_with_its_share_of_the_mean_square() -> None:
    html = causes(summary())
    assert cells(html, "Faster than a strip")[1:7] == ["0.300", "9", "", "0.00", "0", ""]
    assert cells(html, "Lag")[1:7] == ["0.800", "64", "", "0.00", "0", ""]
    assert cells(html, "Relief")[1:7] == ["", "", "", "3.00", "36", ""]
    assert cells(html, "Noise")[1:7] == ["0.600", "36", "", "4.00", "64", ""]
    assert cells(html, "Rest")[1:7] == ["-0.300", "-9", "", "0.00", "0", ""]
    assert '<div style="width:64.0%">' in html
    assert '<div class="against" style="width:9.0%">' in html


def test_the_largest_causes_are_said() -> None:
    assert "the crab is 64 % lag, 36 % noise; the v/h error is 64 % noise, 36 % relief." in text(causes(summary()))


def test_parts_that_are_not_known_are_dashes_with_their_reason() -> None:
    parts = CRAB | {"lag": None, "noise": None, "convergence": None}
    notes = {"crab.split_deg.lag": "another filter <that>", "crab.split_deg.noise": "another filter <that>"}
    html = causes(summary(crab={"residual_rms_deg": 1.0, "split_deg": parts}, notes=notes))
    assert cells(html, "Lag")[1:3] == ["–", "–"]
    assert html.count("Another filter &lt;that&gt;.") == 1
    bare = causes(summary(crab={"residual_rms_deg": None, "split_deg": dict.fromkeys(CRAB)}))
    assert cells(bare, "Mount")[1:3] == ["–", "–"]


def test_verdicts_with_bounds() -> None:
    html = text(consistency(summary()))
    assert "Drift 240 0.10 2.50 (0.80 to 1.25) 0.40 over-confident : the errors are larger" in html
    assert "consistent : the errors are as large as the filter believes" in html
    none = dict.fromkeys(FOUND) | {"strips": 3, "verdict": None}
    notes = {"consistency.vh.verdict": "too few strips"}
    assert "v/h too few strips" in text(consistency(summary(consistency={"vh": none}, notes=notes)))


def test_a_summary_without_them_has_no_such_sections() -> None:
    assert causes({}) == consistency({}) == causes({"crab": {"residual_rms_deg": 1.0}, "vh": None}) == ""


def test_on_the_page(fresh_run: Callable[[], Path]) -> None:
    run = fresh_run()
    found = json.loads((run / "summary.json").read_text())
    (run / "summary.json").write_text(json.dumps(found | summary()))
    # a strip that was refused for a reason that this module has never heard of
    strips = pq.read_table(run / "matches.parquet")
    reasons = ["unheard_of" if reason == "ambiguous" else reason for reason in strips["reason"].to_pylist()]
    count = reasons.count("unheard_of")
    assert count
    at = strips.column_names.index("reason")
    pq.write_table(strips.set_column(at, "reason", pa.array(reasons)), run / "matches.parquet")
    html = write_report(run).read_text()
    assert f"unheard_of ({count})" in html
    assert "Where the residual comes from" in html
    verdict = html[html.index('class="verdict') : html.index('class="tiles"')]
    assert "the drift filter is over-confident: its innovations have 2.5 times the variance" in verdict
