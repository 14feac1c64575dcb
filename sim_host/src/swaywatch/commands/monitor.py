"""``swaywatch monitor``: the state of the combination, live from a bus."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import can
from rich.console import Console, Group
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from swaywatch.analysis import AXLE_NAMES, LIMITS, SEARCHED_M_S
from swaywatch.commands._options import add_bitrate, add_files
from swaywatch.commands.feed import open_bus
from swaywatch.drive import load_drive
from swaywatch.ecu.bus import encode_drive
from swaywatch.ecu.core import (
    ALARM,
    AXLES,
    QUALITY,
    REASON,
    VALID,
    VCRIT,
    columns_of,
    positions_of,
)
from swaywatch.ecu.live import NodeFeed, Playback, RoleFeed
from swaywatch.ecu.supervised import findings_text
from swaywatch.errors import SwaywatchError
from swaywatch.recording import read_recording
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle

_STYLE = {
    "off": "dim", "normal": "bold white on green", "notice": "bold black on yellow",
    "warning": "bold black on dark_orange", "critical": "bold white on red",
}  # fmt: skip
_DEG = 180 / math.pi


def add_parser(subparsers: Any) -> None:
    """Add the ``monitor`` command."""
    parser = subparsers.add_parser(
        "monitor",
        help="live view of a bus, or of a recording as it was driven: margin, damping, alarm",
        description="Live view over any interface of python-can, or of a recording, played in real "
        "time. Without --signals the frames are assumed to be those of dbc/swaywatch.dbc; with "
        "it, any bus is decoded by its DBC and roles.",
    )
    parser.add_argument(
        "recording", type=Path, nargs="?", help="recording to play instead of listening to a bus"
    )
    parser.add_argument(
        "--speed", type=float, default=1.0, metavar="N",
        help="play a recording at N times real time; 0: without pause",
    )  # fmt: skip
    parser.add_argument(
        "--interface", help="python-can interface, e.g. socketcan, pcan, vector, virtual"
    )
    parser.add_argument(
        "--channel", help="channel of the interface, e.g. can0, vcan0, PCAN_USBBUS1"
    )
    add_bitrate(parser)
    add_files(parser, signals=False)
    parser.add_argument(
        "--signals", type=Path, metavar="TOML", help="roles and DBC of the bus or of the recording"
    )
    parser.add_argument(
        "--car-accelerometer", type=float, default=0.0, metavar="M",
        help="position of the car's lateral accelerometer ahead of the centre of gravity "
        "(negative: behind it); with --signals, the position given there is used",
    )  # fmt: skip
    parser.add_argument(
        "--trailer-accelerometer",
        type=float,
        default=0.0,
        metavar="M",
        help="the same for the trailer",
    )
    parser.add_argument(
        "--send", action="store_true", help="send the status frames to the bus, as the ECU does"
    )
    parser.add_argument(
        "--page", type=int, nargs="?", const=0, metavar="PORT",
        help="also show the report's figures, updated while driving, in a browser of this machine; "
        "the address is printed (PORT: default a free one)",
    )  # fmt: skip
    parser.add_argument(
        "--duration", type=float, default=math.inf, metavar="S", help="end after this time"
    )


def run(args: argparse.Namespace) -> int:
    """Watch until interrupted or until --duration is over."""
    vehicle = load_vehicle(args.vehicle)
    if args.recording is not None and (args.interface or args.channel):
        raise SwaywatchError(f"{args.recording} and --interface: give one of them")
    if args.recording is None and not (args.interface and args.channel):
        raise SwaywatchError(
            "no source given: give --interface and --channel of a bus (such as socketcan can0), "
            "or a "
            "recording"
        )
    positions = {
        "car_lateral_acceleration": args.car_accelerometer,
        "trailer_lateral_acceleration": args.trailer_accelerometer,
    }
    feed: NodeFeed | RoleFeed
    bus: can.BusABC | Playback
    if args.recording is not None:
        feed, bus = _recorded(args, vehicle, positions)
    else:
        feed = (
            NodeFeed(vehicle, positions)
            if args.signals is None
            else RoleFeed(vehicle, args.signals)
        )
        bus = open_bus(args)
    console = Console(highlight=False)
    with ExitStack() as stack:
        stack.enter_context(bus)
        note = _page(args, vehicle, console, stack)
        if console.is_terminal:
            live = stack.enter_context(Live(console=console, screen=False, auto_refresh=False))
            _watch(
                bus, feed, args, 0.2, lambda: live.update(picture(feed, args), refresh=True), note
            )
        else:
            _watch(bus, feed, args, 1.0, lambda: console.print(line(feed), soft_wrap=True), note)
    console.print(line(feed), soft_wrap=True)
    return 0


def _page(
    args: argparse.Namespace, vehicle: Vehicle, console: Console, stack: ExitStack
) -> Callable[[Any, str], None] | None:
    """With --page: serve it until the command ends; what is called with each status."""
    if args.page is None:
        return None
    from swaywatch.report.live import LivePage, Server

    if not 0 <= args.page <= 65535:
        raise SwaywatchError(f"--page {args.page}: expected a port, 1024 to 65535, or 0 for any")
    page = LivePage(vehicle, _place(args))
    server = stack.enter_context(Server(page, args.page))
    console.print(server.address, soft_wrap=True)
    return page.note


def _place(args: argparse.Namespace) -> str:
    return str(args.recording) if args.recording else f"{args.interface} {args.channel}"


def _recorded(
    args: argparse.Namespace, vehicle: Vehicle, positions: dict[str, float]
) -> tuple[NodeFeed | RoleFeed, Playback]:
    """A recording in place of a bus: its own frames, or its signals as frames of the ECU."""
    if args.send:
        raise SwaywatchError("--send needs a bus; a recording takes no frames")
    if args.speed < 0.0:
        raise SwaywatchError(f"--speed {args.speed:g} must not be negative")
    frames = read_recording(args.recording).frames
    if frames is not None and args.signals is None:
        return NodeFeed(vehicle, positions), Playback(frames, args.speed)
    if frames is not None:
        return RoleFeed(vehicle, args.signals), Playback(frames, args.speed)
    if args.signals is None:
        raise SwaywatchError(
            f"{args.recording}: holds decoded signals; --signals assigns them to roles"
        )
    drive = load_drive([args.recording], args.signals)
    return NodeFeed(vehicle, positions_of(drive)), Playback(encode_drive(drive), args.speed)


def _watch(
    bus: can.BusABC | Playback,
    feed: NodeFeed | RoleFeed,
    args: argparse.Namespace,
    every_s: float,
    show: Callable[[], None],
    note: Callable[[Any, str], None] | None,
) -> None:
    """Receive, and show every so often."""
    end = time.monotonic() + args.duration
    due = time.monotonic() + every_s
    try:
        while time.monotonic() < end:
            message = bus.recv(timeout=0.05)
            if message is None and isinstance(bus, Playback):
                if bus.at_end:
                    break
                continue
            if message is not None:
                _take(bus, feed, args, message)
                if note:
                    note(feed.status(), said_of_trailer(feed))
            else:
                feed.advance(time.time())
            if time.monotonic() >= due:
                show()
                due = max(due + every_s, time.monotonic())
    except KeyboardInterrupt:
        pass
    except can.CanError as error:
        raise SwaywatchError(f"the bus {args.channel} failed: {error}") from None


def _take(
    bus: can.BusABC | Playback,
    feed: NodeFeed | RoleFeed,
    args: argparse.Namespace,
    message: can.Message,
) -> None:
    """One frame; with --send what the ECU answers goes to the bus."""
    for identifier, data in feed.receive(message):
        if args.send:
            assert not isinstance(bus, Playback)
            bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))


def _values(feed: NodeFeed | RoleFeed) -> tuple[Any, dict[str, float]]:
    status = feed.status()
    return status[0], {name: float(column[0]) for name, column in columns_of(status).items()}


def _number(text: str, shown: bool, value: float, error: float | None = None) -> str:
    if not shown:
        return "-"
    if error is None:
        return text.format(value)
    return f"{text.format(value)} ± {text.replace('+', '').format(error)}"


def _critical(status: Any, value: dict[str, float]) -> str:
    """The critical speed with its error; a bound of the search is said to be one."""
    if not status["valid"] & VALID["critical_speed"]:
        return "-"
    kind = VCRIT[int(status["v_crit_kind"])]
    low, high = (speed * 3.6 for speed in SEARCHED_M_S)
    if kind == "beyond_range":
        return f"none up to {high:.0f}"
    if kind == "below_range":
        return f"below {low:.0f}"
    return _number("{:.1f}", True, value["v_crit_m_s"] * 3.6, value["v_crit_se_m_s"] * 3.6)


def said_of_trailer(feed: NodeFeed | RoleFeed) -> str:
    """The ECU's sentence on the trailer that it remembers; empty where the bus has none."""
    return "" if feed.trailer is None else feed.trailer.sentence


def line(feed: NodeFeed | RoleFeed) -> str:
    """The state in one line."""
    status, value = _values(feed)

    def valid(name: str) -> bool:
        return bool(status["valid"] & VALID[name])

    critical = _critical(status, value)
    known = valid("critical_speed") and VCRIT[int(status["v_crit_kind"])] in LIMITS
    margin = _number("{:+.1f}", known, value["margin_m_s"] * 3.6)
    frequency = _number("{:.3f}", valid("line"), value["frequency_hz"])
    damping = _number("{:+.3f}", valid("line"), value["damping_ratio"])
    trailer = "" if feed.trailer is None else f"trailer {feed.trailer.state}  "
    return (
        f"{ALARM[int(status['alarm'])].upper():8s} v {value['speed_m_s'] * 3.6:6.1f} km/h  "
        f"v_crit {critical} km/h  margin {margin} km/h  f {frequency} Hz  damping {damping}  "
        f"{trailer}estimates {int(status['sequence'])}  frames used {feed.counts.used}, other "
        f"{feed.counts.other}, errors {feed.counts.errors}"
    )


def picture(feed: NodeFeed | RoleFeed, args: argparse.Namespace) -> Panel:
    """The state as a panel for the terminal."""
    status, value = _values(feed)

    def valid(name: str) -> bool:
        return bool(status["valid"] & VALID[name])

    state = ALARM[int(status["alarm"])]
    reasons = [name.replace("_", " ") for name, bit in REASON.items() if status["reasons"] & bit]
    head = Text.assemble(
        (f"  {state.upper()}  ", _STYLE[state]), "  ", ", ".join(reasons) or "no reason for alarm"
    )
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(style="dim")
    table.add_column(justify="right")
    table.add_column()
    known = valid("critical_speed") and VCRIT[int(status["v_crit_kind"])] in LIMITS
    rows = (
        ("speed", _number("{:.1f}", valid("speed"), value["speed_m_s"] * 3.6), "km/h"),
        ("critical speed", _critical(status, value), "km/h"),
        ("margin", _number("{:+.1f}", known, value["margin_m_s"] * 3.6), "km/h"),
        (
            "frequency",
            _number("{:.3f}", valid("line"), value["frequency_hz"], value["frequency_se_hz"]),
            "Hz",
        ),
        (
            "damping ratio",
            _number("{:+.4f}", valid("line"), value["damping_ratio"], value["damping_ratio_se"]),
            "",
        ),
        (
            "damping ratio, model",
            _number(
                "{:+.4f}",
                valid("model"),
                value["model_damping_ratio"],
                value["model_damping_ratio_se"],
            ),
            "",
        ),
        (
            "yaw rate amplitude",
            _number("{:.2f}", valid("line"), value["amplitude_rad_s"] * _DEG),
            "°/s",
        ),
    )
    for row in rows:
        table.add_row(*row)
    for axle in AXLES:
        table.add_row(
            f"stiffness, {AXLE_NAMES[axle]}",
            _number(
                "{:.1f}",
                valid(axle),
                value[f"{axle}.cornering_stiffness_n_per_rad"] * 1e-3,
                value[f"{axle}.cornering_stiffness_se_n_per_rad"] * 1e-3,
            ),
            "kN/rad",
        )
    flags = [name.replace("_", " ") for name, bit in QUALITY.items() if status["quality"] & bit]
    faults = [f"{name} {count}" for name, count in feed.faults().items() if count]
    supervision = findings_text(feed.status())
    trailer = said_of_trailer(feed)
    foot = Text(
        (f"trailer: {trailer}\n" if trailer else "") + f"quality: {', '.join(flags) or 'good'}\n"
        f"inputs and vehicle: {supervision or 'no fault found'}\n"
        f"frames: {feed.counts.used} used, {feed.counts.other} other, {feed.counts.errors} error "
        f"frames, {feed.counts.rate_hz:.0f}/s; faults: {', '.join(faults) or 'none'}",
        style="dim",
    )
    title = f"swaywatch  {_place(args)}"
    return Panel(Group(head, table, foot), title=title, title_align="left")
