"""Two ways into the one plant, from the simulator and from the diagnosis, say the same.

An effect of `models.physics` and the effect of `effects.library` of the same name fill slots each
in its own way; here the change of the motion by one must be that by the other. Small steering
keeps both in the linear range; effects that need roll, whose constants the two take from different
sources, are compared in their own tests.
"""

from __future__ import annotations

import numpy as np
import pytest
from sprung_pairs import SPACING, constants, manoeuvre
from test_double_track import TIME, VEHICLE, impulse

from swaywatch.diagnose.fit.data import body_of
from swaywatch.diagnose.fit.fit import Problem, predict_run
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library
from swaywatch.effects.runs import Run
from swaywatch.models.double_track import DoubleTrack
from swaywatch.models.multibody import Multibody
from swaywatch.models.multibody_vehicle import Inputs, Physics, reference_combination
from swaywatch.models.physics import PhysicsEffect
from swaywatch.plant.lanes import OUTPUT, PlantInput, simulate

SPEED = 27.0
YAW = [OUTPUT.index(name) for name in ("car_yaw_rate", "trailer_yaw_rate")]
CHANNELS = ("car_yaw_rate", "trailer_yaw_rate", "articulation", "hitch_lateral_force")
STEERING = impulse(2.0)
WINDOW = {"start_s": 4.005, "stop_s": 8.005}  # edges between samples


def ours(term: ActiveEffect | None) -> dict[str, np.ndarray]:
    """Channels of the plant of the diagnosis."""
    run = Run("run", TIME, {"steering_wheel_angle": STEERING}, {}, VEHICLE.car.steering_ratio)
    run.speed, run.acceleration = np.full(TIME.size, SPEED), np.zeros(TIME.size)
    run.steer = STEERING / VEHICLE.car.steering_ratio
    problem = Problem((run,), body_of(VEHICLE))
    terms = (term,) if term else ()
    return predict_run(problem, 0, terms, np.zeros(5), np.zeros(0))


def term(name: str, *values: float, runs: tuple[int, ...] = ()) -> ActiveEffect:
    """A term of the diagnosis' library by id and component (the first form)."""
    return ActiveEffect(next(e for e in library() if e.name == name), values, runs)


CASES: list[tuple[PhysicsEffect, ActiveEffect]] = [
    (
        PhysicsEffect("steering_compliance", stiffness_n_per_rad=1.4e6),
        term("steering_compliance:car_front", 1.0 / 1.4e6),
    ),
    (
        PhysicsEffect("tyre_relaxation", length_m=0.6, axle="car_rear"),
        term("tyre_relaxation:car_rear", 0.6),
    ),
    (
        PhysicsEffect("tyre_relaxation", length_m=0.5, axle="trailer"),
        term("tyre_relaxation:trailer", 0.5),
    ),
    (
        PhysicsEffect("hitch_friction", moment_nm=50.0, rate_scale_rad_s=0.01),
        term("hitch_friction:hitch", 50.0, 0.01),
    ),
    (
        PhysicsEffect("hitch_damping", coefficient_nms_per_rad=800.0),
        term("hitch_damping:hitch", 800.0),
    ),
    (
        PhysicsEffect("drawbar_compliance", stiffness_n_per_m=1e5),
        term("drawbar_compliance:hitch", 1e-5),
    ),
    (
        PhysicsEffect(
            "trailer_aerodynamics", side_force_coefficient=1.5, yaw_moment_coefficient=0.5
        ),
        term("trailer_aerodynamics:trailer", 1.5, 0.5),
    ),
    (
        PhysicsEffect("tyre_stiffness_change", [WINDOW | {"factor": 0.9}], axle="car_rear"),
        term("tyre_stiffness_change:car_rear", 4.005, 8.005, 0.9, runs=(0,)),
    ),
    (
        PhysicsEffect("crosswind_gust", [WINDOW | {"force_n": 400.0}], body="trailer"),
        term("crosswind_gust:trailer", 4.005, 8.005, 400.0, runs=(0,)),
    ),
    (
        PhysicsEffect("road_bank", [WINDOW | {"angle_deg": 1.0}]),
        term("road_bank:road", 4.005, 8.005, 1.0, runs=(0,)),
    ),
]


@pytest.mark.parametrize(("simulated", "diagnosed"), CASES, ids=lambda x: str(getattr(x, "id", "")))
def test_an_effect_changes_both_plants_alike(
    simulated: PhysicsEffect, diagnosed: ActiveEffect
) -> None:
    changed = DoubleTrack(VEHICLE, [simulated]).run(TIME, STEERING, SPEED)
    plain = DoubleTrack(VEHICLE).run(TIME, STEERING, SPEED)
    with_term, without = ours(diagnosed), ours(None)
    for name in CHANNELS:
        one, other = changed[name] - plain[name], with_term[name] - without[name]
        # edges of windows fall between samples: rms, not the largest difference
        size = float(np.sqrt(np.mean(one**2)))
        assert size > 0.0
        assert float(np.sqrt(np.mean((one - other) ** 2))) < 0.05 * size, name


def test_without_effects_both_plants_move_alike() -> None:
    trace, plain = DoubleTrack(VEHICLE).run(TIME, STEERING, SPEED), ours(None)
    for name in CHANNELS:
        size = float(np.abs(trace[name]).max())
        assert float(np.abs(trace[name] - plain[name]).max()) < 0.01 * size, name


def test_drawbar_of_an_independent_simulator() -> None:
    """MuJoCo's trailer on a slide at the ball: far nearer with the effect than without it."""
    whole = reference_combination()
    time, wheel = manoeuvre("slalom", 20.0, 10.0)
    soft = Physics(more="elastic_drawbar", more_size=5e4)
    motion = Multibody(whole, soft).run(Inputs(time, wheel, np.full_like(time, SPEED)))
    motion = motion.resample(time)
    judged = np.stack([motion.yaw_rate_rad_s, motion.trailer_yaw_rate_rad_s], axis=1)

    def off(*terms: ActiveEffect) -> float:
        own = PlantInput(
            SPACING, motion.speed_m_s, np.gradient(motion.speed_m_s, SPACING),
            motion.road_wheel_rad, constants(whole),
        )  # fmt: skip
        for t in terms:
            t.effect.act(own, Run("r", time, {}, {}, 15.0), t.as_dict(), ())
        return float(np.std(simulate(own)[:, YAW] - judged) / np.std(judged))

    assert off(term("drawbar_compliance:hitch", 1.0 / 5e4)) < 0.1 * off()
