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

sys.path.insert(0, str(Path(__file__).parent))

import rig

REPORT = rig.Report()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Without CAN in the kernel there is nothing to test; `tests/hil/run` brings one."""
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        skip = pytest.mark.skip(reason="this kernel has no CAN; run `make hil`")
        for item in items:
            item.add_marker(skip)


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
            f"right again: {row['right again']}"
        )
    is_bench = "HIL_SECONDS" in os.environ
    lines = [
        f"**`make {'hil-bench' if is_bench else 'hil'}`, Linux {platform.release()}"
        f"{', User Mode Linux on one core' if 'HIL_GUEST' in os.environ else ''}**",
        "",
        "| scenario | what the ECU said | what it counted | right again |",
        "|---|---|---|---|",
        *(f"| {' | '.join(row.values())} |" for row in REPORT.rows),
    ]
    target = rig.ROOT / "build" / "bench"
    target.mkdir(parents=True, exist_ok=True)
    (target / ("latency.md" if is_bench else "hil.md")).write_text("\n".join(lines) + "\n")
