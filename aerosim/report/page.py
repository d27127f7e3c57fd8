"""report.html: one file about one run, without scripts and without links to anywhere."""

from __future__ import annotations

import base64
import math
import os
import platform
from collections import Counter
from collections.abc import Callable, Iterator
from html import escape
from importlib import metadata
from pathlib import Path

from aerosim.report import residual
from aerosim.report.figures import headline
from aerosim.report.source import Source, open_source
from aerosim.report.words import how_flown

CSS = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; color: #1a1a1a; background: #fff;
  max-width: 62rem; margin: 0 auto; padding: 1.5rem 1.25rem 4rem; }
h1 { font-size: 1.8rem; margin: 0 0 .2rem; } h2 { font-size: 1.2rem; margin: 2.2rem 0 .6rem; }
.purpose { color: #444; margin: 0 0 1rem; }
.verdict { border-left: .5rem solid; padding: .7rem 1rem; margin: 1rem 0; background: #f4f4f4; }
.verdict b { font-size: 1.1rem; } .verdict p { margin: .3rem 0 0; }
.met { border-color: #009E73; } .unmet { border-color: #D55E00; } .none { border-color: #777; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(8.5rem, 1fr)); gap: .6rem; margin: 1rem 0; }
.tiles div { border: 1px solid #ddd; padding: .5rem .7rem; } .tiles b { display: block; font-size: 1.25rem; }
.tiles span { font-size: .84rem; color: #555; }
table { border-collapse: collapse; width: 100%; font-size: .94rem; }
th, td { text-align: left; padding: .28rem .7rem .28rem 0; border-bottom: 1px solid #ddd; vertical-align: top; }
td.n { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
th.n { text-align: right; } th.n, td.n { padding-right: 1.2rem; } td.why, .note { color: #555; }
figure { margin: .5rem 0 1.6rem; } figure svg, figure img { width: 100%; height: auto; display: block; }
figcaption { font-size: .9rem; color: #444; margin-top: .3rem; }
pre { background: #f6f6f6; padding: .8rem; overflow-x: auto; font-size: .82rem; line-height: 1.4; }
summary { cursor: pointer; font-weight: 600; }
@media print { body { max-width: none; padding: 0; font-size: 10.5pt; } figure, tr { break-inside: avoid; }
  h2 { break-after: avoid; } details:not([open]) { display: none; } }
"""

FIRST = (
    "flight.drift_mean_deg", "crab.residual_rms_deg", "crab.accepted_pct", "vh.error_rms_pct",
    "photos.end_lap_mean_pct", "photos.out_of_tolerance",
)  # fmt: skip


def _verdict(source: Source) -> str:
    """Whether the run met what its scenario expects, in words and colour."""
    from aerosim.metrics.consistency import overconfident
    from aerosim.metrics.expect import check_expect
    from aerosim.metrics.summary import lines_not_seen

    summary, expect = source.summary, source.scenario.expect
    status = str(summary.get("status", "unknown"))
    unmet = check_expect(summary, expect)
    lines = [escape(line) for line in (*unmet, *lines_not_seen(summary), *overconfident(summary).values())]
    if status not in ("done", "ok"):
        notes = summary.get("notes") or {}
        reason = notes.get("status") or summary.get("reason") or "the run left no reason"
        kind, head = "unmet", f"The run did not end as planned: {escape(status)}"
        lines = [escape(str(reason)), "The record up to there is shown.", *lines]
    elif not expect:
        kind, head = "none", "Done; the scenario expects nothing in particular"
    elif unmet:
        kind, head = "unmet", f"Expectations not met: {len(unmet)} of {len(expect)}"
    else:
        kind, head = "met", f"Expectations met: {len(expect)} of {len(expect)}"
    body = "".join(f"<p>{line}</p>" for line in lines)
    return f'<div class="verdict {kind}" role="status"><b>{head}</b>{body}</div>'


def _expectations(source: Source) -> str:
    """The scenario's limits beside what came out."""
    from aerosim.metrics.expect import check_expect, value_at

    rows = []
    for path, limit in source.scenario.expect.items():
        value = value_at(source.summary, path)
        shown = f"{value:.4g}" if isinstance(value, (int, float)) else "–"
        ends = (("at least", limit.min), ("at most", limit.max))
        bounds = [f"{word} {end:g}" for word, end in ends if end is not None]
        met = "not met" if check_expect(source.summary, {path: limit}) else "met"
        rows.append(
            f'<tr><td><code>{escape(path)}</code></td><td class="n">{shown}</td>'
            f"<td>{', '.join(bounds)}</td><td>{met}</td></tr>"
        )
    if not rows:
        return ""
    head = '<tr><th>Expected</th><th class="n">Found</th><th>Limits</th><th></th></tr>'
    return f"<table><thead>{head}</thead><tbody>{''.join(rows)}</tbody></table>"


def _tiles(source: Source) -> str:
    """The few figures that are looked at first."""
    tiles = [
        f"<div><b>{escape(value)}</b><span>{escape(figure.name)}</span></div>"
        for figure, value, _ in headline(source.summary)
        if figure.path in FIRST
    ]
    return f'<div class="tiles">{"".join(tiles)}</div>'


def _figures(source: Source) -> str:
    """The headline figures with unit and meaning."""
    rows = [
        f'<tr><td>{escape(figure.name)}</td><td class="n">{escape(value)}</td><td class="why">'
        f"{escape(figure.meaning)}{f' ({escape(reason)})' if reason else ''}</td></tr>"
        for figure, value, reason in headline(source.summary)
    ]
    seconds = source.scenario.record.exclude_first_s
    note = f'<p class="note">Over the survey lines, without the first {seconds:g} s of each.</p>'
    head = '<tr><th>Figure</th><th class="n">Value</th><th>What it is</th></tr>'
    return f"<h2>Figures</h2>{note}<table><thead>{head}</thead><tbody>{''.join(rows)}</tbody></table>"


def _figure(content: str, title: str, caption: str) -> str:
    content = content.replace("<svg ", f'<svg role="img" aria-label="{escape(title)}" ', 1)
    return f"<h2>{escape(title)}</h2><figure>{content}<figcaption>{escape(caption)}</figcaption></figure>"


def _verdicts(source: Source) -> str:
    """How many photos got which verdict."""
    counts = Counter(str(verdict) for verdict in source.photos.get("verdict", ()))
    return ", ".join(f"{name} {count}" for name, count in counts.most_common()) or "none"


def _plots(source: Source) -> Iterator[str]:
    """The four time plots, or what is missing for one."""
    from aerosim.metrics.photos import PERIOD_PRACTICE
    from aerosim.report import plots

    limit = PERIOD_PRACTICE
    tolerance = 100.0 * limit.end_lap
    flown = source.count(source.telemetry) > 1
    wanted: tuple[tuple[str, str, bool, Callable[[], str]], ...] = (
        (
            "Crab and drift",
            "Drift is track less aircraft heading, crab is track less camera heading; positive to the right.",
            flown,
            lambda: plots.motion(source),
        ),
        (
            "Speed-to-height ratio",
            "Strips stand at the middle of their two exposures, about half a recognition ago.",
            flown,
            lambda: plots.speed_to_height(source),
        ),
        (
            "Photos",
            f"End lap with the photo before; tolerance {tolerance:g} % to either side of the wanted one. "
            f"Tilt of the optical axis (at most {math.degrees(limit.tilt):g} deg), blur in picture pixels (at "
            f"most {limit.blur:g}); crab may be {math.degrees(limit.crab):g} deg. Verdicts of all photos: "
            f"{_verdicts(source)}.",
            flown and source.count(source.photos) > 0,
            lambda: plots.photos(source, tolerance),
        ),
        (
            "Strips",
            "Exposures between the two rows, the least mean absolute difference, and the decision on each strip.",
            flown and source.count(source.matches) > 0,
            lambda: plots.strips(source),
        ),
    )
    for title, caption, there, draw in wanted:
        if there:
            yield _figure(draw(), title, caption)
        else:
            yield f'<h2>{title}</h2><p class="note">Nothing was recorded to draw here.</p>'


def _map(source: Source) -> str:
    from aerosim.report.chart import map_jpeg

    data = base64.b64encode(map_jpeg(source)).decode()
    text = "Map of the land with planned lines, flown path and photo footprints"
    picture = f'<img alt="{text}" src="data:image/jpeg;base64,{data}">'
    name = source.grid.crs.name
    grid = "the orthophoto's, which has no name" if name.lower() in ("unnamed", "unknown") else name
    beyond = int(source.count(source.photos) - source.whole_footprints.sum())
    left_out = f" {beyond} that leave the land are not drawn." if beyond else ""
    caption = f"Map grid: {grid}. Footprints are where the picture's corners meet the ground.{left_out}"
    return _figure(picture, "Map", caption)


def versions_here() -> dict[str, str]:
    """Versions of Python and of the packages that a run depends on, as a manifest has them."""
    from aerosim.rundir import PACKAGES

    return {"python": platform.python_version(), **{name: metadata.version(name) for name in PACKAGES}}


def _background(source: Source) -> str:
    """Scenario, versions and seed."""
    text = (source.path / "scenario.yaml").read_text(encoding="utf-8")
    # a run's own report is drawn before its manifest is written, which holds the report's hash
    versions = source.manifest.get("versions") or versions_here()
    facts = {
        "seed": source.scenario.seed,
        "aerosim": source.manifest.get("aerosim") or metadata.version("aerosim-survey"),
        **versions,
        "telemetry_sha256": source.summary.get("telemetry_sha256") or "–",
    }
    rows = "".join(
        f"<tr><td>{escape(str(name))}</td><td><code>{escape(str(value))}</code></td></tr>"
        for name, value in facts.items()
    )
    return (
        f"<h2>How it was made</h2><table><tbody>{rows}</tbody></table>"
        f"<details><summary>Scenario, every default filled in</summary><pre>{escape(text)}</pre></details>"
    )


def page(source: Source) -> str:
    """The report as HTML text."""
    name, purpose = escape(source.scenario.name), escape(source.scenario.purpose)
    body = [
        _verdict(source),
        f'<p class="note">{escape(how_flown(source))}</p>',
        _tiles(source),
        _expectations(source),
        _map(source),
        *_plots(source),
        residual.causes(source.summary),
        residual.consistency(source.summary),
        _figures(source),
    ]
    missing = "".join(f'<p class="note">{escape(line)}</p>' for line in source.missing)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{name}: aerosim report</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>'
        f"{CSS}{residual.CSS}</style></head>\n<body>"
        f'<h1>{name}</h1><p class="purpose">{purpose}</p>{missing}\n'
        + "\n".join(body)
        + _background(source)
        + "</body></html>\n"
    )


def write_report(run_dir: Path) -> Path:
    """Write report.html of a run, whole or not at all.  Returns its path.

    Raises InputError for a directory that is no run.
    """
    file = run_dir / "report.html"
    part = run_dir / f".report.html.{os.getpid()}"
    try:
        part.write_text(page(open_source(run_dir)), encoding="utf-8")
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
    return file
