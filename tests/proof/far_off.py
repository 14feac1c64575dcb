"""``make proof-far-off``: a vehicle.toml that is far off, as in the dissertation.

Its tyres held 1.47 times (car) and 1.36 times (trailer) what the simulation believed, its steering
was elastic and its tyres relaxed over 0.5 m (chapter 5). Two drives of 39 s of the practice
combination p03 are made on the rigid-body plant (MuJoCo, which shares no code with the diagnosis),
bodies in the plane, with the sensors of a test vehicle; the diagnosis gets a file that is off by as
much. The table says what was concealed and what is said; nothing here is asserted.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swaywatch.diagnose.engine import diagnose
from swaywatch.ecu.bus import encode_drive
from swaywatch.recording import write_recording
from swaywatch.simulate import simulate_scenario
from swaywatch.simulate.scenario import read_scenario
from swaywatch.simulate.signals import write_signals
from swaywatch.vehicle_file import load_vehicle

TYPE = Path(__file__).resolve().parents[1] / "data" / "practice" / "p03" / "vehicle.toml"
AXLES = ("car front", "car rear", "trailer front", "trailer rear")
RELAXATION_M = 0.5
STEERING_N_RAD = 1.437e6
DRIVES = ((110.0, (3, 14, 27)), (90.0, (4, 17, 29)))
ANGLES_DEG = (14.0, -20.0, 17.0)


@dataclass(frozen=True)
class Case:
    """True over believed stiffness of each axle; elastic steering and relaxation or not."""

    name: str
    factors: tuple[float, float, float, float]
    soft: bool = False


CASES = (
    Case("all 15 % too high", (0.85,) * 4),
    Case("all 15 % too low", (1.15,) * 4),
    Case("all 30 % too low", (1.30,) * 4),
    Case("all 47 % too low", (1.47,) * 4),
    Case("elastic steering, relaxation", (1.0,) * 4, soft=True),
    Case("the dissertation's", (1.47, 1.47, 1.36, 1.36), soft=True),
)


def drive(folder: Path, case: Case) -> list[Path]:
    """Two recordings of the true vehicle, and the file that is off."""
    folder.mkdir(parents=True, exist_ok=True)
    vehicle = load_vehicle(TYPE)
    paths = []
    for number, (speed, starts) in enumerate(DRIVES, start=1):
        plant: dict[str, Any] = {"bodies": "planar", "tyre_law": "linear"}
        if case.soft:
            plant["steering_stiffness_n_rad"] = STEERING_N_RAD
            axles = (name.replace(" ", "_") for name in AXLES)
            plant["relaxation_m"] = dict.fromkeys(axles, RELAXATION_M)
        content = {
            "vehicle": "unused", "duration_s": 39.0, "speed_kmh": speed, "model": "multibody",
            "multibody": plant,
            "manoeuvre": [
                {"kind": "impulse", "start_s": start, "angle_deg": angle, "frequency_hz": 0.6}
                for start, angle in zip(starts, ANGLES_DEG, strict=True)
            ],
        }  # fmt: skip
        scenario = read_scenario(content, "far off", folder, "far off", 7 + number, vehicle)
        recording, _ = simulate_scenario(scenario)
        paths.append(folder / f"run{number}.blf")
        write_recording(paths[-1], encode_drive(recording))
        write_signals(folder / "signals.toml", recording)
    (folder / "vehicle.toml").write_text(believed(TYPE.read_text("utf-8"), case), "utf-8")
    return paths


def believed(text: str, case: Case) -> str:
    """The file with every cornering stiffness off by its factor."""
    factors = dict(zip(AXLES, case.factors, strict=True))
    lines, part = [], ""
    for line in text.splitlines():
        part = line.strip("[]") if line.startswith("[") else part
        name, _, value = line.partition(" = ")
        if name.endswith("_cornering_stiffness"):
            end = name.split("_")[0]
            lines.append(f"{name} = {float(value) / factors[part + ' ' + end]:.1f}")
        else:
            lines.append(line)
    return "\n".join(lines) + "\n"


def said(effects: Sequence[dict[str, Any]]) -> str:
    """Every claim with its value, interval of 90 % and what it cannot be distinguished from."""
    found = []
    for effect in effects:
        values = [
            f"{value['value']:.4g} ({value['low']:.4g} to {value['high']:.4g})"
            for value in effect["parameters"].values()
            if value.get("low") is not None
        ]
        same = [name for name in effect["equivalent_details"] if "compliance" in name]
        also = f" or {same[0]}" if same else ""
        found.append(f"{effect['id']} {effect['component']} {', '.join(values)}{also}")
    return "; ".join(found) or "nothing"


def main() -> None:
    """Make the cases, diagnose them, print the table."""
    root = Path(sys.argv[1])
    print("| concealed | verdict | said (interval of 90 %) |\n|---|---|---|", flush=True)
    for case in CASES:
        folder = root / case.name.replace(" ", "-").replace("%", "percent")
        paths = drive(folder, case)
        result = diagnose(paths, folder / "vehicle.toml", folder / "signals.toml")
        print(f"| {case.name} | {result['verdict']} | {said(result['effects'])} |", flush=True)


if __name__ == "__main__":
    main()
