"""Modified condition/decision coverage (MC/DC) of the judgement by its unit tests.

``mcdc.py [FILE...]`` takes every ``&&`` and ``||`` of alarm, evidence and judge apart: each
condition is replaced by one that is logged, the unit tests of the file (tests/mutation/files.txt)
are run, and for each condition a pair of evaluations is looked for that differs in it and in the
outcome, all others being the same or not evaluated in one of the two (masking by short
circuit). What has no such pair is listed and fails, but for ``NOT_INDEPENDENT`` below, each with
its reason.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "mutation"))

import mutate
from bench import FLAGS, ROOT, UNITY, Bench, run

JUDGEMENT = tuple(f"lib/judge/sway_{name}.c" for name in ("alarm", "evidence", "judge"))
NOT_INDEPENDENT = {
    "lib/judge/sway_judge.c: (uint32_t)channel < SWAY_CHANNELS": "true for every channel of this "
    "build; the smallest one, which has fewer, is tested by tests/small",
}
"""Conditions that no input can move alone, "FILE: condition", and why."""

SKIPPED = re.compile(
    r'"(?:\\.|[^"\\])*"|/\*.*?\*/|//[^\n]*|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*', re.S | re.M
)
BOUNDARY = re.compile(r"[;{},?:]|(?<![=!<>])=(?!=)")
LOG = """
#include <stdio.h>
#include <stdlib.h>
static unsigned char mcdc_seen[100][1460];
static int mcdc_now[100][6];
static void mcdc_begin(int d) { for (int k = 0; k < 6; k++) mcdc_now[d][k] = 2; }
static int mcdc_c(int d, int k, int v) { mcdc_now[d][k] = v != 0; return v; }
static int mcdc_end(int d, int v)
{
    int code = 0;
    for (int k = 5; k >= 0; k--) code = 3 * code + mcdc_now[d][k];
    mcdc_seen[d][2 * code + (v != 0)] = 1;
    return v;
}
static void __attribute__((destructor)) mcdc_write(void)
{
    FILE *const file = fopen(getenv("MCDC_LOG"), "a");
    for (int d = 0; d < 100; d++)
        for (int code = 0; code < 1460; code++)
            if (mcdc_seen[d][code]) fprintf(file, "%d %d\\n", d, code);
    fclose(file);
}
"""


@dataclass(frozen=True)
class Decision:
    """A Boolean expression and its conditions, as places in the source."""

    start: int
    stop: int
    line: int
    conditions: tuple[tuple[int, int], ...]


def blanked(source: str) -> str:
    """The source with comments, strings and preprocessor lines as blanks of the same length."""
    return SKIPPED.sub(lambda found: re.sub(r"[^\n]", " ", found.group()), source)


def _edge(text: str, at: int, step: int) -> int:
    """How far the expression around `at` goes in one direction; groups of operators are crossed."""
    opening, closing = ("(", ")") if step > 0 else (")", "(")
    depth = 0
    while 0 <= at < len(text):
        letter = text[at]
        if letter == opening:
            depth += 1
        elif letter == closing:
            if depth == 0:
                return at
            depth -= 1
        elif depth == 0 and BOUNDARY.match(text, at):
            return at
        at += step
    return at


def _expression(text: str, operator: int) -> tuple[int, int]:
    """The largest Boolean expression that holds the operator."""
    left, right = _edge(text, operator - 1, -1), _edge(text, operator + 2, 1)
    while text[left] == "(" and re.search(r"(&&|\|\||!|\()\s*$", text[:left]):
        left, right = _edge(text, left - 1, -1), _edge(text, right + 1, 1)
    start = left + 1
    start += len(text[start:right]) - len(text[start:right].lstrip())
    word = re.match(r"return\b\s*", text[start:])
    start += word.end() if word else 0
    return start, start + len(text[start:right].rstrip())


def _split(text: str, start: int, stop: int, operator: str) -> list[tuple[int, int]]:
    depth, parts, first = 0, [], start
    for at in range(start, stop):
        depth += (text[at] == "(") - (text[at] == ")")
        if depth == 0 and text.startswith(operator, at):
            parts.append((first, at))
            first = at + 2
    return [*parts, (first, stop)]


def _conditions(text: str, start: int, stop: int) -> Iterator[tuple[int, int]]:
    """Places of the conditions of an expression, in the order of their evaluation."""
    start += len(text[start:stop]) - len(text[start:stop].lstrip())
    stop = start + len(text[start:stop].rstrip())
    for operator in ("||", "&&"):
        parts = _split(text, start, stop, operator)
        if len(parts) > 1:
            for part in parts:
                yield from _conditions(text, *part)
            return
    inner = start + (text[start] == "!")
    grouped = text[inner] == "(" and _edge(text, inner + 1, 1) == stop - 1
    if grouped and re.search(r"&&|\|\|", text[inner:stop]):
        yield from _conditions(text, inner + 1, stop - 1)
    else:
        yield start, stop


def decisions(source: str) -> list[Decision]:
    """All decisions of a source that have more than one condition."""
    text = blanked(source)
    places = sorted({_expression(text, m.start()) for m in re.finditer(r"&&|\|\|", text)})
    return [
        Decision(a, b, source.count("\n", 0, a) + 1, tuple(_conditions(text, a, b)))
        for a, b in places
    ]


def instrumented(source: str, found: list[Decision]) -> str:
    """The source with each condition and each decision logged."""
    edits: list[tuple[int, int, str]] = []  # place, rank, text
    for number, decision in enumerate(found):
        edits.append((decision.start, 0, f"(mcdc_begin({number}), mcdc_end({number}, ("))
        edits.append((decision.stop, 1, ")))"))
        for k, (start, stop) in enumerate(decision.conditions):
            edits.append((start, 1, f"mcdc_c({number}, {k}, ("))
            edits.append((stop, 0, "))"))
    for at, _, text in sorted(edits, key=lambda e: (e[0], e[1]), reverse=True):
        source = source[:at] + text + source[at:]
    return LOG + source


def evaluations(entry: mutate.Entry, found: list[Decision]) -> dict[int, set[tuple[int, ...]]]:
    """Of each decision what its conditions were (0, 1, 2: not evaluated), and the outcome."""
    seen: dict[int, set[tuple[int, ...]]] = {number: set() for number in range(len(found))}
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        changed = work / "logged.c"
        changed.write_text(instrumented(entry.path.read_text(), found))
        lib = [path for path in (ROOT / "lib").rglob("*.c") if path != entry.path]
        flags = [*FLAGS, "-std=gnu99", *Bench.includes(ROOT), f"-I{entry.path.parent}"]
        archive = [ROOT / "build/gcc" / name for name in ("codec", "kissfft")]
        objects = [path for folder in archive for path in folder.glob("*.o")]
        program = work / "test"
        for test in entry.tests:
            sources = [ROOT / f"tests/unit/{test}.c", UNITY / "unity.c", changed, *lib, *objects]
            run("gcc", *flags, *sources, "-lm", "-o", program)
            log = work / "log"
            done = subprocess.run(
                [program], env={"MCDC_LOG": str(log)}, check=False, capture_output=True, text=True
            )
            if done.returncode != 0:
                sys.exit(f"{entry.name}: a test fails with its decisions logged:\n{done.stdout}")
            for line in log.read_text().splitlines():
                number, code = map(int, line.split())
                values, rest = [], code // 2
                for _ in found[number].conditions:
                    values.append(rest % 3)
                    rest //= 3
                seen[number].add((*values, code % 2))
    return seen


def shown(k: int, seen: set[tuple[int, ...]]) -> bool:
    """Whether condition `k` alone was seen to change the outcome."""
    for one, other in combinations(seen, 2):
        alone = all(
            a == b or 2 in (a, b)
            for i, (a, b) in enumerate(zip(one[:-1], other[:-1], strict=True)) if i != k
        )  # fmt: skip
        if alone and {one[k], other[k]} == {0, 1} and one[-1] != other[-1]:
            return True
    return False


def table(names: list[str]) -> tuple[str, list[str]]:
    """The table in Markdown, and the conditions that were not shown and have no reason."""
    lines = ["| decision | conditions | shown |", "|---|---|---|"]
    missing: list[str] = []
    count = total = 0
    for entry in mutate.entries():
        if entry.name not in names:
            continue
        source = entry.path.read_text()
        found = decisions(source)
        for (number, seen), decision in zip(evaluations(entry, found).items(), found, strict=True):
            del number
            good = 0
            for k, (start, stop) in enumerate(decision.conditions):
                text = f"{entry.name}: {' '.join(source[start:stop].split())}"
                reached = shown(k, seen)
                good += reached
                if not reached and text not in NOT_INDEPENDENT:
                    missing.append(f"{text} (line {decision.line})")
            short = " ".join(source[decision.start : decision.stop].split()).replace("|", "\\|")
            of = len(decision.conditions)
            lines.append(f"| {entry.path.name} `{short}` | {of} | {good} |")
            count, total = count + good, total + of
    lines.append(f"| all | {total} | {count} |")
    lines += [
        f"\nNot shown: `{what}`: {why}." for what, why in NOT_INDEPENDENT.items()
        if what.partition(":")[0] in names
    ]  # fmt: skip
    return "\n".join(lines) + "\n", missing


def main() -> int:
    """Print the table; 1 where a condition is not shown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "files", nargs="*", default=list(JUDGEMENT), help="as lib/judge/sway_alarm.c"
    )
    text, missing = table(parser.parse_args().files)
    print(text, end="")
    for one in missing:
        print(f"not shown: {one}")
    return int(bool(missing))


if __name__ == "__main__":
    sys.exit(main())
