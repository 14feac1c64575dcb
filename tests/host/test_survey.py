"""A folder of recordings over night: ``swaywatch survey``."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from conftest import DATA

from swaywatch import __version__
from swaywatch.cli import main
from swaywatch.survey import work
from swaywatch.survey.fleet import mark, scatter_of
from swaywatch.survey.outcome import Journal, SurveyOutcome
from swaywatch.survey.page import make_page
from swaywatch.survey.plan import find_runs, groups
from swaywatch.survey.warm import Ran, Warm
from swaywatch.survey.workers import problem_here

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clean run, one with a concealed effect, one cut off, one without a vehicle."""
    top = tmp_path_factory.mktemp("night") / "runs"
    shutil.copytree(DATA / "practice", top)
    for name in ("p01/run2.blf", "p03/run2.asc"):
        (top / name).unlink()
    concealed = top / "p03" / "run1.asc"
    lines = concealed.read_text().splitlines(keepends=True)
    end = next(i for i, line in enumerate(lines[4:], 4) if float(line.split()[0]) > 19.0)
    concealed.write_text("".join(lines[:end]))  # until after its second window, 15 to 18 s
    whole = (top / "p01" / "run1.blf").read_bytes()
    (top / "p01" / "cut.blf").write_bytes(whole[:3000])
    shutil.copy(top / "p01" / "run1.blf", top / "alone.blf")
    shutil.copy(top / "p01" / "run1.blf", top / "p01" / "simulation_run1.blf")
    return top


def states(out: Path) -> dict[str, dict[str, Any]]:
    lines = (out / "survey.jsonl").read_text().splitlines()
    return {entry["name"]: entry for entry in map(json.loads, lines)}


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
    assert "rear axle swings by up to" in found["p03/run1.asc"]["why"][0]
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

    def no_command(words: list[str], place: Path, limit_s: float) -> Ran:
        asked.append(words[1])
        return Ran(1, "not this time")

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

    def command(words: list[str], place: Path, limit_s: float) -> Ran:
        (top / "odd.blf").unlink(missing_ok=True)
        if "run1" in words[1]:
            raise RuntimeError("stumbled")
        return Ran(1, "not read")

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
    monkeypatch.setattr(work, "_command", lambda words, place, limit_s: Ran(1, "refused"))
    out = tmp_path / "out"
    seen: list[int] = []
    add = Journal.add

    def watched(self: Journal, outcome: SurveyOutcome) -> None:
        add(self, outcome)
        seen.append(len(states(out)))

    monkeypatch.setattr(Journal, "add", watched)
    assert main(["survey", str(top), "--out", str(out), "--jobs", "8"]) == 1
    assert seen == [*range(1, 61)]
    assert len(states(out)) == 60
    table = pq.read_table(out / "survey.parquet")
    assert table["name"].to_pylist() == [f"r{number:02d}.blf" for number in range(60)]
    assert set(table["state"].to_pylist()) == {"failed"}


def test_a_survey_that_was_cut_off_goes_on(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    journal.add(SurveyOutcome("good", "k", "agrees"))
    journal.add(SurveyOutcome("bad", "k", "failed"))
    journal.add(SurveyOutcome("good", "later", "agrees"))
    with journal.path.open("a") as stream:
        stream.write('{"name": "torn", "key": "k", "sta')
    again = Journal(tmp_path)
    assert {name: outcome.key for name, outcome in again.kept.items()} == {"good": "later"}
    again.add(SurveyOutcome("next", "k", "agrees"))
    assert set(states(tmp_path)) == {"good", "next"}


def fleet(odd: float, count: int = 200) -> list[SurveyOutcome]:
    """Runs whose stiffness scatters by 3 %, known to 1 %, but run 17's, which is `odd`."""
    random = np.random.default_rng(5)
    found = []
    for number in range(count):
        ratio = (odd if number == 17 else 1.0 + 0.03 * random.standard_normal()) * 0.95
        value = 1e5 * ratio * (1.0 + 0.01 * random.standard_normal())
        values: dict[str, list[float | None]] = {
            "car_rear.cornering_stiffness_n_per_rad": [value, 1e3, 1e5],
            "frequency_hz": [0.6, 0.01, None],
        }
        found.append(SurveyOutcome(f"run{number}", "", "not diagnosed", values=values))
    return found


@pytest.mark.parametrize(("odd", "stands_out"), [(0.8, True), (1.02, False)])
def test_the_outlier_of_a_fleet_is_found(odd: float, stands_out: bool) -> None:
    runs = fleet(odd)
    (entry,) = mark(runs)
    assert entry.scatter == pytest.approx(0.03, rel=0.2)
    unlike = [run.name for run in runs if run.stands_out]
    assert unlike == (["run17"] if stands_out else [])
    page = make_page("folder", runs, [], "1 min")
    assert "Outliers of the fleet" in page
    if stands_out:
        assert "stiffness, rear axle of the car: 2" in runs[17].stands_out[0]
        assert "below the fleet" in runs[17].stands_out[0]
        assert page.index("run17") < page.index("run1<")


def test_errors_larger_than_the_scatter_are_no_scatter() -> None:
    random = np.random.default_rng(1)
    error = np.full(400, 0.05)
    assert scatter_of(0.02 * random.standard_normal(400), error) == 0.0
    assert mark(fleet(0.5, count=7)) == []  # too few to compare


def test_only_what_stands_out_is_diagnosed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    top = tmp_path / "runs"
    top.mkdir()
    for name in ("vehicle.toml", "signals.toml"):
        shutil.copy(DATA / "practice" / "p01" / name, top)
    runs = {run.name: run for run in fleet(0.7, 40)}
    for name in runs:
        (top / f"{name}.blf").write_bytes(name.encode())
    asked: list[tuple[str, str]] = []

    def command(words: list[str], place: Path, limit_s: float) -> Ran:
        name = Path(words[1]).stem
        asked.append((words[0], name))
        if words[0] == "diagnose":
            return Ran(1, "not in this test")
        assert ("--no-report" in words) == (asked.count(("analyze", name)) == 1)
        values = {
            key: {"value": value, "standard_error": error, "believed": believed}
            for key, (value, error, believed) in runs[name].values.items()
        }
        drive = {"conclusion": ["calm"], "values": values, "alarms": [], "duration_s": 9.0}
        place.mkdir(parents=True, exist_ok=True)
        (place / "summary.json").write_text(json.dumps({"drives": [drive]}))
        return Ran(0, cpu_s=0.5, memory_mb=100.0)

    monkeypatch.setattr(work, "_command", command)
    out = tmp_path / "out"
    words = ["survey", str(top), "--out", str(out), "--jobs", "2", "--diagnose", "outliers"]
    assert main(words) == 1  # the diagnosis failed
    assert [name for what, name in asked if what == "diagnose"] == ["run17"]
    assert "1 is an outlier of the fleet" in capsys.readouterr().out
    table = {row["name"]: row for row in pq.read_table(out / "survey.parquet").to_pylist()}
    assert table["run17.blf"]["stands_out"]
    assert table["run3.blf"]["state"] == "not diagnosed"
    assert table["run3.blf"]["cpu_s"] == 0.5
    assert table["run3.blf"]["car_rear.cornering_stiffness_n_per_rad_believed"] == 1e5


def test_a_warm_process_outlives_its_commands() -> None:
    """Each command is a copy of its own: one that fails, hangs or dies leaves the next alone."""
    warm = Warm()
    unknown = warm.run(["analyse"], 60.0)
    assert unknown.code == 2
    assert "did you mean 'analyze'" in unknown.said
    late = warm.run(["monitor", str(DATA / "practice" / "p01" / "run1.blf"), "--vehicle",
                     str(DATA / "practice" / "p01" / "vehicle.toml")], 0.5)  # fmt: skip
    assert late.late
    assert late.code == -signal.SIGKILL
    again = warm.run(["roles"], 60.0)
    assert again.code == 0
    assert again.memory_mb > 10.0
    assert warm._process is not None
    warm._process.kill()
    warm._process.wait()
    assert warm.run(["roles"], 60.0).code == 0  # started again


def test_an_interrupted_survey_leaves_no_process(folder: Path, tmp_path: Path) -> None:
    words = [Path(sys.executable).parent / "swaywatch", "survey", folder / "p03"]
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # see test_cli
    process = subprocess.Popen(
        [*words, "--out", tmp_path / "out", "--jobs", "1"], stderr=subprocess.PIPE, text=True
    )
    signal.signal(signal.SIGINT, before)

    def below(number: int) -> list[int]:
        tasks = Path(f"/proc/{number}/task").glob("*/children")
        found = [int(child) for task in tasks for child in task.read_text().split()]
        return [*found, *(far for near in found for far in below(near))]

    end = time.monotonic() + 120.0
    while len(children := below(process.pid)) < 2:  # the warm process and its copy at work
        assert time.monotonic() < end
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert "interrupted" in said
    while any(Path(f"/proc/{child}").exists() for child in children):
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_worker_that_lacks_something_is_reported(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    assert "not see" in problem_here(tmp_path, mark, __version__)
    mark.touch()
    assert problem_here(tmp_path, mark, __version__) == ""
    assert "expected 9.9" in problem_here(tmp_path, mark, "9.9")
    assert "has no" in problem_here(tmp_path / "nowhere", mark, __version__)


def test_a_cluster_that_loses_a_worker_gives_the_same_table(tmp_path: Path) -> None:
    """Two workers by their address, one killed half-way: the rows of a survey on this machine."""
    done = subprocess.run(
        [sys.executable, str(ROOT / "tests/bench/fleet.py"), "--count", "6", "--seconds", "6",
         "--workers", "--out", str(tmp_path / "bench")],
        capture_output=True, text=True, check=False, timeout=900,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "one killed half-way" in done.stdout
    assert "NO" not in done.stdout


def test_no_scheduler_is_said_so(tmp_path: Path, capsys: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr("swaywatch.survey.workers.ANSWER_S", 0.3)
    (tmp_path / "a.blf").touch()
    words = ["survey", str(tmp_path), "--out", str(tmp_path / "out")]
    assert main([*words, "--scheduler", "tcp://127.0.0.1:9"]) == 1
    said = capsys.readouterr().err
    assert "tcp://127.0.0.1:9: no dask scheduler answers" in said
    assert not (tmp_path / "out").exists()


def test_a_line_says_what_where_and_when() -> None:
    outcome = SurveyOutcome(
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
        (["{empty}", "--scheduler", "tcp://127.0.0.1:9"], "no recording in it"),
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
        SurveyOutcome("calm", "", "agrees", mismatch=1.0),
        SurveyOutcome("bad <b>", "", "disagrees", mismatch=4.0, why=["a & b"]),
        SurveyOutcome("worse", "", "disagrees", mismatch=9.0),
    ]
    page = make_page("folder", outcomes, [], "1 min")
    assert page.index("worse") < page.index("bad &lt;b&gt;") < page.index("calm")
    assert "a &amp; b" in page
