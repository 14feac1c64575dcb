"""Prediction of a run that was held back: from committed verdicts and from a made-up model."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import recordings
from numpy.typing import NDArray

from swaywatch.diagnose.engine import write
from swaywatch.diagnose.fit import data
from swaywatch.diagnose.fit.beliefs import beliefs_of
from swaywatch.diagnose.fit.fit import Fit, predict_run
from swaywatch.diagnose.fit.holdout import held_out
from swaywatch.diagnose.model import embedded, model_block, read_model, signals_for, terms_of
from swaywatch.diagnose.predict import _split, blind_run, predict
from swaywatch.drive import Drive, load_drives, load_signals
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library
from swaywatch.errors import SignalError, SwaywatchError
from swaywatch.plant.lanes import BODY

Array = NDArray[np.float64]
VERDICTS = Path(__file__).resolve().parent.parent / "proof" / "verdicts" / "practice"


def _effect(name: str, form: object = None) -> object:
    return next(e for e in library() if e.name == name and e.extra.get("form") == form)


def _copy(case: str, folder: Path) -> Path:
    """The committed verdict of a practice case, somewhere else."""
    target = folder / "model.json"
    shutil.copy(VERDICTS / f"{case}.json", target)
    return target


def _record(monkeypatch: pytest.MonkeyPatch, name: str, fault: Callable[[Array], Array]) -> None:
    """Recordings are read with a fault in one channel."""

    def read(paths: list[Path], signals: Path) -> list[Drive]:
        drive = load_drives(paths, signals)[0]
        channel = drive.channels[name]
        changed = {name: replace(channel, value=fault(channel.value))}
        return [replace(drive, channels=drive.channels | changed)]

    monkeypatch.setattr(data, "load_drives", read)


def test_a_committed_verdict_predicts_a_run(tmp_path: Path) -> None:
    run = sorted(recordings("practice", "p07").glob("run2.*"))[0]
    result = predict(_copy("p07", tmp_path), run)
    assert result["diagnosed_nrmse"] < 0.2 * result["baseline_nrmse"]
    assert result["diagnosed_nrmse_after_start"] < 0.05
    assert result["effects_applied"] == ["hitch_friction:hitch"]
    assert any("speed" in line for line in result["taken_from_recording"])


def test_a_sensor_that_a_diagnosis_puts_right_is_put_right_here_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = sorted(recordings("practice", "p07").glob("run2.*"))[0]
    _record(monkeypatch, "steering_wheel_angle", lambda value: -value)
    result = predict(_copy("p07", tmp_path), run)
    assert result["diagnosed_nrmse_after_start"] < 0.05
    assert any("SteeringWheelAngle" in note for note in result["notes"])


def test_a_sensor_that_freezes_is_left_out_where_it_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = sorted(recordings("practice", "p07").glob("run2.*"))[0]

    def frozen(value: Array) -> Array:
        held = value.copy()
        held[value.size // 3 : value.size // 2] = value[value.size // 3]
        return held

    _record(monkeypatch, "car_yaw_rate", frozen)
    result = predict(_copy("p07", tmp_path), run)
    assert result["diagnosed_nrmse_after_start"] < 0.05
    assert any("frozen" in note for note in result["notes"])


def test_dampers_of_a_vehicle_without_springs_are_refused(tmp_path: Path) -> None:
    """Models beside a simulation had none once; their dampers would do nothing, and say nothing."""
    run = sorted(recordings("practice", "p01").glob("run2.*"))[0]
    model = _copy("p01", tmp_path)
    content = json.loads(model.read_text())
    content["model"]["terms"] = [
        {"id": "damper_fade", "component": "car_rear", "form": "both",
         "values": [0.5, 0.0, 0.0, 0.0], "window_runs": []}
    ]  # fmt: skip
    model.write_text(json.dumps(content))
    with pytest.raises(SwaywatchError, match=r"damper_fade acts on springs.*diagnose again"):
        predict(model, run)


def test_no_effect_gives_equal_scores(tmp_path: Path) -> None:
    run = sorted(recordings("practice", "p01").glob("run2.*"))[0]
    result = predict(_copy("p01", tmp_path), run)
    assert result["baseline_nrmse"] == result["diagnosed_nrmse"]
    assert any("no effect" in note for note in result["notes"])


def test_windows_are_found_and_scored_apart(tmp_path: Path) -> None:
    run = recordings("practice", "p03", "run1.asc")
    truth = json.loads(recordings("practice", "p03", "truth.json").read_text())["run1"]["windows"]
    result = predict(_copy("p03", tmp_path), run)
    assert result["diagnosed_with_windows_nrmse"] < 0.3 * result["diagnosed_nrmse"]
    # the baseline's values have bent towards an effect that it does not have
    assert result["diagnosed_with_windows_nrmse"] < 0.5 * result["baseline_nrmse"]
    found = [(w["start"], w["stop"]) for w in result["windows_found"]]
    assert np.allclose(found, truth, atol=0.3)


def test_windows_are_not_invented(tmp_path: Path) -> None:
    """A healthy run of the same combination holds none of them."""
    run = sorted(recordings("practice", "p01").glob("run1.*"))[0]
    result = predict(_copy("p03", tmp_path), run)
    assert result["windows_found"] == []


def test_windows_over_whole_runs_are_permanent() -> None:
    from test_diagnose import synthetic

    effect = _effect("tyre_stiffness_change:car_rear")
    term = ActiveEffect(effect, (0.1, 24.8, 0.8, -0.2, 12.0, 0.9, 12.1, 24.9, 0.9), (0, 1, 1))  # type: ignore[arg-type]
    problem = synthetic((), seed=4)
    runs = [{"name": run.name, "duration_s": 25.0} for run in problem.runs]
    lasting, windowed = _split((term,), runs, problem.runs[0])
    assert not windowed
    assert lasting[0].values[2] == pytest.approx(0.85, abs=0.01)
    assert _split((term,), [], problem.runs[0])[1] == (term,)
    short = ActiveEffect(effect, (3.0, 9.0, 0.8), (0,))  # type: ignore[arg-type]
    assert _split((short,), runs, problem.runs[0])[1] == (short,)


def test_a_prediction_does_not_see_the_outputs() -> None:
    """Replace everything measured but steering and speed: the prediction stays the same."""
    from test_diagnose import synthetic

    effect = _effect("axle_load_harmonic:car_rear")
    term = ActiveEffect(effect, (-1.0, 26.0, 800.0, 0.0), (0,))  # type: ignore[arg-type]
    shared = np.zeros(0)
    predictions = []
    for spoiled in (False, True):
        problem = synthetic((), seed=5)
        if spoiled:
            for name, value in list(problem.runs[0].channels.items()):
                if name not in ("steering_wheel_angle", "speed"):
                    problem.runs[0].channels[name] = -3.0 * value
        predictions.append(blind_run(problem, (term,), np.zeros(5), shared))
    assert np.array_equal(predictions[0]["car_yaw_rate"], predictions[1]["car_yaw_rate"])
    plain = predict_run(synthetic((), seed=5), 0, (), np.zeros(5), shared)
    assert not np.allclose(plain["car_yaw_rate"], predictions[0]["car_yaw_rate"], atol=1e-5)


def test_a_left_out_run_values_windows_by_the_others() -> None:
    from test_diagnose import synthetic

    effect = _effect("tyre_stiffness_change:car_rear")
    term = ActiveEffect(effect, (6.0, 12.0, 0.8, 8.0, 14.0, 0.8), (0, 1))  # type: ignore[arg-type]
    problem = synthetic((term,), seed=6)
    alone = Fit((), np.zeros((2, 5)), np.zeros(0))
    block = held_out(problem, Fit((term,), np.zeros((2, 5)), np.zeros(0)), alone)
    assert block["held_out_diagnosed_nrmse"] < 0.5 * block["held_out_baseline_nrmse"]
    assert any("values from the windows of the other runs" in s for s in block["held_out_how"])
    single = ActiveEffect(effect, (6.0, 12.0, 0.8), (0,))  # type: ignore[arg-type]
    block = held_out(problem, Fit((single,), np.zeros((2, 5)), np.zeros(0)), alone)
    assert block["held_out_diagnosed_nrmse"] is None
    assert any("no other window gives their values" in s for s in block["held_out_how"])


def test_a_left_out_run_is_compared_with_the_vehicle_calibrated_to_the_others() -> None:
    """A wrong stiffness is no merit of the finding: calibration alone mends it."""
    from test_diagnose import synthetic

    truth = synthetic((), seed=7)
    body = truth.body.copy()
    body[BODY.index("trailer.rear_cornering_stiffness")] *= 1.1
    problem = replace(truth, body=body, beliefs=beliefs_of(body, truth.channels(truth.runs[0])))
    nothing = np.zeros(len(problem.beliefs.items))
    alone = Fit((), np.zeros((2, 5)), nothing)
    friction = _effect("hitch_friction:hitch")
    term = ActiveEffect(friction, (1.0, 0.01), ())  # type: ignore[arg-type]
    fit = Fit((term,), np.zeros((2, 5)), nothing)
    written, calibrated = (held_out(problem, fit, alone, calibrated=c) for c in (False, True))
    key = "held_out_baseline_nrmse"
    assert calibrated[key] < 0.3 * written[key]
    assert calibrated["held_out_diagnosed_nrmse"] > 0.5 * calibrated[key]


def test_a_model_survives_the_way_through_json() -> None:
    from test_diagnose import synthetic

    friction = _effect("hitch_friction:hitch")
    terms = (
        ActiveEffect(friction, tuple(p.starts[0] for p in friction.parameters)),  # type: ignore[attr-defined,arg-type]
        ActiveEffect(_effect("crosswind_gust:car", "half_sine"), (3.0, 6.0, 500.0, 0.4), (1,)),  # type: ignore[arg-type]
    )
    problem = synthetic((), seed=7)
    fit = Fit(terms, np.zeros((2, 5)), np.zeros(0))
    block = model_block(problem, fit, fit)
    back = terms_of(json.loads(json.dumps(block))["terms"], library())
    assert [(t.effect.name, t.values, t.window_runs) for t in back] == [
        (t.effect.name, t.values, t.window_runs) for t in terms
    ]
    assert back[1].effect.extra["form"] == "half_sine"
    assert block["runs"][1]["duration_s"] == pytest.approx(24.99)
    # windows of an older model have no centre of pressure: it was the centre of gravity
    gust = block["terms"][1] | {"values": [3.0, 6.0, 500.0]}
    (old,) = terms_of([gust], library())
    assert old.values == (3.0, 6.0, 500.0, 0.0)


def test_the_mapping_travels_inside_the_model(tmp_path: Path) -> None:
    case = recordings("practice", "p03")
    inside = json.loads(json.dumps(embedded(case / "signals.toml")))
    with signals_for({"signals": inside}, tmp_path / "run.asc", None) as (source, words):
        mappings, databases = load_signals(source)
        assert databases[0].read_text() == (case.parent / "measurement.dbc").read_text()
        assert mappings == load_signals(case / "signals.toml")[0]
        assert "inside the model" in words
    with (
        pytest.raises(SignalError, match="no role mapping"),
        signals_for({}, tmp_path / "run.asc", None),
    ):
        pass


@pytest.mark.parametrize(
    ("text", "message"),
    [("{}", "holds no model"), ("[1]", "holds no model"), ("nonsense", "not a diagnosis.json")],
)
def test_what_is_no_model_is_refused(tmp_path: Path, text: str, message: str) -> None:
    bad = tmp_path / "diagnosis.json"
    bad.write_text(text)
    with pytest.raises(SwaywatchError, match=message):
        read_model(bad)
    with pytest.raises(SwaywatchError, match="cannot be read"):
        read_model(tmp_path / "absent.json")


def test_a_recording_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(SwaywatchError, match=r"run9.blf: no such file"):
        predict(_copy("p07", tmp_path), tmp_path / "run9.blf")


def test_a_number_that_is_none_becomes_null(tmp_path: Path) -> None:
    write(
        {"a": float("nan"), "b": [np.float64("inf"), 1.0], "c": {"d": np.arange(2.0)}},
        tmp_path / "x",
    )
    assert json.loads((tmp_path / "x").read_text()) == {
        "a": None, "b": [None, 1.0], "c": {"d": [0.0, 1.0]},
    }  # fmt: skip
