"""Limits of generated cases: the right vehicle and effect, kept, and what MuJoCo itself shows."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

pytest.importorskip("mujoco")

sys.path.insert(0, str(Path(__file__).parents[1] / "proof" / "blind"))

import beside_limits
import case_limits
import effects
import generate
import own_limits

SEED, INDEX = 20261103, 7  # friction at the ball of a rigid combination
SIMULATED = (20261103, 1)
ANSWER = {"run1": {"v_kmh": 95.0}, "run2": {"v_kmh": 80.0}}


@pytest.fixture(autouse=True)
def one_thread():
    """Small matrices: threads would wait for each other."""
    with threadpool_limits(1):
        yield


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A case with its files: folder of cases, of answers, name."""
    folder = tmp_path_factory.mktemp("limits")
    cases, answers = folder / "cases", folder / "answers"
    generate.generate(SEED, 0, cases, answers, 1)
    return cases, answers, generate.make_case(SEED, INDEX, cases, answers)


def run_job(made, seed=SEED):
    cases, answers, name = made
    case_limits._job((seed, cases, answers / name, None, "method"))
    return answers / name / case_limits.FILE


def test_a_limit_is_written_beside_the_answer_and_kept(made):
    file = run_job(made)
    written = json.loads(file.read_text())
    (limit,) = written["limits"]
    answer = json.loads((file.parent / "answer.json").read_text())
    assert limit["id"] == answer["effects"][0]["id"]
    assert 0.0 < limit["name"] <= limit["detect"]
    before = file.stat().st_mtime_ns
    run_job(made)
    assert file.stat().st_mtime_ns == before
    file.write_text(json.dumps(written | {"digest": "of another method"}))
    again = json.loads(run_job(made).read_text())
    assert again["digest"] == written["digest"]
    assert again["limits"] == written["limits"]


def test_cases_of_another_seed_are_refused(made):
    _, answers, name = made
    (answers / name / case_limits.FILE).unlink(missing_ok=True)
    with pytest.raises(ValueError, match="not of seed 8"):
        run_job(made, 8)


def test_the_packages_plant_and_mujoco_see_the_same_change(made):
    """Two plants that share no code: how far the channels are off without the effect."""
    cases, answers, name = made
    answer = json.loads((answers / name / "answer.json").read_text())
    case = generate.draw_case(SEED, INDEX)
    seen = beside_limits.Seen(case, answer)
    judge = float(np.linalg.norm(seen.change(case.draws, [])))
    true = case_limits.vehicle_of(case, {})
    known = own_limits.Known(False, case_limits.slots_of(case), False)
    runs = own_limits.runs_of(cases / name, true, case.noise_factor)
    problem = own_limits.problem_of(runs, true, known)
    concealed = [case_limits.concealed_of(case, case.draws[0], answer)]
    point = own_limits._Point(problem, known, concealed)
    without = float(np.linalg.norm(point.channels([()])[0] - point.base))
    assert without == pytest.approx(judge, rel=0.2)


def test_values_of_a_wrong_file_are_what_was_drawn():
    case = generate.draw_case(SEED, INDEX)
    user = {"trailer.mass": 1.1, "car.steering_ratio": 0.95, "car.hitch_to_cog": 1.05}
    true, believed = case_limits.vehicle_of(case, {}), case_limits.vehicle_of(case, user)
    found = own_limits.wrong_values(true, believed)
    assert set(found) == set(user)
    assert found["trailer.mass"] == pytest.approx(0.1, abs=1e-4)
    assert found["car.steering_ratio"] == pytest.approx(-0.05, abs=1e-4)
    length = case.healthy.car.hitch_to_cog_m
    assert found["car.hitch_to_cog"] == pytest.approx(length - length / 1.05, abs=1e-4)


def test_outside_the_library_and_clean_have_no_limit():
    case = generate.draw_case(SEED, INDEX)
    outside = replace(case, draws=[effects.outside_slosh(np.random.default_rng(1), 0.8)])
    for nothing in (replace(case, draws=[]), outside):
        assert case_limits.limits_of(nothing, {}, Path("nowhere")) == []


def test_beside_a_simulation_a_stronger_effect_leaves_more(monkeypatch):
    """Four drives of the plant each; wrong effects are not looked for."""
    monkeypatch.setattr(beside_limits, "NAMEABLE", np.inf)
    case = generate.draw_case(*SIMULATED)
    left = []
    for strength in (0.3, 0.7):
        draw = effects.hitch_damping(np.random.default_rng(1), strength)
        (limit,) = beside_limits.limits(replace(case, draws=[draw]), ANSWER)
        left.append(limit.detect)
    assert left[1] > 2.0 * left[0] > 0.0


def test_beside_a_simulation_a_gain_inside_its_tolerance_leaves_nothing(monkeypatch):
    monkeypatch.setattr(beside_limits, "NAMEABLE", np.inf)
    draw = effects.sensor_gain(np.random.default_rng(1), 0.5)
    draw.sensors = {"YawRate1": {"gain": 1.005}}
    case = replace(generate.draw_case(*SIMULATED), draws=[draw])
    (limit,) = beside_limits.limits(case, ANSWER)
    assert limit.detect < 1.01


def test_wrong_effects_beside_a_simulation_are_all_the_others():
    case = generate.draw_case(*SIMULATED)
    assert case.draws[0].answer["id"] == "axle_load_harmonic"
    found = dict(beside_limits.wrong_draws(case))
    true = f"axle_load_harmonic:{case.draws[0].answer['axle']}"
    assert true not in found
    ids = {name.split(":")[0] for name in found}
    assert ids >= {function.__name__ for function in effects.WITH_SIMULATION} - {true}
    assert {f"tyre_relaxation:{axle}" for axle in effects.AXLE_NUMBERS} <= set(found)
    assert len(found["trailer_aerodynamics"]) == 2
    (gust, *_) = found["crosswind_gust:car"]
    assert gust.windows["run1"] == case.draws[0].windows["run1"]
    always = replace(case, draws=[effects.hitch_damping(np.random.default_rng(1), 0.5)])
    assert not any(draw.windows for _, some in beside_limits.wrong_draws(always) for draw in some)


def test_another_kind_of_damper_is_no_wrong_name_for_a_fade():
    case = generate.draw_case(*SIMULATED)
    kind = generate.beside.damper_kind(np.random.default_rng(1), 2)
    axle = kind.answer["axle"]
    names = {name for name, _ in beside_limits.wrong_draws(replace(case, draws=[kind]))}
    assert not any(name.startswith(f"damper_fade:{axle}") for name in names)
    assert any(name.startswith("damper_fade:") for name in names)
