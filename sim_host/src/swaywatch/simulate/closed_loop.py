"""Hardware in the loop: a scenario driven in real time over a bus, with an ECU that answers.

Each cycle the driver steers, the double track goes on, the sensors measure, the messages are sent
at the cycle's absolute deadline, and what the ECU has said in the meantime is read. ``[reaction]``
of the scenario says what its alarm does to the drive::

    [reaction]
    kind = "trailer_brake"     # or "slow_down", "none"
    at = "warning"             # alarm state from which on: "notice", "warning", "critical"
    delay_s = 0.1
    force_n = 3000.0           # trailer_brake: at the trailer's axles; needs speed_control = true
    deceleration_m_s2 = 2.5    # slow_down: of the speed that the driver wants
    until_kmh = 70.0           # not below this speed

With ``model = "fmu"`` the plant is the user's own, FMI 2 or 3 (:mod:`swaywatch.cosim.mapping`)::

    [fmu]
    file = "my_combination.fmu"
    signals = "my_combination.toml"   # its roles; without it they are found by name
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from swaywatch.cosim.plant import FmuPlant
from swaywatch.ecu._core import ffi, lib
from swaywatch.ecu.bus import MESSAGES, database
from swaywatch.ecu.core import ALARM
from swaywatch.errors import RecordingError, ScenarioError
from swaywatch.models.double_track import DoubleTrack, SpeedControl
from swaywatch.simulate.driver import make_driver
from swaywatch.simulate.feed import FeedResult, send, wait_until
from swaywatch.simulate.plant import Plant
from swaywatch.simulate.scenario import Scenario
from swaywatch.simulate.sensors import Sensor, available, quantity, read_sensors
from swaywatch.simulate.table import Table

ALARM_MESSAGE, ALARM_SIGNAL = "SwayAlarm", "AlarmState"
REACTIONS = ("none", "trailer_brake", "slow_down")
"""Words for ``kind`` of ``[reaction]``."""
MEMORY_S = 2.0
"""Longest delay of a sensor."""


class LoopBus(Protocol):
    """What the loop needs of a python-can bus."""

    def send(self, msg: Any, timeout: float | None = None) -> None:
        """Send one message."""

    def recv(self, timeout: float | None = None) -> Any:
        """The next message, or None."""


@dataclass
class LoopResult:
    """What happened.

    Attributes
    ----------
    feed : frames sent, lateness of each cycle in s
    alarms : (time in s since the start, state) at each change
    reacted_s : when the reaction began; None where it never did
    swing_rad_s : largest trailer (or solo car) yaw rate of each second
    speed_m_s : at the end
    status_frames : frames that the ECU sent
    """

    feed: FeedResult = field(default_factory=FeedResult)
    alarms: list[tuple[float, int]] = field(default_factory=list)
    reacted_s: float | None = None
    swing_rad_s: list[float] = field(default_factory=list)
    speed_m_s: float = 0.0
    status_frames: int = 0

    def summary(self) -> str:
        """A few lines for the user."""
        deg = np.degrees(self.swing_rad_s) if self.swing_rad_s else np.zeros(1)
        alarms = ", ".join(f"{ALARM[state]} at {at:.1f} s" for at, state in self.alarms)
        lines = [
            self.feed.summary(),
            f"ECU: {self.status_frames} alarm frames; {alarms or 'no alarm'}",
            f"reaction: {'none' if self.reacted_s is None else f'from {self.reacted_s:.1f} s on'}",
            f"largest yaw rate {deg.max():.1f} deg/s, in the last second {deg[-1]:.1f} deg/s; "
            f"{self.speed_m_s * 3.6:.0f} km/h at the end",
        ]
        if self.status_frames == 0:
            lines[1] = (
                "ECU: silent; is one on this bus? `swaywatchd --vehicle vehicle.toml CHANNEL`"
            )
        return "\n".join(lines)


class Reaction:
    """What the alarm does to the drive."""

    def __init__(self, table: Table, speed_control: bool) -> None:
        self.kind = table.word("kind", REACTIONS, "none")
        states = [ALARM[state] for state in sorted(ALARM)]
        self.at = states.index(table.word("at", states[2:], "warning"))
        self.delay_s = table.number("delay_s", 0.0, 10.0, "s", 0.1)
        self._force = table.number("force_n", 0.0, 20000.0, "N", 3000.0)
        self._deceleration = table.number("deceleration_m_s2", 0.1, 10.0, "m/s2", 2.5)
        self._until = table.number("until_kmh", 10.0, 300.0, "km/h", 70.0) / 3.6
        if self.kind == "trailer_brake" and not speed_control:
            raise ScenarioError(
                f"{table.place}: a trailer brake needs speed_control = true in the scenario; with "
                "a prescribed speed no force can slow the combination"
            )
        table.done()
        self._alarm_since: float | None = None
        self.since_s: float | None = None
        self._braking = False

    def see(self, state: int, now_s: float) -> None:
        """The ECU's alarm state at a time."""
        if self.kind == "none" or self.since_s is not None:
            return
        if state < self.at:
            self._alarm_since = None
        elif self._alarm_since is None:
            self._alarm_since = now_s
        if self._alarm_since is not None and now_s >= self._alarm_since + self.delay_s:
            self.since_s = now_s

    def speed(self, meant_m_s: float, now_s: float) -> float:
        """Speed that the driver wants."""
        if self.since_s is None:
            return meant_m_s
        slowed = meant_m_s - self._deceleration * (now_s - self.since_s)
        return max(slowed, min(self._until, meant_m_s))

    def act(self, plant: Plant) -> None:
        """Brake the trailer, or stop braking it."""
        wanted = (
            self.kind == "trailer_brake"
            and self.since_s is not None
            and plant.value("speed") > self._until
        )
        if wanted != self._braking:
            plant.brake("trailer", self._force if wanted else 0.0)
            self._braking = wanted


class Sensors:
    """The sensors of a scenario, one sample at a time; see :mod:`swaywatch.simulate.sensors`."""

    def __init__(self, scenario: Scenario, plant: Plant) -> None:
        self._rear = scenario.vehicle.car.rear_axle_to_cog
        place = f"{scenario.name} [sensors]"
        first = plant.trace(0.0)
        self.sensors = read_sensors(Table(scenario.sensors, place), available(first))
        for name, sensor in self.sensors.items():
            if sensor.roll_gravity and f"{name.partition('_')[0]}_roll" not in first:
                raise ScenarioError(
                    f"{place}: {name}: this plant provides no roll for roll_gravity"
                )
        self._random = np.random.default_rng(scenario.seed)
        self._past: dict[str, deque[tuple[float, float]]] = {
            name: deque() for name, sensor in self.sensors.items() if _remembers(sensor)
        }

    def measure(self, plant: Plant, steering_rad: float) -> dict[str, float]:
        """Channel -> value at this moment."""
        now = np.array([plant.time_s])
        trace = plant.trace(steering_rad)
        return {name: self._one(name, sensor, trace, now) for name, sensor in self.sensors.items()}

    def _one(self, name: str, sensor: Sensor, trace: Any, now: Any) -> float:
        value, _ = quantity(trace, name, sensor, self._rear)
        times, values = now, value
        past = self._past.get(name)
        if past is not None:
            past.append((float(now[0]), float(value[0])))
            keep = min(float(now[0]), sensor.frozen_from_s) - MEMORY_S
            while past[0][0] < keep:
                past.popleft()
            times, values = np.array(past).T
        since_start = np.array([0.0, float(now[0])])  # drift counts from 0
        return float(sensor.measure(times, values, since_start, self._random)[-1])


def _remembers(sensor: Sensor) -> bool:
    return sensor.delay_s > 0.0 or sensor.frozen_from_s < 1e9


class Encoder:
    """Messages of ``dbc/swaywatch.dbc`` with validity, rolling counter and CRC, one at a time."""

    def __init__(self, channels: list[str]) -> None:
        self._messages = [
            (database().messages[name], [e for e in entries if e[0] in channels], entries)
            for name, entries in MESSAGES.items()
            if any(entry[0] in channels for entry in entries)
        ]
        self._counter = dict.fromkeys((m.frame_id for m, _, _ in self._messages), 0)
        self._missing = {
            message.name: {
                entry[2]: float(any(e[2] == entry[2] and e not in there for e in entries))
                for entry in entries
            }
            for message, there, entries in self._messages
        }

    def encode(self, values: dict[str, float]) -> list[tuple[int, bytes]]:
        """Identifier and data of every message; values beyond a signal's range are clipped."""
        return [self._encode(message, there, values) for message, there, _ in self._messages]

    def _encode(
        self, message: Any, there: list[tuple[str, str, str, float]], values: dict[str, float]
    ) -> tuple[int, bytes]:
        content: dict[str, float] = {signal.name: 0.0 for signal in message.signals}
        content |= self._missing[message.name]
        for channel, name, _, factor in there:
            signal = message.get_signal_by_name(name)
            content[name] = min(max(factor * values[channel], signal.minimum), signal.maximum)
        data = ffi.new("uint8_t[]", bytes(message.encode(content, strict=False)))
        counter = self._counter[message.frame_id]
        lib.sway_e2e_protect(message.frame_id, counter, data)
        self._counter[message.frame_id] = lib.sway_e2e_next(counter)
        return message.frame_id, bytes(ffi.buffer(data)[0 : message.length])


def drive_closed_loop(
    scenario: Scenario,
    bus: LoopBus,
    *,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
    result: LoopResult | None = None,
) -> LoopResult:
    """Drive a scenario over a bus in real time, at its ``timing.rate_hz``.

    Latency and jitter of ``[timing]`` are those of the real bus here; ``lost`` withholds frames.

    Parameters
    ----------
    scenario : with the double track or an FMU as model
    bus : a python-can bus, or anything with its ``send`` and ``recv``
    clock, sleep : for tests
    result : counted into, so that an interrupted drive still knows what it did

    Raises
    ------
    ScenarioError
        Another model, or a key in [driver], [sensors] or [reaction] is wrong.
    RecordingError
        A frame could not be sent.
    """
    if scenario.model not in ("double_track", "fmu"):
        raise ScenarioError(f"{scenario.name}: model = {scenario.model!r}; the loop closes with "
                            "'double_track' or 'fmu'")  # fmt: skip
    result = result if result is not None else LoopResult()
    period = 1.0 / scenario.timing.rate_hz
    with closing(make_plant(scenario, period)) as plant:
        loop = _Loop(scenario, plant, period, result)
        start = clock()
        for cycle in range(loop.cycles):
            wait_until(start + cycle * period, clock, sleep)
            late = max(clock() - start - cycle * period, 0.0)
            for identifier, data in loop.cycle(cycle):
                send(_message(identifier, data), bus, 1.0, clock, sleep, result.feed)
                result.feed.sent += 1
            result.feed.lateness_s.append(late)
            while (message := bus.recv(timeout=0.0)) is not None:
                loop.hear(message)
    return result


def make_plant(scenario: Scenario, period_s: float) -> Plant:
    """The plant of a scenario, sample by sample."""
    plan = scenario.plan
    speed = float(plan.speed_m_s[0])
    if scenario.fmu is not None:
        return FmuPlant(
            *scenario.fmu, period_s, speed, has_trailer=scenario.vehicle.trailer is not None,
            rear_axle_m=scenario.vehicle.car.rear_axle_to_cog,
        )  # fmt: skip
    control = SpeedControl() if scenario.speed_control else None
    model = DoubleTrack(
        scenario.vehicle, [*scenario.physics, *plan.effects], sprung=scenario.sprung
    )
    return model.stepper(period_s, speed, speed_control=control)


def _message(identifier: int, data: bytes) -> Any:
    import can

    return can.Message(arbitration_id=identifier, is_extended_id=False, data=data)


class _Loop:
    """Plant, driver, sensors and reaction of one drive."""

    def __init__(
        self, scenario: Scenario, plant: Plant, period_s: float, result: LoopResult
    ) -> None:
        self.scenario, self.plant, self.result = scenario, plant, result
        self.period = period_s
        self.cycles = int(scenario.duration_s * scenario.timing.rate_hz)
        self.driver = make_driver(
            Table(scenario.driver, f"{scenario.name} [driver]"), self.period,
            scenario.vehicle.car.steering_ratio,
        )  # fmt: skip
        self.reaction = Reaction(
            Table(scenario.reaction, f"{scenario.name} [reaction]"),
            scenario.speed_control or scenario.fmu is not None,
        )
        self.sensors = Sensors(scenario, plant)
        self.encoder = Encoder(list(self.sensors.sensors))
        self._alarm = database().messages[ALARM_MESSAGE]
        self._swing = "car_yaw_rate" if scenario.vehicle.trailer is None else "trailer_yaw_rate"
        self._lost = np.random.default_rng(scenario.seed + 1)

    def cycle(self, cycle: int) -> list[tuple[int, bytes]]:
        """One cycle on; the frames to send."""
        now, plan = cycle * self.period, self.scenario.plan
        meant = float(np.interp(now, plan.time_s, plan.steering_rad))
        speed = self.reaction.speed(float(np.interp(now, plan.time_s, plan.speed_m_s)), now)
        steering = meant if self.driver is None else self.driver.steer(meant, self.plant)
        if cycle > 0:
            self.reaction.act(self.plant)
            self.plant.advance(steering, speed)
        if not self.plant.is_whole:
            raise ScenarioError(
                f"{self.scenario.name}: after {now:.1f} s the motion left all bounds; a lower "
                "speed_kmh or an earlier reaction keeps it on the road"
            )
        self._note(now)
        frames = self.encoder.encode(self.sensors.measure(self.plant, steering))
        lost = self.scenario.timing.lost
        return [f for f in frames if lost == 0.0 or self._lost.random() >= lost]

    def _note(self, now: float) -> None:
        swing = self.result.swing_rad_s
        if len(swing) <= int(now):
            swing.append(0.0)
        swing[-1] = max(swing[-1], abs(self.plant.value(self._swing)))
        self.result.speed_m_s = self.plant.value("speed")

    def hear(self, message: Any) -> None:
        """A frame from the bus."""
        if message.is_error_frame or message.arbitration_id != self._alarm.frame_id:
            return
        if len(message.data) != self._alarm.length:
            raise RecordingError(
                f"{ALARM_MESSAGE} with {len(message.data)} bytes; {self._alarm.length} expected"
            )
        decoded = self._alarm.decode(bytes(message.data), decode_choices=False)
        state, now = int(decoded[ALARM_SIGNAL]), self.plant.time_s
        self.result.status_frames += 1
        before = self.result.alarms[-1][1] if self.result.alarms else None
        if state != before:
            self.result.alarms.append((now, state))
        self.reaction.see(state, now)
        self.result.reacted_s = self.reaction.since_s
