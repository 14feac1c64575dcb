"""What stands above the numbers of a CSV: comments, names, perhaps a row of units."""

from __future__ import annotations

import csv
import itertools
import re
from dataclasses import dataclass, field
from pathlib import Path

from swaywatch.errors import RecordingError

HEAD_BYTES = 1 << 20
"""Within which the first row of numbers must begin."""
MOST_COLUMNS = 10_000
_LONGEST_UNIT = 16
_NUMBER = re.compile(r"^[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?$")
_LINE_END = re.compile(r"\r\n|\n|\r")
_DATE = re.compile(r"^\d{4}-\d\d-\d\d[T ]\d\d:\d\d")
_BRACKETS = {"]": "[", ")": "("}


@dataclass(frozen=True)
class CsvHead:
    """How a CSV is to be read.

    Attributes
    ----------
    names
        Of the columns.
    lines
        Before the first row of numbers.
    units
        Column to unit, from a row of units.
    comments
        Lines beginning with ``#`` among `lines`.
    dates
        Column whose first cell is a date.
    """

    names: tuple[str, ...]
    lines: int
    delimiter: str
    decimal_point: str
    encoding: str
    units: dict[str, str] = field(default_factory=dict)
    comments: int = 0
    dates: str | None = None


def split_name(column: str) -> tuple[str, str]:
    """Signal and unit of ``Signal [unit]`` or ``Signal (unit)``."""
    text = column.strip()
    opening = _BRACKETS.get(text[-1:])
    if opening is None:
        return text, ""
    name, mark, unit = text[:-1].rpartition(opening)
    return (name.strip(), unit.strip()) if mark else (text, "")


def read_head(path: Path) -> CsvHead:
    """Find the names, the units and the first row of numbers.

    Raises
    ------
    RecordingError
        Binary, without names, or text where the numbers should begin.
    """
    with path.open("rb") as file:
        raw = file.read(HEAD_BYTES)
    if b"\0" in raw[:65536]:
        raise RecordingError(f"{path}: not a CSV file: it holds binary data")
    text, encoding = _decoded(raw)
    lines = _LINE_END.split(text)
    if len(raw) == HEAD_BYTES and len(lines) > 1:
        lines.pop()  # perhaps not whole
    at = _first_line(lines)
    if at >= len(lines):
        raise RecordingError(f"{path}: empty CSV: nothing but comments and blank lines in it")
    delimiter = max((",", ";", "\t"), key=lines[at].count)
    names, at, in_comment = _names(lines, at, delimiter)
    if len(names) > MOST_COLUMNS:
        raise RecordingError(
            f"{path}: not a CSV file of signals: its first line has {len(names)} columns"
        )
    rows = (i for i in range(at, len(lines)) if lines[i].strip() and lines[i][:1] != "#")
    following = list(itertools.islice(rows, 2))
    units: dict[str, str] = {}
    if following and _is_text(cells := _cells(lines[following[0]], delimiter)):
        if len(cells) != len(names) or max(map(len, cells)) > _LONGEST_UNIT:
            raise RecordingError(
                f"{path}: line {following[0] + 1} should hold numbers, or units, and is "
                f"{lines[following[0]][:60]!r}"
            )
        units = {n: _bare(cell) for n, cell in zip(names, cells, strict=True)}
        at = following[0] + 1
        following = following[1:]
    first = _cells(lines[following[0]], delimiter) if following else []
    dates = next((n for n, cell in zip(names, first, strict=False) if _DATE.match(cell)), None)
    decimal = "," if delimiter != "," and "," in "".join(lines[at : at + 40]) else "."
    skipped = sum(1 for line in lines[:at] if line.lstrip().startswith("#")) - in_comment
    return CsvHead(tuple(names), at, delimiter, decimal, encoding, units, max(skipped, 0), dates)


def _decoded(raw: bytes) -> tuple[str, str]:
    """The text and the character set: UTF-8, else that of Windows in Western Europe."""
    if raw.startswith(b"\xef\xbb\xbf"):
        raw = raw[3:]
    try:
        return raw.decode("utf-8"), "utf8"
    except UnicodeDecodeError as error:
        if error.start > len(raw) - 4 and len(raw) >= HEAD_BYTES - 3:  # cut within a character
            return raw.decode("utf-8", "replace"), "utf8"
        return raw.decode("cp1252", "replace"), "cp1252"


def _first_line(lines: list[str]) -> int:
    """Index of the first line that is no comment."""
    for number, line in enumerate(lines):
        text = line.strip()
        if text and not text.startswith("#") and not text.lower().startswith("sep="):
            return number
    return len(lines)


def _names(lines: list[str], at: int, delimiter: str) -> tuple[list[str], int, int]:
    """Names, the line after them, and 1 where they stand in a comment above the numbers."""
    names = _cells(lines[at], delimiter)
    if at and not _is_text(names) and lines[at - 1].lstrip().startswith("#"):
        above = _cells(lines[at - 1].lstrip().lstrip("#"), delimiter)
        if len(above) == len(names) and _is_text(above):
            return above, at, 1
    return names, at + 1, 0


def _cells(line: str, delimiter: str) -> list[str]:
    try:
        row = next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error:
        row = line.split(delimiter)
    return [cell.strip() for cell in row]


def _is_text(cells: list[str]) -> bool:
    """Whether no cell is a number or a date, and some say something."""
    said = [cell for cell in cells if cell]
    return bool(said) and not any(
        _NUMBER.match(cell) or _DATE.match(cell) or cell.lower() == "nan" for cell in said
    )


def _bare(cell: str) -> str:
    return "" if cell in ("-", "[-]", "(-)") else cell.strip("[]() ")
