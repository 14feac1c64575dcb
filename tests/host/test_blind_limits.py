"""What an effect leaves in its recordings: less where less is known, more where more is seen."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).parents[1] / "proof" / "blind"))

import explanations
import information
import own_limits
from information import Wrong, limit_of, with_prior
from own_limits import Concealed, Known

from swaywatch.diagnose.fit.fit import COMPARED, NUISANCES, Fit, Fitter, predict_run
from swaywatch.effects.runs import RATE_HZ, Run
from swaywatch.vehicle_file import load_vehicle

VEHICLE = load_vehicle(Path(__file__).parents[1] / "data" / "practice" / "p01" / "vehicle.toml")
ROLL = {"gain_car": 0.0115, "gain_trailer": 0.015, "frequency": 13.0, "damping": 0.112}
KNOWN = Known(exact=False, slots={}, springs=False)
CAR = ("car_yaw_rate", "car_lateral_acceleration")
ALL = tuple(
    name
    for name in COMPARED
    if not name.startswith("trailer_wheel") and name not in ("articulation", "hitch_vertical_force")
)


@pytest.fixture(autouse=True)
def one_thread():
    """Small matrices: threads would wait for each other."""
    with threadpool_limits(1):
        yield


def drive(seconds=30.0, names=ALL):
    """Two runs; what the channels show does not matter, for nothing reads a recording."""
    time = np.arange(0.0, seconds, 1.0 / RATE_HZ)
    runs = []
    for speed, hertz in ((26.0, 0.5), (22.0, 0.8)):
        steer = np.radians(10.0) * np.sin(2.0 * np.pi * hertz * time) * (time % 15.0 > 2.0)
        channels = {name: np.sin(time) for name in names}
        run = Run("run", time, channels, {}, VEHICLE.car.steering_ratio)
        run.speed, run.acceleration = np.full_like(time, speed), np.zeros_like(time)
        run.steer = steer / VEHICLE.car.steering_ratio
        run.scales = {name: own_limits.noise(name) * information.BLOCK_NOISE for name in names}
        runs.append(run)
    return tuple(runs)


def effect(effect_id="hitch_friction", **values):
    truth = {"id": effect_id, **(values or {"moment_nm": 60.0})}
    return Concealed(explanations.concealed(truth, [], ROLL, {}), {})


def limits(*concealed, runs=None, known=KNOWN):
    problem = own_limits.problem_of(runs or drive(), VEHICLE, known)
    return own_limits.limits(problem, known, concealed)


def test_a_stronger_effect_leaves_more():
    weak, strong = (limits(effect(moment_nm=size))[0] for size in (20.0, 60.0))
    assert strong.detect > 2.0 * weak.detect
    assert strong.name > 2.0 * weak.name


def test_more_samples_leave_more():
    short, long = (limits(effect(), runs=drive(seconds))[0] for seconds in (15.0, 60.0))
    assert long.detect > 1.5 * short.detect
    assert long.name > 1.5 * short.name


def test_without_the_trailers_sensors_and_forces_less_is_left():
    everything, own = (limits(effect(), runs=drive(names=names))[0] for names in (ALL, CAR))
    assert own.detect < 0.7 * everything.detect
    assert own.name < 0.7 * everything.name


def test_less_noise_leaves_more():
    runs = drive()
    for run in runs:
        run.scales = {name: 0.5 * scale for name, scale in run.scales.items()}
    assert limits(effect(), runs=runs)[0].detect > 1.2 * limits(effect())[0].detect


def test_what_is_not_known_exactly_takes_away():
    exact = limits(effect(), known=replace(KNOWN, exact=True))[0]
    sensors = limits(effect(), known=replace(KNOWN, sensors=False))[0]
    both = limits(effect())[0]
    assert both.detect < 0.9 * exact.detect
    assert both.detect <= sensors.detect


def test_a_wrong_value_leaves_no_more_than_its_tolerances():
    """Inside its tolerance it is no finding, however well the recording shows it."""
    within, beyond = (limits(Concealed(None, {"trailer.mass": share}))[0] for share in (0.01, 0.15))
    assert within.detect < 1.5
    assert beyond.detect > 5.0
    assert beyond.detect == pytest.approx(15.0 * within.detect, rel=1e-6)


def test_axle_loads_of_the_file_speak_against_a_wrong_mass():
    wrong = Concealed(None, {"trailer.mass": 0.15})
    weighed = own_limits.problem_of(drive(), VEHICLE, KNOWN)
    assert weighed.beliefs.weighings
    never = replace(weighed, beliefs=replace(weighed.beliefs, weighings=()))
    with_loads, without = (
        own_limits.limits(problem, KNOWN, [wrong])[0] for problem in (weighed, never)
    )
    assert without.detect < with_loads.detect < 0.15 / 0.015  # tolerances off: no more than these


def test_an_effect_like_what_is_believed_hides_there():
    """A gain of one half per cent is the tolerance of a sensor."""
    small = limits(effect("sensor_gain", channel="YawRate1", factor=1.005))[0]
    assert small.detect < 1.0


def test_two_effects_leave_less_each_than_alone():
    friction, damping = effect(), effect("hitch_damping", coefficient_nms_per_rad=600.0)
    alone = limits(friction)[0]
    beside = limits(friction, damping)
    assert len(beside) == 2
    assert beside[0].detect < 0.95 * alone.detect
    assert all(own.name <= own.detect for own in beside)


def test_the_best_wrong_effect_is_another_one():
    found = limits(effect())[0]
    assert found.name < found.detect
    assert not found.best_wrong.startswith("hitch_friction")


def test_every_effect_that_is_drawn_is_in_the_library():
    """Of each kind that a case conceals, in each form: it changes the channels."""
    windows = [(0, (8.0, 11.0)), (1, (8.0, 11.0))]
    loads = {"harmonic": [{"amplitude_n": 400.0, "phase_deg": 30.0}] * 2}
    always = [
        {"id": "steering_compliance", "stiffness_n_per_rad": 1e6},
        {"id": "steering_free_play", "gap_deg": 1.0, "law": "backlash"},
        {"id": "steering_free_play", "gap_deg": 1.0, "law": "aligned"},
        {"id": "tyre_relaxation", "axle": "trailer", "length_m": 0.4},
        {"id": "tyre_saturation", "peak_friction": 1.0},
        {"id": "tyre_load_sensitivity", "degression": 0.3},
        {"id": "hitch_damping", "coefficient_nms_per_rad": 500.0},
        {"id": "trailer_aerodynamics", "side_force_coefficient": 1.0,
         "yaw_moment_coefficient": 0.5},
        {"id": "roll_steer", "axle": "car_front", "coefficient": 0.05},
        {"id": "sensor_delay", "channel": "LatAcc2", "delay_s": 0.03},
        {"id": "sensor_roll_gravity", "channel": "LatAccRear1", "share_of_roll": 0.8},
    ]  # fmt: skip
    at_times = [
        {"id": "axle_load_harmonic", "axle": "car_rear"},
        {"id": "tyre_stiffness_change", "axle": "trailer", "factor": 0.9},
        {"id": "crosswind_gust", "body": "car", "force": 500.0},
        {"id": "road_bank", "angle_deg": 1.0, "sensing": "motion"},
        {"id": "road_bank", "angle_deg": 1.0, "sensing": "specific_force"},
    ]
    runs = drive(names=ALL)
    for truth in always:
        found = limits(Concealed(explanations.concealed(truth, [], ROLL, {}), {}), runs=runs)
        assert 0.0 < found[0].name < found[0].detect, truth
    for truth in at_times:
        concealed = Concealed(explanations.concealed(truth, windows, ROLL, loads), {})
        assert limits(concealed, runs=runs)[0].name > 0.0, truth


def test_a_refit_without_the_effect_leaves_about_as_much():
    """No linearisation: the effect is taken away in steps, the rest fitted to what it had made."""
    concealed = effect()
    problem = own_limits.problem_of(drive(), VEHICLE, KNOWN)
    true = (concealed.effect(1.0),)
    rest = problem.at_rest()
    for index, run in enumerate(problem.runs):
        shown = predict_run(problem, index, true, np.zeros(NUISANCES), rest)
        run.channels.update({name: shown[name] for name in run.scales})
    target = tuple(replace(w, off=0.0) for w in problem.beliefs.weighings)
    problem = replace(problem, beliefs=replace(problem.beliefs, weighings=target))
    fitter, fit = Fitter(problem), Fit((), np.zeros((2, NUISANCES)), rest)
    for share in (0.8, 0.5, 0.25, 0.0):
        terms = (concealed.effect(share),) if share else ()
        fit = fitter.run(replace(fit, terms=terms), 6, free=0, tolerance=1e-4)
    left = float(np.sqrt(fit.chi2))
    assert 0.5 * left < limits(concealed)[0].detect < 2.0 * left


def test_projection_by_hand():
    """Two channels: an effect along (3, 4), a belief that can do the first alone."""
    change = np.array([3.0, 4.0, 0.0])
    belief = np.array([[1.0], [0.0]])
    free = limit_of(change, with_prior(belief, np.zeros((1, 1))), [])
    assert free.detect == pytest.approx(4.0)
    priced = limit_of(change, with_prior(belief, np.ones((1, 1))), [])
    # min over z of (3 - z)^2 + z^2 is 4.5
    assert priced.detect == pytest.approx(np.sqrt(4.5 + 16.0))
    other = Wrong("other", np.array([[0.0], [1.0], [0.0]]))
    named = limit_of(change, with_prior(belief, np.ones((1, 1))), [other])
    assert named.name == pytest.approx(np.sqrt(4.5))
    assert named.best_wrong == "other"


def test_taking_more_away_never_leaves_more():
    rng = np.random.default_rng(5)
    change = rng.normal(size=40)
    nuisance = with_prior(rng.normal(size=(36, 3)), np.eye(4, 3))
    wrong = [Wrong(str(k), rng.normal(size=(40, 2))) for k in range(6)]
    few, many = limit_of(change, nuisance, wrong[:2]), limit_of(change, nuisance, wrong)
    assert many.name <= few.name < few.detect < float(np.linalg.norm(change))
    wider = np.hstack([nuisance, wrong[0].directions])
    assert limit_of(change, wider, []).detect < few.detect
    run_away = Wrong("run away", np.full((40, 1), np.nan))
    assert limit_of(change, nuisance, [run_away]).name == pytest.approx(few.detect)
