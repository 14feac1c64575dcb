"""Pages in their four forms (desktop, phone, dark, print) beside their kept pictures.

Those that are made in a second or two; that the others are drawn whole, test_pages sees.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import plotly.graph_objects as go
import pytest
from browser import CHROMIUM, LOOKS, Browser
from conftest import DATA
from looks import differs, look_of
from PIL import Image
from test_damping import BAND, a_run, dutch_roll
from test_iso9815 import iso9815_study

from swaywatch.damping.compare import compare_groups
from swaywatch.damping.data import Choice
from swaywatch.damping.page import make_page as damping_page
from swaywatch.damping.study import Study, StudyPlan, study_of
from swaywatch.reproduce.page import Chapter, Plot
from swaywatch.reproduce.page import make_page as reproduce_page
from swaywatch.survey.outcome import SurveyOutcome
from swaywatch.survey.page import make_page as survey_page

KEPT = DATA / "pages"
#: One font, whatever else is installed: letters of another width break lines elsewhere.
FONT = "<style>* { font-family: 'DejaVu Sans' !important; }</style>"
PAGES = ("damping", "iso9815", "reproduce", "survey")

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium (Debian package chromium)")


def damping_study() -> Study:
    """An aeroplane without its yaw damper, compared with itself with it."""
    groups: list[Study] = []
    for gain in (0.0, 0.5):
        runs = []
        for seed in range(3):
            value, rudder, _ = dutch_roll(gain, 20.0, 800, seed)
            runs.append(a_run(value, 0.05, rudder, 170.0 + 10.0 * seed))
        groups.append(study_of(runs, StudyPlan(Choice(), BAND)))
    first, second = groups
    both = compare_groups(first.points, second.points, ("off", "on"))
    return Study(
        **{**first.__dict__, "compared": second, "groups": both},
    )


def _damping() -> str:
    return damping_page(damping_study(), {})


def _iso9815() -> str:
    return damping_page(iso9815_study(), {})


def _survey() -> str:
    outcomes = [
        SurveyOutcome(
            "2026/calm.mf4", "", "agrees", mismatch=1.0, v_crit_kmh=121.0, v_crit_se_kmh=0.6
        ),
        SurveyOutcome(
            "2026/rear.mf4", "", "disagrees", mismatch=9.0, why=["hitch friction 130 Nm"]
        ),
        SurveyOutcome("2026/cut.asc", "", "failed", why=["ends in the middle of a frame"]),
    ]
    return survey_page("folder", outcomes, [], "1 min")


def _reproduce() -> str:
    line = go.Figure(go.Scatter(x=[0.0, 1.0, 2.0], y=[0.0, 1.0, 0.5], name="line"))
    line.update_xaxes(title="speed [km/h]").update_yaxes(title="damping ratio")
    return reproduce_page([Chapter("Chapter 4", "text", [Plot("4.1", line, "note")], [])], 1.0)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Pages that were made already, by name."""
    return {"folder": tmp_path_factory.mktemp("pages")}


def made(name: str, pages: dict[str, Path]) -> Path:
    """A page, made when it is asked for first."""
    if name in pages:
        return pages[name]
    path = pages["folder"] / f"{name}.html"
    written = {"damping": _damping, "iso9815": _iso9815, "survey": _survey}
    path.write_text(written.get(name, _reproduce)().replace("</head>", f"{FONT}</head>", 1))
    pages[name] = path
    return path


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """One browser for all pages."""
    with Browser() as found:
        yield found


@pytest.mark.parametrize("name", PAGES)
def test_page_looks_as_kept(name: str, page: dict[str, Path], browser: Browser) -> None:
    path = made(name, page)
    off = []
    for form in LOOKS:
        browser.complaints.clear()
        browser.open(path, form)
        assert browser.complaints == [], (name, form)
        now = look_of(browser.taken())
        kept = KEPT / f"{name}-{form}.png"
        if os.environ.get("KEEP_LOOKS"):
            kept.parent.mkdir(exist_ok=True)
            now.save(kept, optimize=True)
        with Image.open(kept) as picture:
            text = differs(now, picture.convert("RGB"))
        off += [f"{form}: {text}"] if text else []
    assert off == []


SPOILED = {
    "the style is lost": "document.querySelector('style').remove()",
    "plots are not drawn": "document.querySelectorAll('.draw').forEach(e => e.innerHTML = '')",
    "dark": "document.body.style.background = '#111'",
}


@pytest.mark.parametrize("how", SPOILED)
def test_a_spoiled_page_is_seen(how: str, page: dict[str, Path], browser: Browser) -> None:
    browser.open(made("damping", page))
    browser.evaluate(f"({SPOILED[how]}, 1)")
    with Image.open(KEPT / "damping-desktop.png") as picture:
        assert differs(look_of(browser.taken()), picture.convert("RGB"))
