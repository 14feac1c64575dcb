"""All mutants of a source in one source: a copy of its function for each, chosen by a number.

A function with mutants is written as ``f__0``, as it was, ``f__1`` ..., one with each mutation, and
``f`` itself, which calls the one that ``mutation_now`` says and marks in ``mutation_reached`` that
it was called. What stands outside of functions (tables, constants, macros) is left for
`bench.py` to compile once for each mutant.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from mutants import Mutant

FUNCTION = re.compile(
    r"^(?P<head>(?!typedef\b|struct\b[^()]*\{|enum\b|#|//)[A-Za-z_][\w \t*\n]*?[\s*]"
    r"(?P<name>\w+)\((?P<params>[^;{}]*?)\))\n\{\n(?P<body>.*?)^\}\n",
    re.M | re.S,
)
DECLARED = "extern unsigned mutation_now;\nextern unsigned char *mutation_reached;\n"


@dataclass
class Copy:
    """One function's copy with one mutation, and the lines of the written source that it takes."""

    number: int
    text: str
    first: int = 0
    last: int = 0


@dataclass
class Function:
    """A function with mutants."""

    name: str
    number: int
    start: int
    stop: int
    head: str
    params: str
    original: str
    copies: list[Copy] = field(default_factory=list)


def arguments(params: str) -> list[str] | None:
    """The names of a function's parameters; None where they are not understood."""
    params = re.sub(r"/\*.*?\*/|//[^\n]*", "", params).strip()
    if params in {"void", ""}:
        return []
    names: list[str] = []
    depth = 0
    part = ""
    for letter in params + ",":
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and depth == 0:
            found = re.search(r"\(\*(\w+)\)\(", part) or re.search(
                r"(\w+)\s*(\[[^]]*\]\s*)*$", part
            )
            if found is None:
                return None
            names.append(found.group(1))
            part = ""
        else:
            part += letter
    return names


def functions(source: str, every: list[Mutant], first: int) -> tuple[list[Function], list[Mutant]]:
    """The functions with mutants, numbered from `first`, and the mutants outside of functions.

    A mutant's number is its place in `every`, from 1.
    """
    found: list[Function] = []
    inside: set[int] = set()
    for match in FUNCTION.finditer(source):
        if arguments(match["params"]) is None:
            continue
        body = match.start("body")
        made = Function(
            match["name"], first + len(found), match.start(), match.end(), match["head"],
            match["params"], source[match.start() : match.end()],
        )  # fmt: skip
        for number, mutant in enumerate(every, 1):
            if body <= mutant.start and mutant.stop <= match.end("body"):
                text = source[body : mutant.start] + mutant.text + source[mutant.stop : match.end()]
                made.copies.append(Copy(number, text))
                inside.add(number)
        if made.copies:
            found.append(made)
    return found, [mutant for number, mutant in enumerate(every, 1) if number not in inside]


def renamed(function: Function, name: str) -> str:
    """The function's head with another name, and for this file alone."""
    head = re.sub(
        r"^(static |inline |extern |SWAY_INLINE |SWAY_NOINLINE )*", "static ", function.head
    )
    return re.sub(rf"\b{function.name}(?=\()", name, head, count=1)


def written(source: str, found: list[Function], bad: set[int], slot: int) -> str:
    """The source with all mutants but the `bad` ones; notes the lines of each copy.

    `slot` is the file's: it distinguishes a mutant's number from those of other files.
    """
    parts: list[str] = [DECLARED]
    lines = 2
    at = 0

    def add(text: str) -> None:
        nonlocal lines
        parts.append(text)
        lines += text.count("\n")

    for function in found:
        add(source[at : function.start])
        at = function.stop
        add(f"{function.head};\n")
        body = function.original[len(function.head) :]
        add(renamed(function, f"{function.name}__0") + body)
        table: dict[int, str] = {}
        for copy in function.copies:
            copy.first = lines + 1
            if copy.number not in bad:
                name = f"{function.name}__{copy.number}"
                add(renamed(function, name) + "\n{\n" + copy.text)
                table[copy.number] = name
            copy.last = lines
        first, last = function.copies[0].number, function.copies[-1].number
        names = ", ".join(table.get(n, f"{function.name}__0") for n in range(first, last + 1))
        given = ", ".join(arguments(function.params) or [])
        pointer = renamed(function, f"(*const {function.name}__all[])").replace("static ", "", 1)
        add(
            f"{function.head}\n{{\n    static {pointer} = {{{names}}};\n"
            f"    mutation_reached[{function.number}] = 1;\n"
            f"    const unsigned chosen = mutation_now - {(slot << 16) + first}U;\n"
            f"    return chosen < {last - first + 1}U ? {function.name}__all[chosen]({given})\n"
            f"        : {function.name}__0({given});\n}}\n"
        )
    add(source[at:])
    return "".join(parts)
