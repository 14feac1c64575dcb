"""The example notebooks, cell by cell as a kernel would run them, and what they show."""

from __future__ import annotations

import ast
import shutil
from pathlib import Path
from typing import Any

import nbformat
import pandas as pd
import pytest

from swaywatch import notebook as sway

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "sim_host" / "notebooks").glob("*.ipynb"))


def run_notebook(path: Path) -> tuple[dict[str, Any], list[Any]]:
    """Names at the end, and the value of every cell that ends in an expression."""
    book = nbformat.read(path, as_version=4)
    nbformat.validate(book)
    names: dict[str, Any] = {"__name__": "__main__"}
    shown: list[Any] = []
    for number, cell in enumerate(book.cells):
        if cell.cell_type != "code":
            continue
        assert not cell.outputs, f"{path.name}: cell {number} was saved with its output"
        tree = ast.parse(cell.source, f"{path.name}, cell {number}")
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, path.name, "exec"), names)
        if isinstance(last, ast.Expr):
            shown.append(eval(compile(ast.Expression(last.value), path.name, "eval"), names))
    return names, shown


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A place like that of the notebooks: what they write stays out of the repository."""
    own = tmp_path / "sim_host" / "notebooks"
    own.mkdir(parents=True)
    data = tmp_path / "tests" / "data" / "practice"
    data.mkdir(parents=True)
    shutil.copytree(ROOT / "tests" / "data" / "practice" / "p03", data / "p03")
    shutil.copytree(ROOT / "tests" / "data" / "practice" / "p01", data / "p01")
    shutil.copy(ROOT / "tests" / "data" / "practice" / "measurement.dbc", data)
    monkeypatch.chdir(own)
    return own


def test_there_are_three() -> None:
    assert [path.stem[0] for path in NOTEBOOKS] == ["1", "2", "3"]


def test_a_first_drive(folder: Path) -> None:
    names, shown = run_notebook(NOTEBOOKS[0])
    table = shown[0]
    assert isinstance(table, pd.DataFrame)
    assert {"signal", "unit", "rate_hz"} <= set(table.columns)
    drive = names["drive"]
    assert drive.verdict in drive._repr_html_()
    assert names["critical"].value * 3.6 == pytest.approx(123.5, abs=2.0)
    for picture in shown[-2:]:
        text = picture._repr_html_()
        assert text.startswith("<iframe sandbox='allow-scripts")
        assert "Content-Security-Policy" in text
    assert drive.frame().attrs["units"]["frequency_hz"] == "Hz"
    with pytest.raises(ValueError, match="no such picture; there are signals"):
        drive.picture("nonsense")
    assert drive.save(folder / "page.html").stat().st_size > 100_000


def test_swings_of_any_vehicle(folder: Path) -> None:
    assert folder.is_dir()
    names, shown = run_notebook(NOTEBOOKS[1])
    swings = names["swings"]
    assert len({point.number for point in swings.study.points}) == 6
    low = swings.frame().groupby(lambda k: round(swings.frame()["against"][k]))["damping_ratio"]
    for speed, ratio in low.mean().items():
        assert ratio == pytest.approx(0.2 - 0.005 * (speed - 10.0), abs=0.02)
    assert "0.05" in swings._repr_html_() or swings.verdict in swings._repr_html_()
    assert any("frequency of my model is higher" in text for text in shown[-1])
    with pytest.raises(ValueError, match="there are course, swings"):
        swings.picture("nonsense")


def test_what_if(folder: Path) -> None:
    names, _ = run_notebook(NOTEBOOKS[2])
    both = names["both"]
    assert (folder / "spread.mf4").is_file()
    total = both.study.groups.total("damping_ratio")
    assert total.differs
    assert total.difference.value > 0.0
    assert any("The damping ratio of as it is is higher" in text for text in both.sentences)
    assert len(both.picture("course").figure.data) >= 6  # two groups, three quantities


def test_a_diagnosis_shows_itself() -> None:
    """Of the form that `diagnose` gives; the diagnosis itself is tested elsewhere."""
    moment = {"value": 130.0, "low": 120.0, "high": 140.0, "unit": "Nm"}
    effect = {
        "id": "hitch_friction", "component": "hitch", "parameters": {"moment_nm": moment},
        "windows": [], "window_details": [], "confidence": 0.97, "equivalents": [],
        "equivalent_details": [],
    }  # fmt: skip
    found = sway.Diagnosis({"verdict": "effects_found", "effects": [effect]})
    assert "friction at the hitch: 130" in found.sentences[0]
    assert "hitch_friction" in found._repr_html_()
