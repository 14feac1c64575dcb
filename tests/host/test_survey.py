"""A folder of recordings over night: ``swaywatch survey``."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from typing import Any

import pytest
from conftest import DATA

from swaywatch.cli import main
from swaywatch.survey import work
from swaywatch.survey.page import make_page
from swaywatch.survey.plan import find_runs, groups
from swaywatch.survey.work import Outcome


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clean run, one with a concealed effect, one cut off, one without a vehicle."""
    top = tmp_path_factory.mktemp("night") / "runs"
    shutil.copytree(DATA / "practice", top)
    for name in ("p01/run2.blf", "p03/run2.asc"):
        (top / name).unlink()
    whole = (top / "p01" / "run1.blf").read_bytes()
    (top / "p01" / "cut.blf").write_bytes(whole[:3000])
    shutil.copy(top / "p01" / "run1.blf", top / "alone.blf")
    shutil.copy(top / "p01" / "run1.blf", top / "p01" / "simulation_run1.blf")
    return top


def states(out: Path) -> dict[str, dict[str, Any]]:
    content = json.loads((out / "survey.json").read_text())
    return {entry["name"]: entry for entry in content["runs"]}


def test_every_run_is_judged_and_shown(
    folder: Path, tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    assert main(["survey", str(folder), "--out", str(out), "--jobs", "1"]) == 1  # two runs failed
    found = states(out)
    assert {name: entry["state"] for name, entry in found.items()} == {
        "alone.blf": "failed",
        "p01/cut.blf": "failed",
        "p01/run1.blf": "agrees",
        "p03/run1.asc": "disagrees",
    }
    assert "--vehicle" in found["alone.blf"]["why"][0]
    assert "truncated BLF" in found["p01/cut.blf"]["why"][0]
    assert "axle load harmonic" in found["p03/run1.asc"]["why"][0]
    assert "2f" in found["p03/run1.asc"]["where"][0]
    page = (out / "survey.html").read_text()
    for name in found:
        assert name in page
    for entry in found.values():
        for link in entry["pages"].values():
            assert (out / link).is_file()
    assert "1 of 4 runs disagree with the model" in capsys.readouterr().out

    # Started again, only what failed is done again; a changed run is judged anew.
    asked: list[str] = []

    def no_command(words: list[str], place: Path, limit_s: float) -> str:
        asked.append(words[1])
        return "not this time"

    monkeypatch.setattr(work, "_command", no_command)
    assert main(["survey", str(folder), "--out", str(out)]) == 1
    assert {Path(name).name for name in asked} == {"cut.blf"}
    assert states(out)["p03/run1.asc"] == found["p03/run1.asc"]


def test_a_run_that_takes_too_long_costs_only_itself(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert main(["survey", str(folder), "--out", str(out), "--limit", "0.05"]) == 1
    assert "longer than" in states(out)["p01/run1.blf"]["why"][0]


def test_what_vanishes_or_cannot_be_read_costs_only_itself(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    top = tmp_path / "runs"
    shutil.copytree(folder / "p01", top)
    for name in ("cut.blf", "simulation_run1.blf"):
        (top / name).unlink()
    shutil.copy(folder.parent / "runs" / "measurement.dbc", tmp_path)
    (top / "gone.blf").symlink_to(top / "nowhere.blf")
    shutil.copy(top / "run1.blf", top / "odd.blf")
    os.mkfifo(top / "pipe.log")

    def command(words: list[str], place: Path, limit_s: float) -> str:
        (top / "odd.blf").unlink(missing_ok=True)
        if "run1" in words[1]:
            raise RuntimeError("stumbled")
        return "not read"

    monkeypatch.setattr(work, "_command", command)
    out = tmp_path / "out"
    assert main(["survey", str(top), "--out", str(out), "--jobs", "3"]) == 1
    found = states(out)
    assert set(found) == {"gone.blf", "odd.blf", "pipe.log", "run1.blf"}
    assert {entry["state"] for entry in found.values()} == {"failed"}
    assert "no such file" in found["gone.blf"]["why"][0]
    assert "pipe" in found["pipe.log"]["why"][0]
    assert "stumbled" in found["run1.blf"]["why"][0]
    assert "4 failed" in capsys.readouterr().out


def test_no_row_is_lost_with_many_jobs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    top = tmp_path / "runs"
    top.mkdir()
    for number in range(60):
        (top / f"r{number:02d}.blf").write_bytes(b"LOGG" + bytes(number + 1))
    for name in ("vehicle.toml", "signals.toml"):
        shutil.copy(DATA / "practice" / "p01" / name, top)
    monkeypatch.setattr(work, "_command", lambda words, place, limit_s: "refused")
    out = tmp_path / "out"
    seen: list[int] = []
    write = work._write

    def watched(place: Path, outcomes: list[Outcome]) -> None:
        write(place, outcomes)
        seen.append(len(states(out)))

    monkeypatch.setattr(work, "_write", watched)
    assert main(["survey", str(top), "--out", str(out), "--jobs", "8"]) == 1
    assert seen == [*range(1, 61), 60]


def test_a_line_says_what_where_and_when() -> None:
    outcome = Outcome(
        "run", "", "disagrees",
        why=["tyre stiffness change (car, rear axle): factor 0.8 (0.7 to 0.9)", "and more"],
        where=["car, rear axle: 3.0 to 9.5 s, at f"], effects=["tyre stiffness change"],
    )  # fmt: skip
    assert outcome.line() == (
        "tyre stiffness change (car, rear axle): factor 0.8 (0.7 to 0.9) "
        "[car, rear axle: 3.0 to 9.5 s, at f]; and more"
    )


def test_nearest_files_are_taken(folder: Path, tmp_path: Path) -> None:
    given = folder / "p01" / "vehicle.toml"
    runs = find_runs(folder, given, None, ["simulation*"], tmp_path)
    by_name = {run.name: run for run in runs}
    assert "p01/simulation_run1.blf" not in by_name
    assert by_name["p03/run1.asc"].vehicle == folder / "p03" / "vehicle.toml"
    assert by_name["alone.blf"].vehicle == given
    assert by_name["alone.blf"].signals is None
    assert len(groups(runs)) == 2


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["nowhere"], "nowhere: no such folder"),
        (["{empty}"], "no recording in it"),
        (["{empty}", "--jobs", "0"], "--jobs 0"),
        (["{empty}", "--vehicle", "none.toml"], "none.toml: no such file"),
    ],
)
def test_bad_input(tmp_path: Path, capsys: Any, words: list[str], text: str) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    words = [word.format(empty=empty) for word in words]
    assert main(["survey", *words, "--out", str(tmp_path / "out")]) == 1
    assert text in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_page_puts_the_worst_first() -> None:
    outcomes = [
        Outcome("calm", "", "agrees", mismatch=1.0),
        Outcome("bad <b>", "", "disagrees", mismatch=4.0, why=["a & b"]),
        Outcome("worse", "", "disagrees", mismatch=9.0),
    ]
    page = make_page("folder", outcomes, [], "1 min")
    assert page.index("worse") < page.index("bad &lt;b&gt;") < page.index("calm")
    assert "a &amp; b" in page
