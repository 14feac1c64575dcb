"""Markup is in templates alone, and nothing that is put into one becomes markup."""

from __future__ import annotations

import ast
import json
import re
import shutil
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest
from conftest import DATA
from markupsafe import Markup
from test_iso9815 import iso9815_study
from test_layout import PACKAGE, modules
from test_looks import damping_study
from test_survey import fleet

from swaywatch import notebook
from swaywatch.cli import main
from swaywatch.damping.page import make_page as damping_page
from swaywatch.discover.page import lines, section
from swaywatch.drive import load_drive
from swaywatch.ecu.bus import encode_drive
from swaywatch.ecu.core import positions_of
from swaywatch.ecu.live import NodeFeed, Playback
from swaywatch.report import shell
from swaywatch.report.live import LivePage
from swaywatch.report.shell import PackedPlot, document, fill, plot
from swaywatch.reproduce.page import Chapter, Check, PageTable, Plot
from swaywatch.reproduce.page import make_page as reproduce_page
from swaywatch.survey.page import make_page as survey_page
from swaywatch.vehicle_file import load_vehicle

P01 = DATA / "practice" / "p01"
P03 = DATA / "practice" / "p03"
TEMPLATES = {path.relative_to(PACKAGE).as_posix(): path for path in PACKAGE.rglob("*.html")}

# --- markup is in templates alone -----------------------------------------------------------------

TAG = re.compile(
    r"</?(?:a|article|b|body|button|code|details|div|em|extra|br|figcaption|figure|form|h[1-6]|head|"
    r"html|i|iframe|img|input|li|link|main|meta|nav|ol|p|pre|script|section|select|small|span|strong|"
    r"style|sub|summary|sup|svg|table|tbody|td|th|thead|title|tr|ul)\b[^<>]*>?"
)
OF_PLOTLY = {"b", "br", "extra", "span", "sub"}
"""Tags of Plotly's own language for titles and words under the pointer."""
WITH_FIGURES = {
    "damping/page", "diagnose/car_alone/page", "diagnose/report/page", "report/figures",
    "report/shell", "reproduce/chapter5", "reproduce/courses", "survey/page",
}  # fmt: skip
"""Modules that give Plotly such titles or words."""
OTHER_XML = {"models/multibody_mjcf"}
"""MuJoCo's description of a vehicle."""


def markup(text: str) -> set[str]:
    """Names of the tags in a module's strings."""
    strings = [
        node.value
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    return {re.findall(r"\w+", tag)[0] for string in strings for tag in TAG.findall(string)}


def test_no_module_makes_html() -> None:
    found = {name: markup(text) for name, text in modules().items() if name not in OTHER_XML}
    for name in WITH_FIGURES:
        assert found[name] & OF_PLOTLY, f"{name}: no exception is needed any more"
        found[name] -= OF_PLOTLY
    assert {name: tags for name, tags in found.items() if tags} == {}


def test_html_in_a_module_is_found() -> None:
    assert markup("x = f\"<p class='note'>{name}</p>\"") == {"p"}
    assert markup("parts.append('<h2>Runs</h2>')") == {"h2"}
    assert markup("head = '<table>' + rows") == {"table"}
    assert markup("text = 'a < b, or <field> of x'") == set()


def test_nothing_goes_around_the_escaping() -> None:
    """Only the shell vouches for markup: for our own css, js and policy."""
    users = {name for name, text in modules().items() if re.search(r"Markup|markupsafe", text)}
    assert users == {"report/shell"}
    for name, path in TEMPLATES.items():
        assert not re.search(r"\bsafe\b|autoescape", path.read_text()), name


def test_a_template_lies_beside_the_module_that_fills_it() -> None:
    """It has its name; a part has no module, and other templates or the module name it."""
    for name, path in TEMPLATES.items():
        if not path.with_suffix(".py").is_file():
            texts = [p.read_text() for p in [*PACKAGE.rglob("*.html"), *PACKAGE.rglob("*.py")]]
            assert any(f'"{name}"' in text for text in texts), name
    named = {
        found for text in modules().values() for found in re.findall(r'"([\w/]+\.html)"', text)
        if "/" in found or found.startswith("notebook")
    }  # fmt: skip
    assert named <= set(TEMPLATES)


# --- what is put in stays words -------------------------------------------------------------------

POISON = "<script>alert(1)</script><img src=x onerror=alert(1)>'\"></td>&amp;"
FIGURE = plot(go.Figure(go.Scatter(x=[0.0, 1.0], y=[0.0, 1.0])), run="r", least_width=9)
VERDICT = {"kind": "bad", "sentence": "s", "reasons": [("text", "remark"), ("text", ""), "text"]}
LAW: dict[str, Any] = {
    "text": "a moment", "perhaps": "a spring", "law": "M = gain x theta", "energy": "stores energy",
    "library_would_say": ["hitch_friction"], "log_bayes_factor_to_library": 40.0,
    "share_explained": 0.9, "equivalent": [{"place": "hitch", "depends_on": "articulation"}],
    "kept_out": {"calibrated_nrmse": 0.3, "library_nrmse": 0.2, "with_law_nrmse": 0.1,
                 "log_times_likelier_than_library": [12.0, 30.0]},
    "variables": ["articulation"],
    "parameters": {"gain": {"value": 1.0, "low": 0.5, "high": 2.0, "unit": "Nm/rad"}},
    "input": {
        "place": "hitch", "unit": "Nm", "motion_unit": "rad",
        "runs": [{"run": "run 1", "time_s": [0.0, 1.0], "value": [1.0, 2.0], "law": [1.0, 2.0],
                  "standard_error": [0.1, 0.1], "motion": [0.0, 1.0]}],
    },
}  # fmt: skip
DIAGNOSIS: dict[str, Any] = {
    "verdict": VERDICT, "effects": [["1"] * 8], "amounts": [["e"] * 4], "signals": [FIGURE],
    "unexplained": ["something"], "checks": ["a check"],
    "laws": section({"discovered": [LAW]}),
}  # fmt: skip
WHOLE: dict[str, Any] = {
    **DIAGNOSIS, "run_files": "run 1: a.asc", "above_clean": " above", "repaired": True,
    "evidence": {"reduced_chi_square_as_written": 3.0, "reduced_chi_square_calibrated": 2.0,
                 "reduced_chi_square_diagnosed": 1.0},
    "calibrated": [["v"] * 7], "clean_percent": 3.0, "maps": [FIGURE], "best": [("e", "+4")],
    "costs": {"summary": "s", "plot": FIGURE, "head": ["h"], "rows": [["r"]],
              "left_out": [("n", "why")]},
    "claimed": True, "own": True, "by_calibration": False, "stretched": False,
    "scores": {"rows": [["r"] * 4], "held_out": ["run 2"]},
    "five_percent": (["head"], [["row"]]),
}  # fmt: skip
CAR: dict[str, Any] = {
    **DIAGNOSIS, "relations": [["r"] * 5], "cloud": FIGURE, "alone": [("e", "1")],
    "evidence": {"held_out_nrmse": [0.2, 0.1], "level_without": 2.0, "level_with": 1.0},
    "dropped": ["e: no"], "quantities": [["q"] * 4], "fits": [["f"] * 3],
}  # fmt: skip


def _live() -> None:
    vehicle = load_vehicle(P01 / "vehicle.toml")
    drive = load_drive([P01 / "run1.blf"], P01 / "signals.toml")
    feed, page = NodeFeed(vehicle, positions_of(drive)), LivePage(vehicle, "run1")
    with Playback(encode_drive(drive), 0.0) as bus:
        while (message := bus.recv(0.0)) is not None:
            feed.receive(message)
            page.note(feed.status())
    page.html()
    assert json.loads(page.state())["verdict"]


def _notebook() -> None:
    roles = {"vehicle": P01 / "vehicle.toml", "signals": P01 / "signals.toml"}
    [drive] = notebook.analyze(P01 / "run1.blf", **roles)
    drive._repr_html_()
    drive.picture("stiffness")._repr_html_()


def _reproduce() -> None:
    figure = go.Figure(go.Scatter(x=[0.0, 1.0], y=[0.0, 1.0]))
    checks = [Check("a", 1.0, 9.0, 0.1, "Hz", cause="c"), Check("b", 1.0, 2.0, 0.1, "Hz", "above")]
    parts: list[Plot | PageTable] = [
        Plot("f", figure, "n"), PageTable("t", ("h",), ((1.0, "w"),), "n")
    ]  # fmt: skip
    reproduce_page([Chapter("c", "t", parts, checks)], 1.0)


def _survey() -> None:
    runs = fleet(0.7, 40)
    runs[0].pages = {"report": "run0/report.html", "diagnosis": "run0/d/report.html"}
    runs[0].why = ["hitch friction 130 Nm", "road bank"]
    survey_page("folder", runs, runs[:2], "1 min")


P01_FILES = ["--vehicle", str(P01 / "vehicle.toml"), "--signals", str(P01 / "signals.toml")]
P03_FILES = ["--vehicle", str(P03 / "vehicle.toml"), "--signals", str(P03 / "signals.toml")]
MAKERS: dict[str, Callable[[str], object]] = {
    "analyze": lambda out: main(["analyze", str(P03 / "run1.asc"), str(P03 / "run2.asc"),
                                 *P03_FILES, "--out", out]),
    "validate": lambda out: main(["validate", str(P01 / "run1.blf"), *P01_FILES, "--out", out]),
    "plan": lambda out: main(["plan", *P03_FILES[:2], "--error", "3", "--out", out]),
    "iso9815": lambda _: damping_page(iso9815_study(), {"recording": [P03 / "run1.asc"]}),
    "damping": lambda _: damping_page(damping_study(), {}),
    "live": lambda _: _live(),
    "notebook": lambda _: _notebook(),
    "reproduce": lambda _: _reproduce(),
    "survey": lambda _: _survey(),
    "diagnose": lambda _: document("diagnose/report/page.html", "t", **WHOLE),
    "nothing claimed": lambda _: document(
        "diagnose/report/page.html", "t",
        **{**WHOLE, "effects": [], "amounts": [], "claimed": False}),
    "calibration alone": lambda _: document(
        "diagnose/report/page.html", "t",
        **{**WHOLE, "by_calibration": True,
           "evidence": {**WHOLE["evidence"], "reduced_chi_square_as_written": None}}),
    "a vehicle that nobody would believe": lambda _: document(
        "diagnose/report/page.html", "t",
        **{**WHOLE, "by_calibration": True, "stretched": True}),
    "beside a simulation": lambda _: document(
        "diagnose/report/page.html", "t", **{**WHOLE, "own": False}),
    "car alone": lambda _: document("diagnose/car_alone/page.html", "t", **CAR),
}  # fmt: skip
"""Each makes all pages and parts of a kind, in the folder given."""

Filled = list[tuple[str, dict[str, Any]]]


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Filled]:
    """What each kind of page put into which templates."""
    kinds: dict[str, Filled] = {}
    with pytest.MonkeyPatch.context() as patch:
        for kind, make in MAKERS.items():
            kept: Filled = []
            for module in (shell, notebook):
                patch.setattr(
                    module, "fill", lambda t, k=kept, **data: k.append((t, data)) or fill(t, **data)
                )
            patch.setattr("swaywatch.report.live.fill", shell.fill)
            make(str(tmp_path_factory.mktemp("page")))
            kinds[kind] = kept
    return kinds


@pytest.fixture
def poisoned(monkeypatch: pytest.MonkeyPatch) -> None:
    """All that a template prints, but for numbers and what a macro has escaped, carries markup."""
    templates = shell._templates().overlay(
        finalize=lambda value: (
            value if isinstance(value, int | float | Markup) else f"{value}{POISON}"
        ),
        cache_size=50,
    )
    monkeypatch.setattr(shell, "_templates", lambda: templates)


class _Tags(HTMLParser):
    """Tags with the names of their attributes, and the words, those of attributes too."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, ...]] = []
        self.words = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, *(name for name, _ in attrs)))
        self.words += " ".join(value or "" for _, value in attrs)

    def handle_endtag(self, tag: str) -> None:
        self.tags.append((f"/{tag}",))

    def handle_data(self, data: str) -> None:
        self.words += data


@pytest.mark.parametrize("kind", MAKERS)
def test_words_of_no_page_become_markup(
    kind: str, filled: dict[str, Filled], poisoned: None
) -> None:
    assert filled[kind]
    for template, data in filled[kind]:
        clean = fill_clean(template, data)
        spoiled = _Tags(shell.fill(template, **data))
        assert "<script>alert(1)</script>" in spoiled.words, template  # it was there, as words
        assert spoiled.tags == _Tags(clean).tags, template


@pytest.mark.parametrize("kind", MAKERS)
def test_no_heading_stands_over_nothing(kind: str, filled: dict[str, Filled]) -> None:
    """Below a heading comes a word or a plot before the next of its rank or a higher one."""
    for template, data in filled[kind]:
        tags = _Tags(fill_clean(template, data)).tags
        open_ = 0  # rank of the heading that nothing has followed yet
        for tag, *_ in [*tags, ("h1",)]:
            rank = int(tag[1]) if re.fullmatch("h[1-6]", tag) else 0
            if rank:
                assert not open_ or rank > open_, f"{template}: an empty section of rank {open_}"
                open_ = rank
            elif not tag.startswith("/"):
                open_ = 0


def fill_clean(template: str, data: dict[str, Any]) -> str:
    """As the package fills it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shell, "_templates", TRUE_TEMPLATES)
        return shell.fill(template, **data)


TRUE_TEMPLATES = shell._templates


def test_a_template_that_does_not_escape_is_seen(poisoned: None) -> None:
    """The comparison sees a value that is put in as it is."""
    templates = shell._templates()
    loose = templates.overlay(autoescape=False).from_string("<p>{{ name }}</p>")
    assert _Tags(loose.render(name="a")).tags != [("p",), ("/p",)]
    assert _Tags(templates.from_string("<p>{{ name }}</p>").render(name="a")).tags == [
        ("p",), ("/p",),
    ]  # fmt: skip


def test_every_template_is_filled_here(filled: dict[str, Filled]) -> None:
    """Together with those that they extend, include or take macros from."""
    used = {template for kept in filled.values() for template, _ in kept}
    for _ in range(3):
        used |= {n for t in used for n in re.findall(r'"([\w/]+\.html)"', TEMPLATES[t].read_text())}
    assert used | {"report/macros.html"} == set(TEMPLATES)


def test_a_recording_whose_name_is_markup(tmp_path: Path) -> None:
    run = tmp_path / "p" / "run<img src=x onerror=alert('1')>&amp;.asc"
    run.parent.mkdir()
    shutil.copy(P03 / "run1.asc", run)
    assert main(["analyze", str(run), *P03_FILES, "--out", str(tmp_path / "out")]) == 0
    text = (tmp_path / "out" / "report.html").read_text()
    assert "<img" not in text.partition("<main>")[2].partition("</main>")[0]
    assert run.name in _Tags(text).words


def test_a_law_says_what_it_is() -> None:
    [(text, remark)] = lines({"discovered": [LAW]})
    assert text == "A moment (a spring?)"
    assert "outside the library" in remark
    page = fill("discover/page.html", laws=section({"discovered": [LAW]}))
    assert "hitch friction" in page
    assert "0.5 to 2" in page
    assert page.count("<figure class='plot'") == 2


def test_a_name_that_a_template_lacks_is_an_error() -> None:
    with pytest.raises(Exception, match="'laws' is undefined"):
        fill("discover/page.html")


def test_a_packed_plot_has_its_numbers() -> None:
    assert isinstance(FIGURE, PackedPlot)
    assert np.isfinite(FIGURE.height)
