"""Builds the unit test programs with all mutants in them, and tries mutants on single tests.

A program (tests/unit, tests/port, tests/small) is linked with the sources under test as
`schemata.py` writes them and with `harness.c`, which runs single tests in processes of their own.
Of each test it is known which functions it calls: a mutant of a function is tried on the tests that
call it, those of its file (files.txt) first, the quick and the successful ones before the others,
until one fails. What passes is tried again under the sanitizers, on the tests of its file. What
passes there, too, and is the same machine code once optimised, is no mutation.
"""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import schemata
from mutants import Mutant, mutants

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
UNITY = ROOT / "build/third_party/ntpsec/tests/unity"
KISSFFT = ROOT / "build/third_party/kissfft"
CODEC = ROOT / "build/codec"

LIMIT = 10
"""Times the processor time of a test without a mutation ..."""
QUICK_S = 0.05
LEAST_MS = {"plain": 200, "sanitized": 1000}
"""... and so much more, after which a mutant is taken to hang."""
FLAGS = ("-std=c99", "-w", "-D_GNU_SOURCE", "-DFIXED_POINT=32", "-DSWAY_REGISTER_MODEL",
         "-DUNITY_INCLUDE_DOUBLE", "-DUNITY_SUPPORT_64")  # fmt: skip
FLAVOURS = {
    "plain": ("-O1",),
    "sanitized": ("-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
}
FOLDERS = ("lib", "port", "port/cortex_m", "port/stm32g4", "port/replay", "port/socketcan",
           "port/xcp")  # fmt: skip
ENVIRONMENT = {
    **os.environ,
    "ASAN_OPTIONS": "detect_leaks=0:symbolize=0:print_legend=0",
    "UBSAN_OPTIONS": "symbolize=0",
}


def small_sizes() -> list[str]:
    """The defines of the smallest configuration."""
    text = (ROOT / "tests/mk/firmware.mk").read_text()
    found = re.search(r"^FW_SIZES_small := (.*)$", text, re.M)
    assert found
    return found.group(1).split()


@dataclass
class Source:
    """A file under test: its mutants, and how they are written."""

    path: Path
    tests: list[str]
    slot: int
    text: str = ""
    every: list[Mutant] = field(default_factory=list)
    functions: list[schemata.Function] = field(default_factory=list)
    outside: list[Mutant] = field(default_factory=list)
    bad: dict[str, set[int]] = field(default_factory=dict)
    """Of each configuration, the numbers of mutants that are no C."""

    def __post_init__(self) -> None:
        self.text = self.path.read_text()
        self.every = sorted(mutants(self.path), key=lambda m: (m.start, m.stop))
        self.functions, self.outside = schemata.functions(self.text, self.every, self.slot << 9)

    @property
    def name(self) -> str:
        return str(self.path.relative_to(ROOT))

    def function_of(self, number: int) -> schemata.Function | None:
        return next(
            (f for f in self.functions if f.copies[0].number <= number <= f.copies[-1].number), None
        )


class Server:
    """A running test program; one test at a time."""

    def __init__(self, program: Path) -> None:
        self.process = subprocess.Popen(
            [program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            text=True, env=ENVIRONMENT,
        )  # fmt: skip

    def ask(self, line: str) -> str:
        assert self.process.stdin
        assert self.process.stdout
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            sys.exit(f"{self.process.args} ended")
        return answer.rstrip("\n")

    def names(self) -> list[str]:
        found = [self.ask("list")]
        assert self.process.stdout
        while found[-1]:
            found.append(self.process.stdout.readline().rstrip("\n"))
        return found[:-1]

    def close(self) -> None:
        assert self.process.stdin
        self.process.stdin.close()
        self.process.wait()


@dataclass
class Test:
    """One test of a program."""

    program: str
    index: int
    name: str
    spent_s: dict[str, float]
    reached: set[int]
    """The numbers of the functions that it calls."""

    @property
    def title(self) -> str:
        return f"{self.program}: {self.name}"


def run(*command: str | Path) -> None:
    """Run a tool, or end with what it says."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr[:3000]}")


class Bench:
    """All test programs with all mutants.

    If not `thorough`, slow tests of other files and the sanitizers are left out.
    """

    def __init__(
        self, sources: list[Source], needs: dict[str, list[Path]], work: Path, thorough: bool
    ) -> None:
        self.sources, self.needs, self.work, self.thorough = sources, needs, work, thorough
        self.flavours = list(FLAVOURS) if thorough else ["plain"]
        self.tree = work / "src"
        self.kills: Counter[str] = Counter()
        self.tries: Counter[str] = Counter()
        self.servers: dict[tuple[str, str], Server] = {}
        self.tests: list[Test] = []
        self.originals: dict[str, bytes] = {}
        self.reaching: defaultdict[int, list[Test]] = defaultdict(list)

    # --- building ---------------------------------------------------------------------------------

    @staticmethod
    def includes(tree: Path) -> list[str]:
        """The folders that the sources of a tree need."""
        folders = [tree / folder for folder in FOLDERS]
        folders += [KISSFFT, CODEC, ROOT / "tests/unit", ROOT / "tests/port", UNITY, HERE]
        return [f"-I{folder}" for folder in folders]

    def compile(self, source: Path, made: Path, tree: Path, *more: str) -> bool:
        done = subprocess.run(
            ["gcc", *FLAGS, *more, *self.includes(tree), "-c", source, "-o", made],
            capture_output=True, check=False,
        )  # fmt: skip
        return done.returncode == 0

    def must(self, source: Path, made: Path, tree: Path, *more: str) -> Path:
        made.parent.mkdir(parents=True, exist_ok=True)
        if not self.compile(source, made, tree, *more):
            sys.exit(f"{source} does not compile")
        return made

    def configurations(self, source: Source) -> list[str]:
        return ["all", "small"] if source.name.startswith("lib/") else ["all"]

    def configured(self, configuration: str) -> list[str]:
        return small_sizes() if configuration == "small" else []

    def write_tree(self) -> None:
        """A copy of the sources with all mutants in them, but those that do not compile."""
        written = {source.path: source for source in self.sources}
        for configuration in ("all", "small"):
            for top in ("lib", "port"):
                for path in (ROOT / top).rglob("*.[ch]"):
                    copy = self.tree / configuration / path.relative_to(ROOT)
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    text = path.read_text()
                    if path in written:
                        source = written[path]
                        bad = self.bad(source, configuration)
                        source.bad[configuration] = bad
                        text = schemata.written(text, source.functions, bad, source.slot)
                    if not copy.exists() or copy.read_text() != text:
                        copy.write_text(text)

    def bad(self, source: Source, configuration: str) -> set[int]:
        """The numbers of the mutants that do not compile; known while the file stays as it is."""
        if configuration not in self.configurations(source):
            return set()
        digest = hashlib.sha256(f"{configuration} {source.text}".encode()).hexdigest()[:16]
        kept = self.work / "bad" / f"{source.path.stem}-{digest}"
        if kept.exists():
            return {int(word) for word in kept.read_text().split()}
        kept.parent.mkdir(parents=True, exist_ok=True)
        path = self.work / f"try_{source.path.name}"
        # A copy with a brace too few or too many would take those behind it along.
        bad = {
            copy.number
            for function in source.functions
            for copy in function.copies
            if copy.text.count("{") + 1 != copy.text.count("}")
        }
        while True:
            path.write_text(schemata.written(source.text, source.functions, bad, source.slot))
            done = subprocess.run(
                ["gcc", *FLAGS, *self.configured(configuration), f"-I{source.path.parent}",
                 *self.includes(ROOT), "-fsyntax-only", "-fmax-errors=0", "-x", "c", path],
                capture_output=True, text=True, check=False,
            )  # fmt: skip
            if done.returncode == 0:
                break
            found = re.findall(rf"^{re.escape(str(path))}:(\d+):\d+: error", done.stderr, re.M)
            at = {int(line) for line in found}
            new = {
                copy.number
                for function in source.functions
                for copy in function.copies
                if any(copy.first <= line <= copy.last for line in at)
            }
            if not new - bad:
                sys.exit(f"{path} does not compile:\n{done.stderr[:2000]}")
            bad |= new
        path.unlink()
        kept.write_text(" ".join(map(str, sorted(bad))))
        return bad

    def objects(self, flavour: str, configuration: str) -> dict[str, Path]:
        """The object of each source with all mutants, where it is new."""
        made: dict[str, Path] = {}
        flags = [*FLAVOURS[flavour], *self.configured(configuration)]
        tree = self.tree / configuration
        for source in self.sources:
            if source.path.suffix != ".c" or configuration not in self.configurations(source):
                continue
            path = tree / source.name
            to = self.work / flavour / configuration / (source.name.replace("/", "_")[:-2] + ".o")
            if self.newer(to, path):
                self.must(path, to, tree, *flags)
            made[source.name] = to
        folder = self.work / flavour / configuration
        if (folder / "kissfft.o").exists():
            return made | {"codec": folder / "codec.o", "kissfft": folder / "kissfft.o"}
        made["codec"] = self.must(CODEC / "swaywatch_dbc.c", folder / "codec.o", tree, *flags)
        made["kissfft"] = self.must(KISSFFT / "kiss_fft.c", folder / "kissfft.o", tree, *flags)
        return made

    def newer(self, made: Path, source: Path) -> bool:
        """Whether an object has to be made again."""
        return not made.exists() or made.stat().st_mtime < max(
            source.stat().st_mtime, self.newest_header
        )

    def plain_objects(self) -> dict[str, Path]:
        """The objects without any mutant, for those that are compiled one by one."""
        made: dict[str, Path] = {}
        for flavour in self.flavours:
            folder = self.work / flavour / "none"
            for source in self.sources:
                if source.path.suffix == ".c":
                    to = folder / (source.name.replace("/", "_")[:-2] + ".o")
                    if self.newer(to, source.path):
                        self.must(source.path, to, ROOT, *FLAVOURS[flavour])
                    made[f"{flavour} {source.name}"] = to
        return made

    def support(self, flavour: str, program: str) -> list[Path]:
        """The objects of a test program that hold no mutants: test, harness, Unity, models."""
        flags = FLAVOURS[flavour]
        configuration = "small" if program == "test_small" else "all"
        more = self.configured(configuration)
        folder = self.work / flavour / "tests"
        test = next(ROOT.glob(f"tests/*/{program}.c"))
        models = [path for path in self.needs[program] if path.is_relative_to(ROOT / "tests")]
        made: list[Path] = []
        for path in (test, HERE / "harness.c", UNITY / "unity.c", *models):
            to = folder / f"{path.stem}.o"
            offered = (
                ["-fwrapv", "-include", str(HERE / "harness.h"), *more] if path == test else []
            )
            if self.newer(to, path):
                self.must(path, to, ROOT, *flags, *offered)
            made.append(to)
        return made

    def wanted(self, program: str) -> list[str]:
        """The sources of lib/ and port/ that a program is linked with."""
        lib = [s.name for s in self.sources if s.name.startswith("lib/") and s.path.suffix == ".c"]
        names = [str(path.relative_to(ROOT)) for path in self.needs[program]]
        return lib + [name for name in names if name.startswith("port/")]

    def link(self, flavour: str, objects: list[Path], program: Path) -> bool:
        command = ["gcc", *FLAVOURS[flavour], "-fuse-ld=gold", *objects, "-lm", "-o", program]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(done.stderr[:2000], file=sys.stderr)
        return done.returncode == 0

    def build(self) -> None:
        """Everything, and which test calls which function."""
        self.write_tree()
        headers = [p for top in (self.tree, ROOT / "tests") for p in top.rglob("*.h")]
        self.newest_header = max(path.stat().st_mtime for path in headers)
        self.supports: dict[tuple[str, str], list[Path]] = {}
        for flavour in self.flavours:
            made = {c: self.objects(flavour, c) for c in ("all", "small")}
            for program in self.needs:
                objects = made["small" if program == "test_small" else "all"]
                parts = self.support(flavour, program)
                self.supports[flavour, program] = [*parts, objects["codec"], objects["kissfft"]]
                parts = [*parts, *(objects[name] for name in self.wanted(program))]
                linked = self.work / flavour / program
                parts += [objects["codec"], objects["kissfft"]]
                is_new = linked.exists() and all(
                    part.stat().st_mtime <= linked.stat().st_mtime for part in parts
                )
                if not is_new and not self.link(flavour, parts, linked):
                    sys.exit(f"{program} cannot be linked")
                self.servers[flavour, program] = Server(linked)
        self.plain = self.plain_objects()
        for program in self.needs:
            for index, name in enumerate(self.servers["plain", program].names()):
                test = Test(program, index, name, {}, set())
                for flavour in self.flavours:
                    answer = self.servers[flavour, program].ask(f"reach {index}").split()
                    if int(answer[0]) < 0:
                        sys.exit(f"{flavour} {test.title} fails alone without a mutation")
                    test.spent_s[flavour] = int(answer[0]) * 1e-6
                    test.reached = {int(word) for word in answer[1:]}
                self.tests.append(test)
                for number in test.reached:
                    self.reaching[number].append(test)

    # --- trying -----------------------------------------------------------------------------------

    def order(self, tests: list[Test], source: Source, place: str) -> list[Test]:
        """The order in which they probably take the least time until one fails."""

        def price(test: Test) -> float:
            key = f"{place} {test.title}"
            chance = (self.kills[key] + 0.3) / (self.tries[key] + 1)
            return (test.spent_s["plain"] + 0.002) / chance * (1 if self.own(test, source) else 3)

        return sorted(tests, key=price)

    @staticmethod
    def own(test: Test, source: Source) -> bool:
        return test.program in source.tests

    def passes(self, test: Test, number: int, flavour: str, server: Server) -> bool:
        limit_ms = LEAST_MS[flavour] + int(1000 * LIMIT * test.spent_s[flavour])
        return server.ask(f"{number} {limit_ms} {test.index}") == "1"

    def outcome(self, source: Source, number: int) -> str:
        """What becomes of a mutant: "no code", "killed by ...", or "survived"."""
        mutant = source.every[number - 1]
        function = source.function_of(number)
        if function is None:
            return self.outcome_alone(source, mutant)
        if number in source.bad["all"]:
            return "no code"
        tests = [
            test for test in self.order(self.reaching[function.number], source, function.name)
            if self.thorough or self.own(test, source) or test.spent_s["plain"] < QUICK_S
        ]  # fmt: skip
        for test in tests:
            key = f"{function.name} {test.title}"
            self.tries[key] += 1
            server = self.servers["plain", test.program]
            if not self.passes(test, (source.slot << 16) + number, "plain", server):
                self.kills[key] += 1
                return f"killed by {test.title}"
        for test in tests if self.thorough else []:
            server = self.servers["sanitized", test.program]
            if self.own(test, source) and not self.passes(
                test, (source.slot << 16) + number, "sanitized", server
            ):
                return f"killed by {test.title}, sanitized"
        return "no code" if self.is_same_code(source, mutant) else "survived"

    def outcome_alone(self, source: Source, mutant: Mutant) -> str:
        """The same for a mutant outside of functions: compiled alone, on the tests of its file."""
        if source.path.suffix == ".h":
            return "not tried"
        mutated = self.work / "mutant.c"
        mutated.write_text(source.text[: mutant.start] + mutant.text + source.text[mutant.stop :])
        numbers = range(source.slot << 9, (source.slot + 1) << 9)
        include = f"-I{source.path.parent}"
        for flavour in self.flavours:
            made = self.work / "mutant.o"
            if not self.compile(mutated, made, ROOT, include, *FLAVOURS[flavour]):
                return "no code"
            for program in source.tests:
                if program == "test_small":
                    continue
                others = [self.plain[f"{flavour} {n}"] for n in self.wanted(program)
                          if n != source.name]  # fmt: skip
                linked = self.work / "mutant"
                if not self.link(
                    flavour, [*self.supports[flavour, program], made, *others], linked
                ):
                    return "no code"
                server = Server(linked)
                for test in self.order(self.tests, source, source.name):
                    if test.program != program or test.reached.isdisjoint(numbers):
                        continue
                    key = f"{source.name} {test.title}"
                    self.tries[key] += 1
                    if not self.passes(test, 0, flavour, server):
                        self.kills[key] += 1
                        server.close()
                        return f"killed by {test.title}"
                server.close()
        return "no code" if self.is_same_code(source, mutant) else "survived"

    def is_same_code(self, source: Source, mutant: Mutant) -> bool:
        """Whether the optimiser makes the same of the mutant, in each configuration."""
        mutated = source.text[: mutant.start] + mutant.text + source.text[mutant.stop :]
        return source.path.suffix == ".c" and all(
            self.optimised(source, configuration, mutated)
            == self.optimised(source, configuration, source.text)
            for configuration in self.configurations(source)
        )

    def optimised(self, source: Source, configuration: str, text: str) -> bytes:
        """The object that the optimiser makes of a source's text."""
        key = f"{source.name} {configuration}"
        if text == source.text and key in self.originals:
            return self.originals[key]
        path, to = self.work / "same.c", self.work / "same.o"
        path.write_text(text)
        more = [f"-I{source.path.parent}", "-O2", *self.configured(configuration)]
        if not self.compile(path, to, ROOT, *more):
            return b"does not compile"
        if text == source.text:
            self.originals[key] = to.read_bytes()
        return to.read_bytes()

    def close(self) -> None:
        for server in self.servers.values():
            server.close()
