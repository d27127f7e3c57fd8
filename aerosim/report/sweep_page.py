"""report.html of a sweep: one file, without scripts and without links to anywhere."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any

from aerosim.report.page import CSS
from aerosim.report.sweep_view import MetricView, SweepView, axis, is_number, less, limits, told, with_limits, word

ROWS_MOST = 80  # of a table in the page; more are in runs.parquet
MORE_CSS = """
h3 { font-size: 1.02rem; margin: 1.4rem 0 .3rem; } td.bad { color: #A34700; } details { margin: .6rem 0 1rem; }
caption { text-align: left; color: #555; font-size: .9rem; padding-bottom: .3rem; }
.wide { overflow-x: auto; } .wide td:first-child { white-space: nowrap; } dt { font-weight: 600; }
dd { margin: 0 0 .5rem; }
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
    hours, minutes = view.wall_s / 3600.0, view.wall_s / 60.0
    time = f"{hours:.1f} h" if hours >= 1.0 else f"{minutes:.1f} min" if minutes >= 2.0 else f"{view.wall_s:.0f} s"
    facts = (
        (f"{view.points}", "point" if view.points == 1 else "points"),
        (f"{view.seeds}", "seed at each" if view.seeds == 1 else "seeds at each"),
        (f"{view.runs}", "runs ended"),
        (f"{view.failed}", "of them failed"),
        (time, "time of all runs"),
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
    if view.points == 1:
        return "<h2>What was varied</h2>" + _table((("Key", False), ("In words", False), ("Value", False)), rows)
    how = "All combinations." if view.grid else "A sample, not all combinations."
    same = f"The same {view.seeds} seeds" if view.seeds > 1 else "The same seed"
    note = (
        f'<p class="note">{how} {same} at every point: the points differ by what is varied and fly in the same '
        f"air{', so that differences are paired' if view.grid else ''}.</p>"
    )
    return f"<h2>What was varied</h2>{note}" + _table(
        (("Key", False), ("In words", False), ("Values", False)), rows
    )


def _reading(view: SweepView) -> str:
    """What the plots show, in words."""
    percent = f"{100.0 * view.level:g} %"
    terms = {
        "Mean and band": (
            "A marker is the mean of all seeds at a point. Its band (or bar) holds, with a confidence of "
            f"{percent}, the mean that very many seeds would give (Student's t). It does not show how far single "
            "runs scatter. With few seeds it is wide, and may reach below zero where no run can."
        )
    }
    if view.grid:
        terms["Paired difference"] = (
            "Two values of one key, everything else equal, seed by seed: both fly in the same air. Its limits are "
            "mostly narrower than those of the two means beside each other. Where they do not hold 0, the two "
            "values differ."
        )
        effect = "How far the mean of all runs with a value lies from the mean of all runs, over all other keys."
    else:
        effect = (
            "Of a number: by how much the figure changes from its lowest to its highest value, in a linear fit of "
            "all keys. Of a word: how far its runs lie from the mean, in the same fit."
        )
    terms["Main effect"] = effect
    body = "".join(f"<dt>{name}</dt><dd>{escape(text)}</dd>" for name, text in terms.items())
    return f"<details><summary>How to read it</summary><dl>{body}</dl></details>"


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
    whole = " open" if view.points == 1 else ""  # it stands for the plot
    return f"<details{whole}><summary>Means at all points</summary>{_table(head, rows)}</details>"


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
        name = less("", pair)
        every = [pair.overall] if not keys else [pair.overall, *pair.differences]
        for d in every:
            where = [told("", d.values[key]) if key in d.values else "all" for key in keys]
            errors = [f"{e:.2g}" if e == e else "–" for e in (d.standard_error, d.unpaired_standard_error)]  # noqa: PLR0124
            text = with_limits(d.mean, d.half_width, metric.figure.digits)
            rows.append([name, *where, text, *errors, str(d.seeds), _left_out(d.missing, d.failed)])
    caption = "Unpaired: what the standard error of the same runs would be without common seeds."
    return f"<details><summary>Paired differences in numbers</summary>{_table(head, rows, caption)}</details>"


def _metric(view: SweepView, metric: MetricView) -> Iterator[str]:
    figure = metric.figure
    meaning = f" {figure.meaning[0].upper()}{figure.meaning[1:]}." if figure.meaning else ""
    yield f'<h2>{escape(figure.name)}</h2><p class="note"><code>{escape(figure.path)}</code>.{escape(meaning)}</p>'
    for note in metric.notes:
        yield f'<p class="note">{escape(note)}</p>'
    if all(m.mean != m.mean for m in metric.means):
        yield '<p class="note">No run has a value of this.</p>'
        return
    if view.points > 1:  # of one, the table of its mean is all
        yield from _plots(view, metric)
    yield _means(view, metric)
    yield _pairs(view, metric)


def _plots(view: SweepView, metric: MetricView) -> Iterator[str]:
    from aerosim.report import sweep_plots as plots

    name, limits_of = metric.figure.name, f"{100.0 * view.level:g} % confidence limits"
    limited = f"with {limits_of}" if view.seeds > 1 else "of one seed, without confidence limits"
    rest = (
        f" Averaged over {', '.join(word(key) for key in view.axes.rest)}." if view.axes.rest and view.grid else ""
    )
    crosses = " Crosses: seeds that failed there." if any(m.failed for m in metric.means) else ""
    draw: Callable[[], str] = (
        (lambda: plots.over_parameter(metric, view.varied, view.axes))
        if view.grid
        else (lambda: plots.cloud(metric, view.varied))
    )
    yield _figure(draw(), f"{name} over what was varied", f"Means over the seeds {limited}.{rest}{crosses}")
    if metric.pairs:
        yield "<h3>Differences</h3>"
        if all(d.mean == 0.0 and d.half_width == 0.0 for pair in metric.pairs for d in pair.differences):
            pairs = ", ".join(less(view.compared, pair) for pair in metric.pairs)
            yield f'<p class="note">None: {escape(pairs)} is 0 at every seed.</p>'
        else:
            content = plots.differences(metric, view.varied, view.axes, view.compared)
            caption = f"Paired differences over common seeds {limited}.{rest}"
            yield _figure(content, f"Differences of {name}", caption)
    rounding = 1e-12 * max((abs(m.mean) for m in metric.means if m.mean == m.mean), default=0.0)
    if any(abs(e.effect) > rounding for e in metric.effects):  # NaN, where it is not known, is not
        kind = (
            "Mean of all runs with a value less the mean of all runs"
            if view.grid
            else "Change over a key's whole range in a linear fit; of a word, how far it lies from the mean"
        )
        bars = f", {limited}" if view.seeds > 1 else ""
        content = plots.main_effects(metric)
        yield "<h3>Main effects</h3>" + _figure(content, f"Main effects on {name}", f"{kind}{bars}.")


def _others(view: SweepView) -> str:
    """Least and greatest mean of the figures that have no section of their own."""
    rows: list[Sequence[str]] = []
    for metric in view.others:
        known = [m for m in metric.means if m.mean == m.mean]
        if known and view.points == 1:
            rows.append((metric.figure.name, metric.figure.unit, limits(metric.figure, known[0])))
        elif known:
            low, high = min(known, key=lambda m: m.mean), max(known, key=lambda m: m.mean)
            names = (metric.figure.name, metric.figure.unit)
            texts = [limits(metric.figure, m) for m in (low, high)]
            rows.append((*names, texts[0], _at(low.values), texts[1], _at(high.values)))
    if not rows:
        return ""
    head = (
        ("Figure", False), ("", False), ("Least mean", True), ("at", False), ("Greatest mean", True), ("at", False)
    )  # fmt: skip
    one = (*head[:2], ("Mean", True))
    return "<h2>Other figures</h2>" + _table(one if view.points == 1 else head, rows)


def _at(values: dict[str, Any]) -> str:
    return ", ".join(f"{word(key)} {told(key, value)}" for key, value in values.items())


def sweep_page(view: SweepView) -> str:
    """The report as HTML text."""
    name, purpose = escape(view.name), escape(view.purpose)
    body = [
        _verdict(view),
        _tiles(view),
        _varied(view),
        _reading(view),
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
