"""The report's page while the drive goes on: figures, numbers, verdict from what is known by now.

Served to this machine only. The page is the report's own (:mod:`swaywatch.report.page` and
``figures``), drawn again as estimates come, so it cannot show another picture than the report will.
"""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import numpy as np
import plotly.graph_objects as go

from swaywatch.analysis import DriveResult, conclude
from swaywatch.drive import Channel, Drive
from swaywatch.ecu.core import ALARM, Estimates, columns_of
from swaywatch.errors import SwaywatchError
from swaywatch.report import figures
from swaywatch.report.page import key_figures, verdict_box
from swaywatch.report.shell import document, figure_json, fill, plot
from swaywatch.vehicle import Vehicle

HERE = "127.0.0.1"
"""The only address that is listened to."""
MOST = 20_000
"""Estimates that are kept, the newest: about an hour and a half."""
EVERY_S = 1.0
"""Between two pictures, however many pages are open."""

FIGURES: dict[str, tuple[str, Callable[[DriveResult], go.Figure | None]]] = {
    "margin_against_speed": ("Margin against speed", lambda r: figures.margin_against_speed([r])),
    "margin": ("Speed, critical speed, alarm", figures.margin),
    "oscillation": ("Oscillation: frequency, amplitude, damping", figures.oscillation),
    "stiffness": ("Cornering stiffness of each axle", figures.stiffness),
    "loads": ("Axle loads", figures.loads),
}
"""Name -> heading and the report's function."""


class LivePage:
    """Results of a drive so far, and its page.

    Parameters
    ----------
    vehicle : of the file
    title : what is watched
    """

    def __init__(self, vehicle: Vehicle, title: str) -> None:
        self._vehicle = vehicle
        self._title = title
        self._lock = threading.Lock()
        self._status: deque[Any] = deque(maxlen=MOST)
        self._start_us: int | None = None
        self._sequence = 0
        self._trailer = ""
        self._made: tuple[float, bytes] = (-EVERY_S, b"")

    def note(self, status: Any, trailer: str = "") -> None:
        """The newest status, shape (1,); kept where it is a new estimate.

        `trailer` is what the ECU says of the trailer that it remembers, a sentence.
        """
        self._trailer = trailer
        sequence = int(status["sequence"][0])
        if sequence == self._sequence:
            return
        self._sequence = sequence
        with self._lock:
            if self._start_us is None:
                self._start_us = int(status["time_us"][0])
            self._status.append(status[0])

    def result(self) -> DriveResult | None:
        """What `analyze` would conclude from the estimates so far; None: there are none."""
        with self._lock:
            if not self._status:
                return None
            status = np.stack(list(self._status))
            start_us = self._start_us
        for name in ("time_us", "mid_time_us"):  # 0: there was no window yet
            status[name] = np.where(status[name] == 0, 0, status[name] - start_us)
        columns = columns_of(status)
        speed = Channel("speed", columns["time_s"], columns["speed_m_s"], "speed", "m/s")
        drive = Drive("now", (), {"speed": speed}, 0)
        return conclude(drive, self._vehicle, Estimates(status, {}, (), {}, columns), [])

    def state(self) -> bytes:
        """What the page draws, JSON: verdict and numbers as HTML, figures by name."""
        made, content = self._made
        if time.monotonic() - made < EVERY_S:
            return content
        result = self.result()
        found: dict[str, Any] = {
            "estimates": 0, "trailer": self._trailer, "figures": dict.fromkeys(FIGURES),
        }  # fmt: skip
        if result is not None:
            found["estimates"] = self._sequence
            found["alarm"] = ALARM[int(result.estimates.status["alarm"][-1])]
            found["verdict"] = fill("report/verdict.html", verdicts=[verdict_box(result)])
            found["numbers"] = fill("report/key_figures.html", numbers=key_figures([result]))
            for name, (_, draw) in FIGURES.items():
                figure = draw(result)
                found["figures"][name] = None if figure is None else figure_json(figure)
        content = json.dumps(found).encode()
        self._made = (time.monotonic(), content)
        return content

    def html(self) -> str:
        """The page, still empty."""
        shown = []
        for name, (heading, _) in FIGURES.items():
            empty = go.Figure().update_layout(height=300)
            run = "" if name == "margin_against_speed" else "now"
            shown.append((name, heading, plot(empty, run=run, name=name)))
        return document(
            "report/live.html", "Stability margin, live", meta=self._title, live=True,
            figures=shown,
        )  # fmt: skip


class Server:
    """Serves a page to browsers of this machine; a context manager.

    Parameters
    ----------
    page : what is served
    port : 0 takes a free one

    Raises
    ------
    SwaywatchError
        The port is taken.
    """

    def __init__(self, page: LivePage, port: int) -> None:
        try:
            self._server = ThreadingHTTPServer((HERE, port), _handler(page))
        except OSError as error:
            raise SwaywatchError(
                f"--page {port}: cannot be opened: {error.strerror}; 0 takes a free port"
            ) from None
        self._server.daemon_threads = True
        self.port = int(self._server.server_address[1])
        self.address = f"http://{HERE}:{self.port}/"

    def __enter__(self) -> Server:
        threading.Thread(target=self._server.serve_forever, name="page", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._server.server_close()


def _handler(page: LivePage) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        server_version = "swaywatch"
        sys_version = ""

        def do_GET(self) -> None:
            host = (self.headers.get("Host") or "").rpartition(":")[0]
            if host not in (HERE, "localhost"):  # a foreign page that calls itself by our address
                self.send_error(HTTPStatus.FORBIDDEN, "only for this machine")
            elif self.path == "/":
                self._send(page.html().encode(), "text/html; charset=utf-8")
            elif self.path == "/state":
                self._send(page.state(), "application/json")
            elif self.path == "/favicon.ico":  # browsers ask for it; there is none
                self.send_response(HTTPStatus.NO_CONTENT)
                self.end_headers()
            else:
                self.send_error(HTTPStatus.NOT_FOUND)

        def _send(self, content: bytes, kind: str) -> None:
            self.send_response(HTTPStatus.OK)
            for name, value in (
                ("Content-Type", kind), ("Content-Length", str(len(content))),
                ("Cache-Control", "no-store"), ("X-Content-Type-Options", "nosniff"),
                ("X-Frame-Options", "DENY"), ("Cross-Origin-Resource-Policy", "same-origin"),
            ):  # fmt: skip
                self.send_header(name, value)
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *_: Any) -> None:  # the terminal shows the drive
            pass

    return Handler
