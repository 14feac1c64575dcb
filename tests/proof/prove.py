"""Diagnose every case folder and write its verdict with the sha256 of each recording.

    python tests/proof/prove.py RECORDINGS OUT [--only GROUP] [--jobs N]

A case is any folder with vehicle.toml, signals.toml and run*.*; simulation_run*.* in it is the
user's own simulation. Every case is treated alike: there are no settings for any of them.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

#: Groups of cases below the recordings' root, in this order.
GROUPS = ("practice", "sealed", "chrono")


def cases(root: Path) -> list[Path]:
    """Folders with everything a diagnosis needs."""
    found = []
    for group in GROUPS:
        for folder in sorted((root / group).glob("*")):
            if (folder / "vehicle.toml").exists() and (folder / "signals.toml").exists():
                found.append(folder)
    return found


def sha256(path: Path) -> str:
    """Of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def portable(result: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The verdict without paths of this machine."""
    result.pop("inputs", None)
    files = sorted(p for p in folder.iterdir() if p.name != "truth.json")
    return {
        "case": f"{folder.parent.name}/{folder.name}",
        "sha256": {p.name: sha256(p) for p in files},
        **result,
    }


def work(job: tuple[Path, Path]) -> tuple[str, str, float]:
    """Diagnose one case."""
    from swaywatch.diagnose.engine import diagnose, write

    folder, out = job
    started = time.monotonic()
    runs = sorted(folder.glob("run*.*"))
    simulations = sorted(folder.glob("simulation_run*.*"))
    result = diagnose(
        runs, folder / "vehicle.toml", folder / "signals.toml", simulations=simulations
    )
    target = out / folder.parent.name / f"{folder.name}.json"
    target.parent.mkdir(parents=True, exist_ok=True)
    write(portable(result, folder), target)
    return target.stem, line(result), time.monotonic() - started


def line(result: dict[str, Any]) -> str:
    """One line about a verdict."""
    parts = [result["verdict"]]
    for effect in result["effects"]:
        values = " ".join(f"{k}={v['value']:.4g}" for k, v in effect["parameters"].items())
        same = "".join(f" ~{name}" for name in effect["equivalent_details"])
        parts.append(
            f"{effect['id']}({effect['component']}) {values} {effect['confidence']:.2f}{same}"
        )
    return "; ".join(parts)


def main() -> int:
    """Run over all cases."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recordings", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", nargs="*", default=list(GROUPS), help="groups to run")
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    todo = [(c, args.out) for c in cases(args.recordings) if c.parent.name in args.only]
    if not todo:
        print(f"no cases below {args.recordings}", file=sys.stderr)
        return 1
    with ProcessPoolExecutor(args.jobs) as pool:
        for (folder, _), (_, text, seconds) in zip(todo, pool.map(work, todo), strict=True):
            print(f"{folder.parent.name}/{folder.name}: {text} [{seconds:.0f} s]", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
