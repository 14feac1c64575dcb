"""What every HTML page of swaywatch is made of: the page around its parts, tables, plots, sources.

A page is one file that needs nothing else and sends nothing: the plot library is inside (packed),
the address of no host is in it, and its content security policy forbids every connection, so that
a confidential recording stays where it is. ``page.css`` and ``page.js`` beside this module give
it its look on a screen, a phone, in the dark and on paper, one zoom for all plots of a run, and a
CSV of every plot.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import plotly.offline

from swaywatch import __version__

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; connect-src 'none'; form-action 'none'; base-uri 'none'"
)
"""Content security policy: what is in the page runs, nothing is loaded, nothing is sent."""

LIVE_POLICY = POLICY.replace("connect-src 'none'", "connect-src 'self'")
"""Of a page that asks the very program that served it for what is new."""

FONT = {"family": "Helvetica, Arial, sans-serif", "size": 13, "color": "#1f2937"}
_HOST = re.compile(r"https?://(?!www\.w3\.org)(?:[A-Za-z0-9-]+\.)+[A-Za-z]{2,}")
_UNIT = re.compile(r"\[([^\]]*)\]|,\s*([^,\[\]]{1,12})$")
_HEADING = re.compile(r"<h([23])>(.*?)</h\1>", re.DOTALL)
_TAG = re.compile(r"<[^>]*>")


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """An HTML table; cells are text."""
    cells = "".join(f"<th>{html.escape(x)}</th>" for x in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(x)}</td>" for x in row) + "</tr>" for row in rows
    )
    return wide(f"<table><tr>{cells}</tr>{body}</table>")


def wide(content: str) -> str:
    """What may be wider than a phone scrolls by itself."""
    return f"<div class='wide'>{content}</div>"


def plot(figure: go.Figure, *, run: str = "", name: str = "plot", least_width: int = 0) -> str:
    """A figure in the page's look.

    Parameters
    ----------
    figure
        Titles of its axes carry units, ``speed [km/h]`` or ``speed, km/h``: they are shown beside
        the numbers under the pointer. Width, colours of text and grid are the page's.
    run
        Plots of equal `run` are zoomed in time together; empty: alone.
    name
        Of the CSV file.
    least_width
        Pixels below which the plot scrolls instead of shrinking.
    """
    content = gzip.compress(figure_json(figure).encode("utf-8"), 9, mtime=0)
    attributes = {"run": run, "name": re.sub(r"\W+", "_", name), "x": "time [s]" if run else ""}
    data = "".join(f" data-{k}='{html.escape(v, quote=True)}'" for k, v in attributes.items() if v)
    least = f" data-least='{least_width}'" if least_width else ""
    height = int(figure.layout.height or 450)
    return (
        f"<figure class='plot'{data}{least}><script type='text/plain'>"
        f"{base64.b64encode(content).decode('ascii')}</script>"
        f"<div class='scroll'><div class='draw' style='min-height:{height}px'></div></div>"
        "<figcaption><button type='button'>CSV of this plot</button></figcaption></figure>"
    )


def figure_json(figure: go.Figure) -> str:
    """A figure as the page's script draws it."""
    figure.update_layout(template=None, font=FONT)
    figure.update_layout(width=None)
    _units_in_hovers(figure)
    return str(_compact(figure).to_json())


def _compact(figure: go.Figure) -> go.Figure:
    """Numbers with the seven digits that a plot can show: half the size."""
    for trace in figure.data:
        for key in ("x", "y", "z", "customdata"):
            if key not in trace or trace[key] is None:
                continue
            values = np.asarray(trace[key])
            if values.dtype == np.float64:
                trace[key] = values.astype(np.float32)
    return figure


def _units_in_hovers(figure: go.Figure) -> None:
    """The unit of each axis beside the numbers under the pointer."""
    for axis in figure.select_xaxes():
        axis.hoverformat = axis.hoverformat or ".2f"
    if str(figure.layout.hovermode).endswith("unified"):
        figure.update_xaxes(unifiedhovertitle_text="%{x:.2f} s")
    for trace in figure.data:
        if trace.type != "scatter" or trace.hoverinfo == "skip" or trace.hovertemplate:
            continue
        shown = ["y"] if str(figure.layout.hovermode).endswith("unified") else ["x", "y"]
        words = ", ".join(
            f"%{{{letter}:.5~g}}{_unit_of(figure, trace, letter)}" for letter in shown
        )
        if trace.customdata is not None:
            words += " ± %{customdata:.2~g}"
        trace.hovertemplate = words if len(shown) == 1 else words + f"<extra>{trace.name}</extra>"


def _unit_of(figure: go.Figure, trace: Any, letter: str) -> str:
    number = str(trace[f"{letter}axis"] or letter)[1:]
    axis = figure.layout[f"{letter}axis{number}"]
    text = _TAG.sub(" ", str(axis.title.text or "")).strip()
    found = _UNIT.search(text)
    unit = (found[1] or found[2] or "").strip() if found else ""
    return "" if unit in ("", "-", "–", "1") else f" {unit}"


@cache
def _library() -> str:
    """The plot library, packed, with no address of any host in it."""
    text = _HOST.sub("about:blank#", plotly.offline.get_plotlyjs())
    return base64.b64encode(gzip.compress(text.encode("utf-8"), 9, mtime=0)).decode("ascii")


@cache
def asset(name: str) -> str:
    """Content of a file beside this one."""
    return resources.files("swaywatch.report").joinpath(name).read_text(encoding="utf-8")


def document(
    title: str,
    parts: Sequence[str],
    *,
    meta: str = "",
    sources: Mapping[str, Sequence[Path | str]] | None = None,
    policy: str = POLICY,
    script: str = "",
) -> str:
    """The page around its parts.

    Parameters
    ----------
    title
        Of the page, text.
    parts
        HTML. ``<h2>`` and ``<h3>`` headings without attributes get into the table of contents.
    meta
        A line below the title, text.
    sources
        Files by what they are (``recording``, ``vehicle``, ``signals``): listed with their
        SHA-256 at the end of the page.
    policy
        Content security policy.
    script
        JavaScript behind the page's own.
    """
    body, contents = _with_anchors("\n".join([*parts, _sources(sources or {})]))
    line = " · ".join(
        filter(
            None, (meta, f"swaywatch {__version__}", f"{datetime.now(tz=UTC):%Y-%m-%d %H:%M} UTC")
        )
    )
    scripts = f"<script>{script}</script>" if script else ""
    if "<figure class='plot'" in body:
        scripts = (
            f"<script id='library' type='text/plain'>{_library()}</script>"
            f"<script>{asset('page.js')}</script>{scripts}"
        )
    return (
        "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        "<meta name='referrer' content='no-referrer'>"
        f"<title>{html.escape(title)}</title><style>{asset('page.css')}</style></head><body><main>"
        f"<h1>{html.escape(title)}</h1><div class='meta'>{html.escape(line)}</div>"
        f"{contents}{body}</main>{scripts}</body></html>\n"
    )


def _with_anchors(body: str) -> tuple[str, str]:
    """Body with an anchor at each heading, and the table of contents."""
    entries: list[tuple[int, str, str]] = []

    def anchor(match: re.Match[str]) -> str:
        level, inner = int(match[1]), match[2]
        entries.append((level, f"s{len(entries) + 1}", _TAG.sub("", inner)))
        return f"<h{level} id='{entries[-1][1]}'>{inner}</h{level}>"

    body = _HEADING.sub(anchor, body)
    if len(entries) < 3:
        return body, ""
    items: list[str] = []
    for level, name, text in entries:
        link = f"<a href='#{name}'>{text}</a>"
        if level == 2 or not items:
            items.append(f"<li>{link}<ul></ul></li>")
        else:
            items[-1] = items[-1].removesuffix("</ul></li>") + f"<li>{link}</li></ul></li>"
    listed = "".join(items).replace("<ul></ul>", "")
    return (
        body,
        "<nav class='contents'><details><summary>Contents</summary>"
        f"<ul>{listed}</ul></details></nav>",
    )


def _sources(sources: Mapping[str, Sequence[Path | str]]) -> str:
    """Where the page comes from: each file with its SHA-256."""
    rows = [
        (what, str(path), *_digest(Path(path))) for what, paths in sources.items() for path in paths
    ]
    if not rows:
        return ""
    body = "".join(
        f"<tr><td>{html.escape(what)}</td><td>{html.escape(path)}</td>"
        f"<td class='number'>{size}</td><td><code>{digest}</code></td></tr>"
        for what, path, size, digest in rows
    )
    head = "<tr><th></th><th>file</th><th>bytes</th><th>SHA-256</th></tr>"
    return f"<h2>Made from</h2><div class='sources'>{wide(f'<table>{head}{body}</table>')}</div>"


def _digest(path: Path) -> tuple[str, str]:
    try:
        with path.open("rb") as file:
            return f"{path.stat().st_size:,}".replace(",", " "), hashlib.file_digest(
                file, "sha256"
            ).hexdigest()
    except OSError:
        return "–", "no longer there"
