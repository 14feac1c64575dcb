"""The compiled plant: simulations side by side do not disturb each other; forces as documented."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from swaywatch.diagnose.fit.side_by_side import SideBySide
from swaywatch.plant._plant import lib
from swaywatch.plant.lanes import (
    AHEAD,
    ALL,
    BLOCK,
    LANES,
    OUTPUT,
    SCALARS,
    SERIES,
    SHAPE,
    Job,
    PlantInput,
    run_along,
    run_jobs,
    simulate,
)

Array = NDArray[np.float64]

BODY = np.array(
    [
        1600.0, 2600.0, 1.2, 1.5, 2.5, 90e3, 110e3, 1400.0, 2500.0, 0.3, 0.4, 3.8, 60e3, 50e3,
        8500.0, 7000.0, 6500.0, 6500.0,
    ]
)  # fmt: skip
FEATURES = [
    {},
    {"peak_friction_inverse": 1.3},
    {"relaxation_car_front": 0.2, "relaxation_trailer": 0.05},
    {"roll_steer_car_front": 0.1, "free_play": 0.002},
    {"observer_car": 2.0, "observer_trailer": 2.0},
    {"law_gain": 3e3, "law_of_articulation": 1.0, "law_to_hitch": 1.0, "law_shape": 1.0,
     "law_bend": 0.01},
    *({"law_gain": 3e3, "law_of_articulation": 1.0, "law_to_hitch": 1.0, "law_shape": shape,
       "law_bend": 0.01} for shape in (0.0, 7.0, 10.0, 19.0, 20.0, 21.0)),
    {"hitch_friction": 300.0, "aero_side": 1.0, "steering_flexibility": 1e-6},
    {"sprung_mass_car": 1400.0, "trail_car_front": 0.03},
    {"sprung_mass_car": 1400.0, "sprung_mass_trailer": 1300.0, "peak_friction_inverse": 1.2},
    {"drawbar_compliance": 2e-5},
    {"drawbar_compliance": 1e-6, "sprung_mass_car": 1400.0, "sprung_mass_trailer": 1300.0},
]  # fmt: skip
SPRUNG = {"sprung_height": 0.5, "roll_inertia": 500.0, "roll_stiffness": 9e4,
          "roll_damping_rate": 4e3, "roll_front_share": 0.6, "roll_damping_share": 0.6}  # fmt: skip


def plant(samples: int, seed: int, steer: float = 0.02, **scalars: float) -> PlantInput:
    """A drive at some 25 m/s with a steering of 0.6 Hz and a load that comes and goes."""
    time = np.arange(samples) / 100.0
    shift = np.random.default_rng(seed).uniform(-1.0, 1.0)
    found = PlantInput(
        0.01,
        25.0 + np.sin(time / 7.0 + shift),
        np.cos(time / 7.0 + shift) / 7.0,
        steer * np.sin(2.0 * np.pi * 0.6 * time + shift),
        BODY * (1.0 + 0.01 * shift),
    )
    for name in ("track_car_front", "track_car_rear", "track_trailer"):
        found.scalar(name, 1.5)
    for name, value in SPRUNG.items():
        found.scalar(f"{name}_car", value)
        found.scalar(f"{name}_trailer", value)
    for name, value in scalars.items():
        found.scalar(name, value)
    found.add_series("load_car_rear", 300.0 * np.sin(3.0 * time))
    return found


@pytest.mark.parametrize("fine", [True, False])
def test_alone_and_beside_others(fine: bool) -> None:
    """Bit by bit the same, whatever the lengths and the physics of the others are."""
    plants = [
        plant(samples, seed, **FEATURES[seed % len(FEATURES)])
        for seed, samples in enumerate(
            (401, 300, 402, 57, 400, 400, 399, 310, 20, 11, 1, 401, 400, 333, 402, 12, 77, 401)
        )
    ]
    assert len(plants) > len(FEATURES)
    together = run_jobs([Job(p, columns=ALL) for p in plants], fine=fine)
    for one, among in zip(plants, together, strict=True):
        assert among.output is not None
        np.testing.assert_array_equal(simulate(one, fine=fine), among.output)
        (alone,) = run_jobs([Job(one, columns=ALL)], fine=fine)
        np.testing.assert_array_equal(alone.blocks, among.blocks)


def test_simulations_begin_while_others_are_put_together() -> None:
    """Of two lengths and kinds: each once, as alone, and never many in memory."""
    count = (AHEAD + 3) * LANES + 3
    plants = [
        plant(200 + 50 * (i % 2), i, **({"hitch_friction": 90.0} if i % 3 else {}))
        for i in range(count)
    ]
    made: list[PlantInput] = []

    def jobs() -> Iterator[Job]:
        for one in plants:
            made.append(one)
            yield Job(one, columns=ALL)

    found: dict[int, Array] = {}
    for index, outcome in run_along(jobs()):
        assert index not in found
        assert outcome.output is not None
        found[index] = outcome.output
        # begun and not taken, and a row of each length and kind that is not full yet
        assert len(made) - len(found) <= (AHEAD + 1 + 4) * LANES
    assert len(found) == count
    for index in (0, 1, 2, count - 1):
        assert np.array_equal(found[index], simulate(plants[index]))


def test_blocks_are_sums_of_the_samples() -> None:
    outcome = run_jobs([Job(plant(403, 0), columns=ALL)], fine=False)[0]
    assert outcome.output is not None
    whole = outcome.output[:400].reshape(40, BLOCK, -1).sum(axis=1)
    np.testing.assert_allclose(outcome.blocks[:40], whole, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(outcome.blocks[40], outcome.output[400:].sum(axis=0), rtol=1e-12)


@pytest.mark.parametrize("fine", [True, False])
def test_branch_goes_on_from_a_state(fine: bool) -> None:
    whole = run_jobs([Job(plant(400, 3), columns=ALL, states=True)], fine=fine)[0]
    assert whole.states is not None
    assert whole.output is not None
    job = Job(plant(400, 3), (120, 305), whole.states[120], columns=(3, 16))
    branch = run_jobs([job], fine=fine)[0]
    assert branch.output is not None
    part = whole.output[120:304][:, [3, 16]]
    np.testing.assert_array_equal(branch.output[120:304], part)
    assert not branch.output[:120].any()
    assert not branch.output[305:].any()


def test_divergence_leaves_zeros_and_the_neighbours_alone() -> None:
    wild = plant(2000, 5)
    wild.add_series("moment_trailer", np.full(2000, 1e12))
    calm = plant(2000, 6)
    alone = simulate(calm)
    both = run_jobs([Job(wild, columns=ALL), Job(calm, columns=ALL)])
    assert both[0].output is not None
    assert both[1].output is not None
    assert both[0].output[0].any()
    assert not both[0].output[-1].any()
    np.testing.assert_array_equal(both[1].output, alone)


@pytest.mark.parametrize("sprung", [0.0, 1.0])
def test_drawbar_gives_way_to_the_force_at_the_ball(sprung: float) -> None:
    """What the bodies have there is the drawbar's force; a stiff one is a rigid trailer."""
    springs = {"sprung_mass_car": 1400.0 * sprung, "sprung_mass_trailer": 1300.0 * sprung}
    given = plant(800, 2, **springs, drawbar_compliance=2e-5)
    found = run_jobs([Job(given, columns=ALL, states=True)])[0]
    assert found.output is not None
    assert found.states is not None
    out = {name: found.output[:, i] for i, name in enumerate(OUTPUT)}
    theta = out["articulation"]
    force = out["hitch_y"] * np.cos(theta) - out["hitch_x"] * np.sin(theta)
    moved, rate = found.states[:, lib.X_DRAWBAR], found.states[:, lib.X_DRAWBAR + 1]
    own = (moved + 0.005 * rate) / 2e-5
    np.testing.assert_allclose(force[:-1], own[:-1], atol=1e-6 * np.abs(force).max())
    rigid, stiff = (simulate(plant(800, 2, **springs, drawbar_compliance=c)) for c in (0.0, 1e-8))
    size = np.std(rigid[:, :4], axis=0)
    assert np.all(np.std(stiff[:, :4] - rigid[:, :4], axis=0) < 2e-4 * size)
    assert np.any(np.std(found.output[:, :4] - rigid[:, :4], axis=0) > 0.05 * size)


@pytest.mark.parametrize("steer", [0.005, 0.05, 0.2])
def test_saturated_forces(steer: float) -> None:
    """Below, around and far above the knee, against the formula in numpy."""
    outputs = simulate(plant(200, 1, steer, peak_friction_inverse=1.25))
    col = {name: outputs[:, index] for index, name in enumerate(OUTPUT)}
    for axle, stiffness, load in (("f", 5, 14), ("r", 6, 15)):
        body = plant(200, 1).body
        for side in "lr":
            fz = col[f"vertical_{axle}{side}"]
            linear = body[stiffness] * col[f"slip_{axle}"] * fz / body[load]
            peak = fz / 1.25
            force = peak * np.sin(SHAPE * np.arctan(linear / (SHAPE * np.maximum(peak, 1e-9))))
            held = fz > 1.0
            np.testing.assert_allclose(
                col[f"lateral_{axle}{side}"][held], force[held], rtol=1e-11, atol=1e-9
            )


def test_what_levels_off_is_a_hyperbolic_tangent() -> None:
    """Made of sums and products alone, so that it is the same to the bit on any machine."""
    at = np.concatenate([-np.geomspace(1e-9, 40.0, 60), [0.0], np.geomspace(1e-9, 40.0, 60)])
    force = OUTPUT.index("car_yaw_acceleration")

    def turned(x: float, gain: float) -> float:
        given = plant(20, 1, law_gain=gain)
        given.steer = np.full(20, 0.001 * x)
        for slot, value in (("shape", 1.0), ("bend", 0.001), ("of_steer", 1.0)):
            given.scalar(f"law_{slot}", value)
        given.scalar("law_to_moment_car", 1.0)
        return float(simulate(given)[0, force])

    with_law = np.array([turned(x, 1e12) for x in at])
    found = with_law - np.array([turned(x, 0.0) for x in at])
    np.testing.assert_allclose(found / found[-1], np.tanh(at), rtol=2e-13)


def test_requests_of_threads_are_answered_together() -> None:
    sizes: list[int] = []

    def answer(requests: list[int]) -> list[int]:
        sizes.append(len(requests))
        return [10 * request for request in requests]

    side_by_side: SideBySide[int, int] = SideBySide(answer)

    def calculate(item: int) -> int:
        first = side_by_side.ask([item])[0]
        return first + sum(side_by_side.ask([item, 1])) if item % 2 else first

    results = side_by_side.map(calculate, range(6), 6)
    assert results == [0, 30, 20, 70, 40, 110]
    assert sum(sizes) == 12
    assert side_by_side.ask([7]) == [70]


def test_an_error_reaches_every_thread() -> None:
    """No thread waits for ever when a calculation, or what answers it, fails."""

    def answer(requests: list[int]) -> list[int]:
        if 3 in requests:
            raise ValueError("three")
        return list(requests)

    side_by_side: SideBySide[int, int] = SideBySide(answer)

    def calculate(item: int) -> int:
        if item == 1:
            raise KeyError("one")
        return side_by_side.ask([item])[0]

    with pytest.raises(KeyError):
        side_by_side.map(calculate, [0, 1, 2], 3)
    with pytest.raises(ValueError, match="three"):
        side_by_side.map(calculate, [2, 3, 4], 3)
    assert threading.active_count() < 20


def test_the_kernel_and_python_agree_on_every_slot() -> None:
    """The order of the slots is written down on both sides."""
    assert [getattr(lib, f"E_{name.upper()}") for name in SCALARS] == list(range(len(SCALARS)))
    assert len(SCALARS) == lib.PLANT_SCALARS
    assert [getattr(lib, f"T_{name.upper()}") for name in SERIES] == list(range(len(SERIES)))
