"""lib/bus/sway_frames.c and lib/bus/sway_e2e.c against dbc/swaywatch.dbc as cantools reads it.

Every signal of every message that the ECU reads or sends: what cantools packs, the core must
decode, and what the core packs, cantools must decode, to half a step of the signal.
"""

from __future__ import annotations

import re
import subprocess
from fractions import Fraction
from pathlib import Path

import cantools
import pytest
from cantools.autosar.end_to_end import check_profile2_crc, compute_profile2_crc
from cantools.database.can import Message
from cantools.database.can.signal import Signal

from swaywatch.ecu._core import ffi, lib

ROOT = Path(__file__).resolve().parents[2]
DATABASE = cantools.database.load_file(ROOT / "dbc" / "swaywatch.dbc", strict=True)
INPUTS = [m for m in DATABASE.messages if m.frame_id < 0x1A0]
OUTPUTS = [m for m in DATABASE.messages if 0x1A0 <= m.frame_id < 0x200]

RADIAN = Fraction(31415926535897932, 10**16) / 180
CORE_UNIT = {
    "deg": RADIAN * 10**6,
    "deg/s": RADIAN * 10**6,
    "m/s2": Fraction(10**6),
    "km/h": Fraction(1000 * 10, 36),
    "N": Fraction(1000),
    "s": Fraction(1000),
    "Hz": Fraction(10**6),
    "1/s": Fraction(10**6),
    "N/rad": Fraction(1),
    "1/rad": Fraction(1000),
    "kgm2": Fraction(1000),
    "": Fraction(10**6),
}
"""The core's integers per unit of the DBC; without a unit: ratios, in ppm."""

STATUS_FIELD = {
    "TimeToLimit": "time_to_limit_ms",
    "CriticalSpeed": "v_crit_mm_s",
    "CriticalSpeedError": "v_crit_se_mm_s",
    "SpeedMargin": "margin_mm_s",
    "DampingRatio": "margin_damping_ratio_ppm",
    "DampingRatioError": "margin_damping_ratio_se_ppm",
    "ModelDampingRatio": "model_damping_ratio_ppm",
    "SignalDampingRatio": "damping_ratio_ppm",
    "SignalDampingRatioError": "damping_ratio_se_ppm",
    "Growth": "growth_ppm_per_s",
    "Frequency": "frequency_uhz",
    "FrequencyError": "frequency_se_uhz",
    "Amplitude": "amplitude_urad_s",
    "ModelFrequency": "model_frequency_uhz",
    "ModelDampingRatioError": "model_damping_ratio_se_ppm",
    "UsedSpeed": "speed_mm_s",
    "CarYawInertia": "car_yaw_inertia_gm2",
    "TrailerYawInertia": "trailer_yaw_inertia_gm2",
    "TrailerYawInertiaError": "trailer_yaw_inertia_se_gm2",
    "WindowLength": "window_ms",
    "FindingSize": "finding_size_micro",
    "FindingError": "finding_se_micro",
    "LowestCriticalSpeed": "lowest_v_crit_mm_s",
    "LowestCriticalSpeedError": "lowest_v_crit_se_mm_s",
    "LowestCriticalSpeedSwing": "lowest_v_crit_swing_urad_s",
    "RelationSize": "relation_ppm",
    "RelationDeviation": "relation_se_ppm",
}
AXLE_FIELD = {
    "Stiffness": "cornering_stiffness_n_per_rad",
    "StiffnessError": "cornering_stiffness_se_n_per_rad",
    "StiffnessArgument": "argument_urad",
    "EffectiveLoad": "effective_load_mn",
    "EffectiveLoadError": "effective_load_se_mn",
    "LoadHarmonic": "load_harmonic_mn",
    "NormalisedStiffness": "normalised_stiffness_milli_per_rad",
    "LateralFriction": "lateral_friction_ppm",
    "LoadHarmonicPhase": "load_harmonic_phase_urad",
}
for number, axle in enumerate(("CarFront", "CarRear", "TrailerFront", "TrailerRear")):
    STATUS_FIELD |= {
        f"{name}{axle}": f"axle.{number}.{field}" for name, field in AXLE_FIELD.items()
    }

ALWAYS = ("WindowLength", "FindingSize", "FindingError", "RelationSize", "RelationDeviation")
"""Signals of the status that have a value without an estimate."""

MASKS = {
    "MissingInputs": "missing_inputs",
    "SuspectInputs": "suspect_inputs",
    "RejectedInputs": "rejected_inputs",
}
"""Signals that hold a bit for each channel, and their fields of the status."""

CODES = {
    "AlarmState": ("alarm", "SWAY_ALARM_"),
    "CriticalSpeedSource": ("source", "SWAY_SOURCE_"),
    "DampingSource": ("belief", "SWAY_BELIEF_"),
    "CriticalSpeedKind": ("v_crit_kind", "SWAY_VCRIT_"),
}
"""Signals of codes: field of the status, prefix of the C constants."""

C_NAME = {
    "partly identified": "PARTLY",
    "signals": "SIGNAL",
    "not computed": "NONE",
    "beyond 250 km/h": "BEYOND_RANGE",
    "below 10 km/h": "BELOW_RANGE",
    "no solution": "SINGULAR",
    "static limit": "DIVERGENCE",
}
"""Choices of the DBC whose C constant is called otherwise."""


def upper(name: str) -> str:
    """``CarWheelFL`` as ``CAR_WHEEL_FL``."""
    parts = [""]
    for before, letter in zip(" " + name, name, strict=False):
        if letter.isupper() and not before.isupper():
            parts.append("")
        parts[-1] += letter.upper()
    return "_".join(part for part in parts if part)


def scale(signal: Signal) -> Fraction:
    return Fraction(str(signal.scale)) * CORE_UNIT[signal.unit or ""]


def raw_range(signal: Signal) -> tuple[int, int]:
    """All that fits the bits of a signal."""
    if signal.is_signed:
        return -(1 << signal.length - 1), (1 << signal.length - 1) - 1
    return 0, (1 << signal.length) - 1


def pack(message: Message, raw: dict[str, int]) -> bytes:
    every = {signal.name: raw.get(signal.name, 0) for signal in message.signals}
    return bytes(message.encode(every, scaling=False, strict=False))


def unpack(message: Message, data: bytes) -> dict[str, int]:
    return {
        name: int(value)
        for name, value in message.decode(data, decode_choices=False, scaling=False).items()
    }


# --- what comes in --------------------------------------------------------------------------------
def signals(message: Message) -> list[Signal]:
    """The physical signals of a message that the ECU reads; HitchFz is for records only."""
    return [s for s in message.signals if s.length == 16 and s.name != "HitchFz"]


def validity(message: Message, signal: Signal) -> Signal:
    names = (f"{signal.name}Validity", "HitchForcesValidity")
    return next(s for s in message.signals if s.name in names)


def input_of(signal: Signal) -> int:
    """``sway_input_t`` that a signal is, found by its name."""
    name = re.sub(r"(Car|Trailer)Wheel(..)(F[yz])", r"\1_\3_\2", signal.name)
    name = {"VehicleSpeed": "Speed", "ArticulationAngle": "Articulation"}.get(name, name)
    return int(getattr(lib, f"SWAY_INPUT_{(name if '_' in name else upper(name)).upper()}"))


def decoded(message: Message, raw: dict[str, int]) -> dict[int, tuple[int, bool]]:
    """Value and validity by input, as the core decodes what cantools packs."""
    found = lib.sway_frames_find(message.frame_id)
    assert found == getattr(lib, upper(message.name).replace("SWAY_", "SWAY_MESSAGE_", 1))
    samples = ffi.new("sway_sample_t[2]")
    count = lib.sway_frames_decode(found, pack(message, raw), samples)
    assert count == len(signals(message))
    return {int(s.input): (int(s.value), bool(s.valid)) for s in samples[0:count]}


def to_core(signal: Signal, raw: int) -> int:
    """To the nearest integer, halves away from zero."""
    exact = raw * scale(signal)
    size = int(abs(exact) + Fraction(1, 2))
    return size if exact > 0 else -size


@pytest.mark.parametrize("message", INPUTS, ids=lambda message: str(message.name))
def test_the_core_reads_what_cantools_packs(message: Message) -> None:
    assert message.frame_id == lib.sway_frames_input_id(lib.sway_frames_find(message.frame_id))
    for signal in signals(message):
        low, high = raw_range(signal)
        ends = (round(float(end) / float(signal.scale)) for end in (signal.minimum, signal.maximum))
        for raw in {low, low + 1, -256, -255, -1, 0, 1, 255, 256, high - 1, high, *ends}:
            if low <= raw <= high:
                reported = decoded(message, {signal.name: raw})
                assert reported[input_of(signal)] == (to_core(signal, raw), True), (
                    signal.name,
                    raw,
                )
                others = [value for key, value in reported.items() if key != input_of(signal)]
                assert all(other == (0, True) for other in others), signal.name


@pytest.mark.parametrize("message", INPUTS, ids=lambda message: str(message.name))
def test_only_what_the_dbc_calls_valid_is_valid(message: Message) -> None:
    for signal in signals(message):
        flag = validity(message, signal)
        assert flag.choices is not None
        assert sorted(flag.choices) == [0, 1, 2, 3]
        for code, meaning in flag.choices.items():
            reported = decoded(message, {signal.name: 1, flag.name: int(code)})
            assert reported[input_of(signal)][1] == (str(meaning) == "valid"), (signal.name, code)


def test_every_input_of_the_core_is_one_signal() -> None:
    inputs = sorted(input_of(signal) for message in INPUTS for signal in signals(message))
    assert inputs == list(range(lib.SWAY_INPUT_COUNT))
    assert len(INPUTS) == lib.SWAY_MESSAGE_COUNT


# --- what goes out --------------------------------------------------------------------------------
class Source:
    """What frames are made of, all zero at first."""

    def __init__(self) -> None:
        self.status = ffi.new("sway_status_t *")
        self.state = ffi.new(f"uint8_t[{lib.SWAY_MESSAGE_COUNT}]")
        self.fault = ffi.new(f"uint32_t[{lib.SWAY_FRAME_FAULT_COUNT}]")
        self.source = ffi.new("sway_frames_source_t *", (self.status, self.state, self.fault, 0))

    def frame(self, message: Message) -> bytes:
        output = message.frame_id - lib.sway_frames_output_id(lib.SWAY_OUTPUT_ALARM)
        assert message.frame_id == lib.sway_frames_output_id(output)
        data = ffi.new("uint8_t[8]", b"\xa5" * 8)
        lib.sway_frames_encode(output, self.source, data)
        return bytes(data)

    def set(self, path: str, value: int) -> None:
        """A field of the status, or of another table: ``name``, ``axle.0.name``, ``state.3``."""
        *parents, last = path.split(".")
        target = self if parents[:1] in (["state"], ["fault"]) else self.status
        for name in parents:
            target = target[int(name)] if name.isdigit() else getattr(target, name)
        if last.isdigit():
            target[int(last)] = value
        else:
            setattr(target, last, value)


def reported(source: Source, message: Message) -> dict[str, int]:
    """All signals of a frame; packing them again must give the frame: no bit is of no signal."""
    data = source.frame(message)
    raw = unpack(message, data)
    assert pack(message, raw) == data
    return raw


def physical(message: Message) -> list[Signal]:
    return [signal for signal in message.signals if signal.name in STATUS_FIELD]


@pytest.mark.parametrize("message", OUTPUTS, ids=lambda message: str(message.name))
def test_cantools_reads_what_the_core_packs(message: Message) -> None:
    for signal in physical(message):
        minimum, maximum = (round(end / signal.scale) for end in (signal.minimum, signal.maximum))
        for wanted in {minimum, minimum + 1, -256, -1, 0, 1, 255, 256, 12345, maximum - 1, maximum}:
            if not minimum <= wanted <= maximum:
                continue
            source = Source()
            source.status.valid = 0xFFFFFFFF
            before = reported(source, message)
            source.set(STATUS_FIELD[signal.name], to_core(signal, wanted))
            assert reported(source, message) == before | {signal.name: wanted}, signal.name
            for value, end in ((2**31 - 1, maximum), (-(2**31), minimum)):
                source.set(STATUS_FIELD[signal.name], value)
                assert reported(source, message)[signal.name] == end, signal.name


@pytest.mark.parametrize("message", OUTPUTS, ids=lambda message: str(message.name))
def test_without_an_estimate_the_dbc_says_not_available(message: Message) -> None:
    source = Source()
    for signal in physical(message):
        source.set(STATUS_FIELD[signal.name], 123456)
        if signal.name not in ALWAYS:  # always there
            assert signal.choices is not None
            assert str(signal.choices[reported(source, message)[signal.name]]) == "not available"


Trial = tuple[str, int, int]
"""Where to write (as ``Source.set`` takes it), what, and the raw value to be sent."""


def flags(signal: Signal) -> list[Trial]:
    for prefix, word in (("Quality", "quality"), ("Reason", "reasons")):
        if signal.name.startswith(prefix):
            return [(word, int(getattr(lib, f"SWAY_{upper(signal.name)}")), 1)]
    return []


def codes(signal: Signal) -> list[Trial]:
    if signal.name not in CODES:
        return []
    field, prefix = CODES[signal.name]
    assert signal.choices is not None
    names = {int(k): C_NAME.get(str(v), str(v).upper()) for k, v in signal.choices.items()}
    return [(field, int(getattr(lib, prefix + name)), code) for code, name in names.items()]


def counters(signal: Signal) -> list[Trial]:
    if not signal.name.startswith("Fault"):
        return []
    kind = upper(signal.name).removeprefix("FAULT_")
    frames = getattr(lib, f"SWAY_FRAME_FAULT_{kind}", None)
    path = (
        f"fault_count.{getattr(lib, f'SWAY_FAULT_{kind}')}" if frames is None else f"fault.{frames}"
    )
    most = raw_range(signal)[1]
    return [(path, count, min(count, most)) for count in (1, most, most + 1, 2**32 - 1)]


def states(signal: Signal) -> list[Trial]:
    if not signal.name.startswith("Input") or signal.name == "InputsLost":
        return []
    message = getattr(lib, f"SWAY_MESSAGE_{upper(signal.name).removeprefix('INPUT_')}")
    return [(f"state.{message}", value, value) for value in range(4)]


def findings(signal: Signal) -> list[Trial]:
    if signal.name != "Finding":
        return []
    assert signal.choices is not None
    known = {int(getattr(lib, name)) for name in dir(lib) if name.startswith("SWAY_FINDING_")}
    return [("finding", int(c), int(c)) for c in signal.choices if int(c) in known or int(c) > 16]


def relations(signal: Signal) -> list[Trial]:
    if signal.name not in ("Relation", "RelationState"):
        return []
    assert signal.choices is not None
    step = 1 if signal.name == "Relation" else 256
    return [("relation", step * int(code), int(code)) for code in signal.choices]


def numbers(signal: Signal) -> list[Trial]:
    if not signal.name.startswith("Estimate") and not signal.name.endswith("Estimate"):
        return []
    return [("sequence", 0x98765, 0x98765 & raw_range(signal)[1])]


@pytest.mark.parametrize("message", OUTPUTS, ids=lambda message: str(message.name))
def test_flags_codes_and_counters_are_where_the_dbc_has_them(message: Message) -> None:
    idle = reported(Source(), message)
    for signal in message.signals[2:]:
        every = [
            trial
            for kind in (flags, codes, counters, states, findings, relations, numbers)
            for trial in kind(signal)
        ]
        elsewhere = ("InputsLost", "JudgementDegraded", *MASKS)
        assert every or signal.name in STATUS_FIELD or signal.name in elsewhere, signal.name
        source = Source()
        for path, value, expected in every:
            source.set(path, value)
            assert reported(source, message) == idle | {signal.name: expected}, (signal.name, value)


def test_lost_inputs_are_reported() -> None:
    message = DATABASE.get_message_by_name("SwayAlarm")
    source = Source()
    idle = reported(source, message)
    source.source.inputs_lost = True
    assert reported(source, message) == idle | {"InputsLost": 1}


@pytest.mark.parametrize("signal", MASKS)
def test_inputs_that_the_judgement_lacks_are_reported(signal: str) -> None:
    message = DATABASE.get_message_by_name("SwayJudgement")
    alarm = DATABASE.get_message_by_name("SwayAlarm")
    source = Source()
    every = (1 << lib.SWAY_CHANNEL_COUNT) - 1
    assert message.get_signal_by_name(signal).maximum == every  # no code: all may be lacking
    for flags in (*(1 << channel for channel in range(lib.SWAY_CHANNEL_COUNT)), every):
        source.set(MASKS[signal], flags)
        assert reported(source, message) == reported(Source(), message) | {signal: flags}
        assert reported(source, alarm) == reported(Source(), alarm) | {"JudgementDegraded": 1}


def test_every_status_field_is_one_signal() -> None:
    names = {signal.name for message in OUTPUTS for signal in message.signals}
    assert set(STATUS_FIELD) | set(CODES) <= names
    assert len(OUTPUTS) == lib.SWAY_OUTPUT_COUNT


# --- protection -----------------------------------------------------------------------------------
def data_id(message: Message) -> int:
    """As the comments of the DBC say it: the same at every counter."""
    return message.frame_id & 0xFF


def test_every_message_has_another_data_id() -> None:
    assert len({data_id(m) for m in DATABASE.messages}) == len(DATABASE.messages)


@pytest.mark.parametrize("message", DATABASE.messages, ids=lambda message: str(message.name))
def test_crc_and_counter_of_every_identifier(message: Message) -> None:
    crc_name, counter_name = (signal.name for signal in message.signals[:2])
    counter = 0
    for number in range(31):
        payload = bytes((number * 37 + 11 * place) & 0xFF for place in range(8))
        data = ffi.new("uint8_t[8]", payload)
        lib.sway_e2e_protect(message.frame_id, counter, data)
        frame = bytes(data)
        raw = unpack(message, frame)
        assert raw[crc_name] == compute_profile2_crc(frame, data_id(message))
        assert raw[counter_name] == number % 16
        assert frame[2:] == payload[2:]
        assert frame[1] >> 4 == payload[1] >> 4
        assert lib.sway_e2e_check(message.frame_id, data)
        assert check_profile2_crc(frame, data_id(message))
        for other in DATABASE.messages:
            right = bool(lib.sway_e2e_check(other.frame_id, data))
            assert right == (other.frame_id == message.frame_id)
        counter = lib.sway_e2e_next(counter)


def test_the_codec_needs_its_generator_only(tmp_path: Path) -> None:
    """`make codec` installs cantools and what that needs, in the versions of everything else."""
    said = subprocess.run(
        ["make", "-n", "codec", f"VENV={tmp_path}/venv", f"B={tmp_path}/build"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert re.findall(r"-r (\S+)", said) == ["sim_host/requirements/codec.lock"]
    assert "gcc" not in said

    def pinned(name: str) -> set[str]:
        text = (ROOT / "sim_host" / "requirements" / name).read_text()
        return set(re.findall(r"^([a-z0-9-]+==\S+)", text, re.MULTILINE))

    assert pinned("codec.lock") < pinned("run.lock")
    assert len(pinned("codec.lock")) < 12
