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
