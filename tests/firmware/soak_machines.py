"""The soak on emulated machines: `soak_machines.py BUILD`.

The host writes the same drive, with a fault every 4 s, as a recording, and what a receiver has to
count of it. Machines replay it (the R5 over its CAN controllers): all that are built with the
supervision of the inputs have to say the same, byte for byte, and so have all without it (a
rejected sensor leaves the estimate of the first); all end with exactly the
injected counts in their frames.
"""

from __future__ import annotations

import concurrent.futures
import subprocess
import sys
from pathlib import Path

from faults import DATABASE, decode
from identical import common, first_difference
from machines import Outcome, frame_of, run

GROUPS = (("x86", "mips", "stm32g4"), ("m0plus", "m4f", "r5"))
"""Supervising, and without (SWAY_SUPERVISION=0, as tests/mk/firmware.mk builds them)."""
TARGETS = tuple(target for group in GROUPS for target in group)
COUNTERS = {
    "CRC": ("SwayFaultsFrames", "FaultCrc"),
    "lost": ("SwayFaultsFrames", "FaultLost"),
    "repeated": ("SwayFaultsFrames", "FaultRepeated"),
    "late": ("SwayFaultsOrder", "FaultLate"),
    "length": ("SwayFaultsOrder", "FaultLength"),
    "timeout": ("SwayFaultsOrder", "FaultTimeout"),
    "stuck": ("SwayInputs", "FaultStuck"),
    "frozen": ("SwayInputs", "FaultFrozen"),
    "range": ("SwayFaultsSamples", "FaultRange"),
}
"""Counters that the bus tells, and where."""


def last_signals(outcome: Outcome) -> dict[str, dict[str, int]]:
    """Return the last frame of each kind."""
    found = {}
    for line in outcome.answers:
        frame_id, signals = decode(line)
        found[DATABASE.get_message_by_frame_id(frame_id).name] = signals
    return found


def main(build: Path) -> int:
    """Write the drive, run it everywhere, compare."""
    folder = build / "runs"
    folder.mkdir(exist_ok=True)
    recording, expected = folder / "soak.log", folder / "soak.expected"
    subprocess.run([build / "soak", "--write", recording, expected], check=True)
    block = build / "cases" / "p01-run1.block"
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        runs = {t: pool.submit(run, build, t, block, recording, f"soak-{t}") for t in TARGETS}
    outcomes = {target: future.result() for target, future in runs.items()}
    answers = {t: [frame_of(line) for line in common(o.answers, t)] for t, o in outcomes.items()}
    wrong = [
        f"{target}: status {outcome.status} {outcome.message[-200:]}"
        for target, outcome in outcomes.items()
        if outcome.status != 0
    ]
    wrong += [
        f"{target}: {first_difference(answers[group[0]], answers[target])}"
        for group in GROUPS
        for target in group[1:]
        if answers[target] != answers[group[0]]
    ]
    wanted = dict(line.rsplit(" ", 1) for line in expected.read_text().splitlines())
    for target, *_ in GROUPS:
        reported = last_signals(outcomes[target])
        for name, (message, signal) in COUNTERS.items():
            count = reported[message][signal]
            if count != int(wanted[name]):
                wrong.append(f"{target}: {name}: {count} counted, {wanted[name]} injected")
    for line in wrong:
        print(f"soak: {line}", file=sys.stderr)
    verdict = "wrong" if wrong else "all counters exact, identical"
    print(f"soak on machines: {len(answers['x86'])} frames, {verdict} on {' '.join(TARGETS)}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
