"""The command line as people expect it: hints, one line for each error, an end on Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from conftest import DATA

from swaywatch import cli
from swaywatch.analysis import DriveResult, Value, _implausible, analyze, conclude
from swaywatch.checks.samples import Finding
from swaywatch.checks.sensor_faults import IDS
from swaywatch.cli import main
from swaywatch.commands.physics import known
from swaywatch.diagnose.car_alone.effects import effects
from swaywatch.drive import load_drive
from swaywatch.ecu.core import VCRIT, columns_of
from swaywatch.effects.effect import library
from swaywatch.models.physics import MODULES
from swaywatch.report.page import make_report
from swaywatch.report.sentences import critical_words, sentences, verdict
from swaywatch.roles import CHANNELS
from swaywatch.terminal import crash
from swaywatch.vehicle_file import load_vehicle

P03 = DATA / "practice" / "p03"
VEHICLE, SIGNALS = P03 / "vehicle.toml", P03 / "signals.toml"
RUN = P03 / "run1.asc"
TWO_ROLES = '[signals]\nspeed = "v"\ncar_yaw_rate = "r"\ntrailer_yaw_rate = "r2"\n'


# --- words ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def result() -> DriveResult:
    """The analysis of one run."""
    return analyze([RUN], VEHICLE, SIGNALS)[0]


def _with(result: DriveResult, critical_kmh: float, error_kmh: float) -> DriveResult:
    values = {k: v for k, v in result.values.items() if "damping" not in k}
    values["v_crit_m_s"] = Value(critical_kmh / 3.6, error_kmh / 3.6, 9)
    return DriveResult(**{**result.__dict__, "values": values})


def test_verdict_gives_the_distance_and_its_uncertainty(result: DriveResult) -> None:
    kind, text = verdict(_with(result, 145.1, 8.7))
    speed = float(text.split()[1])
    assert "± 8.7 km/h below its critical speed of 145.1 ± 8.7 km/h" in text
    distance = float(text.split(" is ")[1].split()[0])
    assert distance == pytest.approx(145.1 - speed, abs=0.11)
    assert kind == "good"
    kind, text = verdict(_with(result, 125.0, 8.7))
    assert kind == "near"
    assert "may be on either side" in text
    kind, text = verdict(_with(result, 100.0, 1.0))
    assert kind == "bad"
    assert "± 1.0 km/h above its critical speed" in text


@pytest.mark.parametrize(
    ("kind", "words"), [("beyond_range", "none up to 250"), ("below_range", "below 10")]
)
def test_a_bound_of_the_search_is_no_critical_speed(
    result: DriveResult, kind: str, words: str
) -> None:
    status = result.estimates.status.copy()
    status["v_crit_kind"] = next(number for number, name in VCRIT.items() if name == kind)
    status["v_crit_mm_s"], status["v_crit_se_mm_s"] = 69444, 0
    estimates = replace(result.estimates, status=status, columns=columns_of(status))
    bound = conclude(result.drive, result.vehicle, estimates, [])
    assert bound.critical_kind == kind
    assert "v_crit_m_s" not in bound.values
    assert critical_words(bound) == words
    said = [verdict(bound)[1], *sentences(bound), make_report([bound])]
    assert all("250.0 ±" not in text and "10.0 ±" not in text for text in said)
    assert "where the search" in said[0]


def test_no_limit_found_but_little_damping_measured_is_not_good(result: DriveResult) -> None:
    values = {k: v for k, v in result.values.items() if k != "v_crit_m_s"}
    values["damping_ratio"] = Value(0.012, 0.012, 30)
    values["model_damping_ratio"] = Value(0.64, 0.01, 30)
    odd = replace(result, values=values, critical_kind="beyond_range")
    kind, text = verdict(odd)
    assert kind == "bad"
    assert "0.012 ± 0.012" in text
    assert "physics is missing from it" in text


def test_a_verdict_on_signals_that_do_not_fit_says_so(result: DriveResult) -> None:
    finding = Finding("warning", "sign_or_unit", ("x",), "x: its sign is wrong")
    odd = DriveResult(**{**result.__dict__, "findings": [finding]})
    assert verdict(odd)[1].startswith(verdict(result)[1])
    assert "the signals do not fit together (see below): a rough guide" in verdict(odd)[1]


def test_a_speed_that_no_trailer_sees_is_reported() -> None:
    drive = load_drive([RUN], SIGNALS)
    speed = drive.channels["speed"]
    fast = {**drive.channels, "speed": replace(speed, value=speed.value * 1.852)}
    vehicle = load_vehicle(VEHICLE)
    [finding] = _implausible(replace(drive, channels=fast), vehicle)
    assert "km/h is faster than a car with a trailer is driven" in finding.text
    assert _implausible(drive, vehicle) == []


def test_no_usable_estimate_is_said_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng(1)
    lines = ["time_s,v [km/h],r [deg/s],r2 [deg/s]"]
    lines += [
        f"{i * 0.01:.2f},20,{a:.4f},{b:.4f}"
        for i, (a, b) in enumerate(rng.normal(0, 0.3, (2000, 2)))
    ]
    (tmp_path / "slow.csv").write_text("\n".join(lines))
    (tmp_path / "signals.toml").write_text(TWO_ROLES)
    code = main(
        ["analyze", str(tmp_path / "slow.csv"), "--vehicle", str(VEHICLE),
         "--signals", str(tmp_path / "signals.toml"), "--out", str(tmp_path / "out")]
    )  # fmt: skip
    out = " ".join(capsys.readouterr().out.split())
    assert code == 0
    assert "No critical speed could be found" in out
    assert "rough guide" not in out
    assert "measured vehicle.toml unit" not in out


@pytest.mark.parametrize("command", ["analyze", "diagnose"])
def test_trailer_roles_without_a_trailer_are_refused_with_the_fix(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    alone = tmp_path / "vehicle.toml"
    alone.write_text(VEHICLE.read_text().split("[trailer]")[0])
    code = main(
        [command, str(RUN), "--vehicle", str(alone), "--signals", str(SIGNALS),
         "--out", str(tmp_path / "out")]
    )  # fmt: skip
    error = capsys.readouterr().err
    assert code == 1
    assert "trailer_yaw_rate" in error
    assert "has no [trailer]: add it" in error
    assert "leave these roles out" in error


def test_a_recording_given_twice_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["analyze", str(RUN), str(RUN), "--vehicle", str(VEHICLE), "--signals", str(SIGNALS)]
    assert main(words) == 1
    assert "is given twice" in capsys.readouterr().err


# --- hints, versions, JSON ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("typed", "meant"), [("analyse", "analyze"), ("diagnosis", "diagnose"), ("simulat", "simulate")]
)
def test_a_word_that_is_no_command_gets_a_hint(
    typed: str, meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([typed, "x"]) == 2
    assert f"did you mean '{meant}'?" in capsys.readouterr().err


def test_an_unknown_option_gets_a_hint(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["analyze", "x.blf", "--vehicle", "v", "--signals", "s", "--ignore-qualty"])
    assert stop.value.code == 2
    assert "did you mean --ignore-quality?" in capsys.readouterr().err


def test_version_names_the_core(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert "(core 0." in capsys.readouterr().out


def test_json_alone_on_standard_output(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = main(
        ["analyze", str(RUN), "--vehicle", str(VEHICLE), "--signals", str(SIGNALS),
         "--out", str(tmp_path), "--no-report", "--json"]
    )  # fmt: skip
    assert code == 0
    content = json.loads(capsys.readouterr().out)
    assert content == json.loads((tmp_path / "summary.json").read_text())


def test_quiet_says_nothing_and_verbose_tells_steps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["analyze", str(RUN), "--vehicle", str(VEHICLE), "--signals", str(SIGNALS),
             "--out", str(tmp_path), "--no-report"]  # fmt: skip
    assert main([*words, "-q"]) == 0
    assert capsys.readouterr().out == ""
    assert main([*words, "-v"]) == 0
    said = capsys.readouterr()
    assert "reading" in said.err
    assert "critical speed" in said.out


def test_physics_lists_every_id_that_can_be_reported(capsys: pytest.CaptureFixture[str]) -> None:
    rows = known()
    reported = {e.id for e in library()} | {e.id for e in effects(tuple(CHANNELS))}
    reported |= {*IDS.values(), "sensor_sign"}
    assert reported == {name for name, row in rows.items() if row["reported"]}
    assert set(MODULES) == {name for name, row in rows.items() if row["simulated"]}
    assert main(["physics"]) == 0
    listed = capsys.readouterr().out
    assert all(name in listed for name in rows)
    titles = {line.find(rows[line.split()[0]]["title"]) for line in listed.splitlines()}
    assert len(titles) == 1  # one column, also beside the longest id
    for name, row in rows.items():
        assert row["title"] != name.replace("_", " "), name
        assert main(["physics", name]) == 0
        assert "equation" in capsys.readouterr().out, name


def test_command_list_is_that_of_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    listed = capsys.readouterr().out
    assert all(name in listed for name in cli.command_names())


def test_completion_knows_every_command_and_option(capsys: pytest.CaptureFixture[str]) -> None:
    for shell in ("bash", "zsh", "fish"):
        assert main(["completion", shell]) == 0
        script = capsys.readouterr().out
        assert all(name in script for name in cli.command_names()), shell
        assert "ignore-quality" in script
    main(["completion", "bash"])
    script = capsys.readouterr().out
    probe = "COMP_WORDS=(swaywatch analyze --ve); COMP_CWORD=2; _swaywatch; echo ${COMPREPLY[@]}"
    done = subprocess.run(
        ["bash", "-c", f"{script}\n{probe}"], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["--vehicle", "--verbose"]


def test_manual_pages_of_every_command(tmp_path: Path) -> None:
    assert main(["manual", "--out", str(tmp_path)]) == 0
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"swaywatch.1", *(f"swaywatch-{name}.1" for name in cli.command_names())}
    text = (tmp_path / "swaywatch-analyze.1").read_text()
    for word in (
        ".TH",
        ".SH NAME",
        ".SH SYNOPSIS",
        "ignore",
        ".SH EXIT STATUS",
        "130: interrupted",
    ):
        assert word in text
    assert "%(default)s" not in text


@pytest.mark.parametrize("signals", [True, False])
def test_monitor_plays_a_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], signals: bool
) -> None:
    words = ["monitor", "--vehicle", str(VEHICLE), "--speed", "0"]
    if signals:
        words += [str(RUN), "--signals", str(SIGNALS)]
    else:
        log = tmp_path / "frames.log"
        assert main(["convert", str(RUN), "--signals", str(SIGNALS), "--to", str(log)]) == 0
        words += [str(log), "--car-accelerometer", "-1.383"]
    assert main(words) == 0
    last = capsys.readouterr().out.strip().splitlines()[-1]
    critical = float(last.split("v_crit ")[1].split()[0])
    assert critical == pytest.approx(123.3, abs=2.5)


def test_monitor_of_nothing_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["monitor", "--vehicle", str(VEHICLE)]) == 1
    assert "give --interface and --channel" in capsys.readouterr().err
    assert main(["monitor", str(RUN), "--vehicle", str(VEHICLE), "--send"]) == 1
    assert "needs a bus" in capsys.readouterr().err


# --- what nobody foresaw --------------------------------------------------------------------------


def test_unexpected_error_is_one_line_and_a_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("swaywatch.commands.roles.CHANNELS", {"x": 1})
    assert main(["roles"]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "AttributeError" in error
    [report] = tmp_path.glob("swaywatch-crash-*.txt")
    assert str(report) in error
    text = report.read_text()
    for word in ("Traceback", "command: swaywatch roles", "numpy", "Python"):
        assert word in text


def test_a_missing_package_is_one_line_with_the_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(args: object) -> int:
        del args
        raise ModuleNotFoundError("No module named 'mujoco'", name="mujoco")

    monkeypatch.setattr("swaywatch.commands.roles.run", run)
    assert main(["roles"]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "pip install 'swaywatch[mujoco]'" in error
    assert "Traceback" not in error


def test_extras_of_the_messages_exist() -> None:
    project = Path(__file__).resolve().parents[2] / "sim_host" / "pyproject.toml"
    extras = tomllib.loads(project.read_text())["project"]["optional-dependencies"]
    for module, extra in crash.EXTRAS.items():
        wanted = module.replace("_", "-")
        assert any(part.startswith(wanted) for part in extras[extra]), (module, extra)


# --- Ctrl-C ---------------------------------------------------------------------------------------

LONG_C_CALL = """
import ctypes, sys
from swaywatch import cli
import swaywatch.commands.roles as roles
def run(args):
    print("begun", flush=True)
    ctypes.CDLL(None).sleep(120)
    return 0
roles.run = run
sys.exit(cli.main(["roles"]))
"""


def _interrupted(words: list[str], cwd: Path, sign: str) -> tuple[int, float]:
    """Exit code, and seconds from Ctrl-C (sent when `sign` is printed) to the end."""
    # a shell hands a job in the background an ignored Ctrl-C, which its children would inherit
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    process = subprocess.Popen(
        words, cwd=cwd, env={**os.environ, "PYTHONUNBUFFERED": "1"}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    signal.signal(signal.SIGINT, before)
    with process:
        assert process.stdout is not None
        while sign not in (line := process.stdout.readline()):
            assert line, f"ended before {sign!r}"
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        code = process.wait(100)
        return code, time.monotonic() - start


def test_interrupt_reaches_a_long_c_call(tmp_path: Path) -> None:
    code, took = _interrupted([sys.executable, "-c", LONG_C_CALL], tmp_path, "begun")
    assert code == 130
    assert took < 30.0  # the call takes 120 s; a second on a free machine


def test_interrupt_ends_an_analysis_of_hours(tmp_path: Path) -> None:
    time_s = np.arange(0.0, 5 * 3600.0, 0.02)
    rate = 0.1 * np.sin(4.0 * time_s)
    table = pa.table({"time_s": time_s, "v [m/s]": 25.0 + 0.0 * time_s, "r [rad/s]": rate,
                      "r2 [rad/s]": rate})  # fmt: skip
    pyarrow.parquet.write_table(table, tmp_path / "long.parquet")
    (tmp_path / "signals.toml").write_text(TWO_ROLES)
    words = [sys.executable, "-m", "swaywatch.cli", "analyze", "long.parquet", "--vehicle",
             str(VEHICLE), "--signals", "signals.toml", "-v"]  # fmt: skip
    code, took = _interrupted(words, tmp_path, "analysing")
    assert code == 130
    assert took < 30.0
