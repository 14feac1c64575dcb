"""Every page: nothing leaves it, nothing is missing from it, and a real browser draws it."""

from __future__ import annotations

import base64
import gzip
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import pytest
from browser import CHROMIUM, FORMS, Browser
from conftest import DATA
from test_iso9815 import iso9815_study

from swaywatch.cli import main
from swaywatch.damping.page import make_page as damping_page
from swaywatch.report.shell import POLICY, plot
from swaywatch.reproduce.page import Chapter, Plot
from swaywatch.reproduce.page import make_page as reproduce_page
from swaywatch.survey.page import make_page as survey_page

P03 = DATA / "practice" / "p03"
ROLES = ["--vehicle", str(P03 / "vehicle.toml"), "--signals", str(P03 / "signals.toml")]
RUNS = [str(P03 / "run1.asc"), str(P03 / "run2.asc")]
HOST = re.compile(r"(?:https?|wss?|ftp):(?:\\?/){2}([\w.-]+)")
NAMESPACE = "www.w3.org"  # the name of SVG, no address


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory, diagnosed_p03: Path) -> dict[str, Path]:
    """A page of each kind, by its name."""
    out = tmp_path_factory.mktemp("pages")
    assert main(["analyze", *RUNS, *ROLES, "--out", str(out / "a")]) == 0
    sources = {"recording": [Path(RUNS[0]), Path(RUNS[1])], "signals": [Path(ROLES[3])]}
    (out / "iso9815.html").write_text(damping_page(iso9815_study(), sources))
    figure = go.Figure(go.Scatter(x=[0.0, 1.0], y=[0.0, 1.0], name="line"))
    chapter = Chapter("Chapter", "text", [Plot("A figure", figure, "note")], [])
    (out / "reproduce.html").write_text(reproduce_page([chapter], 1.0))
    (out / "survey.html").write_text(survey_page("folder", [], [], "1 min"))
    return {
        "analyze": out / "a" / "report.html",
        "diagnose": diagnosed_p03 / "report.html",
        "iso9815": out / "iso9815.html",
        "reproduce": out / "reproduce.html",
        "survey": out / "survey.html",
    }


class _Page(HTMLParser):
    """Tags, attributes and packed contents of a page."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=False)
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.packed: list[str] = []
        self._packed = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._packed = tag == "script" and dict(attrs).get("type") == "text/plain"

    def handle_data(self, data: str) -> None:
        if self._packed:
            self.packed.append(gzip.decompress(base64.b64decode(data)).decode("utf-8"))
            self._packed = False


def test_no_page_names_a_host_or_can_send_anything(pages: dict[str, Path]) -> None:
    for name, path in pages.items():
        text = path.read_text()
        page = _Page(text)
        for part in (text, *page.packed):
            assert set(HOST.findall(part)) <= {NAMESPACE}, name
        policies = [a["content"] for t, a in page.tags if a.get("http-equiv")]
        assert policies == [POLICY], name
        for tag, attributes in page.tags:
            assert tag not in ("iframe", "object", "embed", "form", "base", "link", "img"), name
            for key in ("src", "action", "srcset", "ping"):
                assert key not in attributes, (name, tag)
            target = str(attributes.get("href", "#"))
            assert target.startswith("#") or "://" not in target, (name, target)
    for rule in ("default-src 'none'", "connect-src 'none'", "form-action 'none'"):
        assert rule in POLICY


def test_plots_carry_numbers_units_and_no_upload(pages: dict[str, Path]) -> None:
    page = _Page(pages["analyze"].read_text())
    figures = [json.loads(text) for text in page.packed if text.startswith('{"data"')]
    assert len(figures) == 13
    assert all("plotlyServerURL" not in json.dumps(f.get("config", {})) for f in figures)
    hovers = [t.get("hovertemplate", "") for f in figures for t in f["data"]]
    assert any("km/h" in hover for hover in hovers)
    assert any("N" in hover for hover in hovers)
    text = pages["analyze"].read_text()
    assert "showSendToCloud: false" in text
    assert "name='viewport'" in text


def test_page_says_what_it_was_made_from(pages: dict[str, Path]) -> None:
    import hashlib

    for name in ("analyze", "diagnose", "iso9815"):
        text = pages[name].read_text()
        for source in (*RUNS, ROLES[3]):
            digest = hashlib.sha256(Path(source).read_bytes()).hexdigest()
            assert digest in text, (name, source)


def test_pages_are_small(pages: dict[str, Path]) -> None:
    assert all(path.stat().st_size < 4_000_000 for path in pages.values())


def test_contents_lead_to_every_heading() -> None:
    figure = go.Figure(go.Scatter(x=[0.0], y=[0.0]))
    chapters = [Chapter("One", "", [Plot("Two & a half", figure, "")]), Chapter("Three", "")]
    page = reproduce_page(chapters, 1.0)
    for number in (1, 2, 3, 4):
        assert f"id='s{number}'" in page
    words = ("Comparison with the reference", "One", "Two &amp; a half", "Three")
    first, one, two, three = (f"<a href='#s{k}'>{word}</a>" for k, word in enumerate(words, 1))
    contents = re.sub(r">\s+", ">", page.partition("<nav")[2].partition("</nav>")[0])
    assert (
        f"<ul><li>{first}</li><li>{one}<ul><li>{two}</li></ul></li><li>{three}</li></ul>"
    ) in contents


def test_plot_keeps_gaps_and_digits() -> None:
    figure = go.Figure(go.Scatter(x=np.arange(3.0), y=np.array([1.23456789, np.nan, 2.0])))
    content = json.loads(gzip.decompress(base64.b64decode(plot(figure).content)))
    raw = base64.b64decode(content["data"][0]["y"]["bdata"])
    assert np.frombuffer(raw, "<f4")[0] == pytest.approx(1.23456789, abs=1e-6)
    assert np.isnan(np.frombuffer(raw, "<f4")[1])


# --- in a real browser ----------------------------------------------------------------------------

real = pytest.mark.skipif(CHROMIUM is None, reason="no chromium here (Debian package chromium)")


@pytest.fixture(scope="module")
def browser() -> Browser:
    """One browser for all pages."""
    with Browser() as found:
        yield found


@real
@pytest.mark.parametrize("form", FORMS)
def test_browser_draws_every_page_in_every_form(
    pages: dict[str, Path], browser: Browser, form: str
) -> None:
    for name, path in pages.items():
        browser.complaints.clear()
        browser.open(path, form)
        assert browser.complaints == [], name
        outside = [u for u in browser.requests if not u.startswith(("file:", "about:", "data:"))]
        assert outside == [], name
        wide = browser.evaluate("document.documentElement.scrollWidth - innerWidth")
        assert wide <= 0, f"{name} is wider than the screen"
        small = browser.evaluate(
            "Math.min(99, ...[...document.querySelectorAll('main *')].filter(e => e.innerText)"
            ".map(e => parseFloat(getComputedStyle(e).fontSize)))"
        )
        assert small >= 10, name
        drawn = browser.evaluate("document.querySelectorAll('.js-plotly-plot .main-svg').length")
        assert (drawn > 0) == (name != "survey"), name


TITLES = """
[...document.querySelectorAll('.js-plotly-plot')].flatMap((plot, number) => {
  const box = e => e.getBoundingClientRect();
  const frame = box(plot.querySelector('.main-svg'));
  const all = [...plot.querySelectorAll('.infolayer .ytitle, .infolayer .xtitle')]
    .filter(e => e.textContent).map(e => [e.textContent, box(e)]);
  const out = all.filter(([, b]) => b.left < frame.left - 1 || b.right > frame.right + 1
    || b.top < frame.top - 1 || b.bottom > frame.bottom + 1).map(([t]) => `${number}: ${t} is cut`);
  const over = all.flatMap(([t, a], i) => all.slice(i + 1)
    .filter(([, b]) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2
      && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2)
    .map(([u]) => `${number}: ${t} over ${u}`));
  return [...out, ...over];
})
"""
"""Titles of axes that lie over each other or outside their plot."""


@real
@pytest.mark.parametrize("form", ["desktop", "phone"])
def test_titles_of_axes_can_be_read(pages: dict[str, Path], browser: Browser, form: str) -> None:
    for name, path in pages.items():
        browser.open(path, form)
        assert browser.evaluate(TITLES) == [], name


@real
def test_plots_fit_the_paper(pages: dict[str, Path], browser: Browser, tmp_path: Path) -> None:
    browser.complaints.clear()
    browser.open(pages["analyze"])
    browser.evaluate("window.dispatchEvent(new Event('beforeprint')), 1")
    widest = browser.evaluate(
        "Math.max(...[...document.querySelectorAll('.main-svg')].map(e => e.clientWidth))"
    )
    assert 0 < widest <= 703  # A4 less its margins, in CSS pixels
    browser.evaluate("window.dispatchEvent(new Event('afterprint')), 1")
    browser.printed(tmp_path / "page.pdf")
    assert (tmp_path / "page.pdf").read_bytes().startswith(b"%PDF")
    assert browser.complaints == []


@real
def test_zoom_is_one_for_all_plots_of_a_run(pages: dict[str, Path], browser: Browser) -> None:
    browser.open(pages["analyze"])
    ranges = browser.evaluate(
        "(async () => {"
        " const [first] = swaywatch.plots.filter(p => p.linked === 'run1');"
        " await Plotly.relayout(first.div, {'xaxis.range': [5, 9]});"
        " await new Promise(r => setTimeout(r, 800));"
        " const of = run => swaywatch.plots.filter(p => p.linked === run)"
        "   .map(p => p.div._fullLayout.xaxis.range.map(Number));"
        " return [of('run1'), of('run2')]; })()"
    )
    assert all(found == [5, 9] for found in ranges[0])
    assert len(ranges[0]) == 6
    assert all(found != [5, 9] for found in ranges[1])


@real
def test_csv_of_a_plot_has_names_units_and_numbers(
    pages: dict[str, Path], browser: Browser
) -> None:
    browser.open(pages["analyze"])
    tables = browser.evaluate("swaywatch.plots.map(p => swaywatch.tableOf(p))")
    assert all(len(text.splitlines()) > 1 for text in tables)
    assert any(text.startswith("time [s],speed: speed [km/h]") for text in tables)
    speed = next(text for text in tables if text.startswith("time [s],speed: speed [km/h]"))
    first = speed.splitlines()[1].split(",")
    assert float(first[1]) == pytest.approx(121.5, abs=3.0)
