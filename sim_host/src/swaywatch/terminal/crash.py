"""What the user has of an error that nobody foresaw: one line, and a file that tells the rest."""

from __future__ import annotations

import datetime
import importlib.metadata
import platform
import tempfile
import traceback
from collections.abc import Sequence
from pathlib import Path

from swaywatch import __version__

PACKAGES = (
    "numpy", "scipy", "python-can", "cantools", "asammdf", "pyarrow", "plotly", "jinja2", "rich",
    "cffi", "numba", "mujoco",
)  # fmt: skip

EXTRAS = {
    "numba": "mujoco", "mujoco": "mujoco", "objective_rating_metrics": "diagnosis",
    "distributed": "cluster",
}  # fmt: skip
"""Module that may be missing to the extra of the package that brings it."""


def write_report(words: Sequence[str], error: BaseException) -> Path | None:
    """A file on what happened, in the current folder or, where that fails, a temporary one.

    It holds the command, versions and the traceback, no data of a recording.

    Returns
    -------
    Path or None
        None where no file could be written.
    """
    now = datetime.datetime.now(tz=datetime.UTC)
    lines = [
        f"swaywatch {__version__}, {now:%Y-%m-%d %H:%M:%S} UTC",
        f"command: swaywatch {' '.join(words)}",
        f"Python {platform.python_version()}, {platform.platform()}",
        "packages: " + ", ".join(f"{name} {_version(name)}" for name in PACKAGES),
        "",
        "".join(traceback.format_exception(error)),
    ]
    for folder in (Path.cwd(), Path(tempfile.gettempdir())):
        path = folder / f"swaywatch-crash-{now:%Y%m%d-%H%M%S}.txt"
        try:
            path.write_text("\n".join(lines), encoding="utf-8")
        except OSError:
            continue
        return path
    return None


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "(not installed)"


def missing_module(error: BaseException) -> str:
    """The line for a package that is not installed: which, and the command that brings it."""
    name = (getattr(error, "name", None) or "").partition(".")[0]
    extra = EXTRAS.get(name)
    if extra is None:
        return f"the Python package {name} is not installed: pip install {name}"
    return (
        f"needs the Python package {name}, which is not installed: pip install "
        f"'swaywatch[{extra}]' (in a checkout: make setup)"
    )
