"""How many standard deviations each concealed effect leaves: ``limit.json`` beside each answer.

``python case_limits.py --seed S --cases DIR --answers DIR`` with the seed that the cases were
generated with. What is here already is kept while the answer and what it is calculated by are the
same. Causes outside the library, and cases with nothing concealed, have no limit.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import multiprocessing
import sys
import tempfile
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import as_plant
import beside
import beside_limits
import explanations
import generate
import knowledge
import numpy as np
import own_limits
from effects import Draw
from generate import Case
from information import Limit
from own_limits import Concealed, Known
from threadpoolctl import threadpool_limits

import swaywatch
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle

Json = dict[str, Any]
FILE = "limit.json"
#: What a limit is calculated by, of this folder and of the package.
OWN = ("information.py", "as_plant.py", "explanations.py", "own_limits.py", "beside_limits.py",
       "beside_score.py", "case_limits.py", "effects.py", "recorder.py")  # fmt: skip
OF_PACKAGE = ("plant", "effects", "models", "diagnose/fit")


def method_digest() -> str:
    """Digest of what a limit depends on beside the case."""
    here, package = Path(__file__).parent, Path(swaywatch.__file__).parent
    files = [here / name for name in OWN]
    for folder in OF_PACKAGE:
        files += [p for p in (package / folder).rglob("*") if p.suffix in (".py", ".c", ".h")]
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def vehicle_of(case: Case, user: dict[str, float]) -> Vehicle:
    """The vehicle of a file that is right but for the factors of `user`."""
    right = dict.fromkeys(case.known.factors, 1.0)
    known = replace(
        case.known, factors=right, shift_m={"car": 0.0, "trailer": 0.0}, loads=(1.0, 1.0, 1.0, 1.0)
    )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "vehicle.toml"
        file.write_text(knowledge.vehicle_toml(case.healthy, known, user))
        return load_vehicle(file)


def slots_of(case: Case) -> dict[str, float]:
    """What vehicle.toml does not say, as slots of the plant."""
    if not case.known.sprung:
        return as_plant.rigid(case.healthy)
    whole = case.healthy
    found = as_plant.springs(whole) | as_plant.bounce(whole) | as_plant.tyres(case.base)
    # whether an accelerometer sees gravity, and from how high, is for the tolerances to say
    return {name: value for name, value in found.items() if not name.startswith("sensor_height")}


def concealed_of(case: Case, draw: Draw, answer: Json) -> Concealed:
    """A drawn effect in the words of the package's library."""
    if draw.user:
        true, believed = vehicle_of(case, {}), vehicle_of(case, draw.user)
        return Concealed(None, own_limits.wrong_values(true, believed))
    car, trailer = case.healthy.car, case.healthy.trailer
    roll = {
        "gain_car": car.roll_gain_rad_m_s2, "gain_trailer": trailer.roll_gain_rad_m_s2,
        "frequency": 2.0 * np.pi * car.roll_frequency_hz, "damping": car.roll_damping_ratio,
    }  # fmt: skip
    windows = [
        (number, window)
        for number, run in enumerate(("run1", "run2"))
        for window in draw.windows.get(run, [])
    ]
    loads = [load for run in ("run1", "run2") for load in answer[run].get("harmonic", [])]
    known = {"harmonic": loads} if loads else {}
    return Concealed(explanations.concealed(draw.answer, windows, roll, known), {})


def limits_of(case: Case, answer: Json, folder: Path) -> list[Limit]:
    """Limit of each effect of a case whose files are in `folder`."""
    if case.simulated and case.draws:
        return beside_limits.limits(case, answer)
    if not case.draws or any(draw.outside for draw in case.draws):
        return []
    concealed = [concealed_of(case, draw, answer) for draw in case.draws]
    exact = case.known.tier in "AC" and not any(own.wrong for own in concealed)
    known = Known(exact, slots_of(case), case.known.sprung)
    true = vehicle_of(case, {})
    runs = own_limits.runs_of(folder, true, case.noise_factor)
    return own_limits.limits(own_limits.problem_of(runs, true, known), known, concealed)


def _job(work: tuple[int, Path, Path, str | None, str]) -> str:
    seed, cases, answers, only, method = work
    answer_file = answers / "answer.json"
    text = answer_file.read_text()
    digest = hashlib.sha256((method + text).encode()).hexdigest()[:16]
    out = answers / FILE
    if out.exists() and json.loads(out.read_text())["digest"] == digest:
        return answers.name
    answer = json.loads(text)
    case = generate.draw_case(seed, int(answers.name[1:]) - 1, only)
    drawn = json.loads(json.dumps([draw.answer for draw in case.draws], default=float))
    if drawn != answer["effects"]:
        raise ValueError(f"{answers.name} is not of seed {seed}: its answer says otherwise")
    began = time.monotonic()
    failed = ""
    with threadpool_limits(1):
        try:
            found = limits_of(case, answer, cases / answers.name)
        except FloatingPointError as error:  # counted as a case without a limit
            found, failed = [], str(error)
    out.write_text(
        json.dumps(
            {
                "digest": digest,
                "seconds": round(time.monotonic() - began, 2),
                "failed": failed,
                "limits": [
                    {"id": draw.answer["id"]} | asdict(limit)
                    for draw, limit in zip(case.draws, found, strict=bool(found))
                ],
            },
            indent=1,
        )
        + "\n"
    )
    return answers.name


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--cases", type=Path, required=True)
    parser.add_argument("--answers", type=Path, required=True)
    parser.add_argument("--count", type=int, default=0, help="the first so many; 0: all")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--beside", choices=beside.SETS, help="as given to generate.py")
    given = parser.parse_args()
    method = method_digest()
    folders = sorted(path.parent for path in given.answers.glob("*/answer.json"))
    work = [
        (given.seed, given.cases, folder, given.beside, method)
        for folder in folders[: given.count or None]
    ]
    with multiprocessing.get_context("spawn").Pool(given.jobs) as pool:
        for done, name in enumerate(pool.imap_unordered(_job, work), 1):
            print(f"\r{done}/{len(work)} {name}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)


if __name__ == "__main__":
    main()
