"""What every reader and writer shares: refusals with the file's name, and whole files only."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from swaywatch.errors import RecordingError, SwaywatchError

SMALL_BYTES = 64 << 20
"""A file may always become so much when unpacked,"""
MOST_RATIO = 64
"""and a larger one so many times its size: measurements pack to a third or a tenth."""


def must_exist(path: Path, what: str = "recording") -> None:
    """Raise unless `path` is a readable, regular file with something in it."""
    must_be_regular(path, what, RecordingError)
    if path.stat().st_size == 0:
        raise RecordingError(f"{path}: the file is empty (0 bytes); expected a {what}")


def must_be_regular(path: Path, what: str, kind: type[SwaywatchError]) -> None:
    """Raise `kind` unless `path` can be opened and ends: a pipe or a device may never do."""
    try:
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise kind(f"{path}: is a folder; give the {what} file itself")
        if not stat.S_ISREG(mode):
            raise kind(f"{path}: is a pipe or a device, not a file; save the {what} to a file")
        with path.open("rb"):
            pass
    except FileNotFoundError:
        raise kind(f"{path}: no such file (expected a {what})") from None
    except OSError as error:
        raise kind(f"{path}: cannot be read: {error.strerror or error}") from None
    except ValueError:  # a NUL in the name
        raise kind(f"{str(path)!r}: cannot be the name of a {what}") from None


def most_unpacked(path: Path) -> int:
    """Bytes that what is packed in a file may need at most; more is damage, or an attack."""
    return max(SMALL_BYTES, MOST_RATIO * path.stat().st_size)


def must_fit(path: Path, needed: int, what: str) -> None:
    """Refuse a file that would need far more memory than its size can account for."""
    most = most_unpacked(path)
    if needed > most:
        raise RecordingError(
            f"{path}: damaged {what}: its {path.stat().st_size} bytes would unpack to "
            f"{needed / 1e6:.0f} MB or more; at most {most / 1e6:.0f} MB are believed"
        )


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
