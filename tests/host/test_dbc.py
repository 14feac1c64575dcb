"""dbc/swaywatch.dbc: what every signal must have, and what lib/bus/sway_frames.c relies on."""

from __future__ import annotations

import re
from pathlib import Path

import cantools
import pytest
from cantools.database.can import Message

ROOT = Path(__file__).resolve().parents[2]
DATABASE = cantools.database.load_file(ROOT / "dbc" / "swaywatch.dbc", strict=True)
MESSAGES = DATABASE.messages
COUNTED = re.compile(
    r"Crc$|Counter$|Estimate$|Validity$|^Fault|^Quality|^Reason|^Input|Inputs$|Degraded$|^Parameter"
)


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: str(message.name))
def test_every_signal_is_described(message: Message) -> None:
    assert message.comment
    assert message.length == 8
    for signal in message.signals:
        assert signal.comment, signal.name
        assert signal.minimum is not None, signal.name
        assert signal.maximum is not None, signal.name
        assert signal.minimum < signal.maximum, signal.name
        assert len(signal.name) <= 32, signal.name  # the format's limit


def test_names_are_unique() -> None:
    names = [signal.name for message in MESSAGES for signal in message.signals]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: str(message.name))
def test_protection_is_in_the_same_place_everywhere(message: Message) -> None:
    crc, counter = message.signals[:2]
    assert (crc.start, crc.length, counter.start, counter.length) == (0, 8, 8, 4)
    assert crc.name.endswith("Crc")
    assert counter.name.endswith("Counter")
    assert counter.maximum == 15


def layout(message: Message) -> list[tuple[object, ...]]:
    """Everything of a message but its names."""
    return [
        (s.start, s.length, s.is_signed, s.byte_order, s.scale, s.offset, s.minimum, s.maximum,
         s.unit, None if s.choices is None else sorted(s.choices))
        for s in message.signals
    ]  # fmt: skip


@pytest.mark.parametrize("family", ["Wheel", "SwayStiffness", "SwayLoad", "SwayTyre"])
def test_messages_that_share_a_codec_are_alike(family: str) -> None:
    alike = [m for m in MESSAGES if family in m.name]
    assert len(alike) == (8 if family == "Wheel" else 4)
    for message in alike[1:]:
        assert layout(message) == layout(alike[0]), message.name


def test_outputs_of_three_words_share_a_codec() -> None:
    alike = [m for m in MESSAGES if 0x1A1 <= m.frame_id <= 0x1B2 or 0x1B9 <= m.frame_id <= 0x1BA]
    assert len(alike) == 20
    places = [(0, 8), (8, 4), (12, 4), (16, 16), (32, 16), (48, 16)]
    for message in alike:
        assert [(s.start, s.length) for s in message.signals] == places, message.name
        assert all(s.byte_order == "little_endian" for s in message.signals), message.name


def test_outputs_follow_each_other() -> None:
    ids = [m.frame_id for m in MESSAGES if 0x1A0 <= m.frame_id < 0x200]
    assert ids == list(range(0x1A0, 0x1A0 + 29))


def test_inputs_have_validity_codes() -> None:
    for message in MESSAGES:
        if message.frame_id < 0x1A0:
            validity = [s for s in message.signals if s.name.endswith("Validity")]
            assert validity, message.name
            for signal in validity:
                assert signal.choices is not None
                assert len(signal.choices) == 4


def test_outputs_can_say_not_available() -> None:
    for message in MESSAGES:
        if 0x1A0 <= message.frame_id < 0x1B3:
            for signal in message.signals:
                if signal.length == 16:
                    assert signal.choices is not None, signal.name
                    value = -32768 if signal.is_signed else 65535
                    assert str(signal.choices[value]) == "not available", signal.name


def test_resolution_keeps_recordings_lossless() -> None:
    recorder = cantools.database.load_file(
        ROOT / "tests" / "data" / "practice" / "measurement.dbc", strict=True
    )
    finest = {s.unit: s.scale for m in recorder.messages for s in m.signals if "Rate" not in s.name}
    finest["deg/s"] = 0.01
    for message in MESSAGES:
        if message.frame_id < 0x1A0:
            for signal in message.signals:
                if signal.length == 16:
                    assert signal.scale <= finest[signal.unit], signal.name
