"""The single track against the reference's recomputed golden values."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import DATA

from swaywatch.models.single_track import PARAMETERS, SingleTrack
from swaywatch.vehicle_file import load_vehicle

VEHICLE = load_vehicle(DATA / "practice" / "p01" / "vehicle.toml")  # Tables A and B
MODEL = SingleTrack.of(VEHICLE)

MODES = {
    80.0: ((0.2520, 0.6478), (0.9178, 0.5180)),
    100.0: ((0.1115, 0.6659), (0.8840, 0.5385)),
    107.9: ((0.0689, 0.6690), (0.8712, 0.5448)),
    117.3: ((0.0250, 0.6712), (0.8565, 0.5513)),
    140.0: ((-0.0587, 0.6729), (0.8240, 0.5638)),
}
SENSITIVITY = {
    "m1": 0.188, "m2": -0.216, "iz1": 0.140, "iz2": -0.721, "lf1": 0.064, "lr1": 0.844,
    "lh1": -0.767, "lf2": -0.062, "lr2": 0.284, "lh2": 1.452, "cf1": -0.156, "cr1": 0.440,
    "cf2": 0.005, "cr2": 0.334,
}  # fmt: skip


@pytest.mark.parametrize("speed_kmh", MODES)
def test_modes(speed_kmh: float) -> None:
    modes = MODEL.modes(speed_kmh / 3.6)
    found = [(mode.damping_ratio, mode.frequency_hz) for mode in modes]
    assert found == [pytest.approx(pair, abs=6e-5) for pair in MODES[speed_kmh]]


def test_critical_speed() -> None:
    assert MODEL.critical_speed() * 3.6 == pytest.approx(123.3397, abs=1e-4)


def test_critical_speed_with_the_stiffness_of_the_road_test() -> None:
    values = dict(
        zip(("cf1", "cr1", "cf2", "cr2"), (109.2e3, 184.9e3, 134.2e3, 123.4e3), strict=True)
    )
    changed = SingleTrack(**{**MODEL.__dict__, **values})
    assert changed.critical_speed() * 3.6 == pytest.approx(123.028, abs=1e-3)


@pytest.mark.parametrize("name", PARAMETERS)
def test_sensitivity(name: str) -> None:
    assert MODEL.sensitivity(name) * 3.6 == pytest.approx(SENSITIVITY[name], abs=6e-4)


@pytest.mark.parametrize(
    ("speed", "yaw", "angle"),
    [(10.0, 3.35706, -1.99922), (20.0, 4.98953, -1.37428), (30.0, 5.24074, -0.83228)],
)
def test_steady_state(speed: float, yaw: float, angle: float) -> None:
    state = MODEL.steady_state(speed)
    assert (state[1], state[3]) == pytest.approx((yaw, angle), abs=6e-6)


def test_response_settles_at_the_steady_state() -> None:
    time = np.arange(0.0, 60.0, 0.01)
    steering = np.full(time.size, 0.1)
    response = MODEL.run(time, steering, 20.0)
    state = MODEL.steady_state(20.0) * 0.1 / MODEL.steering_ratio
    assert response["car_yaw_rate"][-1] == pytest.approx(state[1], rel=1e-6)
    assert response["trailer_yaw_rate"][-1] == pytest.approx(state[1], rel=1e-6)
    assert response["articulation"][-1] == pytest.approx(state[3], rel=1e-6)
    acceleration = 20.0 * state[1]
    assert response["car_lateral_acceleration"][-1] == pytest.approx(acceleration, rel=1e-6)
    assert response["trailer_lateral_acceleration"][-1] == pytest.approx(acceleration, rel=1e-6)


def test_car_alone_never_oscillates_unstably() -> None:
    car = SingleTrack(**{**MODEL.__dict__, "has_trailer": False})
    assert car.critical_speed() == float("inf")  # understeers
    assert len(car.root_locus([10.0, 30.0])[0]) == 2
