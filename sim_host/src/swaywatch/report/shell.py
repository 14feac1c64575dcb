"""What every HTML page of swaywatch is made by: templates filled, figures packed, sources listed.

All markup is in Jinja2 templates, none in Python: a module hands over words, numbers and figures.
The template of a page lies beside the module that fills it and has its name (``damping/page.py``,
``damping/page.html``); ``shell.html`` here is the page around all of them, ``macros.html`` has the
parts that they share. What is put into a template is escaped.

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
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import plotly.graph_objects as go
import plotly.offline

from swaywatch import __version__

if TYPE_CHECKING:
    from jinja2 import Environment

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
_TAG = re.compile(r"<[^>]*>")


@dataclass(frozen=True)
class PackedPlot:
    """A figure as a template shows it (``ui.plot``).

    Attributes
    ----------
    content : the figure's JSON, packed, in base64
    run : plots of equal `run` are zoomed in time together
    file : name of the CSV file
    least_width : pixels below which the plot scrolls instead of shrinking; 0: none
    height : pixels
    """

    content: str
    run: str
    file: str
    least_width: int
    height: int


def plot(
    figure: go.Figure, *, run: str = "", name: str = "plot", least_width: int = 0
) -> PackedPlot:
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
    return PackedPlot(
        base64.b64encode(content).decode("ascii"), run, re.sub(r"\W+", "_", name), least_width,
        int(figure.layout.height or 450),
    )  # fmt: skip


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


@cache
def _templates() -> Environment:
    """All templates of the package, by their path in it (``damping/page.html``)."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    templates = Environment(
        loader=PackageLoader("swaywatch", ""), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    # our own, and nothing else goes into a page as it is
    templates.globals["asset"] = lambda name: Markup(asset(name))
    templates.globals["policies"] = {False: Markup(POLICY), True: Markup(LIVE_POLICY)}
    templates.globals["library"] = _library
    return templates


def fill(template: str, **data: Any) -> str:
    """HTML of a template.

    Parameters
    ----------
    template
        Its path in the package.
    data
        What it names. It has ``ui`` besides, the macros of ``report/macros.html``.
    """
    contents: list[tuple[int, str, str]] = []  # level, anchor, words: each heading adds itself
    shared = _templates().get_template("report/macros.html").make_module({"contents": contents})
    return _templates().get_template(template).render(ui=shared, contents=contents, **data)


def document(
    template: str,
    title: str,
    *,
    meta: str = "",
    sources: Mapping[str, Sequence[Path | str]] | None = None,
    live: bool = False,
    **data: Any,
) -> str:
    """A whole page: a template that extends ``report/shell.html``, filled.

    Parameters
    ----------
    template
        Its path in the package.
    title
        Of the page.
    meta
        A line below the title.
    sources
        Files by what they are (``recording``, ``vehicle``, ``signals``): listed with their
        SHA-256 at the end of the page.
    live
        May ask the program that served it for what is new.
    data
        What the template names.
    """
    made = f"{datetime.now(tz=UTC):%Y-%m-%d %H:%M} UTC"
    line = " · ".join(filter(None, (meta, f"swaywatch {__version__}", made)))
    files = [
        (what, str(path), *_digest(Path(path)))
        for what, paths in (sources or {}).items()
        for path in paths
    ]
    return fill(template, title=title, line=line, files=files, live=live, **data)


def _digest(path: Path) -> tuple[str, str]:
    try:
        with path.open("rb") as file:
            return f"{path.stat().st_size:,}".replace(",", " "), hashlib.file_digest(
                file, "sha256"
            ).hexdigest()
    except OSError:
        return "–", "no longer there"
