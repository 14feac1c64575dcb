"""What a diagnosis is given: missing roles, other vehicles, clocks and orders, too little."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from test_diagnose import BODY_VALUES, synthetic

from swaywatch.diagnose.engine import _untestable, diagnose
from swaywatch.diagnose.fit.data import _foreign, load, load_with_body
from swaywatch.diagnose.fit.simulation import attach, clock_offset
from swaywatch.effects.effect import library
from swaywatch.errors import RecordingError, SignalError
from swaywatch.plant.lanes import BODY

UNITS = {"angle": "rad", "rate": "rad/s", "acceleration": "m/s2", "force": "N", "load": "N"}


def _unit(channel: str) -> str:
    if channel == "speed":
        return "m/s"
    return next(unit for word, unit in UNITS.items() if word in channel)


def _write(path: Path, time: np.ndarray, channels: Mapping[str, np.ndarray]) -> Path:
    """One run as CSV."""
    names = [f"{name} [{_unit(name)}]" for name in channels]
    table = np.column_stack([time, *channels.values()])
    np.savetxt(path, table, delimiter=",", header=",".join(["time_s", *names]), comments="")
    return path


def _case(
    folder: Path, *, without: Sequence[str] = (), heavier: float = 1.0, seconds: float = 25.0
) -> tuple[list[Path], Path, Path]:
    """Two runs of the synthetic combination as files of a user.

    Parameters
    ----------
    without
        Beginnings of the names of channels that are not recorded.
    heavier
        Factor on the wheel loads of the second run.
    seconds
        Length kept of each run.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files, names = [], []
    for number, run in enumerate(synthetic((), seed=11).runs, start=1):
        keep = run.time <= seconds
        channels = {
            name: value[keep] * (heavier if number == 2 and "load" in name else 1.0)
            for name, value in run.channels.items()
            if not name.startswith(tuple(without))
        }
        names = list(channels)
        files.append(_write(folder / f"run{number}.csv", run.time[keep], channels))
    signals = folder / "signals.toml"
    lines = ["[signals]"]
    for role in ("wheel_lateral_force", "wheel_vertical_load"):
        if f"{role}_fl" in names:
            quoted = [f'"{role}_{wheel}"' for wheel in ("fl", "fr", "rl", "rr")]
            lines.append(f"{role} = [{', '.join(quoted)}]")
    for name in (n for n in names if not n.startswith("wheel_")):
        position = ", position = -1.383" if name == "car_lateral_acceleration" else ""
        lines.append(f'{name} = {{ signal = "{name}"{position} }}')
    signals.write_text("\n".join(lines) + "\n")
    vehicle = folder / "vehicle.toml"
    text = ""
    for part in ("car", "trailer"):
        text += f"[{part}]\n" + ("steering_ratio = 15.0\n" if part == "car" else "")
        for key, value in zip(BODY, BODY_VALUES, strict=True):
            if key.startswith(part + "."):
                text += f"{key.split('.')[1]} = {value}\n"
    vehicle.write_text(text)
    return files, vehicle, signals


def test_runs_of_different_vehicles_are_refused(tmp_path: Path) -> None:
    files, vehicle, signals = _case(tmp_path, heavier=1.3)
    with pytest.raises(RecordingError, match=r"different vehicles or loadings: axle loads sum to"):
        load(files, vehicle, signals)


def test_the_run_with_another_loading_is_named_though_the_first_has_no_loads(
    tmp_path: Path,
) -> None:
    files, vehicle, signals = _case(tmp_path)
    problem = load(files, vehicle, signals).problem
    assert problem is not None
    first, second = problem.runs
    for wheel in ("fl", "fr", "rl", "rr"):
        del first.channels[f"wheel_vertical_load_{wheel}"]
        second.channels[f"wheel_vertical_load_{wheel}"] *= 1.3
    (sentence,) = _foreign((first, second), problem.body)
    assert sentence.startswith(f"{second.name}: axle loads sum to")


def test_another_loading_than_the_file_says_is_reported(tmp_path: Path) -> None:
    files, vehicle, signals = _case(tmp_path)
    vehicle.write_text(
        vehicle.read_text().replace("front_axle_load = 9674.0", "front_axle_load = 4000.0")
    )
    checks = load(files, vehicle, signals).checks
    assert any("another vehicle or another loading" in check for check in checks)


@pytest.mark.parametrize(
    ("without", "sentence"),
    [
        (("wheel_vertical",), "without wheel loads axle_load_harmonic and tyre_stiffness_change"),
        (("wheel_lateral",), "without wheel forces axles are distinguished only by the motion"),
        (("hitch",), "without the hitch force trailer mass and trailer forces"),
        (("trailer_yaw",), "sensor_delay of trailer_yaw_rate: not recorded"),
    ],
)
def test_missing_roles_say_what_cannot_be_tested(
    tmp_path: Path, without: tuple[str, ...], sentence: str
) -> None:
    files, vehicle, signals = _case(tmp_path, without=without)
    loaded = load(files, vehicle, signals)
    assert loaded.problem is not None
    assert any(sentence in text for text in _untestable(loaded.problem, library()))
    assert any(text.startswith("not recorded: ") for text in loaded.checks)


def test_without_steering_nothing_can_be_driven(tmp_path: Path) -> None:
    files, vehicle, signals = _case(tmp_path, without=("steering",))
    with pytest.raises(
        SignalError, match="no steering_wheel_angle; the model cannot run without it"
    ):
        load(files, vehicle, signals)


def test_without_yaw_rates_it_cannot_say(tmp_path: Path) -> None:
    files, vehicle, signals = _case(tmp_path, without=("car_yaw", "trailer_yaw"))
    result = diagnose(files, vehicle, signals)
    assert result["verdict"] == "unexplained"
    assert result["effects"] == []
    assert (
        "cannot say: neither car_yaw_rate nor trailer_yaw_rate"
        in result["unexplained"][0]["reason"]
    )


def test_a_short_recording_is_not_judged(tmp_path: Path) -> None:
    files, vehicle, signals = _case(tmp_path, seconds=4.0)
    result = diagnose(files, vehicle, signals)
    assert result["verdict"] == "unexplained"
    assert all("cannot say: 4.0 s long" in note["reason"] for note in result["unexplained"])


def test_a_recording_without_excitation_is_not_judged(tmp_path: Path) -> None:
    files, vehicle, signals = _case(tmp_path)
    problem = synthetic((), seed=11)
    for path, run in zip(files, problem.runs, strict=True):
        calm = {n: v.mean() + 1e-3 * (v - v.mean()) for n, v in run.channels.items()}
        _write(path, run.time, calm)
    result = diagnose(files, vehicle, signals)
    assert any("no excitation" in note["reason"] for note in result["unexplained"])


def test_one_short_run_of_two_is_left_out_and_said(tmp_path: Path) -> None:
    files, vehicle, signals = _case(tmp_path / "long")
    short, _, _ = _case(tmp_path / "short", seconds=4.0)
    loaded = load([files[0], short[1]], vehicle, signals)
    assert loaded.problem is not None
    assert len(loaded.problem.runs) == 1
    assert any("run 2: cannot say" in text for text in loaded.cannot)


def test_order_and_names_of_the_files_do_not_matter(tmp_path: Path) -> None:
    """The search sees the very same numbers, so that the verdict is the same."""
    files, vehicle, signals = _case(tmp_path)
    renamed = [tmp_path / "b.csv", tmp_path / "a.csv"]
    for old, new in zip(files, renamed, strict=True):
        new.write_bytes(old.read_bytes())
    problems = [
        load(paths, vehicle, signals).problem
        for paths in (files, files[::-1], renamed, renamed[::-1])
    ]
    first = problems[0]
    assert first is not None
    for other in problems[1:]:
        assert other is not None
        for one, two in zip(first.runs, other.runs, strict=True):
            assert one.channels.keys() == two.channels.keys()
            assert all(np.array_equal(one.channels[k], two.channels[k]) for k in one.channels)
            assert one.noise == two.noise


def test_a_simulation_on_another_clock_is_aligned(tmp_path: Path) -> None:
    files, vehicle, signals = _case(tmp_path, seconds=16.0)
    problem = load(files[:1], vehicle, signals).problem
    assert problem is not None
    run = problem.runs[0]
    late = _write(tmp_path / "simulation.csv", run.time + 0.43, run.channels)
    offset, score = clock_offset(run, run.time + 0.43, run.channels["steering_wheel_angle"])
    assert offset == pytest.approx(0.43, abs=0.006)
    assert score > 0.99
    free, _, checks = attach(problem, [late], signals)
    # files begin with their first sample, so a shift of all of it is no offset; one inside is
    assert free.runs[0].correction
    assert not any("clock" in check for check in checks)
    early = {n: v[60:] for n, v in run.channels.items()}
    cut = _write(tmp_path / "cut.csv", run.time[60:], early)
    _, _, checks = attach(load(files[:1], vehicle, signals).problem or problem, [cut], signals)
    assert any("the simulation's clock is -0.600 s ahead; aligned" in c for c in checks)


def test_a_simulation_of_another_manoeuvre_is_refused(tmp_path: Path) -> None:
    files, vehicle, signals = _case(tmp_path)
    problem = load(files[:1], vehicle, signals).problem
    assert problem is not None
    run = problem.runs[0]
    other = run.channels | {"steering_wheel_angle": 0.1 * np.sin(9.0 * run.time)}
    wrong = _write(tmp_path / "simulation.csv", run.time, other)
    with pytest.raises(RecordingError, match="no simulation has its steering"):
        attach(problem, [wrong], signals)


def test_a_run_to_predict_that_is_too_short_is_refused(tmp_path: Path) -> None:
    files, _, signals = _case(tmp_path, seconds=4.0)
    with pytest.raises(RecordingError, match="at least 6 s needed"):
        load_with_body(files[0], signals, BODY_VALUES, 15.0)


def test_adding_one_file_adds_an_explanation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "nose_wheel_drag.py").write_text(
        '"""A dragging nose wheel, one file."""\n'
        "import numpy as np\n"
        "from swaywatch.effects.effect import Effect, Parameter\n"
        "def act(plant, run, values, windows):\n"
        "    plant.add_series('moment_trailer', np.full(plant.speed.size, values['moment_nm']))\n"
        "EFFECTS = [Effect(id='nose_wheel_drag', component='trailer', kind='physics',\n"
        "    equation='N = moment', source='example', act=act,\n"
        "    parameters=(Parameter('moment_nm', 'Nm', 0.0, -1e4, 1e4, (50.0,), 5.0),))]\n"
    )
    package = importlib.import_module("swaywatch.effects.library")
    before = {effect.name for effect in library()}
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(tmp_path)])
    after = {effect.name for effect in library()}
    sys.modules.pop("swaywatch.effects.library.nose_wheel_drag", None)
    assert after - before == {"nose_wheel_drag:trailer"}


def test_the_report_has_all_its_chapters(diagnosed_p08: Path) -> None:
    page = (diagnosed_p08 / "report.html").read_text()
    for heading in (
        "Where measurement and model disagree", "What is missing", "How large it is",
        "The calibrated vehicle", "Simulation before and after", "Unexplained", "Checks",
    ):  # fmt: skip
        assert f">{heading}" in page
