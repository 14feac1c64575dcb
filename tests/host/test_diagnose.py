"""The diagnosis: library, plant, noise, bad input, practice cases."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import DATA, recordings

from swaywatch.diagnose.engine import diagnose
from swaywatch.diagnose.evidence.search import reduced_chi_square
from swaywatch.diagnose.fit.data import load
from swaywatch.diagnose.fit.fit import Fit, Fitter, Problem, predict_run
from swaywatch.diagnose.predict import predict
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect, Parameter, library
from swaywatch.effects.runs import Run
from swaywatch.errors import SwaywatchError
from swaywatch.plant.lanes import BODY, OUTPUT, PlantInput, simulate

WORDS = {
    "steering_compliance", "steering_free_play", "axle_load_harmonic", "tyre_relaxation",
    "tyre_saturation", "tyre_load_sensitivity", "tyre_stiffness_change", "hitch_friction",
    "hitch_damping", "trailer_aerodynamics", "roll_steer", "crosswind_gust", "road_bank",
    "sensor_delay", "sensor_gain", "sensor_roll_gravity", "parameter_error", "damper_fade",
    "damper_asymmetry", "friction_reduction", "roll_stiffness_change",
    "drawbar_compliance",
}  # fmt: skip
BODY_VALUES = np.array(
    [1955, 2690, 1.302, 1.383, 2.166, 109300, 185200, 1880, 10350, 0.124, 0.526, 5.073,
     131200, 124400, 9674, 10204, 9226, 8517], dtype=float,
)  # fmt: skip
_LOADS = [f"wheel_vertical_load_{w}" for w in ("fl", "fr", "rl", "rr")]


def synthetic(terms: tuple[ActiveEffect, ...], seed: int, duration_s: float = 25.0) -> Problem:
    """Two runs of the plant with sensor noise."""
    rng = np.random.default_rng(seed)
    runs = []
    for number, speed in enumerate((31.0, 25.0)):
        time = np.arange(0.0, duration_s, 0.01)
        wheel = 0.02 * np.sin(2 * np.pi * 0.6 * time) + 0.15 * np.exp(-(((time - 5) / 0.4) ** 2))
        channels = {
            "steering_wheel_angle": wheel * (1.0 + number),
            "speed": np.full(time.size, speed) + rng.normal(0, 0.01, time.size),
        }
        run = Run(f"run {number}", time, channels, {"car_lateral_acceleration": -1.383}, 15.0)
        run.steer = channels["steering_wheel_angle"] / 15.0
        run.speed = np.full(time.size, speed)
        run.acceleration = np.zeros(time.size)
        out = predict_run(Problem((run,), BODY_VALUES), 0, terms, np.zeros(5), np.zeros(0))
        for name, noise in (
            ("car_yaw_rate", 1e-3), ("trailer_yaw_rate", 1e-3),
            ("car_lateral_acceleration", 0.03), ("trailer_lateral_acceleration", 0.03),
            ("hitch_lateral_force", 10.0), *((f"wheel_lateral_force_{w}", 30.0) for w in
            ("fl", "fr", "rl", "rr")), *((name, 60.0) for name in _LOADS),
        ):  # fmt: skip
            channels[name] = out[name] + rng.normal(0.0, noise, time.size)
        runs.append(run.prepare())
    return Problem(tuple(runs), BODY_VALUES)


def effect(name: str) -> Effect:
    """By id and component."""
    return next(e for e in library() if e.name == name)


def test_library_covers_every_word() -> None:
    assert {e.id for e in library()} == WORDS


def test_steady_state_is_that_of_the_single_track() -> None:
    n = 4000
    plant = PlantInput(
        0.01, np.full(n, 20.0), np.zeros(n), np.full(n, 1e-4), BODY_VALUES.copy()
    )  # fmt: skip
    result = simulate(plant)[-1]
    assert result[OUTPUT.index("car_yaw_rate")] / 1e-4 == pytest.approx(4.98953, rel=1e-3)
    assert result[OUTPUT.index("articulation")] / 1e-4 == pytest.approx(-1.37428, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("hitch_friction:hitch", 90.0),
        ("tyre_relaxation:car_rear", 0.6),
        ("parameter_error:trailer.mass", 1.08),
        ("sensor_delay:trailer_yaw_rate", 0.04),
        ("tyre_load_sensitivity:all", 0.3),
    ],
)
def test_fit_finds_the_value(name: str, value: float) -> None:
    found = effect(name)
    rest = tuple(p.neutral for p in found.parameters[1:])
    problem = synthetic((ActiveEffect(found, (value, *rest)),), seed=1)
    fitter = Fitter(problem)
    start = fitter.start()
    term = ActiveEffect(found, tuple(p.starts[0] for p in found.parameters))
    fit = fitter.run(Fit((term,), start.nuisance, start.shift), 12)
    assert fit.terms[0].values[0] == pytest.approx(value, rel=0.05)
    assert reduced_chi_square(fit) < 1.5
    assert reduced_chi_square(fitter.run(start, 8)) > reduced_chi_square(fit)


def test_a_module_is_one_more_effect() -> None:
    def act(plant: PlantInput, run: Run, values: dict[str, float], windows: object) -> None:
        del run, windows
        plant.add_series("moment_car", np.full(plant.speed.size, values["moment_nm"]))

    extra = Effect(
        id="constant_moment", component="car", kind="physics", equation="N = moment",
        source="example", act=act,
        parameters=(Parameter("moment_nm", "Nm", 0.0, -1e4, 1e4, (50.0,), 5.0),),
    )  # fmt: skip
    assert extra in library([extra])
    problem = synthetic((ActiveEffect(extra, (300.0,)),), seed=2)
    outputs = predict_run(problem, 0, (), np.zeros(5), np.zeros(0))
    assert np.std(outputs["car_yaw_rate"]) > 0.0


def _case(*parts: str) -> Path:
    return recordings(*parts)


def test_a_recording_without_excitation_is_not_judged(tmp_path: Path) -> None:
    case = _case("practice", "p01")
    run = case / "run1.blf"
    loaded = load([run], case / "vehicle.toml", case / "signals.toml")
    assert loaded.problem is not None
    short = Run("x", np.arange(300) / 100.0, {"speed": np.full(300, 30.0)}, {}, 15.0)
    from swaywatch.diagnose.fit.data import _too_little

    assert "cannot say" in _too_little(short)
    del tmp_path


def test_predict_refuses_what_is_no_model(tmp_path: Path) -> None:
    bad = tmp_path / "diagnosis.json"
    bad.write_text("{}")
    with pytest.raises(SwaywatchError, match="holds no model"):
        predict(bad, tmp_path / "run.blf")


LONG = [pytest.param(name, marks=pytest.mark.long) for name in ("p06", "p10")]


@pytest.mark.parametrize("name", ["p01", "p02", "p04", "p05", "p07", "p09", *LONG])
def test_practice_case(name: str) -> None:
    case = _case("practice", name)
    result = diagnose(sorted(case.glob("run*.*")), case / "vehicle.toml", case / "signals.toml")
    _is_right(result, case)


def test_practice_case_alone(diagnosed_p08: Path) -> None:
    result = json.loads((diagnosed_p08 / "diagnosis.json").read_text())
    _is_right(result, _case("practice", "p08"))


def test_practice_case_by_the_command(diagnosed_p03: Path) -> None:
    result = json.loads((diagnosed_p03 / "diagnosis.json").read_text())
    _is_right(result, DATA / "practice" / "p03")


def _is_right(result: dict[str, Any], case: Path) -> None:
    """Name, place and size of what is concealed, and nothing else."""
    truth = json.loads((case / "truth.json").read_text())["effects"]
    assert [e["id"] for e in result["effects"]] == [e["id"] for e in truth]
    for said, true in zip(result["effects"], truth, strict=True):
        for key, value in true.items():
            if isinstance(value, float):
                assert said["parameters"][key]["value"] == pytest.approx(value, rel=0.25)
            elif key in ("axle", "parameter", "channel"):
                assert value in (said["component"], said["role"])
    for fit in (e["fit"] for e in result["effects"] if e["fit"]):
        assert fit["diagnosed_nrmse"] < 0.97 * fit["baseline_nrmse"]
        assert fit["diagnosed_nrmse"] < 0.97 * fit["as_written_nrmse"]


assert len(BODY) == BODY_VALUES.size
