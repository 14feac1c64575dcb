"""Mutation testing of lib/ and port/: does a unit test notice when one token is wrong?

Each mutant changes one operator or number of one file, or leaves one statement out, is compiled
with the unit tests of that file, and must make one of them fail, hang or be stopped by a
sanitizer. What survives is listed; survivors that were looked at and change nothing that a test
could hold them to stand in ``excused.txt`` with the reason.

``files.txt`` says which tests hold which file. Mutants are tried in the order of a hash of what
they change, a few of each file in turn, so that a run that is stopped early is a fair sample, and
the same one while other lines are edited. With ``--keep`` a run goes on where the last one stopped:
what was found by a test is not tried again while its line stays as it is, survivors are.
"""

from __future__ import annotations

import argparse
import datetime
import hashlib
import json
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXCUSED = Path(__file__).with_name("excused.txt")
FILES = Path(__file__).with_name("files.txt")
SWAPS = {
    "<=": "<", "<": "<=", ">=": ">", ">": ">=", "==": "!=", "!=": "==", "&&": "||", "||": "&&",
    "+": "-", "-": "+", "*": "/", "/": "*", "%": "/", "<<": ">>", ">>": "<<", "&": "|", "|": "&",
    "+=": "-=", "-=": "+=", "|=": "&=", "&=": "|=", "++": "--", "--": "++",
    "true": "false", "false": "true",
}  # fmt: skip
TOKEN = re.compile(
    r'"(?:\\.|[^"\\])*"|/\*.*?\*/|//[^\n]*|^[ \t]*#[^\n]*|\b0[xX][0-9a-fA-F]+[uUlL]*|\b\d+[uUlL]*\b'
    r"|'(?:\\.|[^'\\])'|->|\+\+|--|<<=|>>=|<=|>=|==|!=|&&|\|\||\+=|-=|\*=|/=|\|=|&=|<<|>>"
    r"|\btrue\b|\bfalse\b|[-+*/%<>&|!]",
    re.DOTALL | re.MULTILINE,
)
STATEMENT = re.compile(
    r"^[ \t]+(?!return\b|break;|continue;|assert\(|ASSERT\()[^\s#/*}][^\n]*;", re.M
)
"""A statement on a line of its own, where the line before ends one; see `is_whole`."""


@dataclass(frozen=True)
class Mutant:
    """One change of one token or statement; `key` tells it from all others of the file."""

    start: int
    stop: int
    text: str
    line: int
    key: str


def is_whole(source: str, start: int) -> bool:
    """Whether a new statement begins at this line."""
    before = re.sub(r"//[^\n]*$|/\*[^*]*\*/\s*$", "", source[:start].rstrip()).rstrip()
    return before.endswith((";", "{", "}", "*/"))


def changes(source: str) -> Iterator[tuple[int, int, str, str]]:
    """Start, stop, new text and description of all mutants of a source."""
    lines = source.splitlines()
    for match in TOKEN.finditer(source):
        token = match.group()
        if token[0].isdigit():
            digits = re.match(r"0[xX][0-9a-fA-F]+|\d+", token)
            assert digits
            base = 8 if re.fullmatch(r"0\d+", digits.group()) else 0
            changed = str(int(digits.group(), base) + 1) + token[digits.end() :]
        elif token in SWAPS:
            changed = SWAPS[token]
        elif token == "!":
            changed = ""
        else:
            continue
        text = lines[source.count("\n", 0, match.start())]
        left = source[: match.start()].rsplit("\n", 1)[-1]
        is_pointer = token in "*&" and re.search(
            r"(\w+ \**|[(,=] ?|const |return |\))$", left
        ) and not re.match(r" ", source[match.end() :])  # fmt: skip
        if is_pointer or "#include" in text or "SWAY_ERROR" in token:
            continue
        same = 1 + sum(found.group() == token for found in TOKEN.finditer(left))
        which = f" ({same})" if same > 1 else ""
        yield match.start(), match.end(), changed, f"{token} -> {changed}{which} in: {text.strip()}"
    for match in STATEMENT.finditer(source):
        if is_whole(source, match.start()):
            yield match.start(), match.end(), ";", f"left out: {match.group().strip()}"


def mutants(path: Path) -> list[Mutant]:
    """All mutants of one file, by chance, in the same order again after edits elsewhere."""
    source = path.read_text()
    found: list[Mutant] = []
    seen = Counter[str]()
    for start, stop, text, what in changes(source):
        seen[what] += 1
        again = f" #{seen[what]}" if seen[what] > 1 else ""
        found.append(
            Mutant(
                start, stop, text, source.count("\n", 0, start) + 1, f"{path.name}: {what}{again}"
            )
        )
    return sorted(found, key=lambda mutant: hashlib.sha256(mutant.key.encode()).hexdigest())


CPU_LIMIT = 10
"""Times the processor time of the tests without a mutation, and as many seconds at least ..."""
CPU_LEAST_S = 2
"""... after which a mutant is taken to hang."""

FOLDERS = (
    "lib",
    "port",
    "port/cortex_m",
    "port/stm32g4",
    "port/replay",
    "port/socketcan",
    "port/xcp",
    "build/third_party/kissfft",
    "build/codec",
    "tests/unit",
    "tests/port",
    "build/third_party/ntpsec/tests/unity",
)
FLAGS = (
    *("-std=c99", "-O0", "-w", "-D_GNU_SOURCE", "-DFIXED_POINT=32", "-DSWAY_REGISTER_MODEL"),
    *("-DUNITY_INCLUDE_DOUBLE", "-DUNITY_SUPPORT_64", *(f"-I{ROOT / f}" for f in FOLDERS)),
)
SANITIZE = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def compiled(source: Path, made: Path, *more: str) -> Path | None:
    """The object of a source; None where it is no C."""
    done = subprocess.run(
        ["gcc", *FLAGS, *more, "-c", source, "-o", made], capture_output=True, check=False
    )
    return made if done.returncode == 0 else None


class Bench:
    """Compiles and runs mutants of one file against its unit tests.

    First without the sanitizers, which is quicker and finds nearly all; what passes, with them.
    What passes, too, and is the same machine code once optimised, is no mutation.
    """

    def __init__(self, path: Path, tests: list[str], others: list[Path], work: Path) -> None:
        self.path, self.work = path, work
        self.limit_s = {"plain": 100 * CPU_LEAST_S, "sanitized": 100 * CPU_LEAST_S}
        self.archive = work / "rest.a"
        shutil.copy(ROOT / "build/gcc/libsway.a", self.archive)
        self.run("ar", "d", self.archive, path.with_suffix(".o").name)
        for other in others:
            if other != path:
                made = self.must(other, work / f"{other.parent.name}_{other.stem}.o")
                self.run("ar", "q", self.archive, made)
        self.run("ranlib", self.archive)
        unity = ROOT / "build/third_party/ntpsec/tests/unity/unity.c"
        self.unity = self.must(unity, work / "unity.o")
        self.tests = [
            self.must(next(ROOT.glob(f"tests/*/{test}.c")), work / f"{test}.o") for test in tests
        ]

    @staticmethod
    def run(*command: str | Path) -> None:
        subprocess.run(command, capture_output=True, check=True)

    @staticmethod
    def must(source: Path, made: Path, *more: str) -> Path:
        if compiled(source, made, *more) is None:
            sys.exit(f"{source} does not compile")
        return made

    def outcome(self, source: str) -> str:
        """What becomes of this source: "no code", "killed" or "survived"."""
        mutated = self.work / "mutant.c"
        mutated.write_text(source)
        include = f"-I{self.path.parent}"
        for flavour, flags in (("plain", ()), ("sanitized", SANITIZE)):
            made = compiled(mutated, self.work / "mutant.o", include, *flags)
            if made is None:
                return "no code"
            if not all(self._passes(test, made, flavour, flags) for test in self.tests):
                return "killed"
        return "no code" if self._optimised() == self.original else "survived"

    def _optimised(self) -> bytes:
        """What the optimiser makes of the mutant: the same code is no mutation."""
        made = self.work / "optimised.o"
        self.must(self.work / "mutant.c", made, f"-I{self.path.parent}", "-O2")
        return made.read_bytes()

    def calibrate(self, source: str) -> None:
        """Runs the tests without a mutation; from then on they may take little longer."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        self.original = b""
        if self.outcome(source) != "survived":
            sys.exit(f"{self.path.name}: its tests fail without any mutation")
        self.original = self._optimised()
        spent_s = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        limit_s = CPU_LEAST_S + int(CPU_LIMIT * spent_s)
        self.limit_s = {"plain": min(limit_s, 20), "sanitized": limit_s}

    def _passes(self, test: Path, mutant: Path, flavour: str, flags: tuple[str, ...]) -> bool:
        program = self.work / "test"
        link = ["gcc", *flags, test, self.unity, mutant, self.archive, "-lm", "-o", program]
        if subprocess.run(link, capture_output=True, check=False).returncode != 0:
            return False
        limit = self.limit_s[flavour]
        try:
            done = subprocess.run(
                [program],
                capture_output=True,
                timeout=60 * limit,
                check=False,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit)),
            )
        except subprocess.TimeoutExpired:
            return False
        return done.returncode == 0


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


def try_some(entry: Entry, count: int, state: State, again: set[str], until: float) -> int:
    """Up to `count` of a file's mutants that were not tried before; how many were."""
    known = state.setdefault(entry.name, {})
    source = entry.path.read_text()
    every = mutants(entry.path)
    for gone in set(known) - {mutant.key for mutant in every}:
        del known[gone]
    due = [mutant for mutant in every if mutant.key not in known or mutant.key in again][:count]
    if not due:
        return 0
    with tempfile.TemporaryDirectory() as work:
        bench = Bench(entry.path, entry.tests, entry.others, Path(work))
        bench.calibrate(source)
        for tried, mutant in enumerate(due):
            if time.monotonic() > until:
                return tried
            outcome = bench.outcome(source[: mutant.start] + mutant.text + source[mutant.stop :])
            known[mutant.key] = outcome
            again.discard(mutant.key)
    return len(due)


def report(state: State, excused: dict[str, str]) -> tuple[str, list[str]]:
    """The table, and the survivors without a reason."""
    rows: list[tuple[str, Counter[str]]] = []
    open_ones: list[str] = []
    total = Counter[str]()
    for entry in entries():
        known = state.get(entry.name, {})
        every = mutants(entry.path)
        count = Counter(known.values())
        left = [m for m in every if known.get(m.key) == "survived"]
        without = [m for m in left if m.key not in excused]
        open_ones += [f"{entry.name}:{m.line}: {m.key}" for m in without]
        row = Counter(
            all=len(every), tried=count["killed"] + count["survived"], killed=count["killed"],
            excused=len(left) - len(without), survived=len(without), no_code=count["no code"],
        )  # fmt: skip
        total += row
        rows.append((entry.name, row))
    judged = max(total["tried"] - total["excused"], 1)
    lines = [
        f"# Mutation testing, {datetime.datetime.now(datetime.UTC):%Y-%m-%d}",
        "",
        f"{total['tried']} of {total['all'] - total['no_code']} mutants tried; a unit test found "
        f"{total['killed']}, {100 * total['killed'] / judged:.1f} % of the {judged} that change "
        f"something; {total['excused']} survivors change nothing that a test could hold them to, "
        "each with its reason in `excused.txt`. Made by `make mutation`, which goes on where it "
        "stopped.",
        "",
        "| file | possible | tried | found | excused | survived |",
        "|---|---|---|---|---|---|",
    ]
    for name, row in [*rows, ("all", total)]:
        lines.append(
            f"| {name} | {row['all'] - row['no_code']} | {row['tried']} | {row['killed']} | "
            f"{row['excused']} | {row['survived']} |"
        )
    if open_ones:
        lines += ["", "Survivors without a reason:", "", *(f"- `{one}`" for one in open_ones)]
    return "\n".join(lines) + "\n", open_ones


def main() -> int:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", help="only these, as sway_line or port/can")
    parser.add_argument("--sample", type=int, default=0, help="so many of each file, not all")
    parser.add_argument("--seconds", type=float, default=1e9, help="stop after so long")
    parser.add_argument("--keep", type=Path, help="outcomes, kept from one run to the next")
    parser.add_argument("--again", action="store_true", help="try survivors again")
    parser.add_argument("--report", type=Path, help="write the table to this file")
    args = parser.parse_args()
    excused = {}
    for line in EXCUSED.read_text().splitlines():
        name, mark, reason = line.partition(" # ")
        if mark:
            excused[name] = reason
    kept = args.keep and args.keep.exists()
    state: State = json.loads(args.keep.read_text()) if kept else {}
    chosen = [
        entry for entry in entries()
        if not args.files or any(name in (entry.path.stem, entry.name[:-2]) for name in args.files)
    ]  # fmt: skip
    again = {
        key for entry in chosen for key, outcome in state.get(entry.name, {}).items()
        if args.again and outcome == "survived" and key not in excused
    }  # fmt: skip
    until = time.monotonic() + args.seconds
    done, chunk = 0, min(args.sample or 20, 20)
    while done < (args.sample or sys.maxsize) and time.monotonic() < until:
        tried = 0
        for entry in chosen:
            tried += try_some(entry, chunk, state, again, until)
            if args.keep:
                args.keep.parent.mkdir(parents=True, exist_ok=True)
                args.keep.write_text(json.dumps(state, indent=0, sort_keys=True))
        done += chunk
        if tried == 0:
            break
    text, open_ones = report(state, excused)
    print(text, end="")
    if args.report:
        args.report.parent.mkdir(parents=True, exist_ok=True)
        args.report.write_text(text)
    return int(bool(open_ones))


if __name__ == "__main__":
    sys.exit(main())
