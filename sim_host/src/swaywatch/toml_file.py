"""Reading of the user's TOML files, with refusals that name the file and the line."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from swaywatch.errors import SwaywatchError


def load_toml(path: Path, kind: type[SwaywatchError], what: str) -> dict[str, Any]:
    """Parse `path`; `what` is its name in the message, `kind` the error raised."""
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8"))
    except FileNotFoundError:
        raise kind(f"{path}: no such file (expected a {what})") from None
    except IsADirectoryError:
        raise kind(f"{path}: is a folder; give the {what} itself") from None
    except UnicodeDecodeError as error:
        raise kind(f"{path}: not a {what}: byte {error.start} is not UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise kind(f"{path}: not valid TOML: {error}") from None
    except OSError as error:
        raise kind(f"{path}: cannot be read: {error.strerror or error}") from None
