"""Reading of the user's TOML files, with refusals that name the file and the line."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from swaywatch.errors import SwaywatchError
from swaywatch.recording.guard import must_be_regular

MOST_BYTES = 1 << 20


def load_toml(path: Path, kind: type[SwaywatchError], what: str) -> dict[str, Any]:
    """Parse `path`; `what` is its name in the message, `kind` the error raised."""
    must_be_regular(path, what, kind)
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise kind(f"{path}: {size} bytes are too many for a {what}; expected some kilobytes")
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8"))
    except UnicodeDecodeError as error:
        raise kind(f"{path}: not a {what}: byte {error.start} is not UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise kind(f"{path}: not valid TOML: {error}") from None
    except RecursionError:
        raise kind(f"{path}: not a {what}: its brackets are nested too deep") from None
    except ValueError as error:  # a number of thousands of digits
        raise kind(f"{path}: not valid TOML: {error}") from None
    except OSError as error:
        raise kind(f"{path}: cannot be read: {error.strerror or error}") from None


_MARKS = {
    "vehicle.toml": ("car", "trailer"),
    "signals.toml": ("signals", "dbc"),
    "scenario": ("manoeuvre", "vehicle"),
}
"""Top-level keys by which a file of another kind is recognised."""


def refuse_other_kind(
    path: Path, content: dict[str, Any], kind: type[SwaywatchError], what: str
) -> None:
    """Refuse a file that is of another kind than `what` ("vehicle.toml" or "signals.toml").

    Raises
    ------
    SwaywatchError
        Of the class `kind`; names the file, what it is and the option that takes it.
    """
    if any(key in content for key in _MARKS[what]):
        return
    option = "--" + what.removesuffix(".toml")
    for other, keys in _MARKS.items():
        there = [key for key in keys if key in content]
        if other != what and there:
            swapped = "; are --vehicle and --signals swapped?" if other.endswith(".toml") else ""
            raise kind(
                f"{path}: this is a {other} (it has {there[0]!r}); {option} takes a {what}{swapped}"
            )
