"""Ctrl-C ends a command within a second, whatever it is doing.

Python hears of a signal between two of its own steps; a long call into C (a solver, a decoder,
a thread that the end of the program waits for) makes it deaf. The signal's wake-up pipe is
written at once, so a thread that waits there gives the command a moment to end by itself, and
then ends the process.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import threading
from collections.abc import Iterator

GRACE_S = 0.7
"""Time to write a last line and to remove what is half done."""

INTERRUPTED = 130
"""Exit code of a command that was interrupted, as shells have it."""


@contextlib.contextmanager
def ends_at_once() -> Iterator[None]:
    """Interrupted commands end soon, and this process with them; main thread only."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    hears, tells = socket.socketpair()
    tells.setblocking(False)
    done = threading.Event()
    before = signal.set_wakeup_fd(tells.fileno(), warn_on_full_buffer=False)

    def watch() -> None:
        with hears:
            while heard := hears.recv(64):
                if signal.SIGINT in heard and not done.wait(GRACE_S):
                    os.write(2, b"interrupted\n")
                    os._exit(INTERRUPTED)

    threading.Thread(target=watch, name="interrupt", daemon=True).start()
    try:
        yield
    except KeyboardInterrupt:
        signal.set_wakeup_fd(before)
        raise  # the watch goes on: threads of the command may still be in C
    except BaseException:
        done.set()
        raise
    else:
        done.set()
    finally:
        if done.is_set():
            signal.set_wakeup_fd(before)
            tells.close()
