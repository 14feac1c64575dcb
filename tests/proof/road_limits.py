"""Our limits of the road recordings beside those that they state: a check of the method.

``python road_limits.py DIR`` prints both, their ratios and their rank correlation. The stated ones
are of other drives of the same kind and of a plant that is not ours, without tolerances of sensors
(``--exact-sensors``); causes outside the library are left out.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import spearmanr
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).parent / "blind"))

import explanations
import own_limits
from information import Limit
from own_limits import Concealed, Known

from swaywatch.plant.lanes import SCALARS, neutral
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle

Json = dict[str, Any]
#: Values of the file behind the letters of a truth.
LETTERS = {
    "m1": ("car", "mass"), "m2": ("trailer", "mass"), "I1": ("car", "yaw_inertia"),
    "I2": ("trailer", "yaw_inertia"), "Cf1": ("car", "front_cornering_stiffness"),
    "Cr1": ("car", "rear_cornering_stiffness"),
    "Cf2": ("trailer", "front_cornering_stiffness", "rear_cornering_stiffness"),
}  # fmt: skip


def true_vehicle(believed: Vehicle, factors: dict[str, float]) -> Vehicle:
    """The vehicle behind a file whose values are so many times the true ones."""
    for letter, factor in factors.items():
        part, *keys = LETTERS[letter]
        body = getattr(believed, part)
        values = {key: getattr(body, key) for key in keys}
        right = {key: value / factor for key, value in values.items() if value is not None}
        believed = replace(believed, **{part: replace(body, **right)})
    return believed


def slots_of(truth: Json) -> dict[str, float]:
    """What a vehicle on springs has in any case, as slots of the plant."""
    found = {}
    for always in truth["always_there"]:
        if always["id"] == "tyre_relaxation":
            axles = ("car_front", "car_rear") if always["axle"] == "car" else ("trailer",)
            found |= {f"relaxation_{axle}": always["length_m"] for axle in axles}
        elif always["id"] == "tyre_saturation":
            found["peak_friction_inverse"] = 1.0 / always["peak_friction"]
        elif always["id"] == "tyre_load_sensitivity":
            found["degression"] = always["degression"]
    return found


def rolls() -> dict[str, float]:
    """A rigid body's roll as the plant has it where nothing is known."""
    slots = dict(zip(SCALARS, neutral().tolist(), strict=True))
    return {
        "gain_car": slots["roll_gain_car"], "gain_trailer": slots["roll_gain_trailer"],
        "frequency": slots["steer_frequency_car"], "damping": slots["steer_damping_car"],
    }  # fmt: skip


def limit_of_road(folder: Path, *, sensors: bool) -> Limit | None:
    """Limit of the first effect of a case; None where there is none in the library."""
    truth = json.loads((folder / "truth.json").read_text())
    if not truth["effects"] or truth["effects"][0]["id"] == "outside_library":
        return None
    file = load_vehicle(folder / "vehicle.toml")
    vehicle = true_vehicle(file, truth["believed"])
    windows = [(k, tuple(w)) for k in (0, 1) for w in truth[f"run{k + 1}"]["windows"]]
    concealed = [
        Concealed(explanations.concealed(effect, windows, rolls(), {}), {})
        for effect in truth["effects"]
    ]
    known = Known(truth["tier"] in "AC", slots_of(truth), truth["tier"] == "F", sensors)
    runs = own_limits.runs_of(folder, vehicle, 1.0)
    return own_limits.limits(own_limits.problem_of(runs, vehicle, known), known, concealed)[0]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--exact-sensors", action="store_true")
    given = parser.parse_args()
    pairs = []
    for path in sorted(given.folder.glob("r*/truth.json")):
        truth = json.loads(path.read_text())
        with threadpool_limits(1):
            own = limit_of_road(path.parent, sensors=not given.exact_sensors)
        if own is None:
            continue
        stated = truth["limit"]
        pairs.append((stated["detect"], own.detect, stated["name"], own.name))
        print(
            f"{truth['case']} {truth['tier']} {truth['effects'][0]['id']:22s} "
            f"detect {stated['detect']:7.1f} {own.detect:7.1f} "
            f"({own.detect / stated['detect']:.2f})  "
            f"name {stated['name']:7.1f} {own.name:7.1f} ({own.name / stated['name']:.2f})  "
            f"beside {stated['best_wrong']}; {own.best_wrong}"
        )
    table = np.array(pairs)
    for words, first in (("detect", 0), ("name", 2)):
        ratio = table[:, first + 1] / table[:, first]
        rank = spearmanr(table[:, first], table[:, first + 1])[0]
        within = int(np.sum((ratio > 0.5) & (ratio < 2.0)))
        print(
            f"{words}: ours over theirs, median {np.median(ratio):.2f}; within a factor of two "
            f"{within} of {len(table)}; rank correlation {rank:.2f}"
        )
    low = table[:, [2, 3]] < 10.0
    print(f"below 10 by name: theirs {int(low[:, 0].sum())}, ours {int(low[:, 1].sum())}")


if __name__ == "__main__":
    main()
