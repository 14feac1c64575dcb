"""Commands of swaywatch in processes of their own, from one that has everything loaded.

A survey of thousands of short recordings would spend most of its time on loading numpy, the core
and the readers again and again. So a process loads them once and forks for each command: what
crashes, hangs or takes all memory is that copy, and costs only itself. It ends with the process
that asked it, whatever ended that one.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import select
import signal
import subprocess
import sys
import time
import weakref
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import IO, Any

LOADED = (
    "swaywatch.commands.analyze",
    "swaywatch.commands.diagnose",
    "swaywatch.diagnose.engine",
    "swaywatch.diagnose.report.page",
    "asammdf",
    "can",
    "cantools",
    "jinja2",
)
MOST_SAID = 100_000
"""Bytes of a command's messages that are kept, the last ones."""


@dataclass(frozen=True)
class Ran:
    """How a command ended.

    Attributes
    ----------
    code : exit code; minus the signal that ended it
    said : what it wrote to stderr
    late : it took longer than its limit
    cpu_s : processor time, all its threads
    memory_mb : most memory at a time, with what it shares with the process it was forked from
    """

    code: int
    said: str = ""
    late: bool = False
    cpu_s: float = 0.0
    memory_mb: float = 0.0


class Warm:
    """A process that runs commands, one at a time; started with the first."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None

    def run(self, words: Sequence[str], limit_s: float) -> Ran:
        """Run ``swaywatch WORDS``.

        Raises
        ------
        OSError
            It could not be started, or was ended from outside.
        """
        if self._process is None or self._process.poll() is not None:
            self._process = _start()
            weakref.finalize(self, _end, self._process)
        asks, answers = self._process.stdin, self._process.stdout
        assert asks is not None
        assert answers is not None
        asks.write(json.dumps([list(words), limit_s]).encode() + b"\n")
        asks.flush()
        line = answers.readline()
        if not line:
            code = self._process.wait()
            raise ProcessLookupError(f"the process for it was ended from outside (code {code})")
        return Ran(**json.loads(line))


def _start() -> subprocess.Popen[bytes]:
    # -P: a plotly.py in the folder of recordings is no module of ours
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "swaywatch.survey.warm"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C is for the survey, which then ends this by its pipe
    )  # fmt: skip


def _end(process: subprocess.Popen[bytes]) -> None:
    for stream in (process.stdin, process.stdout):
        with contextlib.suppress(OSError):
            if stream is not None:
                stream.close()
    process.wait()


def _serve() -> None:
    """Answer commands until nobody asks any more."""
    asks, answers = os.dup(0), os.fdopen(os.dup(1), "w")
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)
    for name in LOADED:
        importlib.import_module(name)
    with os.fdopen(os.dup(asks), "rb", buffering=0) as stream:
        while line := _line(stream):
            words, limit_s = json.loads(line)
            answers.write(json.dumps(asdict(_fork(words, limit_s, asks))) + "\n")
            answers.flush()


def _line(stream: IO[bytes]) -> bytes:
    """The next line, and not a byte more: select() has to see what is left."""
    line = b""
    while not line.endswith(b"\n"):
        byte = stream.read(1)
        if not byte:
            return b""
        line += byte
    return line


def _fork(words: list[str], limit_s: float, asks: int) -> Ran:
    hears, tells = os.pipe()
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)
        os.close(hears)
        os.close(asks)
        os.dup2(tells, 2)
        os.close(tells)
        os._exit(_command(words))
    os.close(tells)
    with contextlib.suppress(OSError):
        os.setpgid(child, child)  # whichever of the two comes first
    said, late = _listen(hears, asks, child, time.monotonic() + limit_s)
    os.close(hears)
    _, status, used = os.wait4(child, 0)
    return Ran(
        os.waitstatus_to_exitcode(status), said.decode(errors="replace"), late,
        round(used.ru_utime + used.ru_stime, 3), round(used.ru_maxrss / 1024.0, 1),
    )  # fmt: skip


def _listen(hears: int, asks: int, child: int, end: float) -> tuple[bytes, bool]:
    """What the child says until it ends, its time is over, or nobody asks any more."""
    said = b""
    while (left := end - time.monotonic()) > 0.0:
        ready, _, _ = select.select([hears, asks], [], [], left)
        if asks in ready:  # nothing is asked meanwhile, so this is the end of the asking process
            os.killpg(child, signal.SIGKILL)
            os._exit(0)
        if hears in ready:
            part = os.read(hears, 65536)
            if not part:
                return said, False
            said = (said + part)[-MOST_SAID:]
    os.killpg(child, signal.SIGKILL)
    return said, True


def _command(words: list[str]) -> int:
    from swaywatch.cli import main

    code: Any = 1
    try:
        code = main(words)
    except SystemExit as error:
        code = error.code if isinstance(error.code, int) else 2
    except BaseException as error:
        print(f"swaywatch {words[0]}: {type(error).__name__}: {error}", file=sys.stderr)
    finally:
        with contextlib.suppress(OSError, ValueError):
            sys.stderr.flush()
    return int(code)


if __name__ == "__main__":
    _serve()
