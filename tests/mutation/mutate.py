"""Mutation testing of lib/ and port/: does a unit test notice when one token is wrong?

Each mutant changes one operator or number of one file, or leaves one statement out, and must make
a unit test fail, hang or be stopped by a sanitizer; see `bench.py` for how, and for how all of them
are tried in an hour or two. What survives is listed; survivors that were looked at and change
nothing that a test could hold them to stand in ``excused.txt`` with the reason.

``files.txt`` says which tests hold which file. With ``--keep`` a run goes on where the last one
stopped: what was found by a test is not tried again while its line stays as it is, survivors are
with ``--again``.
"""

from __future__ import annotations

import argparse
import datetime
import json
import re
import sys
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from bench import ROOT, Bench, Source
from mutants import mutants

EXCUSED = Path(__file__).with_name("excused.txt")
FILES = Path(__file__).with_name("files.txt")


@dataclass
class Entry:
    """One line of files.txt."""

    path: Path
    tests: list[str]
    others: list[Path]

    @property
    def name(self) -> str:
        return str(self.path.relative_to(ROOT))


def entries() -> list[Entry]:
    """What files.txt says; every source of lib/ and port/ must be in it."""
    sets: dict[str, list[Path]] = {}
    found: list[Entry] = []
    named: set[str] = set()
    for line in FILES.read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        name, _, rest = line.partition(": ")
        if name.startswith("+"):
            sets[name] = [ROOT / word for word in rest.split()]
            continue
        named.add(name)
        if rest.startswith("not: "):
            continue
        words = rest.split()
        others = [path for word in words if word.startswith("+") for path in sets[word]]
        tests = [word for word in words if not word.startswith("+")]
        if (ROOT / name).exists():
            found.append(Entry(ROOT / name, tests, others))
    there = {
        str(path.relative_to(ROOT)) for top in ("lib", "port") for path in (ROOT / top).rglob("*.c")
    }
    if there != named:
        print(f"{FILES.name} and the sources differ: {sorted(there ^ named)}", file=sys.stderr)
    return found


State = dict[str, dict[str, str]]
"""Of each file, the outcome of each mutant's key."""


class Excuses:
    """What excused.txt gives a reason for: a key, or all that an expression behind ~ matches."""

    def __init__(self) -> None:
        self.keys: set[str] = set()
        self.patterns: list[re.Pattern[str]] = []
        for line in EXCUSED.read_text().splitlines():
            name, mark, _ = line.partition(" # ")
            if mark and name.startswith("~"):
                self.patterns.append(re.compile(name[1:]))
            elif mark:
                self.keys.add(name)

    def __contains__(self, key: str) -> bool:
        return key in self.keys or any(pattern.fullmatch(key) for pattern in self.patterns)


def table(state: State, excused: Excuses) -> tuple[list[tuple[str, Counter[str]]], list[str]]:
    """The counts of each file, and the survivors without a reason."""
    rows: list[tuple[str, Counter[str]]] = []
    open_ones: list[str] = []
    for entry in entries():
        known = state.get(entry.name, {})
        row = Counter[str]()
        for mutant in sorted(mutants(entry.path), key=lambda m: m.start):
            outcome = known.get(mutant.key, "not tried")
            if outcome == "survived" and mutant.key in excused:
                outcome = "excused"
            elif outcome == "survived":
                open_ones.append(f"{entry.name}:{mutant.line}: {mutant.key}")
            row["killed" if outcome.startswith("killed") else outcome] += 1
        rows.append((entry.name, row))
    return rows, open_ones


def report(state: State, excused: Excuses) -> tuple[str, list[str]]:
    """The table, and the survivors without a reason."""
    rows, open_ones = table(state, excused)
    total = sum((row for _, row in rows), Counter[str]())
    tried = total["killed"] + total["excused"] + total["survived"]
    judged = max(total["killed"] + total["survived"], 1)
    not_run = sum(
        ": not: " in line for line in FILES.read_text().splitlines() if not line.startswith("#")
    )
    lines = [
        f"# Mutation testing, {datetime.datetime.now(datetime.UTC):%Y-%m-%d}",
        "",
        f"{tried} of {tried + total['not tried']} mutants tried; a unit test found "
        f"{total['killed']}, {100 * total['killed'] / judged:.1f} % of the {judged} that change "
        f"something; {total['excused']} survivors change nothing that a test could hold them to, "
        "each with its reason in `excused.txt`. Made by `make mutation`. Mutants that are no C, or "
        "the same machine code once optimised, are not counted. Not tried are the "
        f"{not_run} files of port/ that no unit test runs (`files.txt` "
        "says what does).",
        "",
        "| file | tried | found | excused | survived | not tried |",
        "|---|---|---|---|---|---|",
    ]
    for name, row in [*rows, ("all", total)]:
        tried = row["killed"] + row["excused"] + row["survived"]
        lines.append(
            f"| {name} | {tried} | {row['killed']} | {row['excused']} | {row['survived']} | "
            f"{row['not tried']} |"
        )
    if open_ones:
        lines += ["", "Survivors without a reason:", "", *(f"- `{one}`" for one in open_ones)]
    return "\n".join(lines) + "\n", open_ones


def try_all(
    bench: Bench, chosen: list[Source], state: State, args: argparse.Namespace, excused: Excuses
) -> None:
    """Every mutant of the chosen files that is due; what is found is kept every few seconds."""
    until = time.monotonic() + args.seconds
    saved_s = 0.0

    def save() -> None:
        if args.keep:
            args.keep.parent.mkdir(parents=True, exist_ok=True)
            made = args.keep.with_suffix(".new")
            made.write_text(json.dumps(state, indent=0, sort_keys=True))
            made.rename(args.keep)

    for source in chosen:
        known = state.setdefault(source.name, {})
        for gone in set(known) - {mutant.key for mutant in source.every}:
            del known[gone]
        before = Counter(known.values())["survived"]
        begun = time.monotonic()
        tried = 0
        for number, mutant in enumerate(source.every, 1):
            old = known.get(mutant.key)
            if old is not None and not (
                args.again and old == "survived" and mutant.key not in excused
            ):
                continue
            if args.lines and not args.lines[0] <= mutant.line <= args.lines[1]:
                continue
            if time.monotonic() > until:
                break
            known[mutant.key] = bench.outcome(source, number)
            tried += 1
            if time.monotonic() > saved_s + 5:
                save()
                saved_s = time.monotonic()
        save()
        after = Counter(known.values())["survived"]
        print(
            f"{source.name}: {tried} tried in {time.monotonic() - begun:.0f} s, "
            f"{after} survive (before: {before})",
            flush=True,
        )


def main() -> int:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", help="only these, as sway_line or port/can")
    parser.add_argument("--lines", type=int, nargs=2, help="only what begins on these lines")
    parser.add_argument("--seconds", type=float, default=1e9, help="stop after so long")
    parser.add_argument("--keep", type=Path, help="outcomes, kept from one run to the next")
    parser.add_argument("--again", action="store_true", help="try survivors again")
    parser.add_argument("--thorough", action="store_true", help="slow tests and sanitizers, too")
    parser.add_argument("--report", type=Path, help="write the result here, too")
    parser.add_argument("--work", type=Path, default=ROOT / "build/mutation")
    args = parser.parse_args()
    excused = Excuses()
    kept = args.keep and args.keep.exists()
    state: State = json.loads(args.keep.read_text()) if kept else {}
    named = entries()
    needs: dict[str, list[Path]] = {}
    for entry in named:
        for test in entry.tests:
            more = [entry.path] if entry.name.startswith("port/") else []
            needs[test] = list(dict.fromkeys([*needs.get(test, []), *more, *entry.others]))
    sources = [Source(entry.path, entry.tests, slot) for slot, entry in enumerate(named, 1)]
    chosen = [
        source for source in sources
        if not args.files
        or any(name in (source.path.stem, source.name[:-2], source.name) for name in args.files)
    ]  # fmt: skip
    bench = Bench(sources, needs, args.work, args.thorough)
    begun = time.monotonic()
    bench.build()
    print(f"built in {time.monotonic() - begun:.0f} s", flush=True)
    try_all(bench, chosen, state, args, excused)
    bench.close()
    text, open_ones = report(state, excused)
    if args.report:
        args.report.parent.mkdir(parents=True, exist_ok=True)
        args.report.write_text(text)
    return int(bool(open_ones))


if __name__ == "__main__":
    sys.exit(main())
