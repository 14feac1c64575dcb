"""The mutants of a C source: one operator or number changed, or one statement left out."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

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
