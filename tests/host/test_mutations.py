"""Damaged files: a reader gives what is there or refuses with its own error, and always ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from swaywatch.errors import SwaywatchError
from swaywatch.recording import FRAME_SUFFIXES, Frames, read_recording, write_recording
from swaywatch.recording.dbc import Database, frames_by_identifier

MUTANTS = 40
RUN = DATA / "practice" / "p01" / "run1.blf"
DBC = DATA / "practice" / "measurement.dbc"


@pytest.fixture(scope="module")
def frames() -> Frames:
    content = read_recording(RUN).frames
    assert content is not None
    return content.take(slice(0, 400))


def mutant(raw: bytes, random: np.random.Generator) -> bytes:
    """Some bytes changed, a stretch taken out, or a stretch doubled."""
    kind = int(random.integers(3))
    start = int(random.integers(len(raw)))
    length = int(random.integers(1, 64))
    if kind == 0:
        changed = bytearray(raw)
        for _ in range(int(random.integers(1, 6))):
            changed[int(random.integers(len(raw)))] = int(random.integers(256))
        return bytes(changed)
    if kind == 1:
        return raw[:start] + raw[start + length :]
    return raw[: start + length] + raw[start:]


@pytest.mark.parametrize("suffix", FRAME_SUFFIXES)
def test_mutated_recordings_are_read_or_refused(
    tmp_path: Path, frames: Frames, suffix: str
) -> None:
    whole = tmp_path / f"whole{suffix}"
    write_recording(whole, frames)
    raw = whole.read_bytes()
    random = np.random.default_rng(7)
    path = tmp_path / f"mutant{suffix}"
    messages: list[str] = []
    for _ in range(MUTANTS):
        path.write_bytes(mutant(raw, random))
        try:
            recording = read_recording(path)
        except SwaywatchError as error:
            messages.append(str(error))
            continue
        if recording.frames is not None:
            assert np.all(np.diff(recording.frames.time_ns) >= 0)
            assert recording.frames.identifier.max() <= 0x1FFFFFFF
    assert messages
    assert all(path.name in message for message in messages)


def test_mutated_databases_decode_or_are_refused(tmp_path: Path, frames: Frames) -> None:
    raw = DBC.read_bytes()
    random = np.random.default_rng(8)
    path = tmp_path / "mutant.dbc"
    rows = frames_by_identifier(frames)
    refused = 0
    for _ in range(MUTANTS):
        path.write_bytes(mutant(raw, random))
        try:
            database = Database([path])
            for message in database.messages.values():
                here = rows.get((message.frame_id, message.is_extended_frame))
                for signal in message.signals if here is not None else ():
                    assert here is not None
                    decoded = database.decode(frames, here, message, signal)
                    assert np.all(np.isfinite(decoded.series.value))
        except SwaywatchError:
            refused += 1
    assert 0 < refused < MUTANTS
