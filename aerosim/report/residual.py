"""Sections of report.html about what is left: its causes, and whether the filters know how large it is."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from aerosim.metrics.consistency import MEANING

CSS = """
table.parts td { vertical-align: middle; } td.bar { width: 9rem; padding-right: 1.6rem; }
td.bar div { height: .8rem; background: #0072B2; print-color-adjust: exact; }
td.bar div.against { background: #D55E00; }
"""

# parts of the crab and of v/h by their keys, what a reader calls them, what they are
ROWS = (
    ("fast_yaw", "fast_speed", "Faster than a strip", "yaw and speed that change within the time a strip takes"),
    ("lag", "lag", "Lag", "strips tell the mean of the past, and the filter mixes older ones in"),
    (None, "relief", "Relief", "height of the ground about its mean on the line, now and in the strips"),
    ("noise", "noise", "Noise", "what strips read wrong: roll, pitch, grey noise, wrong minima"),
    ("convergence", "convergence", "Convergence", "error of a line's first strip while it weighs; all before it"),
    ("mount", None, "Mount", "estimate less mount yaw: its delay, lag, limits; all drift if it stands"),
    ("rest", "rest", "Rest", "what the squares above leave of the whole: parts that go together, other filters"),
)  # fmt: skip
Values = Mapping[str, Any]


def _share(value: Any, whole: Any) -> float | None:
    """Share of the mean square, %; value: rms with the sign of its square."""
    if not isinstance(value, (int, float)) or not isinstance(whole, (int, float)) or not whole > 0.0:
        return None
    return 100.0 * value * abs(value) / whole**2


def _cells(values: Values, key: str | None, whole: Any, digits: int) -> str:
    """Root mean square, share and bar of one part."""
    if key is None:
        return '<td class="n"></td><td class="n"></td><td class="bar"></td>'
    value = values.get(key)
    share = _share(value, whole)
    if share is None:
        shown = f"{value:.{digits}f}" if isinstance(value, (int, float)) else "–"
        return f'<td class="n">{shown}</td><td class="n">–</td><td class="bar"></td>'
    kind = ' class="against"' if share < 0.0 else ""
    bar = f'<div{kind} style="width:{min(abs(share), 100.0):.1f}%"></div>'
    return f'<td class="n">{value:.{digits}f}</td><td class="n">{share:.0f}</td><td class="bar">{bar}</td>'


def _whole(rms: Any, digits: int) -> str:
    """Cells of the last row: the measured root mean square."""
    shown = f"{rms:.{digits}f}" if isinstance(rms, (int, float)) else "–"
    return f'<td class="n"><b>{shown}</b></td><td class="n">100</td><td></td>'


def _largest(values: Values, whole: Any) -> str:
    """The one or two parts that make most of an error, in words; empty if nothing was split."""
    names = {key: name.lower() for crab, vh, name, _ in ROWS for key in (crab, vh) if key not in (None, "rest")}
    found = sorted(((_share(values.get(key), whole) or 0.0, name) for key, name in names.items()), reverse=True)
    said = [f"{share:.0f} % {name}" for share, name in dict.fromkeys(found) if share >= 10.0][:3]
    return ", ".join(said)


def causes(summary: Values) -> str:
    """The section about the causes of crab and v/h error; empty for a summary without them."""
    crab, vh = summary.get("crab") or {}, summary.get("vh") or {}
    of_crab, of_vh = crab.get("split_deg") or {}, vh.get("split_pct") or {}
    if not of_crab and not of_vh:
        return ""
    crab_rms, vh_rms = crab.get("residual_rms_deg"), vh.get("error_rms_pct")
    rows = "".join(
        f"<tr><td>{name}</td>{_cells(of_crab, crab_key, crab_rms, 3)}{_cells(of_vh, vh_key, vh_rms, 2)}"
        f'<td class="why">{escape(meaning)}</td></tr>'
        for crab_key, vh_key, name, meaning in ROWS
    )
    rows += f"<tr><td><b>All</b></td>{_whole(crab_rms, 3)}{_whole(vh_rms, 2)}<td></td></tr>"
    head = (
        '<tr><th>Cause</th><th class="n">Crab, deg</th><th class="n">%</th><th></th>'
        '<th class="n">v/h, %</th><th class="n">%</th><th></th><th>What it is</th></tr>'
    )
    spoken = [
        f"{what} is {said}"
        for what, said in (("the crab", _largest(of_crab, crab_rms)), ("the v/h error", _largest(of_vh, vh_rms)))
        if said
    ]
    sentence = f"Of its mean square, {'; '.join(spoken)}. " if spoken else ""
    notes = summary.get("notes") or {}
    reasons = {
        str(notes[path])
        for path in (*(f"crab.split_deg.{k}" for k in of_crab), *(f"vh.split_pct.{k}" for k in of_vh))
        if path in notes
    }
    why = "".join(f" {escape(reason[:1].upper() + reason[1:])}." for reason in sorted(reasons))
    return (
        f'<h2>Where the residual comes from</h2><p class="note">{sentence}Root mean square of each part, and its '
        "share of the whole mean square; the shares add up to 100 %, rest may be negative (the other way)."
        f'{why}</p><table class="parts"><thead>{head}</thead><tbody>{rows}</tbody></table>'
    )


def consistency(summary: Values) -> str:
    """The section about the filters' innovations; empty for a summary without it."""
    found = summary.get("consistency") or {}
    if not found:
        return ""
    notes = summary.get("notes") or {}
    names = {"drift": "Drift", "vh": "v/h"}
    rows = []
    for name, each in found.items():
        verdict = (each or {}).get("verdict")
        if verdict is None:
            reason = notes.get(f"consistency.{name}.verdict") or "not judged"
            rows.append(
                f'<tr><td>{names.get(name, name)}</td><td class="why" colspan="5">{escape(reason)}</td></tr>'
            )
            continue
        bounds = f"{each['variance_min']:.2f} to {each['variance_max']:.2f}"
        rows.append(
            f'<tr><td>{names.get(name, name)}</td><td class="n">{each["strips"]}</td>'
            f'<td class="n">{each["mean"]:.2f}</td><td class="n">{each["variance"]:.2f} ({bounds})</td>'
            f'<td class="n">{each["lag1"]:.2f}</td><td><b>{escape(verdict)}</b>: '
            f"{escape(MEANING.get(verdict, ''))}</td></tr>"
        )
    head = (
        '<tr><th>Filter</th><th class="n">Strips</th><th class="n">Mean</th><th class="n">Variance (wanted)</th>'
        '<th class="n">To the next</th><th>Verdict</th></tr>'
    )
    return (
        "<h2>Do the filters know how wrong they are?</h2>"
        '<p class="note">Innovations (strip less prediction) over the standard deviation that the filter expects: '
        "of mean 0, variance 1 and uncorrelated from strip to strip, if it is right about its errors.</p>"
        f"<table><thead>{head}</thead><tbody>{''.join(rows)}</tbody></table>"
    )
