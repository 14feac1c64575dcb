"""Scenarios on the rigid-body plant, and its agreement with the other depths of model."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import DATA

pytest.importorskip("mujoco")

from swaywatch.errors import ScenarioError
from swaywatch.simulate import Scenario, simulate_scenario
from swaywatch.simulate.scenario import read_scenario

FOLDER = DATA / "practice" / "p01"
IMPULSE = [{"kind": "impulse", "start_s": 1.0, "angle_deg": 1.0}]


def scenario(**content: Any) -> Scenario:
    base: dict[str, Any] = {
        "vehicle": "vehicle.toml",
        "duration_s": 12.0,
        "speed_kmh": 100.0,
        "model": "multibody",
        "manoeuvre": IMPULSE,
        "sensors": {"preset": "perfect"},
    }
    return read_scenario({**base, **content}, "test", FOLDER, "test.toml")


@pytest.mark.parametrize("other", ["single_track", "double_track"])
def test_depths_of_model_agree_in_the_linear_limit(other: str) -> None:
    """Time histories after a small impulse, within 2 % of their size over ten seconds."""
    planar = {"bodies": "planar"}
    _, mine = simulate_scenario(scenario(multibody=planar))
    _, theirs = simulate_scenario(scenario(model=other))
    for name in ("car_yaw_rate", "trailer_yaw_rate", "articulation"):
        size = np.abs(theirs[name]).max()
        assert np.abs(mine[name] - theirs[name]).max() < 0.02 * size, name


def test_moving_bodies_have_all_channels() -> None:
    drive, trace = simulate_scenario(scenario(multibody={"tyre_law": "magic_formula"}))
    assert {"hitch_vertical_force", "trailer_wheel_vertical_load_rr"} <= set(drive.channels)
    assert trace["hitch_vertical_force"][0] == pytest.approx(-700.0, abs=5.0)
    assert np.abs(trace["car_roll"]).max() > 1e-3


def test_faded_dampers_change_the_loads() -> None:
    slalom = [{"kind": "slalom", "angle_deg": 6.0}]
    _, healthy = simulate_scenario(scenario(manoeuvre=slalom, speed_kmh=85.0))
    faded = {"damper_factor": {"car_rear": 0.1}, "damper": {"kind": "failure_2"}}
    _, sick = simulate_scenario(scenario(manoeuvre=slalom, speed_kmh=85.0, multibody=faded))
    change = sick.axle_load("car_rear") - healthy.axle_load("car_rear")
    assert np.std(change) > 10.0


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ({"multibody": {"bodys": "planar"}}, "bodys"),
        ({"multibody": {"tyre_law": "tanh"}}, "magic_formula"),
        ({"multibody": {"relaxation_m": {"car_rear": 0.01}}}, "shorter step"),
        ({"multibody": {"damper": {"kind": "broken"}}}, "failure_2"),
        ({"driver": {"kind": "lets_go", "from_s": 4.0}}, "driver"),
    ],
)
def test_wrong_input_is_named(content: dict[str, Any], text: str) -> None:
    with pytest.raises(ScenarioError, match=text):
        simulate_scenario(scenario(**content))


def test_tables_that_do_not_fit_the_model() -> None:
    with pytest.raises(ScenarioError, match="multibody"):
        scenario(model="double_track", multibody={"bodies": "planar"})
    with pytest.raises(ScenarioError, match="physics"):
        scenario(physics=[{"id": "hitch_friction"}])
