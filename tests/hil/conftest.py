"""Fixtures of the hardware-in-the-loop tests, and the table that they end with."""

from __future__ import annotations

import os
import platform
import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol

sys.path.insert(0, str(Path(__file__).parent))

import rig

REPORT = rig.Report()
LATE_S = 0.03
"""A machine that was so late did not give the test the real time that it needs."""
RUNS = 4


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Without CAN in the kernel there is nothing to test; `tests/hil/run` brings one."""
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        skip = pytest.mark.skip(reason="this kernel has no CAN; run `make hil`")
        for item in items:
            item.add_marker(skip)


def first_line(failure: pytest.TestReport) -> str:
    """What went wrong, in a line."""
    crash = getattr(failure.longrepr, "reprcrash", None)
    return str(crash.message if crash else failure.longrepr).splitlines()[0][:150]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool:
    """Run a test again that failed while the machine was late, and say so.

    What the loop does is tested in virtual time, tests/host/test_hil.py; here it is the daemon on a
    bus in real time, of which a run that was not in real time says nothing: after the last one it
    is skipped, with the lateness as the reason. A test that fails on time fails.
    """
    hooks = item.ihook
    hooks.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    rows = len(REPORT.rows)
    for run in range(1, RUNS + 1):
        rig.LATENESS.restart()
        del REPORT.rows[rows:]
        reports = runtestprotocol(item, nextitem=nextitem, log=False)
        late_s = rig.LATENESS.worst_s
        if late_s < LATE_S or not any(r.failed for r in reports):
            break
        what = "; ".join(first_line(r) for r in reports if r.failed)
        print(f"\nhil: {item.name}: run {run} of {RUNS}: late by {1e3 * late_s:.0f} ms, {what}")
    else:
        for r in reports:
            if r.failed:
                reason = f"the machine was late in each of {RUNS} runs, {first_line(r)}"
                r.outcome = "skipped"
                r.longrepr = (str(item.path), item.location[1] or 0, reason)
    for r in reports:
        hooks.pytest_runtest_logreport(report=r)
    hooks.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


@pytest.fixture(autouse=True)
def nobody_left() -> Iterator[None]:
    """Whatever a test did, the next one has the bus to itself."""
    yield
    rig.end_all()


@pytest.fixture
def report() -> rig.Report:
    """Where a scenario writes what it showed."""
    return REPORT


@pytest.fixture
def bus() -> Iterator[rig.Bus]:
    """The bus."""
    made = rig.Bus()
    yield made
    made.close()


@pytest.fixture
def daemon(bus: rig.Bus) -> Iterator[rig.Daemon]:
    """A daemon that runs and must end cleanly."""
    made = rig.Daemon()
    yield made
    if made.process.poll() is None:
        made.stop()


@pytest.fixture
def feeder(bus: rig.Bus, daemon: rig.Daemon) -> Iterator[rig.Feeder]:
    """A combination at 90 km/h and 100 Hz whose ECU has seen enough to be right."""
    made = rig.Feeder(bus)
    made.start()
    assert bus.wait_for(rig.inputs_good)
    time.sleep(0.3)  # the ECU learns the periods of its messages
    yield made
    if made.is_alive():
        made.stop()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """The table of scenarios, for the eye and as markdown."""
    if not REPORT.rows:
        return
    terminalreporter.write_line("")
    for row in REPORT.rows:
        terminalreporter.write_line(
            f"{row['scenario']}: {row['said']}; counted: {row['counted']}; "
            f"recovered: {row['right again']}"
        )
    is_bench = "HIL_SECONDS" in os.environ
    lines = [
        f"**`make {'hil-bench' if is_bench else 'hil'}`, Linux {platform.release()}"
        f"{', User Mode Linux on one core' if 'HIL_GUEST' in os.environ else ''}**",
        "",
        "| scenario | ECU status | counters | recovered |",
        "|---|---|---|---|",
        *(f"| {' | '.join(row.values())} |" for row in REPORT.rows),
    ]
    target = rig.ROOT / "build" / "bench"
    target.mkdir(parents=True, exist_ok=True)
    (target / ("latency.md" if is_bench else "hil.md")).write_text("\n".join(lines) + "\n")
