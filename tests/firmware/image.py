"""What an image holds: symbols, and a bound of the stack from its calls."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

FORBIDDEN = re.compile(
    r"^(__aeabi_([fdh]|[ui]+2[fd]|[ul]+2[fd]|c[fd]|h2)\w*|"
    r"__(add|sub|mul|div|neg|cmp|unord|eq|ne|lt|le|gt|ge|fix|float|extend|trunc|pow|gnu_[fhd])"
    r"\w*([sdthx]f|f2h|h2f|d2h)\w*|"
    r"_?(malloc|calloc|realloc|free|sbrk|memalign|aligned_alloc)(_r)?|_?_?(sbrk|malloc)\w*|"
    r"(sin|cos|tan|a?tan2?|asin|acos|sqrt|cbrt|exp2?|log(2|10)?|pow|fmod|floor|ceil|fabs|round)"
    r"[fl]?)$"
)
"""Symbols of software floating point, of its mathematics, and of the heap."""
RECURSION = {"kf_work": 3}
"""kissfft over 64 points: three stages."""
CALL = re.compile(
    r"\t(?:bl|blx|b\.?[nw]?|b(?:eq|ne|cs|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)(?:\.[nw])?)\t"
    r"[0-9a-f]+ <([^>+]+)(\+0x[0-9a-f]+)?>"
)
INDIRECT = re.compile(r"\tblx\tr\d+$|\tbx\tr\d+$")
RETURN = re.compile(r"\tpop\t\{")


@dataclass
class Function:
    """One function of the image."""

    stack: int = 0
    file: str = ""
    calls: set[str] = field(default_factory=set)
    indirect: bool = False


def tool(name: str, *arguments: str) -> str:
    """Return the output of one of the cross tools."""
    done = subprocess.run(
        [f"arm-none-eabi-{name}", *arguments], capture_output=True, text=True, check=True
    )
    return done.stdout


def forbidden_symbols(image: Path) -> list[str]:
    """Return the symbols of floating point or of a heap that are linked."""
    names = {line.split()[-1] for line in tool("nm", str(image)).splitlines()}
    return sorted(name for name in names if FORBIDDEN.match(name))


def read_stack_usage(folder: Path) -> dict[str, tuple[int, str]]:
    """Return frame size and source file of each function that the compiler has listed."""
    found: dict[str, tuple[int, str]] = {}
    for path in folder.rglob("*.su"):
        for line in path.read_text().splitlines():
            where, size, _ = line.split("\t")
            file, _, _, name = where.split(":")
            known = found.get(name, (0, file))
            found[name] = (max(known[0], int(size)), file)
    return found


def frame_of_assembly(line: str) -> int:
    """Return what one instruction pushes (for functions that the compiler tells nothing of)."""
    push = re.search(r"\t(?:push|stmdb)\t(?:sp!, )?\{([^}]*)\}", line)
    if push:
        return 4 * sum(
            int(b[1:]) - int(a[1:]) + 1
            if (a := part.split("-")[0].strip())
            and "-" in part
            and (b := part.split("-")[1].strip())
            else 1
            for part in push.group(1).split(",")
        )
    sub = re.search(r"\tsub(?:\.w)?\tsp, (?:sp, )?#(\d+)", line)
    return int(sub.group(1)) if sub else 0


def read_functions(image: Path, objects: Path) -> dict[str, Function]:
    """Return the functions of an image with their frames and calls."""
    usage = read_stack_usage(objects)
    functions: dict[str, Function] = {}
    current = Function()
    before: list[str] = []
    for listed in tool("objdump", "-d", str(image)).splitlines():
        head = re.match(r"^[0-9a-f]+ <(.+)>:$", listed)
        if head:
            name = head.group(1)
            current = functions.setdefault(name, Function())
            if name in usage:
                current.stack, current.file = usage[name]
            continue
        line = re.sub(r"\s*[@;].*$", "", listed).rstrip()
        if not current.file:
            current.stack += frame_of_assembly(line)
        call = CALL.search(line)
        if call and not call.group(2):
            current.calls.add(call.group(1))
        # ARMv6-M returns by `pop {r3}` and soon after `bx r3`: that is no call.
        if current.file and INDIRECT.search(line) and not RETURN.search("".join(before)):
            current.indirect = True
        before = [*before[-3:], line]
    return functions


def add_indirect_calls(functions: dict[str, Function]) -> None:
    """Let a function that calls through a table reach every function nobody calls by name.

    Tables of steps and of codecs are in the file of their caller; a port's functions, which
    sway_ecu.c calls, are in the port's files.
    """
    called = set().union(*(f.calls for f in functions.values()))
    free = {n: f for n, f in functions.items() if f.file and n not in called and n != "main"}
    for name, function in functions.items():
        if not function.indirect:
            continue
        ports = function.file.startswith("port/")
        function.calls |= {
            other
            for other, candidate in free.items()
            if other != name
            and (candidate.file == function.file or (ports and candidate.file.startswith("port/")))
            and not candidate.file.endswith("startup.c")
        }


def stack_bound(image: Path, objects: Path, root: str) -> tuple[int, list[str]]:
    """Return the deepest stack below `root` in bytes, and the calls that lead there."""
    functions = read_functions(image, objects)
    add_indirect_calls(functions)
    known: dict[str, tuple[int, list[str]]] = {}

    def deepest(name: str, path: tuple[str, ...]) -> tuple[int, list[str]]:
        if name in path or name not in functions:
            return 0, []
        if name not in known:
            below = max(
                (deepest(callee, (*path, name)) for callee in functions[name].calls),
                default=(0, []),
            )
            depth = functions[name].stack * RECURSION.get(name, 1) + below[0]
            known[name] = (depth, [name, *below[1]])
        return known[name]

    return deepest(root, ())
