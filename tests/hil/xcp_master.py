"""An XCP master for the tests: pyxcp on any bus, values by their names in the A2L file."""

from __future__ import annotations

import logging
import queue
import re
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import can
from pyxcp.config import create_application_from_config
from pyxcp.daq_stim import DaqList, DaqOnlinePolicy
from pyxcp.master import Master

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "firmware"))
import access

TYPES = {
    "UBYTE": "U8",
    "UWORD": "U16",
    "ULONG": "U32",
    "SBYTE": "I8",
    "SWORD": "I16",
    "SLONG": "I32",
}
REQUEST_ID, REPLY_ID = 0x6E4, 0x6E5
STATUS = "node.core.status."


@dataclass(frozen=True)
class Label:
    """A value of an A2L file."""

    address: int
    type: str
    conversion: str


class A2l:
    """The few things of an A2L file that a master needs."""

    def __init__(self, path: Path) -> None:
        self.text = path.read_text()
        self.measured = {
            name: Label(int(address, 16), kind, conversion)
            for name, kind, conversion, address in re.findall(
                r"/begin MEASUREMENT (\S+) \"\" (\w+) (\w+) .*\n\s+ECU_ADDRESS (0x\w+)", self.text
            )
        }
        self.parameters = {
            name: Label(int(address, 16), "SLONG", conversion)
            for name, address, conversion in re.findall(
                r"/begin CHARACTERISTIC (\S+) \"[^\"]*\" VALUE (0x\w+) word 0 (\w+)", self.text
            )
        }
        self.order = "big" if "BYTE_ORDER MSB_FIRST" in self.text else "little"


def key_of(key: bytes, seed: bytes) -> bytes:
    """Answer to a seed, from port/README.md."""
    return access.siphash(key, seed + bytes([0xF7, 0]))[:6]


class Samples(DaqOnlinePolicy):
    """Keeps what one DAQ list sends."""

    def __init__(self, daq_lists: list[DaqList]) -> None:
        super().__init__(daq_lists, logger=logging.getLogger("xcp"))
        self.pid_off = False
        self.rows: list[dict[str, int]] = []
        self.stamps: list[int] = []

    def on_daq_list(self, daq_list: int, host_ns: int, slave_ns: int, payload: list[int]) -> None:
        """Called by pyxcp for each whole sample."""
        names = [header[0] for header in self.daq_lists[daq_list].headers]
        self.rows.append(dict(zip(names, payload, strict=True)))
        self.stamps.append(slave_ns)


class Session:
    """A connected master."""

    def __init__(self, master: Master, a2l: A2l) -> None:
        self.master = master
        self.a2l = a2l

    def measure(self, name: str) -> int:
        """Poll one value."""
        label = self.a2l.measured[name]
        size = int(TYPES[label.type][1:]) // 8
        data = self.master.shortUpload(size, label.address)
        return int.from_bytes(data, self.a2l.order, signed=TYPES[label.type][0] == "I")

    def parameter(self, name: str) -> int:
        """Read a parameter of the page that the master sees."""
        data = self.master.shortUpload(4, self.a2l.parameters[name].address)
        return int.from_bytes(data, self.a2l.order, signed=True)

    def calibrate(self, name: str, value: int) -> None:
        """Write a parameter of the page that the master sees."""
        self.master.setMta(self.a2l.parameters[name].address)
        self.master.download(value.to_bytes(4, self.a2l.order, signed=True))

    def lists(self, names: list[str], event: int) -> list[DaqList]:
        """One DAQ list with time stamps."""
        found = [
            (n, self.a2l.measured[n].address, 0, TYPES[self.a2l.measured[n].type]) for n in names
        ]
        return [DaqList("values", event, False, True, found, 0, 1)]


@contextmanager
def session(
    bus: can.BusABC, a2l: A2l, key: bytes = b"", policy: DaqOnlinePolicy | None = None
) -> Iterator[Session]:
    """Connect a pyxcp master on `bus`; `key` is what it answers seeds with."""
    app = create_application_from_config(
        {
            "Transport": {"CAN": {"can_id_master": REQUEST_ID, "can_id_slave": REPLY_ID}},
            "General": {
                "seed_n_key_function": lambda resource, seed: key_of(key, seed),
                "disable_error_handling": True,
            },
        },
        log_level=logging.CRITICAL,
    )
    with Master("can", config=app, policy=policy, transport_layer_interface=bus) as master:
        master.connect()
        yield Session(master, a2l)
        master.disconnect()


class End(can.BusABC):
    """One master's end of a :class:`Pipes`."""

    def __init__(self, pipes: Pipes) -> None:
        self.channel_info = "pipes"
        self.pipes = pipes
        self.answers: queue.Queue[can.Message] = queue.Queue()
        super().__init__(channel="pipes")

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """To the ECU, at the time of the frame played last."""
        frame = f"{msg.arbitration_id:03X}#{msg.data.hex().upper()}"
        self.pipes.write(f"({self.pipes.time_s:.6f}) can0 {frame}")

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        try:
            return self.answers.get(timeout=timeout), True
        except queue.Empty:
            return None, True


class Pipes:
    """A bus to an ECU that reads candump lines and writes them, as the replay programs do.

    Time is that of what is played.
    """

    def __init__(self, to_ecu: Path, from_ecu: Path) -> None:
        self.status: list[tuple[int, bytes]] = []
        self.time_s = 0.0
        self.end: End | None = None
        self._to = to_ecu.open("w", buffering=1)
        self._thread = threading.Thread(target=self._read, args=(from_ecu,), daemon=True)
        self._thread.start()

    def master(self) -> End:
        """The end of a new master."""
        self.end = End(self)
        return self.end

    def _read(self, path: Path) -> None:
        with path.open() as lines:
            for line in lines:
                identifier, _, data = line.split()[2].partition("#")
                number, content = int(identifier, 16), bytes.fromhex(data)
                if number != REPLY_ID:
                    self.status.append((number, content))
                elif self.end is not None:
                    answer = can.Message(arbitration_id=number, data=content, is_extended_id=False)
                    self.end.answers.put(answer)

    def write(self, line: str) -> None:
        """One frame to the ECU."""
        self._to.write(line + "\n")

    def play(self, lines: list[str]) -> None:
        """Frames of a recording."""
        for line in lines:
            self.time_s = float(line[1 : line.index(")")])
            self.write(line)

    def close(self) -> None:
        """The ECU sees the end of its recording."""
        self._to.close()
        self._thread.join(10.0)
