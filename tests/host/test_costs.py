"""What each cause costs in km/h: against eigenvalues, describing functions and long simulations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from conftest import DATA

from swaywatch.diagnose.fit.data import body_of
from swaywatch.effects.runs import Run
from swaywatch.models import modes
from swaywatch.models.costs import (
    SWINGS_RAD_S,
    Base,
    Cause,
    critical_speeds,
    double_frequency,
    slots,
    swings,
    weigh,
)
from swaywatch.models.double_track import DoubleTrack
from swaywatch.models.physics import PhysicsEffect
from swaywatch.plant.lanes import PlantInput, neutral
from swaywatch.vehicle_file import load_vehicle

VEHICLE = load_vehicle(DATA / "practice" / "p03" / "vehicle.toml")
BODY = body_of(VEHICLE)
BASE = Base(BODY, neutral())
KMH = 3.6


def linear(values: dict[str, float]) -> float:
    """Critical speed of the eigenvalues, km/h."""
    still = np.zeros(3)
    plant = PlantInput(0.002, still + 20.0, still, still, BODY, neutral())
    for name, value in values.items():
        plant.scalar(name, value)
    return KMH * modes.critical_speed(plant)


def critical(causes: tuple[Cause, ...], swing: float) -> float:
    """Critical speed at a size of the swing, km/h."""
    speed = critical_speeds([(BASE, causes, swing)])[0]
    assert speed is not None
    return KMH * speed


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"relaxation_car_rear": 0.7},
        {"steering_flexibility": 1e-6},
        {"hitch_damping": 600.0},
        {"aero_side": 1.8, "aero_yaw": 0.9},
    ],
)
def test_linear_causes_cost_what_eigenvalues_say_at_any_size(values: dict[str, float]) -> None:
    for swing in SWINGS_RAD_S:
        assert critical((slots("it", values),), swing) == pytest.approx(linear(values), abs=0.1)


def test_dry_friction_is_worth_its_equivalent_damping() -> None:
    """A rate of amplitude A loses as much to a moment M as to a damper 4 M / (pi A)."""
    moment, swing = 130.0, SWINGS_RAD_S[2]
    friction = slots("friction", {"hitch_friction": moment})
    speed = critical((friction,), swing)
    matrix = modes.transitions(
        [PlantInput(0.002, np.full(3, speed / KMH), np.zeros(3), np.zeros(3), BODY, neutral())],
        [speed / KMH],
    )[0]
    values, vectors = np.linalg.eig(matrix)
    s = np.log(values.astype(complex)) / modes.STEP_S
    k = int(np.argmin(np.abs(s - 4.2j)))  # sway, 0.67 Hz
    shape = vectors[:, k] / vectors[3, k]
    rate = abs(shape[3] - shape[1]) * swing
    assert speed == pytest.approx(linear({"hitch_damping": 4 * moment / math.pi / rate}), abs=0.5)
    assert critical((friction,), SWINGS_RAD_S[1]) > speed + 5.0  # a small swing is held more


def _grows(speed_m_s: float, effect: PhysicsEffect) -> float:
    """Growth of the double track's swing, 1/s, over 20 s after a kick."""
    time = np.arange(0.0, 26.0, 0.01)
    inside = (time > 0.5) & (time < 1.24)
    wheel = np.where(inside, math.radians(12.0) * np.sin(np.pi * (time - 0.5) / 0.74), 0.0)
    trace = DoubleTrack(VEHICLE, [effect]).run(time, wheel, np.full(time.size, speed_m_s))
    rate = trace["trailer_yaw_rate"]
    early, late = rate[600:1200], rate[2000:2600]
    return math.log(float(np.std(late)) / float(np.std(early))) / 14.0


def _double_track(effect: PhysicsEffect) -> float:
    low, high = 105.0 / KMH, 140.0 / KMH
    for _ in range(9):
        middle = 0.5 * (low + high)
        if _grows(middle, effect) > 0.0:
            high = middle
        else:
            low = middle
    return 0.5 * KMH * (low + high)


@pytest.mark.parametrize("phase_deg", [60.0, 240.0])
def test_load_at_twice_the_frequency_costs_what_a_long_simulation_says(phase_deg: float) -> None:
    """The simulator makes that load from the motion itself (Eq. 6.1-6.2), not from a phase."""
    amplitude = 700.0
    f = 0.68
    harmonic = PhysicsEffect(
        "axle_load_harmonic", amplitude_n=amplitude, phase_deg=phase_deg, frequency_hz=f
    )
    own = critical(
        (double_frequency("2f", "car_rear", amplitude, math.radians(phase_deg)),), SWINGS_RAD_S[1]
    )
    assert own == pytest.approx(_double_track(harmonic), abs=1.0)
    assert abs(own - linear({})) > 3.0


def test_ranking_and_what_comes_back() -> None:
    """What gives back most comes first, what holds the combination last."""
    causes = (
        slots("relaxation", {"relaxation_car_rear": 0.5}),
        slots("friction", {"hitch_friction": 130.0}),
        double_frequency("2f", "car_rear", 700.0, math.radians(240.0)),
    )
    costs = weigh(BASE, causes, 28.0)
    by_name = {cost.name: cost for cost in costs.causes}
    assert [cost.name for cost in costs.causes] == ["relaxation", "2f", "friction"]
    for cost in costs.causes:
        for found, without, back in zip(costs.found, cost.without, cost.back, strict=True):
            assert found.value is not None
            assert without.value is not None
            assert back.value == pytest.approx(without.value - found.value, abs=1e-6)
    middle = {name: cost.back[1].value or 0.0 for name, cost in by_name.items()}
    assert middle["relaxation"] > 3.0  # taking it away gives back
    assert middle["2f"] > 2.0
    assert middle["friction"] < -5.0  # it holds the swing: without it, less
    assert by_name["friction"].back[0].value < by_name["friction"].back[2].value  # type: ignore[operator]
    assert costs.damping_found[1] > by_name["friction"].damping_without[1]


def test_of_one_thing_at_different_times_the_worst_counts() -> None:
    """The dissertation's point: with the phase a load at twice the frequency costs or gives."""
    causes = [
        double_frequency("2f", "car_rear", 700.0, math.radians(phase)) for phase in (60.0, 240.0)
    ]
    cost = weigh(BASE, causes, 28.0).causes[0]
    assert cost.worst == 1
    assert cost.back[1] == cost.each[1]
    better, worse = (float(figure.value or 0.0) for figure in cost.each)
    assert better < -3.0
    assert worse > 3.0
    assert 8.0 < worse - better < 12.0  # text: about 10 km/h between phases


def test_what_follows_the_motion_sees_the_swing_itself() -> None:
    """Its yaw rate is of the size that was asked for."""
    seen: list[Run] = []

    def look(plant: PlantInput, values: np.ndarray, run: Run) -> None:
        del plant, values
        seen.append(run)

    base = Base(BODY, neutral())
    swings([(base, (Cause("it", np.zeros(0), look, follows=True),), 34.0, SWINGS_RAD_S[1])])
    run = seen[-1]
    inside = (run.time > 1.0) & (run.time < 4.0)
    rate = run.channels["trailer_yaw_rate"][inside]
    assert np.max(np.abs(rate)) == pytest.approx(SWINGS_RAD_S[1], rel=0.1)


def test_errors_are_those_of_drawn_values() -> None:
    """Values that hold each other too: their errors cancel where the vehicle does not notice."""
    rng = np.random.default_rng(1)
    tight = np.array([[1.0, -0.98], [-0.98, 1.0]])
    cause = double_frequency("2f", "car_rear", 700.0, math.radians(240.0))
    covariance = 60.0**2 * tight
    stated = weigh(BASE, [cause], 28.0, covariance, SWINGS_RAD_S[1:2]).causes[0].back[0].error
    causes = [
        Cause(cause.name, values, cause.act, follows=True)
        for values in rng.multivariate_normal(cause.values, covariance, 16)
    ]
    drawn = critical_speeds([(BASE, (one,), SWINGS_RAD_S[1]) for one in causes])
    assert 0.7 <= stated / (KMH * float(np.std(np.array(drawn, float)))) <= 1.4


def test_none_up_to_the_fastest_speed_and_no_swing() -> None:
    stiff = slots("damper", {"hitch_damping": 200_000.0})
    assert critical_speeds([(BASE, (stiff,), SWINGS_RAD_S[1])]) == [None]
    costs = weigh(BASE, [stiff], 28.0, swings_rad_s=SWINGS_RAD_S[1:2])
    assert costs.found[0].value is None
    assert costs.causes[0].back[0].value is None
    assert swings([(BASE, (), 4.0, SWINGS_RAD_S[1])])[0].real < 0.0
    assert critical_speeds([(BASE, (slots("x", {"hitch_damping": math.nan}),), 0.1)]) == [None]
    with pytest.raises(ValueError, match="no slot"):
        slots("x", {"nothing": 1.0})
    with pytest.raises(ValueError, match="no axle"):
        double_frequency("x", "nothing", 1.0, 0.0)
