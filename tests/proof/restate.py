"""Put the intervals of the present calibration into verdicts that were made before it.

    python restate.py VERDICTS

A verdict keeps the standard error and the size of each parameter, so its intervals follow from the
table without diagnosing again; they come out as `make proof` would write them today. Nothing else
is touched.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from swaywatch.diagnose.engine import write
from swaywatch.diagnose.evidence.calibration import BESIDE, interval


def restate(path: Path) -> None:
    """One file, rewritten whole or not at all."""
    verdict = json.loads(path.read_text())
    beside = BESIDE if "calibration" in verdict["model"] else ""
    for effect in verdict["effects"]:
        for said in effect["parameters"].values():
            if "standard_error" in said:
                error, size = said["standard_error"], said["deviation"]
                scatter = said.get("scatter", 0.0)
                name = effect["id"] + beside
                said.update(interval(name, said["value"], size, error, 1.0, scatter=scatter))
    write(verdict, path)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("verdicts", type=Path)
    given = parser.parse_args()
    for path in sorted(given.verdicts.glob("*/*.json")):
        restate(path)


if __name__ == "__main__":
    main()
