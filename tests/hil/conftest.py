"""Fixtures of the hardware-in-the-loop tests, and the table that they end with."""

from __future__ import annotations

import json
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
    """The table of scenarios."""
    if not REPORT.rows:
        return
    terminalreporter.write_line("")
    for row in REPORT.rows:
        terminalreporter.write_line(
            f"{row['scenario']}: {row['said']}; counted: {row['counted']}; "
            f"right again: {row['right again']}"
        )
    target = rig.ROOT / "build" / "hil"
    target.mkdir(parents=True, exist_ok=True)
    (target / "report.json").write_text(json.dumps(REPORT.rows, indent=1))
