"""What the host tests share: where recordings are found, and a clock."""

from __future__ import annotations

import fcntl
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

DATA = Path(__file__).resolve().parent.parent / "data"
ROOT = DATA.parents[1]
#: Examples of the README that say of themselves that they are tested: language and text.
EXAMPLES = re.findall(
    r"<!-- tested -->\n```(\w+)\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S
)


def built_fmu(name: str) -> Path:
    """One of our FMUs, built; one process at a time, since they share objects."""
    path = ROOT / "build" / "fmu" / f"{name}.fmu"
    path.parent.mkdir(parents=True, exist_ok=True)
    with (path.parent / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        subprocess.run(["make", "-s", "-C", str(ROOT), str(path.relative_to(ROOT))], check=True)
    return path


class Clock:
    """Time that passes only while somebody sleeps or sends."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += max(seconds, 1e-5)


def run_example(body: str) -> str:
    """An example of the README, as it stands there; what it prints."""
    (ROOT / "build/readme").mkdir(parents=True, exist_ok=True)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-eu", "-c", body],
        cwd=ROOT, env={**os.environ, "PATH": path}, capture_output=True, text=True, timeout=900,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Folder that `make` fills, once for all tests and processes of a session."""
    own = factory.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    folder, done = shared / name, shared / f"{name}.done"
    with (shared / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            folder.mkdir(exist_ok=True)
            make(folder)
            done.touch()
    return folder


@pytest.fixture(scope="session")
def diagnosed_p03(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder that the README's ``swaywatch diagnose`` wrote of practice case p03."""
    (example,) = (body for _, body in EXAMPLES if "swaywatch diagnose" in body)
    once(tmp_path_factory, "diagnosed_p03", lambda folder: run_example(example))
    return ROOT / "build" / "readme" / "diagnose"


DIAGNOSE = """
import json, resource, sys
from pathlib import Path
from swaywatch.diagnose.engine import diagnose
case, out = map(Path, sys.argv[1:])
result = diagnose(sorted(case.glob("run*.*")), case / "vehicle.toml", case / "signals.toml",
                  simulations=sorted(case.glob("simulation_run*.*")), report=out / "report.html")
(out / "diagnosis.json").write_text(json.dumps(result))
(out / "peak_kib").write_text(str(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss))
"""


def diagnose_alone(case: Path, out: Path) -> None:
    """A diagnosis in a process of its own: diagnosis.json, report.html, peak_kib of memory."""
    subprocess.run([sys.executable, "-c", DIAGNOSE, str(case), str(out)], check=True)


@pytest.fixture(scope="session")
def diagnosed_p08(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `diagnose_alone` wrote of practice case p08."""
    case = recordings("practice", "p08")
    return once(tmp_path_factory, "diagnosed_p08", lambda folder: diagnose_alone(case, folder))


#: Files of tests that take longest, the longest first: begun late, one of them is what everybody
#: waits for (`make test` hands them out in this order).
LONGEST = (
    "test_discover_found.py", "test_diagnose.py", "test_sensor_faults.py", "test_survey.py",
    "test_pages.py", "test_plan.py", "test_road_vehicle.py", "test_reproduce.py",
    "test_project_readme.py", "test_memory.py", "test_blind.py", "test_attacks.py",
    "test_analyze.py", "test_bad_input.py",
)  # fmt: skip


def pytest_configure(config: pytest.Config) -> None:
    """What is too long for `make test`."""
    config.addinivalue_line("markers", "long: takes a minute or more; run by `make long`")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest files first."""
    order = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: order.get(item.path.name, len(LONGEST)))


def recordings(*parts: str) -> Path:
    """Path inside the folder of shared recordings; skips the test where there is none.

    The folder is ``$SWAYWATCH_RECORDINGS``, or ``shared/recordings`` beside any parent of the
    checkout.
    """
    candidates = [parent / "shared" / "recordings" for parent in Path(__file__).resolve().parents]
    if "SWAYWATCH_RECORDINGS" in os.environ:
        candidates.insert(0, Path(os.environ["SWAYWATCH_RECORDINGS"]))
    for folder in candidates:
        if folder.joinpath(*parts).exists():
            return folder.joinpath(*parts)
    pytest.skip(f"no shared recordings with {'/'.join(parts)}; set SWAYWATCH_RECORDINGS")
