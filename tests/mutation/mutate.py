"""Mutation testing of lib/: does a unit test notice when one token of the source is wrong?

Each mutant changes one operator or number of one file, is compiled with the unit test of that file,
and must make it fail (or fail to compile, or hang). What survives is listed; survivors that were
looked at and change nothing that can be observed stand in ``excused.txt`` with the reason.
"""

from __future__ import annotations

import argparse
import random
import re
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
        return f"{self.file.name}: {before} -> {self.text} in: {self.source_line.strip()}"


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


class Bench:
    """Compiles and runs mutants of one file against its unit test."""

    def __init__(self, path: Path, test: str, work: Path) -> None:
        self.path, self.work = path, work
        folders = (
            "lib",
            "build/third_party/kissfft",
            "build/codec",
            "tests/unit",
            "build/third_party/ntpsec/tests/unity",
        )
        defines = ("-D_GNU_SOURCE", "-DFIXED_POINT=32", "-DUNITY_INCLUDE_DOUBLE")
        include = [f"-I{ROOT / folder}" for folder in folders]
        self.gcc = ["gcc", "-std=c99", "-O1", "-w", *defines, *include]
        archive = work / "rest.a"
        shutil.copy(ROOT / "build/gcc/libsway.a", archive)
        subprocess.run(["ar", "d", archive, path.with_suffix(".o").name], check=True)
        self.rest = [work / "unity.o", work / "unit.o", archive]
        unity = ROOT / "build/third_party/ntpsec/tests/unity/unity.c"
        for source, made in (
            (unity, self.rest[0]),
            (ROOT / "tests/unit" / f"{test}.c", self.rest[1]),
        ):
            subprocess.run([*self.gcc, "-c", source, "-o", made], check=True)

    def survives(self, source: str) -> bool:
        """True where the unit test passes with this source."""
        mutated, program = self.work / self.path.name, self.work / "test"
        mutated.write_text(source)
        build = [*self.gcc, mutated, *self.rest, "-lm", "-o", program]
        if subprocess.run(build, capture_output=True, check=False).returncode != 0:
            return False
        try:
            done = subprocess.run([program], capture_output=True, timeout=5, check=False)
        except subprocess.TimeoutExpired:
            return False
        return done.returncode == 0


def main() -> int:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pairs", nargs="+", metavar="FILE:TEST", help="sway_e2e:test_node")
    parser.add_argument("--sample", type=int, help="only so many mutants of each file, by chance")
    args = parser.parse_args()
    excused = {line.split(" # ")[0] for line in EXCUSED.read_text().splitlines() if line}
    survivors = total = 0
    for pair in args.pairs:
        name, test = pair.split(":")
        path = ROOT / "lib" / f"{name}.c"
        source = path.read_text()
        chosen = list(mutants(path))
        if args.sample and args.sample < len(chosen):
            chosen = random.Random(1).sample(chosen, args.sample)
        with tempfile.TemporaryDirectory() as work:
            bench = Bench(path, test, Path(work))
            if not bench.survives(source):
                sys.exit(f"{test} fails without any mutation")
            for mutant in chosen:
                total += 1
                changed = source[: mutant.start] + mutant.text + source[mutant.stop :]
                known = mutant.name(source)
                if bench.survives(changed) and known not in excused:
                    survivors += 1
                    print(f"lib/{path.name}:{mutant.line}: survived: {known}", flush=True)
    print(f"{total} mutants, {survivors} survived that are not excused")
    return int(survivors > 0)


if __name__ == "__main__":
    sys.exit(main())
