"""Mutation testing of lib/ and port/: does a unit test notice when one token is wrong?

Each mutant changes one operator or number of one file, is compiled with the unit tests of that
file, and must make one of them fail, hang or be
stopped by a sanitizer. What survives is listed; survivors that were looked at
and change nothing that a test could hold them to stand in ``excused.txt`` with the reason.

A sample takes the mutants with the smallest hash of what they change, so it stays the same while
other lines of the file are edited.
"""

from __future__ import annotations

import argparse
import hashlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXCUSED = Path(__file__).with_name("excused.txt")
SWAPS = {
    "<=": "<", "<": "<=", ">=": ">", ">": ">=", "==": "!=", "!=": "==", "&&": "||", "||": "&&",
    "+": "-", "-": "+", "*": "/", "/": "*", "%": "/", "<<": ">>", ">>": "<<", "&": "|", "|": "&",
    "+=": "-=", "-=": "+=", "|=": "&=", "++": "--", "--": "++", "true": "false", "false": "true",
}  # fmt: skip
TOKEN = re.compile(
    r'"(?:\\.|[^"\\])*"|/\*.*?\*/|//[^\n]*|^[ \t]*#[^\n]*|\b0[xX][0-9a-fA-F]+[uUlL]*|\b\d+[uUlL]*\b'
    r"|->|\+\+|--|<<=|>>=|<=|>=|==|!=|&&|\|\||\+=|-=|\*=|/=|\|=|&=|<<|>>|\btrue\b|\bfalse\b"
    r"|[-+*/%<>&|!]",
    re.DOTALL | re.MULTILINE,
)


@dataclass(frozen=True)
class Mutant:
    """One change of one token."""

    file: Path
    start: int
    stop: int
    text: str
    line: int
    source_line: str

    def name(self, source: str) -> str:
        """As in excused.txt: without a line number, so that it keeps through edits."""
        before = source[self.start : self.stop]
        left = source[: self.start].rsplit("\n", 1)[-1]
        same = 1 + sum(match.group() == before for match in TOKEN.finditer(left))
        which = f" ({same})" if same > 1 else ""
        return f"{self.file.name}: {before} -> {self.text}{which} in: {self.source_line.strip()}"


def mutants(path: Path) -> Iterator[Mutant]:
    """All mutants of one file."""
    source = path.read_text()
    lines = source.splitlines()
    for match in TOKEN.finditer(source):
        token = match.group()
        if token[0].isdigit():
            digits = re.match(r"0[xX][0-9a-fA-F]+|\d+", token)
            assert digits
            changed = str(int(digits.group(), 0) + 1) + token[digits.end() :]
        elif token in SWAPS:
            changed = SWAPS[token]
        elif token == "!":
            changed = ""
        else:
            continue
        number = source.count("\n", 0, match.start())
        text = lines[number]
        is_pointer = token in "*&" and re.search(
            r"(\w+ \**|[(,=] ?|const |return |\))$", source[: match.start()].rsplit("\n", 1)[-1]
        ) and not re.match(r" ", source[match.end() :])  # fmt: skip
        if is_pointer or "#include" in text or "SWAY_ERROR" in token:
            continue
        yield Mutant(path, match.start(), match.end(), changed, number + 1, text)


def sample(chosen: list[Mutant], source: str, size: int) -> list[Mutant]:
    """`size` mutants by chance, the same again after edits elsewhere, in order of the file."""

    def key(mutant: Mutant) -> str:
        return hashlib.sha256(mutant.name(source).encode()).hexdigest()

    return sorted(sorted(chosen, key=key)[:size], key=lambda mutant: mutant.start)


CPU_LIMIT = 10
"""Times the processor time of the tests without a mutation, and as many seconds at least ..."""
CPU_LEAST_S = 2
"""... after which a mutant is taken to hang."""

FOLDERS = (
    "lib",
    "port",
    "port/cortex_m",
    "port/stm32g4",
    "build/third_party/kissfft",
    "build/codec",
    "tests/unit",
    "tests/port",
    "build/third_party/ntpsec/tests/unity",
)
FLAGS = (
    *("-std=c99", "-O0", "-w", "-D_GNU_SOURCE", "-DFIXED_POINT=32", "-DSWAY_REGISTER_MODEL"),
    *("-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
    *("-DUNITY_INCLUDE_DOUBLE", "-DUNITY_SUPPORT_64", *(f"-I{ROOT / f}" for f in FOLDERS)),
)


def compiled(source: Path, folder: Path) -> Path | None:
    """The object of a source; None where it is no C."""
    made = folder / source.with_suffix(".o").name
    command = ["gcc", *FLAGS, "-c", source, "-o", made]
    return (
        made if subprocess.run(command, capture_output=True, check=False).returncode == 0 else None
    )


class Bench:
    """Compiles and runs mutants of one file against its unit tests."""

    def __init__(self, path: Path, tests: list[str], others: list[Path], work: Path) -> None:
        self.path, self.work, self.limit_s = path, work, 100 * CPU_LEAST_S
        self.archive = work / "rest.a"
        shutil.copy(ROOT / "build/gcc/libsway.a", self.archive)
        self.run("ar", "d", self.archive, path.with_suffix(".o").name)
        for other in others:
            if other.name != path.name or other.parent != path.parent:
                made = work / f"{other.parent.name}_{other.stem}"
                made.mkdir()
                self.run("ar", "r", self.archive, self.must(other, made))
        unity = ROOT / "build/third_party/ntpsec/tests/unity/unity.c"
        self.unity = self.must(unity, work)
        found = [next(ROOT.glob(f"tests/*/{test}.c")) for test in tests]
        self.tests = [self.must(test, work) for test in found]

    @staticmethod
    def run(*command: str | Path) -> None:
        subprocess.run(command, capture_output=True, check=True)

    @staticmethod
    def must(source: Path, folder: Path) -> Path:
        made = compiled(source, folder)
        if made is None:
            sys.exit(f"{source} does not compile")
        return made

    def outcome(self, source: str) -> str:
        """What becomes of this source: "no code", "killed" or "survived"."""
        mutated = self.work / self.path.name
        mutated.write_text(source)
        made = compiled(mutated, self.work)
        if made is None:
            return "no code"
        return "survived" if all(self._passes(test, made) for test in self.tests) else "killed"

    def calibrate(self, source: str) -> None:
        """Runs the tests without a mutation; from then on they may take little longer."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        if self.outcome(source) != "survived":
            sys.exit(f"{self.path.name}: its tests fail without any mutation")
        spent_s = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        self.limit_s = CPU_LEAST_S + int(CPU_LIMIT * spent_s)

    def _limit(self) -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (self.limit_s, self.limit_s))

    def _passes(self, test: Path, mutant: Path) -> bool:
        program = self.work / "test"
        link = [
            "gcc",
            "-fsanitize=address,undefined",
            test,
            self.unity,
            mutant,
            self.archive,
            "-lm",
            "-o",
            program,
        ]
        if subprocess.run(link, capture_output=True, check=False).returncode != 0:
            return False
        try:
            done = subprocess.run(
                [program],
                capture_output=True,
                timeout=60 * self.limit_s,
                check=False,
                preexec_fn=self._limit,
            )
        except subprocess.TimeoutExpired:
            return False
        return done.returncode == 0


@dataclass
class Score:
    """Counts of one file."""

    file: str
    all: int
    tried: int = 0
    killed: int = 0
    excused: int = 0
    survived: int = 0


def run_file(entry: str, size: int, excused: set[str]) -> Score:
    """All sampled mutants of FILE:TEST[,TEST][:SOURCE,...]; says which survive."""
    name, tests, *others = entry.split(":")
    path = ROOT / f"{name}.c" if "/" in name else next(ROOT.glob(f"lib/*/{name}.c"))
    source = path.read_text()
    every = list(mutants(path))
    score = Score(str(path.relative_to(ROOT)), len(every))
    with tempfile.TemporaryDirectory() as work:
        sources = [ROOT / other for other in ",".join(others).split(",") if other]
        bench = Bench(path, tests.split(","), sources, Path(work))
        bench.calibrate(source)
        for mutant in sample(every, source, size or len(every)):
            outcome = bench.outcome(source[: mutant.start] + mutant.text + source[mutant.stop :])
            known = mutant.name(source)
            score.tried += outcome != "no code"
            score.killed += outcome == "killed"
            if outcome == "survived":
                score.excused += known in excused
                score.survived += known not in excused
                if known not in excused:
                    print(f"{score.file}:{mutant.line}: survived: {known}", flush=True)
    return score


def table(scores: list[Score]) -> str:
    """The report."""
    total = Score("all", *(sum(getattr(s, n) for s in scores) for n in
                           ("all", "tried", "killed", "excused", "survived")))  # fmt: skip
    judged = max(total.tried - total.excused, 1)
    lines = [
        f"**`make mutation`**: {100 * total.killed / judged:.0f} % of {judged} mutants found by a "
        f"unit test; {total.excused} more change nothing that can be observed (excused.txt)",
        "",
        "| file | possible | tried | killed | excused | survived |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {s.file} | {s.all} | {s.tried} | {s.killed} | {s.excused} | {s.survived} |"
        for s in [*scores, total]
    ]
    return "\n".join(lines) + "\n"


def main() -> int:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "entries",
        nargs="+",
        metavar="FILE:TEST[,TEST][:SOURCE,...]",
        help="of lib/ unless it names its folder; what else its tests need, as sway_e2e:test_e2e",
    )
    parser.add_argument("--sample", type=int, default=0, help="only so many mutants of each file")
    parser.add_argument("--report", type=Path, help="write the table to this file")
    args = parser.parse_args()
    excused = {line.split(" # ")[0] for line in EXCUSED.read_text().splitlines() if line}
    scores = [run_file(entry, args.sample, excused) for entry in args.entries]
    text = table(scores)
    print(text, end="")
    if args.report:
        args.report.parent.mkdir(parents=True, exist_ok=True)
        args.report.write_text(text)
    return int(any(score.survived for score in scores))


if __name__ == "__main__":
    sys.exit(main())
