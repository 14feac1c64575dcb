"""``swaywatch monitor --page``: the report's picture as it grows, for this machine only."""

from __future__ import annotations

import contextlib
import http.client
import json
import re
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from browser import CHROMIUM, Browser
from conftest import DATA

from swaywatch.analysis import conclude
from swaywatch.cli import main
from swaywatch.drive import load_drive
from swaywatch.ecu.bus import encode_drive
from swaywatch.ecu.core import Core, Estimates, columns_of, positions_of
from swaywatch.ecu.live import NodeFeed, Playback
from swaywatch.report import live
from swaywatch.report.live import LivePage, Server
from swaywatch.vehicle_file import load_vehicle

P01 = DATA / "practice" / "p01"


@pytest.fixture(scope="module")
def page() -> LivePage:
    """A page that has seen the whole of a recording, frame by frame."""
    vehicle = load_vehicle(P01 / "vehicle.toml")
    drive = load_drive([P01 / "run1.blf"], P01 / "signals.toml")
    feed = NodeFeed(vehicle, positions_of(drive))
    seen = LivePage(vehicle, "run1")
    with Playback(encode_drive(drive), 0.0) as bus:
        while (message := bus.recv(0.0)) is not None:
            feed.receive(message)
            seen.note(feed.status())
    return seen


def get(port: int, path: str, host: str | None = None) -> tuple[int, dict[str, str], bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    with contextlib.closing(connection):
        connection.request("GET", path, headers={} if host is None else {"Host": host})
        answer = connection.getresponse()
        return answer.status, dict(answer.getheaders()), answer.read()


def test_it_concludes_what_the_report_concludes(page: LivePage) -> None:
    drive = load_drive([P01 / "run1.blf"], P01 / "signals.toml")
    vehicle = load_vehicle(P01 / "vehicle.toml")
    status, inputs = Core(vehicle, positions_of(drive)).feed(drive)
    report = conclude(drive, vehicle, Estimates(status, {}, inputs, {}, columns_of(status)), [])
    now = page.result()
    assert now is not None
    assert np.all(np.diff(now.estimates.status["sequence"]) == 1)  # none was missed
    assert now.estimates.time_s.min() == 0.0
    assert now.estimates.time_s.max() == pytest.approx(report.estimates.time_s.max(), abs=1.0)
    # the bus carries the signals in steps, and its first frames settle the counters
    assert len(now.estimates) == pytest.approx(len(report.estimates), rel=0.05)
    assert set(now.values) == set(report.values)
    for name in ("v_crit_m_s", "frequency_hz", "car_rear.cornering_stiffness_n_per_rad"):
        assert now.values[name].value == pytest.approx(report.values[name].value, rel=0.01)
    assert [a.state for a in now.alarms] == [a.state for a in report.alarms]


def test_the_state_holds_the_figures_of_the_report(page: LivePage) -> None:
    state = json.loads(page.state())
    assert set(state["figures"]) == set(live.FIGURES)
    for name in ("margin_against_speed", "margin", "oscillation", "stiffness"):
        figure = json.loads(state["figures"][name])
        assert figure["data"], name
        assert figure["layout"]["height"] > 300
    assert "critical speed of" in state["verdict"]
    assert "kN/rad" in state["numbers"]


def test_only_this_machine_is_answered(page: LivePage) -> None:
    with Server(page, 0) as server:
        assert server._server.server_address[0] == "127.0.0.1"
        status, head, body = get(server.port, "/")
        assert status == 200
        text = body.decode()
        assert "connect-src 'self'" in text
        assert not re.search(r"""(src|href)=["']?(https?:)?//""", text)
        assert not re.search(r"https?://(?!www\.w3\.org)[a-z]", text)
        assert head["Cache-Control"] == "no-store"
        assert get(server.port, "/state")[0] == 200
        assert get(server.port, "/etc/passwd")[0] == 404
        assert get(server.port, "/favicon.ico")[0] == 204
        assert get(server.port, "/", f"elsewhere.example:{server.port}")[0] == 403
        other = socket.socket()  # a second address of the same machine
        with contextlib.closing(other):
            assert other.connect_ex(("127.0.0.2", server.port)) != 0


def test_before_the_first_estimate_there_is_a_page_too() -> None:
    seen = LivePage(load_vehicle(P01 / "vehicle.toml"), "can0")
    assert json.loads(seen.state())["estimates"] == 0
    assert "Waiting for the first estimate" in seen.html()


@contextlib.contextmanager
def monitor(capsys: Any, *words: str) -> Iterator[str]:
    """The command in the background; its address."""
    code: list[int] = []
    arguments = ["monitor", str(P01 / "run1.blf"), "--signals", str(P01 / "signals.toml"),
                 "--vehicle", str(P01 / "vehicle.toml"), "--page", *words]  # fmt: skip
    thread = threading.Thread(target=lambda: code.append(main(arguments)))
    thread.start()
    said = ""
    end = time.monotonic() + 120.0
    while "http://" not in said and time.monotonic() < end and thread.is_alive():
        time.sleep(0.1)
        said += capsys.readouterr().out
    yield said[said.index("http://") :].splitlines()[0]
    thread.join()
    assert code == [0]


def test_the_command_serves_while_it_watches(capsys: Any) -> None:
    with monitor(capsys, "--speed", "4") as address:
        port = int(address.rstrip("/").rpartition(":")[2])
        seen = []
        with contextlib.suppress(OSError, http.client.HTTPException):
            while len(seen) < 400:
                seen.append(json.loads(get(port, "/state")[2])["estimates"])
                time.sleep(0.2)
    assert seen == sorted(seen)
    assert seen[-1] > 50


def test_a_port_that_is_taken_is_said_so(page: LivePage, capsys: Any) -> None:
    with Server(page, 0) as server:
        words = ["monitor", str(P01 / "run1.blf"), "--signals", str(P01 / "signals.toml")]
        words += ["--vehicle", str(P01 / "vehicle.toml"), "--page", str(server.port)]
        code = main(words)
    assert code == 1
    assert f"--page {server.port}" in capsys.readouterr().err


@pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")
def test_a_browser_draws_it_and_asks_nobody_else(page: LivePage) -> None:
    with Server(page, 0) as server, Browser() as browser:
        browser.call("Page.navigate", url=server.address)
        end = time.monotonic() + 60.0
        drawn = ""
        while not drawn:
            assert time.monotonic() < end, browser.complaints
            with contextlib.suppress(RuntimeError):  # asked while the page changes
                drawn = browser.evaluate("document.documentElement.dataset.estimates || ''")
            time.sleep(0.2)
        assert int(drawn) > 100
        traces = browser.evaluate(
            "window.swaywatch.plots.map((plot) => plot.div.data.length).join()"
        )
        assert np.count_nonzero([int(n) for n in traces.split(",")]) >= 4
        assert "Alarm: " in browser.evaluate("document.getElementById('live-alarm').innerText")
        assert browser.complaints == []
        assert all(request.startswith((server.address, "data:", "blob:"))
                   for request in browser.requests)  # fmt: skip
