"""What works after `make run` alone: without packages that only tests and scoring need."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from conftest import DATA

ABSENT = ("numba", "llvmlite", "mujoco", "dask", "objective_rating_metrics", "dtwalign", "control")
BLOCK = f"""
import sys
from importlib.abc import MetaPathFinder
class Absent(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {ABSENT}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Absent())
"""
ROOMS = (
    "commands.simulate", "commands.hil", "commands.reproduce", "commands.diagnose",
    "commands.predict", "diagnose.engine", "diagnose.car_alone.engine", "diagnose.predict",
    "simulate.closed_loop", "reproduce.chapter5", "reproduce.chapter6", "models.modes",
)  # fmt: skip
SIMULATED = """
from swaywatch.simulate import simulate_scenario
from swaywatch.simulate.scenario import read_scenario
content = {"vehicle": "vehicle.toml", "duration_s": 4.0, "speed_kmh": 90.0,
           "manoeuvre": [{"kind": "impulse"}]}
drive, trace = simulate_scenario(read_scenario(content, "test", Path("."), "test.toml"))
assert abs(trace["trailer_yaw_rate"]).max() > 0.01
"""


def without(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run code in a Python that lacks them."""
    return subprocess.run(
        [sys.executable, "-c", BLOCK + code],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_commands_and_the_rooms_behind_them_load(tmp_path: Path) -> None:
    done = without("\n".join(f"import swaywatch.{room}" for room in ROOMS), tmp_path)
    assert done.returncode == 0, done.stderr


def test_a_scenario_is_simulated() -> None:
    done = without("from pathlib import Path\n" + SIMULATED, DATA / "practice" / "p01")
    assert done.returncode == 0, done.stderr
