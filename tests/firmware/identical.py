"""Every machine has to give the same answers to the same frames, byte for byte.

Run by `make firmware-test` as `identical.py BUILD CASE.log ...`; a parameter block lies beside each
case. Exit status 1 if any answer differs, if a machine fails, or if nothing was estimated at all
(then the comparison would have shown nothing).
"""

from __future__ import annotations

import concurrent.futures
import sys
from pathlib import Path

from machines import Outcome, frame_of, run

TARGETS = ["x86", "mips", "m0plus", "m3", "m4f", "m7", "r5", "stm32g4"]
"""stm32g4: the program of that board on the host, on a model of its registers."""
SMALL = ["x86small", "small"]
"""The small configuration, whose answers are its own."""
LEAN = ("m0plus", "m3", "m4f", "r5")
"""Built without the supervision of the inputs (SWAY_SUPERVISION=0, tests/mk/firmware.mk)."""
SUPERVISION_IDS = ("1BA#", "1BB#")
"""Frames that only the others send: SwayFinding, SwayRelation."""
KEEPERS = ("stm32g4",)
"""Keep the trailer that they have learnt from drive to drive; the others have no memory for it."""
KEEPER_IDS = ("6E6#",)
"""Frames that only they send: SwayTrailer."""
SWING_IDS = ("1BC#",)
"""SwaySwing, which LEAN ones do not send (SWAY_SWING needs the supervision's sums)."""
ESTIMATES_MIN = 20
"""Estimates that a case has to bring, so that more than silence is compared."""
OSCILLATION_ID = "1A4#"


def block_of(case: Path, target: str = "x86") -> Path:
    """Return the parameter block of a case, whole or shortened, for a target."""
    kind = ".small.block" if target in SMALL else ".block"
    return case.with_name(case.name.split(".")[0] + kind)


def first_difference(expected: list[str], found: list[str]) -> str:
    """Say where two lists of frames part."""
    for number, (a, b) in enumerate(zip(expected, found, strict=False)):
        if a != b:
            return f"frame {number}: {b} instead of {a}"
    return f"{len(found)} frames instead of {len(expected)}"


def without(answers: list[str], ids: tuple[str, ...]) -> list[str]:
    """Return answers (lines or frames) but for the frames of some identifiers."""
    return [line for line in answers if not any(name in line for name in ids)]


def shared(answers: list[str], target: str) -> list[str]:
    """Return of a supervising machine's answers (lines or frames) those that a target gives too."""
    lacking = SUPERVISION_IDS if target in LEAN else ()
    lacking += SWING_IDS if target in LEAN else ()
    return without(answers, lacking)


def common(answers: list[str], target: str) -> list[str]:
    """Return of a target's answers (lines or frames) those that machines without a store give."""
    return without(answers, KEEPER_IDS) if target in KEEPERS else answers


def judge(case: Path, outcomes: dict[str, Outcome]) -> list[str]:
    """Return what is wrong with the runs of a case; the first one is what the others must be."""
    wrong = []
    first = next(iter(outcomes.values()))
    expected = [frame_of(line) for line in first.answers]
    estimates = sum(frame.startswith(OSCILLATION_ID) for frame in expected)
    if estimates < ESTIMATES_MIN:
        wrong.append(f"{case.name}: only {estimates} estimates to compare")
    for target, outcome in outcomes.items():
        given = common(outcome.answers, target)
        found = [frame_of(line) for line in given]
        if target in KEEPERS and len(given) == len(outcome.answers):
            wrong.append(f"{case.name} {target}: says nothing of the trailer that it keeps")
        if outcome.status != 0:
            wrong.append(f"{case.name} {target}: status {outcome.status}: {outcome.message[-300:]}")
        answers = shared(first.answers, target)
        expected = [frame_of(line) for line in answers]
        if found != expected:
            wrong.append(f"{case.name} {target}: {first_difference(expected, found)}")
        # Without a bus between them the stamps are those of the recording, too.
        if target != "r5" and given != answers:
            wrong.append(f"{case.name} {target}: time stamps differ")
    return wrong


def compare(build: Path, case: Path, targets: list[str]) -> list[str]:
    """Run a case on all targets, print what came out and return what is wrong."""
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        runs = {
            target: pool.submit(
                run, build, target, block_of(case, target), case, f"{case.stem}-{target}"
            )
            for target in targets
        }
    outcomes = {target: future.result() for target, future in runs.items()}
    problems = judge(case, outcomes)
    frames = len(outcomes[targets[0]].answers)
    verdict = "DIFFERENT" if problems else "identical"
    print(f"{case.name}: {frames} frames of status, {verdict} on {' '.join(targets)}")
    return problems


def main(build: Path, cases: list[Path]) -> int:
    """Compare all cases on all machines."""
    wrong: list[str] = []
    for case in cases:
        for targets in (TARGETS, SMALL):
            wrong += compare(build, case, targets)
    for problem in wrong:
        print(f"firmware: {problem}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), [Path(name) for name in sys.argv[2:]]))
