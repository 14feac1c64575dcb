"""Who does a survey's work: threads here, each with a process, or a dask cluster by its address.

Both are executors of :mod:`concurrent.futures`, so a survey knows no difference. dask comes with
``swaywatch[cluster]`` only: on one machine it would do no more than the threads, for 19 packages
and some seconds at each start.
"""

from __future__ import annotations

import contextlib
import logging
import tempfile
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from swaywatch import __version__
from swaywatch.errors import SwaywatchError

ANSWER_S = 15.0
"""Time for a scheduler and a first worker to answer."""


@contextlib.contextmanager
def workers(jobs: int, scheduler: str | None, folder: Path, out: Path) -> Iterator[Executor]:
    """An executor; on an error what has not begun is left undone.

    Parameters
    ----------
    jobs : runs at a time, on this machine
    scheduler : address of a dask scheduler, instead
    folder, out : of the recordings and of the results; every worker has to have both

    Raises
    ------
    SwaywatchError
        No scheduler, no worker, or a worker of another version or without the files.
    """
    with contextlib.ExitStack() as stack:
        executor: Executor
        if scheduler is None:
            executor = ThreadPoolExecutor(jobs)
        else:
            client = _client(scheduler, folder, out)
            stack.callback(client.close)
            executor = client.get_executor(pure=False)
        try:
            yield executor
        except BaseException:
            executor.shutdown(wait=False, **({} if scheduler else {"cancel_futures": True}))
            raise
        executor.shutdown()


def _client(scheduler: str, folder: Path, out: Path) -> Any:
    import distributed

    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    connect: Any = distributed.Client  # which has no types
    try:
        client = connect(scheduler, timeout=ANSWER_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise SwaywatchError(
            f"--scheduler {scheduler}: no dask scheduler answers ({str(error).splitlines()[0]}); "
            "expected an address such as tcp://host:8786, printed by `dask scheduler`"
        ) from None
    try:
        client.wait_for_workers(1, timeout=ANSWER_S)
        _check(client, scheduler, folder, out)
    except TimeoutError:
        client.close()
        raise SwaywatchError(
            f"--scheduler {scheduler}: has no worker; start some: dask worker {scheduler}"
        ) from None
    except BaseException:
        client.close()
        raise
    return client


def _check(client: Any, scheduler: str, folder: Path, out: Path) -> None:
    """Every worker has this version of swaywatch, the recordings and the place of the results."""
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=out, prefix=".survey-") as mark:
        answers = client.run(problem_here, folder, Path(mark.name), __version__, on_error="return")
    for worker, answer in answers.items():
        if answer:
            raise SwaywatchError(f"--scheduler {scheduler}: worker {worker}: {answer}")


def problem_here(folder: Path, mark: Path, version: str) -> str:
    """What a worker lacks for a survey, or nothing."""
    if version != __version__:
        return f"has swaywatch {__version__}; expected {version}, as here"
    if not folder.is_dir():
        return f"has no {folder}; recordings have to lie where all workers find them"
    if not mark.is_file():
        return f"does not see {mark.parent} of this machine; --out has to be a folder all share"
    return ""
