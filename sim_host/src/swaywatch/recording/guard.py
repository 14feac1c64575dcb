"""What every reader and writer shares: refusals with the file's name, and whole files only."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from swaywatch.errors import RecordingError, SwaywatchError


def must_exist(path: Path, what: str = "recording") -> None:
    """Raise unless `path` is a readable file with something in it."""
    try:
        if path.is_dir():
            raise RecordingError(f"{path}: is a folder; give the {what} file itself")
        size = path.stat().st_size
        with path.open("rb"):
            pass
    except FileNotFoundError:
        raise RecordingError(f"{path}: no such file (expected a {what})") from None
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from None
    if size == 0:
        raise RecordingError(f"{path}: the file is empty (0 bytes); expected a {what}")


@contextmanager
def refusing(path: Path, what: str) -> Iterator[None]:
    """Turn whatever a library raises on a damaged file into one RecordingError."""
    try:
        yield
    except SwaywatchError:
        raise
    except MemoryError:
        raise RecordingError(
            f"{path}: damaged {what}: a length in it asks for more memory than there is"
        ) from None
    except Exception as error:  # libraries raise anything from KeyError to struct.error here
        detail = f"{type(error).__name__}: {error}".strip().splitlines()[0][:200]
        raise RecordingError(f"{path}: not a whole {what} file ({detail})") from error


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that becomes `path` only when the block succeeds."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix
        )
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written: {error.strerror or error}") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
