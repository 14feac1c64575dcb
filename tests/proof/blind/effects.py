"""What can be concealed in a generated case: one entry per effect, drawn by strength.

Every effect maps a strength in [0, 1] (0 cannot be seen, 1 is plain) to its parameters, says
what to change in the plant, its inputs, its sensors or the user's vehicle file, and what the
answer is. Names and parameters are those of the recordings' README.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from swaywatch.models.multibody_vehicle import Axle, Body, Combination, HarmonicLoad, Physics

Array = NDArray[np.float64]
Window = tuple[float, float]
RUNS = ("run1", "run2", "run3")

AXLE_NUMBERS = {"car_front": (0,), "car_rear": (1,), "trailer": (2, 3)}
WHEEL_NUMBERS = {"car_front": (0, 1), "car_rear": (2, 3), "trailer": (4, 5, 6, 7)}


@dataclass
class Draw:
    """One concealed effect of one case.

    answer : for the scorer, with `id` first.
    component : where it is, in the words of the axles, bodies, `hitch`, `steering` or a signal.
    windows : per run, empty when it always acts.
    physics, combination : change the plant.
    inputs : (run, time) to input arrays that are added or put in.
    sensors : per signal {"delay": s, "gain": 1, "roll_gravity": rad per m/s2, ...}.
    user : change to what the user believes, vehicle key to factor (true / believed).
    outside : not in the library of effects.
    restless : it keeps the combination moving at any speed, which is no instability.
    """

    answer: dict[str, Any]
    component: str
    strength: float = 0.0
    value: float = 0.0
    windows: dict[str, list[Window]] = field(default_factory=dict)
    physics: Callable[[Physics], Physics] = lambda physics: physics
    combination: Callable[[Combination], Combination] = lambda combination: combination
    inputs: Callable[[str, Array], dict[str, Any]] = lambda run, time: {}
    sensors: dict[str, dict[str, Any]] = field(default_factory=dict)
    user: dict[str, float] = field(default_factory=dict)
    outside: bool = False
    restless: bool = False
    fault: bool = False
    vertical: bool = False


def log_between(weak: float, strong: float, strength: float) -> float:
    """Geometric interpolation."""
    return float(weak * (strong / weak) ** strength)


def signed(rng: Generator, weak: float, strong: float, strength: float) -> float:
    """Deviation of either sign."""
    return float(rng.choice((-1.0, 1.0)) * log_between(weak, strong, strength))


def draw_windows(rng: Generator, low: float = 2.5, high: float = 4.0) -> dict[str, list[Window]]:
    """Two windows in run 1 and run 2, one in run 3, while the combination swings."""
    spans = {"run1": ((8.0, 11.0), (14.5, 17.0)), "run2": ((7.0, 10.5), (21.0, 27.0)),
             "run3": ((5.5, 7.5),)}  # fmt: skip
    out: dict[str, list[Window]] = {}
    for run, places in spans.items():
        out[run] = []
        for low_start, high_start in places:
            start = round(float(rng.uniform(low_start, high_start)), 1)
            out[run].append((start, round(start + float(rng.uniform(low, high)), 1)))
    return out


def inside(time: Array, windows: list[Window], ramp_s: float = 0.15) -> Array:
    """1 inside the windows, 0 outside, smooth over `ramp_s` at their edges."""
    total = np.zeros_like(time)
    for start, end in windows:
        rise = np.clip((time - start) / ramp_s + 0.5, 0.0, 1.0)
        fall = np.clip((end - time) / ramp_s + 0.5, 0.0, 1.0)
        total += 0.5 - 0.5 * np.cos(np.pi * np.minimum(rise, fall))
    return total


def per_axle(numbers: tuple[int, ...], value: float) -> tuple[float, float, float, float]:
    """`value` at these axles, 0 at the others."""
    a, b, c, d = (value if i in numbers else 0.0 for i in range(4))
    return a, b, c, d


def change_axle(
    combination: Combination, number: int, change: Callable[[Axle], Axle]
) -> Combination:
    """Combination with one axle changed."""
    name, place = ("car", "trailer")[number // 2], ("front", "rear")[number % 2]
    body: Body = getattr(combination, name)
    body = replace(body, **{place: change(getattr(body, place))})  # type: ignore[arg-type]
    return replace(combination, **{name: body})  # type: ignore[arg-type]


def steering_compliance(rng: Generator, u: float) -> Draw:
    """Stiffness of the steering falls with strength."""
    value = round(log_between(2e7, 4e5, u), -3)
    return Draw(
        {"id": "steering_compliance", "stiffness_n_per_rad": value},
        "steering",
        physics=lambda p: replace(p, steering_stiffness_n_rad=value),
        value=value,
    )


def steering_free_play(rng: Generator, u: float) -> Draw:
    """A gap, of which there are two readings: with friction, or pushed by the tyres."""
    value = round(log_between(0.1, 5.0, u), 3)
    law = str(rng.choice(("backlash", "aligned")))
    return Draw(
        {"id": "steering_free_play", "gap_deg": value, "law": law},
        "steering",
        physics=lambda p: replace(p, free_play_rad=float(np.radians(value)), free_play_law=law),
        value=value,
    )


def axle_load_harmonic(rng: Generator, u: float) -> Draw:
    """Two windows of different size and delay."""
    axle = str(rng.choice(("car_rear", "car_front"), p=(0.7, 0.3)))
    size = log_between(40.0, 1100.0, u)
    amplitudes = [round(size, 1), round(size * float(rng.uniform(0.6, 1.0)), 1)]
    if rng.random() < 0.5:
        amplitudes.reverse()
    delays = [round(float(d), 3) for d in rng.uniform(0.02, 0.6, 2)]
    windows = draw_windows(rng)

    def inputs(run: str, time: Array) -> dict[str, Any]:
        amplitude, delay = np.zeros_like(time), np.full_like(time, delays[0])
        for number, window in enumerate(windows[run]):
            amplitude += amplitudes[number] * inside(time, [window])
            delay[time > window[0] - 0.5] = delays[number]
        return {"harmonic_n": amplitude, "harmonic_delay_s": delay}

    return Draw(
        {"id": "axle_load_harmonic", "axle": axle, "amplitude_n": amplitudes, "delay": delays},
        axle,
        windows=windows,
        physics=lambda p: replace(p, axle_load=HarmonicLoad(axle)),
        inputs=inputs,
        value=size,
    )


def tyre_relaxation(rng: Generator, u: float) -> Draw:
    """Relaxation length of an axle of the car or of the trailer."""
    axle = str(rng.choice(("car_front", "car_rear", "trailer")))
    value = round(log_between(0.04, 1.0, u), 4)
    return Draw(
        {"id": "tyre_relaxation", "axle": axle, "length_m": value},
        axle,
        physics=lambda p: replace(p, relaxation_m=per_axle(AXLE_NUMBERS[axle], value)),
        value=value,
    )


def tyre_saturation(rng: Generator, u: float) -> Draw:
    """Magic formula with a peak."""
    value = round(log_between(5.0, 0.8, u), 3)
    return Draw(
        {"id": "tyre_saturation", "peak_friction": value},
        "tyres",
        physics=lambda p: replace(p, tyre_law="magic_formula", peak_friction=value),
        value=value,
    )


def tyre_load_sensitivity(rng: Generator, u: float) -> Draw:
    """Degression of stiffness with load."""
    value = round(log_between(0.02, 0.7, u), 4)
    return Draw(
        {"id": "tyre_load_sensitivity", "degression": value},
        "tyres",
        physics=lambda p: replace(p, load_degression=value),
        value=value,
    )


def tyre_stiffness_change(rng: Generator, u: float) -> Draw:
    """Stiffness of an axle in time windows, loads unchanged."""
    axle = str(rng.choice(("car_front", "car_rear", "trailer")))
    factor = round(1.0 + signed(rng, 0.005, 0.25, u), 4)
    windows = draw_windows(rng, 3.0, 6.0)
    names = {"trailer": ("trailer_front", "trailer_rear")}.get(axle, (axle,))

    def inputs(run: str, time: Array) -> dict[str, Any]:
        values = 1.0 + (factor - 1.0) * inside(time, windows[run])
        return {"stiffness_factor": dict.fromkeys(names, values)}

    return Draw(
        {"id": "tyre_stiffness_change", "axle": axle, "factor": factor},
        axle,
        windows=windows,
        inputs=inputs,
        value=abs(factor - 1.0),
    )


def hitch_friction(rng: Generator, u: float) -> Draw:
    """Dry friction of the ball."""
    value = round(log_between(4.0, 300.0, u), 1)
    return Draw(
        {"id": "hitch_friction", "moment_nm": value},
        "hitch",
        physics=lambda p: replace(p, hitch_friction_nm=value),
        value=value,
    )


def hitch_damping(rng: Generator, u: float) -> Draw:
    """Viscous moment of the ball."""
    value = round(log_between(30.0, 3000.0, u), 1)
    return Draw(
        {"id": "hitch_damping", "coefficient_nms_per_rad": value},
        "hitch",
        physics=lambda p: replace(p, hitch_damping_nms_rad=value),
        value=value,
    )


def trailer_aerodynamics(rng: Generator, u: float) -> Draw:
    """Air forces on the trailer's side."""
    side = round(log_between(0.05, 2.5, u), 3)
    yaw = round(side * float(rng.uniform(0.3, 0.7)), 3)
    return Draw(
        {"id": "trailer_aerodynamics", "side_force_coefficient": side,
         "yaw_moment_coefficient": yaw},
        "trailer",
        physics=lambda p: replace(p, side_force_coefficient=side, yaw_moment_coefficient=yaw),
        value=side,
    )  # fmt: skip


def roll_steer(rng: Generator, u: float) -> Draw:
    """Steer with roll, of one axle or the trailer."""
    axle = str(rng.choice(("car_front", "car_rear", "trailer")))
    value = round(signed(rng, 0.004, 0.2, u), 4)
    return Draw(
        {"id": "roll_steer", "axle": axle, "coefficient": value},
        axle,
        physics=lambda p: replace(p, roll_steer=per_axle(AXLE_NUMBERS[axle], value)),
        value=abs(value),
    )


def crosswind_gust(rng: Generator, u: float) -> Draw:
    """Side force at the COG of a body."""
    body = str(rng.choice(("car", "trailer")))
    force = round(signed(rng, 30.0, 1500.0, u), 1)
    windows = draw_windows(rng, 0.8, 2.5)

    def inputs(run: str, time: Array) -> dict[str, Any]:
        return {f"{body}_side_force_n": force * inside(time, windows[run])}

    return Draw(
        {"id": "crosswind_gust", "body": body, "force": force},
        body,
        windows=windows,
        inputs=inputs,
        value=abs(force),
    )


def road_bank(rng: Generator, u: float) -> Draw:
    """Cross-fall; accelerometers of one kind sense the weight's part along it, others do not."""
    angle = round(signed(rng, 0.06, 3.0, u), 3)
    windows = draw_windows(rng, 3.0, 6.0)
    sensing = str(rng.choice(("specific_force", "motion")))

    def inputs(run: str, time: Array) -> dict[str, Any]:
        return {"bank_rad": np.radians(angle) * inside(time, windows[run], 1.0)}

    return Draw(
        {"id": "road_bank", "angle_deg": angle, "sensing": sensing},
        "road",
        windows=windows,
        inputs=inputs,
        sensors={} if sensing == "motion" else {
            name: {"bank": True} for name in ("LatAccRear1", "LatAcc2")
        },
        value=abs(angle),
    )  # fmt: skip


def sensor_delay(rng: Generator, u: float) -> Draw:
    """One channel lags."""
    channel = str(rng.choice(("LatAccRear1", "LatAcc2", "YawRate1", "YawRate2", "HitchFy")))
    value = round(log_between(0.002, 0.12, u), 4)
    return Draw(
        {"id": "sensor_delay", "channel": channel, "delay_s": value},
        channel,
        sensors={channel: {"delay": value}},
        fault=True,
        value=value,
    )


def sensor_gain(rng: Generator, u: float) -> Draw:
    """One channel reads too much or too little."""
    names = ("LatAccRear1", "LatAcc2", "YawRate1", "YawRate2", "HitchFy")
    channel = str(rng.choice(names))
    value = round(1.0 + signed(rng, 0.004, 0.25, u), 4)
    return Draw(
        {"id": "sensor_gain", "channel": channel, "factor": value},
        channel,
        sensors={channel: {"gain": value}},
        fault=True,
        value=abs(value - 1.0),
    )


def sensor_roll_gravity(rng: Generator, u: float) -> Draw:
    """Accelerometer on a rolling body: adds g sin(roll)."""
    channel = str(rng.choice(("LatAccRear1", "LatAcc2")))
    share = log_between(0.05, 1.3, u)
    return Draw(
        {"id": "sensor_roll_gravity", "channel": channel, "share_of_roll": round(share, 4)},
        channel,
        sensors={channel: {"roll_gravity": share}},
        fault=True,
        value=share,
    )


PARAMETERS = (
    "car.mass", "car.yaw_inertia", "car.front_cornering_stiffness",
    "car.rear_cornering_stiffness", "car.steering_ratio", "trailer.mass", "trailer.yaw_inertia",
    "trailer.front_cornering_stiffness", "trailer.rear_cornering_stiffness",
    "trailer.hitch_to_cog", "car.hitch_to_cog",
)  # fmt: skip


def parameter_error(rng: Generator, u: float) -> Draw:
    """The user believes a wrong value; factor is true over believed."""
    parameter = str(rng.choice(PARAMETERS))
    strong = 0.1 if parameter.endswith("hitch_to_cog") else 0.22
    factor = round(1.0 + signed(rng, 0.005, strong, u), 4)
    return Draw(
        {"id": "parameter_error", "parameter": parameter, "factor": factor},
        parameter,
        user={parameter: factor},
        value=abs(factor - 1.0),
    )


def _wheels(axle: str, side: str) -> tuple[int, ...]:
    numbers = WHEEL_NUMBERS[axle]
    return {"left": numbers[::2], "right": numbers[1::2], "both": numbers}[side]


def damper_fade(rng: Generator, u: float) -> Draw:
    """Damping of an axle fades on one side or both."""
    axle = str(rng.choice(("car_front", "car_rear", "trailer")))
    side = str(rng.choice(("left", "right", "both")))
    factor = round(1.0 - log_between(0.08, 0.97, u), 4)
    factors = tuple(factor if i in _wheels(axle, side) else 1.0 for i in range(8))
    return Draw(
        {"id": "damper_fade", "axle": axle, "side": side, "factor": factor},
        axle,
        physics=lambda p: replace(p, damper_factor=factors),
        vertical=True,
        value=1.0 - factor,
    )


def damper_asymmetry(rng: Generator, u: float) -> Draw:
    """Rebound over compression of an axle's dampers, 2 when healthy."""
    axle = str(rng.choice(("car_front", "car_rear", "trailer")))
    ratio = round(2.0 * log_between(1.1, 6.0, u), 3)

    def combination(whole: Combination) -> Combination:
        for number in AXLE_NUMBERS[axle]:
            whole = change_axle(
                whole, number, lambda a: replace(a, damper=replace(a.damper, ratio=ratio))
            )
        return whole

    return Draw(
        {"id": "damper_asymmetry", "axle": axle, "ratio": ratio},
        axle,
        combination=combination,
        vertical=True,
        value=ratio,
    )


def friction_reduction(rng: Generator, u: float) -> Draw:
    """Peak friction falls in time windows; stiffness stays."""
    factor = round(1.0 - log_between(0.05, 0.55, u), 4)
    windows = draw_windows(rng, 3.0, 6.0)

    def inputs(run: str, time: Array) -> dict[str, Any]:
        return {"friction_factor": 1.0 + (factor - 1.0) * inside(time, windows[run])}

    return Draw(
        {"id": "friction_reduction", "factor": factor},
        "road",
        windows=windows,
        inputs=inputs,
        vertical=True,
        value=1.0 - factor,
    )


def roll_stiffness_change(rng: Generator, u: float) -> Draw:
    """Springs against roll of one body become softer or stiffer."""
    body = str(rng.choice(("car", "trailer")))
    factor = round(float(np.exp(signed(rng, 0.03, 0.6, u))), 4)

    def combination(whole: Combination) -> Combination:
        for number in (0, 1) if body == "car" else (2, 3):
            whole = change_axle(whole, number, lambda a: _roll_bar(a, factor))
        return whole

    return Draw(
        {"id": "roll_stiffness_change", "body": body, "factor": factor},
        body,
        combination=combination,
        vertical=True,
        value=abs(float(np.log(factor))),
    )


def _roll_bar(axle: Axle, factor: float) -> Axle:
    """Roll stiffness of an axle, (k + 2 k_bar) s^2/2, times a factor by its bar alone."""
    bar = 0.5 * (factor * (axle.spring_n_m + 2 * axle.roll_bar_n_m) - axle.spring_n_m)
    return replace(axle, roll_bar_n_m=bar)


def outside_slosh(rng: Generator, u: float) -> Draw:
    """Cargo that swings sideways."""
    mass = round(log_between(15.0, 350.0, u), 1)
    frequency = round(float(rng.uniform(0.75, 1.3)), 3)
    place = round(float(rng.uniform(-1.5, 1.5)), 2)
    return Draw(
        {"id": "cargo_slosh", "mass_kg": mass, "frequency_hz": frequency, "position_m": place},
        "trailer",
        physics=lambda p: replace(
            p, slosh_mass_kg=mass, slosh_frequency_hz=frequency, slosh_position_m=place
        ),
        outside=True,
        value=mass,
    )


def outside_yaw_control(rng: Generator, u: float) -> Draw:
    """A stability controller that brakes against the car's yaw."""
    value = round(log_between(100.0, 12000.0, u), 1)
    return Draw(
        {"id": "yaw_moment_control", "gain_nms_per_rad": value},
        "car",
        physics=lambda p: replace(p, yaw_moment_nms_rad=value),
        outside=True,
        value=value,
    )


def outside_hitch_spring(rng: Generator, u: float) -> Draw:
    """A coupling that pulls the combination straight."""
    value = round(log_between(100.0, 12000.0, u), 1)
    return Draw(
        {"id": "hitch_stiffness", "stiffness_nm_per_rad": value},
        "hitch",
        physics=lambda p: replace(p, hitch_spring_nm_rad=value),
        outside=True,
        value=value,
    )


def outside_wheel_drag(rng: Generator, u: float) -> Draw:
    """A brake that drags at one wheel of the trailer."""
    value = round(log_between(30.0, 1500.0, u), 1)
    return Draw(
        {"id": "wheel_drag", "force_n": value},
        "trailer",
        physics=lambda p: replace(p, wheel_drag_n=value),
        outside=True,
        value=value,
    )


FAULTS = ("frozen", "spikes", "drift", "clock")


def outside_sensor(rng: Generator, u: float) -> Draw:
    """A measurement fault that the README does not list."""
    kind = str(rng.choice(FAULTS))
    channel = str(rng.choice(("LatAccRear1", "LatAcc2", "YawRate1", "YawRate2", "HitchFy")))
    size = log_between(0.02, 1.0, u)
    windows = draw_windows(rng) if kind == "frozen" else {}
    return Draw(
        {"id": f"sensor_{kind}", "channel": channel, "size": round(size, 4)},
        channel,
        windows=windows,
        sensors={channel: {kind: windows if kind == "frozen" else size}},
        outside=True,
        fault=True,
        value=size,
    )


PLANAR = (
    steering_compliance, steering_free_play, axle_load_harmonic, tyre_relaxation,
    tyre_saturation, tyre_load_sensitivity, tyre_stiffness_change, hitch_friction,
    hitch_damping, trailer_aerodynamics, roll_steer, crosswind_gust, road_bank, sensor_delay,
    sensor_gain, sensor_roll_gravity, parameter_error,
)  # fmt: skip
VERTICAL = (damper_fade, damper_asymmetry, friction_reduction, roll_stiffness_change)
WITH_SIMULATION = (
    *VERTICAL, *VERTICAL, axle_load_harmonic, tyre_relaxation, tyre_stiffness_change,
    hitch_friction, hitch_damping, steering_compliance, steering_free_play, trailer_aerodynamics,
    crosswind_gust, road_bank, roll_steer, sensor_delay, sensor_gain, sensor_roll_gravity,
)  # fmt: skip
PAIRS = (
    steering_compliance, axle_load_harmonic, tyre_relaxation, hitch_friction, hitch_damping,
    trailer_aerodynamics, sensor_delay, sensor_gain, parameter_error, tyre_saturation,
)  # fmt: skip
OUTSIDE = (outside_slosh, outside_yaw_control, outside_hitch_spring, outside_wheel_drag)
