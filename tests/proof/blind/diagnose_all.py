"""Run ``swaywatch diagnose`` on every case of a directory, several at a time.

Knows nothing of the answers. A case that has been diagnosed by the same version of the package
is not diagnosed again; what a diagnosis cost and how it ended is kept beside its result.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import hashlib
import json
import subprocess
import sys
import time
from pathlib import Path

import swaywatch

LIMIT_S = 3600.0


def package_digest() -> str:
    """Digest of the package's own files that a verdict can depend on."""
    root = Path(swaywatch.__file__).parent
    digest = hashlib.sha256()
    for path in sorted([*root.rglob("*.py"), *root.rglob("*.c"), *root.rglob("*.toml")]):
        if "multibody" not in path.name:
            digest.update(path.relative_to(root).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def command(case: Path, out: Path) -> list[str]:
    """Command line of the diagnosis of one case: what any user would type."""
    runs = sorted(path for path in case.glob("run*.*"))
    simulations = sorted(case.glob("simulation_run*.*"))
    line = [sys.executable, "-m", "swaywatch.cli", "diagnose", *map(str, runs)]
    line += ["--vehicle", str(case / "vehicle.toml"), "--signals", str(case / "signals.toml")]
    if simulations:
        line += ["--simulation", *map(str, simulations)]
    return [*line, "--out", str(out)]


def diagnose(case: Path, out: Path, digest: str) -> str:
    """Diagnose one case unless that has been done; returns a word for the progress line."""
    stamp = out / "run.json"
    if stamp.exists() and json.loads(stamp.read_text())["digest"] == digest:
        return "kept"
    out.mkdir(parents=True, exist_ok=True)
    (out / "diagnosis.json").unlink(missing_ok=True)
    began = time.monotonic()
    try:
        done = subprocess.run(
            command(case, out), capture_output=True, text=True, timeout=LIMIT_S, check=False
        )
        status, said = done.returncode, (done.stderr or done.stdout)[-2000:]
    except subprocess.TimeoutExpired:
        status, said = -1, f"no end within {LIMIT_S:.0f} s"
    stamp.write_text(
        json.dumps(
            {
                "digest": digest,
                "status": status,
                "seconds": round(time.monotonic() - began, 2),
                "said": said if status else "",
            }
        )
    )
    return "done" if status == 0 else f"failed ({status})"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--count", type=int, default=0, help="the first so many; 0: all")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    digest = package_digest()
    cases = sorted(path.parent for path in given.cases.glob("*/vehicle.toml"))
    cases = cases[: given.count or None]
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        pending = {
            pool.submit(diagnose, case, given.out / case.name, digest): case for case in cases
        }
        for number, future in enumerate(concurrent.futures.as_completed(pending), 1):
            name = pending[future].name
            print(f"\r{number}/{len(cases)} {name} {future.result()}   ", end="", file=sys.stderr)
    print(file=sys.stderr)


if __name__ == "__main__":
    main()
