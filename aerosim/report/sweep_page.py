"""report.html of a sweep: one file, without scripts and without links to anywhere."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any

from aerosim.report.page import CSS
from aerosim.report.sweep_view import MetricView, SweepView, axis, is_number, limits, told, with_limits, word

ROWS_MOST = 80  # of a table in the page; more are in runs.parquet
MORE_CSS = """
h3 { font-size: 1.02rem; margin: 1.4rem 0 .3rem; } td.bad { color: #A34700; } details { margin: .6rem 0 1rem; }
caption { text-align: left; color: #555; font-size: .9rem; padding-bottom: .3rem; }
.wide { overflow-x: auto; }
"""


def _verdict(view: SweepView) -> str:
    """How it ended, in words and colour."""
    done = view.runs - view.failed
    kind = "met" if not view.failed and view.runs == view.planned else "unmet" if not done else "none"
    head = f"{done} of {view.planned} runs done" + (f", {view.failed} failed" if view.failed else "")
    lines = [view.status] if view.status else []
    body = "".join(f"<p>{escape(line)}</p>" for line in lines)
    return f'<div class="verdict {kind}" role="status"><b>{head}</b>{body}</div>'


def _tiles(view: SweepView) -> str:
    hours = view.wall_s / 3600.0
    time = f"{hours:.1f} h" if hours >= 1.0 else f"{view.wall_s / 60.0:.1f} min"
    facts = (
        (f"{view.points}", "points"),
        (f"{view.seeds}", "seeds at each"),
        (f"{view.runs}", "runs ended"),
        (f"{view.failed}", "of them failed"),
        (time, "all runs together"),
    )
    return '<div class="tiles">' + "".join(f"<div><b>{a}</b><span>{b}</span></div>" for a, b in facts) + "</div>"


def _cell(tag: str, text: str, number: bool) -> str:
    kind = ' class="n"' if number else ""
    return f"<{tag}{kind}>{escape(text)}</{tag}>"


def _table(head: Sequence[tuple[str, bool]], rows: Sequence[Sequence[str]], caption: str = "") -> str:
    """An HTML table.  head: title and whether its column holds numbers; cells are escaped here."""
    names = "".join(_cell("th", title, number) for title, number in head)
    body = "".join(
        "<tr>" + "".join(_cell("td", cell, number) for cell, (_, number) in zip(row, head, strict=True)) + "</tr>"
        for row in rows[:ROWS_MOST]
    )
    if len(rows) > ROWS_MOST:
        caption += f" The first {ROWS_MOST} of {len(rows)}; the others are in runs.parquet."
    above = f"<caption>{escape(caption.strip())}</caption>" if caption.strip() else ""
    content = f"{above}<thead><tr>{names}</tr></thead><tbody>{body}</tbody>"
    return f'<div class="wide"><table>{content}</table></div>'


def _varied(view: SweepView) -> str:
    """What was varied, and how."""
    rows = []
    for key, values in view.varied.items():
        numbers = all(is_number(value) for value in values)
        if numbers and len(values) > 12:
            text = f"{len(values)} values, {told(key, min(values))} to {told(key, max(values))}"
        else:
            text = ", ".join(told("", value) for value in values)
        rows.append((key, axis(key), text))
    how = "All combinations." if view.grid else "A sample, not all combinations."
    note = (
        f'<p class="note">{how} The same {view.seeds} seeds at every point: the points differ by what is varied '
        "and fly in the same air, so that differences are paired.</p>"
    )
    return f"<h2>What was varied</h2>{note}" + _table(
        (("Key", False), ("In words", False), ("Values", False)), rows
    )


def _failures(view: SweepView) -> str:
    if not view.reasons:
        return ""
    rows = [(reason, str(count), where) for reason, count, where in view.reasons]
    note = (
        '<p class="note">A run that failed has no figures. Its seed is left out where it failed, and wherever it '
        "would have been compared or averaged with others; how often is told beside each figure.</p>"
    )
    head = (("Reason", False), ("Runs", True), ("Where", False))
    return f"<h2>Failed runs</h2>{note}" + _table(head, rows)


def _left_out(missing: int, failed: int) -> str:
    parts = [f"{failed} failed"] if failed else []
    parts += [f"{missing} without value"] if missing else []
    return ", ".join(parts)


def _figure(content: str, label: str, caption: str) -> str:
    content = content.replace("<svg ", f'<svg role="img" aria-label="{escape(label)}" ', 1)
    return f"<figure>{content}<figcaption>{escape(caption)}</figcaption></figure>"


def _means(view: SweepView, metric: MetricView) -> str:
    keys = list(view.varied)
    head = [
        *((axis(key), is_number(view.varied[key][0])) for key in keys),
        (f"mean [{metric.figure.unit}]" if metric.figure.unit else "mean", True),
        ("seeds", True),
        ("left out", False),
    ]
    rows = [
        [
            *(told("", m.values[key]) for key in keys),
            limits(metric.figure, m),
            str(m.seeds),
            _left_out(m.missing, m.failed),
        ]
        for m in metric.means
    ]
    return f"<details><summary>Means at all points</summary>{_table(head, rows)}</details>"


def _pairs(view: SweepView, metric: MetricView) -> str:
    """Paired differences, over all points together and at each."""
    if not metric.pairs:
        return ""
    keys = list(dict.fromkeys(key for pair in metric.pairs for d in pair.differences for key in d.values))
    unit = f" [{metric.figure.unit}]" if metric.figure.unit else ""
    head = [
        (word(view.compared), False), *((axis(key), True) for key in keys), (f"difference{unit}", True),
        ("standard error", True), ("unpaired", True), ("seeds", True), ("left out", False),
    ]  # fmt: skip
    rows = []
    for pair in metric.pairs:
        name = f"{told('', pair.a)} less {told('', pair.b)}"
        every = [pair.overall] if not keys else [pair.overall, *pair.differences]
        for d in every:
            where = [told("", d.values[key]) if key in d.values else "all" for key in keys]
            errors = [f"{e:.2g}" if e == e else "–" for e in (d.standard_error, d.unpaired_standard_error)]  # noqa: PLR0124
            text = with_limits(d.mean, d.half_width, metric.figure.digits)
            rows.append([name, *where, text, *errors, str(d.seeds), _left_out(d.missing, d.failed)])
    caption = "Unpaired: what the standard error of the same runs would be without common seeds."
    return f"<details><summary>Paired differences in numbers</summary>{_table(head, rows, caption)}</details>"


def _metric(view: SweepView, metric: MetricView) -> Iterator[str]:
    from aerosim.report import sweep_plots as plots

    figure, percent = metric.figure, f"{100.0 * view.level:g} %"
    meaning = f" {figure.meaning[0].upper()}{figure.meaning[1:]}." if figure.meaning else ""
    yield f'<h2>{escape(figure.name)}</h2><p class="note"><code>{escape(figure.path)}</code>.{escape(meaning)}</p>'
    for note in metric.notes:
        yield f'<p class="note">{escape(note)}</p>'
    if all(m.mean != m.mean for m in metric.means):
        yield '<p class="note">No run has a value of this.</p>'
        return
    rest = (
        f" Averaged over {', '.join(word(key) for key in view.axes.rest)}." if view.axes.rest and view.grid else ""
    )
    crosses = " Crosses: seeds that failed there." if any(m.failed for m in metric.means) else ""
    caption = f"Means over the seeds with {percent} confidence limits.{rest}{crosses}"
    draw: Callable[[], str] = (
        (lambda: plots.over_parameter(metric, view.varied, view.axes))
        if view.grid
        else (lambda: plots.cloud(metric, view.varied))
    )
    yield _figure(draw(), f"{figure.name} over what was varied", caption)
    if metric.pairs:
        caption = f"Paired differences over common seeds with {percent} confidence limits.{rest}"
        content = plots.differences(metric, view.varied, view.axes, view.compared)
        yield "<h3>Differences</h3>" + _figure(content, f"Differences of {figure.name}", caption)
    if any(e.effect == e.effect for e in metric.effects):
        kind = (
            "Mean over all points with a value less the mean over all points"
            if view.grid
            else "Change over a key's whole range in a linear fit; a value of a word less the mean of all"
        )
        content = plots.main_effects(metric)
        yield "<h3>Main effects</h3>" + _figure(content, f"Main effects on {figure.name}", f"{kind}; {percent}.")
    yield _means(view, metric)
    yield _pairs(view, metric)


def _others(view: SweepView) -> str:
    """Least and greatest mean of the figures that have no section of their own."""
    rows = []
    for metric in view.others:
        known = [m for m in metric.means if m.mean == m.mean]
        if known:
            low, high = min(known, key=lambda m: m.mean), max(known, key=lambda m: m.mean)
            names = (metric.figure.name, metric.figure.unit)
            texts = [limits(metric.figure, m) for m in (low, high)]
            rows.append((*names, texts[0], _at(low.values), texts[1], _at(high.values)))
    if not rows:
        return ""
    head = (
        ("Figure", False), ("", False), ("Least mean", True), ("at", False), ("Greatest mean", True), ("at", False)
    )  # fmt: skip
    return "<h2>Other figures</h2>" + _table(head, rows)


def _at(values: dict[str, Any]) -> str:
    return ", ".join(f"{word(key)} {told(key, value)}" for key, value in values.items())


def sweep_page(view: SweepView) -> str:
    """The report as HTML text."""
    name, purpose = escape(view.name), escape(view.purpose)
    body = [
        _verdict(view),
        _tiles(view),
        _varied(view),
        _failures(view),
        *(part for metric in view.metrics for part in _metric(view, metric)),
        _others(view),
        f"<h2>How it was made</h2><details><summary>sweep.yaml</summary><pre>{escape(view.text)}</pre></details>",
    ]
    head = (
        f'<meta charset="utf-8"><title>{name}: aerosim sweep</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{CSS}{MORE_CSS}</style>"
    )
    body.insert(0, f'<h1>{name}: sweep</h1><p class="purpose">{purpose}</p>')
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>' + "\n".join(body) + "</body></html>\n"


def write_sweep_page(view: SweepView, file: Path) -> Path:
    """Write the report of a sweep, whole or not at all.  Returns its path.  Raises OSError."""
    part = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        part.write_text(sweep_page(view), encoding="utf-8")
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
    return file
