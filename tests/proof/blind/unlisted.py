"""104 kinds of physics that no library lists: six to build on, the rest to open once.

Written down before the discovery was tried on any of them (the third and the fourth six on
2026-11-23, the fifth six on 2026-11-24, each after the six before had been opened and learnt from;
the next sixteen on 2026-11-26 by someone who had not seen how laws are searched for, the next
twelve the same day by someone who knew of the search what DESIGN.md and CHANGELOG.md say, the next
ten on 2026-11-27 from what happens to trailers on the road, by someone who had seen of the search
some lines of DESIGN.md and CHANGELOG.md and the package's plant, `plant_law.h`; the next twelve the
same day, from the same, by someone who had seen of the search nothing but the words of places and
variables and the titles of changes to it; the next twelve, and then the last twelve, the same day,
in the same way).
A kind counts as found where a law is claimed at one of its places and of one of its variables
(`answer["places"]`, `["variables"]`, in the words of `discovered` in a diagnosis.json): in a swing
two variables in phase are one. Values of the file are exact and all sensors there: within
tolerances many of these are no more than a value.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from effects import Draw, log_between
from numpy.random import Generator

from swaywatch.models.multibody_vehicle import GRAVITY, Combination, Physics


def _without_rack(whole: Combination, mass_kg: float) -> Combination:
    """The combination less a mass above the ball, whose weight goes on resting on the car."""
    car = whole.car
    rest = car.mass_kg - mass_kg
    ahead = mass_kg * car.hitch_to_cog_m / rest  # of the COG of what is left
    inertia = car.yaw_inertia_kgm2 - mass_kg * car.hitch_to_cog_m * (car.hitch_to_cog_m + ahead)
    lighter = replace(
        car, mass_kg=rest, yaw_inertia_kgm2=inertia, hitch_to_cog_m=car.hitch_to_cog_m + ahead,
        front=replace(car.front, to_cog_m=car.front.to_cog_m - ahead),
        rear=replace(car.rear, to_cog_m=car.rear.to_cog_m - ahead),
    )  # fmt: skip
    return replace(whole, car=lighter, nose_load_n=whole.nose_load_n + mass_kg * GRAVITY)


def _draw(name: str, size: float, places: str, variables: str, **more: float) -> Draw:
    """A kind of `Physics.more`; places and variables are words with blanks between."""
    settings: dict[str, Any] = {"more": name, "more_size": size} | more

    def combination(whole: Combination) -> Combination:
        car, trailer = whole.car, whole.trailer
        if name == "roof_load":
            return replace(whole, car=replace(car, mass_kg=car.mass_kg - size))
        if name in ("turning_load", "unlocked_slew"):
            rest = trailer.yaw_inertia_kgm2 - size
            return replace(whole, trailer=replace(trailer, yaw_inertia_kgm2=rest))
        if name == "two_tanks":
            rest = trailer.yaw_inertia_kgm2 - size * more["slosh_position_m"] ** 2
            return replace(whole, trailer=replace(trailer, yaw_inertia_kgm2=rest))
        return _without_rack(whole, size) if name == "rear_rack" else whole

    def physics(healthy: Physics) -> Physics:
        return replace(healthy, **settings)

    return Draw(
        {"id": name, **settings, "places": places.split(), "variables": variables.split()},
        places.partition(" ")[0],
        physics=physics,
        combination=combination,
        outside=True,
        value=size,
    )


def jackknife_stop(rng: Generator, u: float) -> Draw:
    """Rubber or bodywork that is touched beyond some degrees."""
    at = round(float(rng.uniform(0.01, 0.04)), 4)
    size = log_between(2e3, 2e5, u)
    return _draw("jackknife_stop", size, "hitch", "articulation", more_at=at)


def trailer_axle_steers(rng: Generator, u: float) -> Draw:
    """A trailer's axles that are steered by the drawbar, into the bend or out of it."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.005, 0.2, u)
    return _draw("trailer_axle_steers", size, "slip_trailer", "articulation")


def car_air(rng: Generator, u: float) -> Draw:
    """Air on the car's side."""
    return _draw("car_air", log_between(1.0, 30.0, u), "force_car moment_car", "sideslip_car")


def tow_assist(rng: Generator, u: float) -> Draw:
    """Power steering that answers the articulation rate."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.001, 0.04, u)
    return _draw("tow_assist", size, "slip_car_front", "articulation_rate")


def roof_load(rng: Generator, u: float) -> Draw:
    """A load on the roof that is not lashed."""
    hz = round(float(rng.uniform(0.8, 2.0)), 3)
    return _draw("roof_load", log_between(10.0, 150.0, u), "car", "swing", more_frequency_hz=hz)


def axle_hysteresis(rng: Generator, u: float) -> Draw:
    """Axles of the trailer that give way in worn bushes, with dry friction."""
    at = round(float(rng.uniform(0.005, 0.03)), 4)
    size = log_between(0.02, 0.6, u)
    variables = "articulation articulation_rate"
    return _draw("axle_hysteresis", size, "slip_trailer", variables, more_at=at)


def tarpaulin(rng: Generator, u: float) -> Draw:
    """Air on a tarpaulin that bulges with a swing of its own."""
    hz = round(float(rng.uniform(0.8, 2.0)), 3)
    return _draw(
        "tarpaulin", log_between(1.0, 30.0, u), "force_trailer moment_trailer trailer",
        "sideslip_trailer articulation yaw_rate_trailer swing", more_frequency_hz=hz,
    )  # fmt: skip


def heading_wind(rng: Generator, u: float) -> Draw:
    """A steady wind over an open road: its part across the trailer goes with the heading."""
    return _draw("heading_wind", log_between(300.0, 2e4, u), "force_trailer", "heading")


def trailer_brakes(rng: Generator, u: float) -> Draw:
    """A stability controller in the trailer that begins at a yaw rate."""
    at = round(float(rng.uniform(0.01, 0.06)), 4)
    size = log_between(300.0, 2e4, u)
    return _draw("trailer_brakes", size, "moment_trailer", "yaw_rate_trailer", more_at=at)


def hydraulic_hitch(rng: Generator, u: float) -> Draw:
    """A hydraulic damper at the drawbar: its moment goes with the square of the rate."""
    return _draw("hydraulic_hitch", log_between(300.0, 2e4, u), "hitch", "articulation_rate")


def rear_wheel_steering(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that are steered with the front ones."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.005, 0.2, u)
    return _draw("rear_wheel_steering", size, "slip_car_rear", "steer")


def tandem_scrub(rng: Generator, u: float) -> Draw:
    """Tyres of a tandem that scrub: a moment of nearly one size against each turn."""
    size = log_between(30.0, 1500.0, u)
    return _draw("tandem_scrub", size, "moment_trailer", "yaw_rate_trailer")


def gap_air(rng: Generator, u: float) -> Draw:
    """Air in the gap between the bodies: a side force on the trailer with the articulation."""
    return _draw("gap_air", log_between(1.0, 60.0, u), "force_trailer", "articulation")


def trailer_hubs(rng: Generator, u: float) -> Draw:
    """Driven hubs of the trailer that work against its swing, as strong as they can."""
    at = round(float(rng.uniform(0.01, 0.1)), 4)
    size = log_between(50.0, 2500.0, u)
    return _draw("trailer_hubs", size, "moment_trailer", "articulation_rate", more_at=at)


def variable_ratio(rng: Generator, u: float) -> Draw:
    """Steering that is more direct, or less, away from its middle."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.1, 6.0, u)
    return _draw("variable_ratio", size, "slip_car_front", "steer")


def late_assist(rng: Generator, u: float) -> Draw:
    """Steering assistance that answers the articulation late."""
    at = round(float(rng.uniform(0.1, 0.5)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.003, 0.15, u)
    variables = "articulation articulation_rate"
    return _draw("late_assist", size, "slip_car_front", variables, more_at=at)


def car_brakes(rng: Generator, u: float) -> Draw:
    """A controller of the car that brakes one side beyond an articulation rate."""
    at = round(float(rng.uniform(0.01, 0.06)), 4)
    size = log_between(300.0, 2e4, u)
    return _draw("car_brakes", size, "moment_car", "articulation_rate", more_at=at)


def turning_load(rng: Generator, u: float) -> Draw:
    """A load in the trailer that turns by itself: a boom, a boat on its cradle."""
    hz = round(float(rng.uniform(0.5, 1.5)), 3)
    size = log_between(20.0, 600.0, u)
    variables = "swing yaw_rate_trailer"
    return _draw("turning_load", size, "trailer moment_trailer", variables, more_frequency_hz=hz)


def air_damping(rng: Generator, u: float) -> Draw:
    """Air that slows a turn of the trailer: it goes with speed times yaw rate."""
    return _draw("air_damping", log_between(4.0, 300.0, u), "moment_trailer", "yaw_rate_trailer")


def rolling_load(rng: Generator, u: float) -> Draw:
    """A load that rolls between two boards, free in the middle."""
    at = round(float(rng.uniform(0.005, 0.05)), 4)
    hz = round(float(rng.uniform(0.8, 2.0)), 3)
    mass = round(log_between(15.0, 300.0, u), 2)
    return _draw(
        "rolling_load", mass, "trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=hz,
    )  # fmt: skip


def locked_axle(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that turn alike: a moment against bends, until one of them slips."""
    at = round(float(rng.uniform(5e-4, 5e-3)), 5)
    size = log_between(50.0, 2500.0, u)
    return _draw("locked_axle", size, "moment_car", "yaw_rate_car", more_at=at)


def lane_assist(rng: Generator, u: float) -> Draw:
    """Front wheels that are steered back to the road's heading beside the driver."""
    return _draw("lane_assist", log_between(0.005, 0.3, u), "slip_car_front", "heading heading_car")


def bearing_play(rng: Generator, u: float) -> Draw:
    """Worn wheel bearings of the trailer: its wheels turn a little with each side force."""
    size = log_between(2e-4, 1e-2, u)
    variables = "slip_trailer sideslip_trailer articulation yaw_rate_trailer"
    return _draw("bearing_play", size, "slip_trailer force_trailer", variables)


def rear_axle_control(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that are steered with its yaw rate, late."""
    at = round(float(rng.uniform(0.05, 0.3)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.002, 0.1, u)
    variables = "yaw_rate_car"
    return _draw("rear_axle_control", size, "slip_car_rear", variables, more_at=at)


def driver_arms(rng: Generator, u: float) -> Draw:
    """Arms and steering wheel that swing beside the angle sensor, driven by the car's yaw rate."""
    hz = round(float(rng.uniform(0.6, 2.0)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.002, 0.06, u)
    variables = "yaw_rate_car swing"
    return _draw("driver_arms", size, "slip_car_front", variables, more_frequency_hz=hz)


def baffled_liquid(rng: Generator, u: float) -> Draw:
    """A liquid between baffles: its damping grows with its own rate."""
    at = round(float(rng.uniform(0.05, 0.4)), 3)
    hz = round(float(rng.uniform(0.5, 1.4)), 3)
    mass = round(log_between(15.0, 400.0, u), 2)
    return _draw(
        "baffled_liquid", mass, "trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=hz, slosh_damping=0.01,
    )  # fmt: skip


def wedge_friction(rng: Generator, u: float) -> Draw:
    """A worn coupling whose friction grows with the articulation."""
    size = log_between(500.0, 2e4, u)
    return _draw("wedge_friction", size, "hitch", "articulation articulation_rate")


def command_steering(rng: Generator, u: float) -> Draw:
    """Axles of the trailer that are steered by the yaw rate of the car."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.002, 0.1, u)
    return _draw("command_steering", size, "slip_trailer", "yaw_rate_car")


def roll_hysteresis(rng: Generator, u: float) -> Draw:
    """Trailer axles that are steered by roll, through worn bushes with dry friction."""
    at = round(float(rng.uniform(0.002, 0.015)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.03, 1.0, u)
    return _draw("roll_hysteresis", size, "slip_trailer", "roll_trailer", more_at=at)


def hedge_wind(rng: Generator, u: float) -> Draw:
    """A side wind through the gaps of a hedge: it comes and goes along the road."""
    at = round(float(rng.uniform(40.0, 160.0)), 1)
    size = log_between(20.0, 1000.0, u)
    return _draw("hedge_wind", size, "force_trailer", "distance", more_at=at)


def caster_axle(rng: Generator, u: float) -> Draw:
    """A self-steering axle of the trailer: its wheels turn after their slip, held by a damper."""
    at = round(float(rng.uniform(0.1, 0.8)), 3)
    size = log_between(0.1, 0.7, u)
    variables = "slip_trailer sideslip_trailer"
    return _draw("caster_axle", size, "slip_trailer force_trailer", variables, more_at=at)


def tyre_warming(rng: Generator, u: float) -> Draw:
    """Treads of the trailer's tyres that soften as they are worked, and recover."""
    at = round(float(rng.uniform(1.0, 5.0)), 2)
    size = log_between(0.05, 0.6, u)
    variables = "slip_trailer sideslip_trailer"
    return _draw("tyre_warming", size, "slip_trailer force_trailer", variables, more_at=at)


def rear_bush_play(rng: Generator, u: float) -> Draw:
    """Worn bushes of the car's rear axle: its wheels give way to a side force, up to a stop."""
    gain = float(rng.uniform(0.3, 0.8))
    size = log_between(2e-4, 1e-2, u)
    at = round(size / gain, 6)
    return _draw("rear_bush_play", size, "slip_car_rear", "slip_car_rear", more_at=at)


def bump_stop_steer(rng: Generator, u: float) -> Draw:
    """Rear axle of a car that the nose load has lowered: it steers once a bump stop is touched.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.002, 0.012)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.05, 0.6, u)
    variables = "roll_car lateral_acceleration_car"
    return _draw("bump_stop_steer", size, "slip_car_rear", variables, more_at=at)


def bent_rim(rng: Generator, u: float) -> Draw:
    """One rear wheel of the car wobbles as it turns."""
    return _draw("bent_rim", log_between(0.004, 0.03, u), "slip_car_rear", "distance")


def cam_centring(rng: Generator, u: float) -> Draw:
    """Cams at the drawbar that hold it straight, no more than so strongly."""
    at = round(float(rng.uniform(0.005, 0.03)), 4)
    return _draw("cam_centring", log_between(60.0, 3000.0, u), "hitch", "articulation", more_at=at)


def stabiliser_windup(rng: Generator, u: float) -> Draw:
    """Friction pads at the ball whose arm gives way before they slide."""
    at = round(float(rng.uniform(0.004, 0.03)), 4)
    variables = "articulation articulation_rate"
    return _draw("stabiliser_windup", log_between(60.0, 800.0, u), "hitch", variables, more_at=at)


def sliding_crate(rng: Generator, u: float) -> Draw:
    """A crate on the trailer's floor that slides where friction does not hold it."""
    at = round(float(rng.uniform(0.5, 2.0)), 3)
    mass = round(log_between(20.0, 400.0, u), 2)
    variables = "swing lateral_acceleration_trailer"
    return _draw(
        "sliding_crate", mass, "trailer force_trailer", variables, more_at=at, slosh_mass_kg=mass,
        slosh_damping=0.0,
    )  # fmt: skip


def padded_load(rng: Generator, u: float) -> Draw:
    """A horse, or a boat, between pads that stiffen the more they are pressed."""
    at = round(float(rng.uniform(0.05, 0.2)), 3)
    hz = round(float(rng.uniform(0.5, 1.2)), 3)
    mass = round(log_between(60.0, 500.0, u), 2)
    return _draw(
        "padded_load", mass, "trailer force_trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=hz, slosh_damping=round(float(rng.uniform(0.15, 0.4)), 3),
    )  # fmt: skip


def pump_catch(rng: Generator, u: float) -> Draw:
    """A worn power steering pump: the front wheels stay behind when steered quickly."""
    at = round(float(rng.uniform(0.005, 0.03)), 4)
    size = log_between(0.02, 0.2, u)
    return _draw("pump_catch", size, "slip_car_front", "steer_rate steer", more_at=at)


def torque_vectoring(rng: Generator, u: float) -> Draw:
    """A rear differential that drives the outer wheel as the driver steers, as far as it can."""
    at = round(float(rng.uniform(0.005, 0.03)), 4)
    size = log_between(100.0, 2500.0, u)
    return _draw("torque_vectoring", size, "moment_car", "steer", more_at=at)


def sway_brake(rng: Generator, u: float) -> Draw:
    """Trailer brakes, both sides alike, that a lateral acceleration of the trailer applies.

    The force acts along the trailer; across it nothing acts but the pull of the hitch.
    """
    at = round(float(rng.uniform(0.5, 1.5)), 3)
    variables = "lateral_acceleration_trailer roll_trailer"
    size = log_between(150.0, 3500.0, u)
    return _draw("sway_brake", size, "drag_trailer", variables, more_at=at)


def wake_shedding(rng: Generator, u: float) -> Draw:
    """Eddies shed in turn from both sides of the trailer's rear: a swing that sustains itself."""
    at = round(float(rng.uniform(8.0, 16.0)), 2)
    size = log_between(0.2, 2.0, u)
    places, variables = "force_trailer moment_trailer trailer", "swing distance"
    drawn = _draw("wake_shedding", size, places, variables, more_at=at)
    return replace(drawn, restless=True)


def car_wake(rng: Generator, u: float) -> Draw:
    """The car's wake, which its side-slip moves across the trailer's front."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(6.0, 80.0, u)
    return _draw("car_wake", size, "force_trailer moment_trailer", "sideslip_car")


def grooved_road(rng: Generator, u: float) -> Draw:
    """Grooves along the road, which all tyres follow as long as they cross them slowly."""
    at = round(float(rng.uniform(0.02, 0.08)), 4)
    places = "slip_car_front slip_car_rear slip_trailer"
    variables = "heading heading_car heading_trailer"
    return _draw("grooved_road", log_between(0.005, 0.3, u), places, variables, more_at=at)


def gyro_stabiliser(rng: Generator, u: float) -> Draw:
    """A gyroscope in the trailer on a damped gimbal: a moment against turns that do not last."""
    at = round(float(rng.uniform(0.15, 1.0)), 3)
    size = log_between(2e3, 3e4, u)
    return _draw("gyro_stabiliser", size, "moment_trailer", "yaw_rate_trailer", more_at=at)


def wire_steering(rng: Generator, u: float) -> Draw:
    """Axles of a trailer that are steered by hydraulics after the car's front wheels, late."""
    at = round(float(rng.uniform(0.15, 0.6)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.3, 1.5, u)
    return _draw("wire_steering", size, "slip_trailer", "steer", more_at=at)


def brake_cable(rng: Generator, u: float) -> Draw:
    """A brake cable that is too short: the right wheels drag as the drawbar turns to one side."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(1500.0, 4e4, u)
    return _draw("brake_cable", size, "moment_trailer drag_trailer", "articulation")


def rubber_coupling(rng: Generator, u: float) -> Draw:
    """A coupling in rubber and oil: it resists a turn, and gives way to one that lasts."""
    at = round(float(rng.uniform(0.15, 1.0)), 3)
    size = log_between(2e3, 3e4, u)
    variables = "articulation articulation_rate"
    return _draw("rubber_coupling", size, "hitch", variables, more_at=at)


def tow_mode(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that are steered with the articulation, as far as they can."""
    at = round(float(rng.uniform(0.008, 0.04)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.01, 0.3, u)
    return _draw("tow_mode", size, "slip_car_rear", "articulation", more_at=at)


def corner_steady(rng: Generator, u: float) -> Draw:
    """A corner steady that has come loose: it drags on the road as the trailer leans to its side.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.003, 0.012)), 4)
    variables = "roll_trailer lateral_acceleration_trailer"
    size = log_between(3e3, 1e5, u)
    return _draw("corner_steady", size, "moment_trailer drag_trailer", variables, more_at=at)


def two_tanks(rng: Generator, u: float) -> Draw:
    """Liquid in two tanks, one ahead of the axles and one behind, not equally full."""
    ahead = round(float(rng.uniform(0.5, 0.9)), 3)
    behind = round(ahead * float(rng.uniform(1.3, 2.0)), 3)
    mass = round(log_between(20.0, 400.0, u), 2)
    return _draw(
        "two_tanks", mass, "trailer", "swing", more_frequency_hz=behind, slosh_mass_kg=mass,
        slosh_frequency_hz=ahead, slosh_position_m=1.2,
        slosh_damping=round(float(rng.uniform(0.02, 0.06)), 3),
    )  # fmt: skip


def wishbone_bush(rng: Generator, u: float) -> Draw:
    """A torn bush of a front wishbone: the wheels give way to a side force beyond its preload."""
    at = round(float(rng.uniform(0.001, 0.006)), 4)
    size = log_between(0.08, 0.6, u)
    return _draw("wishbone_bush", size, "slip_car_front", "slip_car_front", more_at=at)


def bow_wave(rng: Generator, u: float) -> Draw:
    """Air that a tall trailer holds up before it presses on the car's tail as it turns."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(1.5, 30.0, u)
    return _draw("bow_wave", size, "force_car moment_car", "articulation")


def elastic_drawbar(rng: Generator, u: float) -> Draw:
    """A drawbar that is cracked at its root gives way sideways to the force at the ball."""
    return _draw("elastic_drawbar", log_between(5e5, 2.5e4, u), "hitch", "side_force")


def sway_assist(rng: Generator, u: float) -> Draw:
    """A stability controller of the car that brakes its sides in turn once a swing has grown."""
    at = round(float(rng.uniform(0.004, 0.015)), 4)
    size = log_between(1.2e3, 2e4, u)
    return _draw("sway_assist", size, "moment_car", "yaw_rate_car", more_at=at)


def late_air(rng: Generator, u: float) -> Draw:
    """Air on a long body: the flow beside it needs some metres to follow the side-slip."""
    at = round(float(rng.uniform(4.0, 16.0)), 2)
    places = "force_trailer moment_trailer"
    return _draw("late_air", log_between(2.0, 60.0, u), places, "sideslip_trailer", more_at=at)


def loose_u_bolts(rng: Generator, u: float) -> Draw:
    """Loose bolts of the trailer's leaf springs: axles turn in their seats, with dry friction."""
    at = round(float(rng.uniform(0.002, 0.015)), 4)
    size = log_between(0.03, 0.6, u)
    places, variables = "slip_trailer force_trailer", "slip_trailer sideslip_trailer"
    return _draw("loose_u_bolts", size, places, variables, more_at=at)


def puncture(rng: Generator, u: float) -> Draw:
    """Tyres on the trailer's left that lose their air, and with it stiffness, along the road."""
    at = round(float(rng.uniform(60.0, 300.0)), 1)
    places = "slip_trailer force_trailer"
    variables = "slip_trailer sideslip_trailer distance"
    return _draw("puncture", log_between(0.1, 0.8, u), places, variables, more_at=at)


def binding_brake(rng: Generator, u: float) -> Draw:
    """Brakes on the trailer's right that bind, and the more so the hotter they become."""
    at = round(float(rng.uniform(80.0, 400.0)), 1)
    size = log_between(200.0, 3000.0, u)
    return _draw("binding_brake", size, "moment_trailer drag_trailer", "distance", more_at=at)


def glazing_pads(rng: Generator, u: float) -> Draw:
    """Pads of a stabiliser at the ball that glaze as they rub: their friction fades."""
    at = round(float(rng.uniform(0.05, 0.3)), 3)
    return _draw("glazing_pads", log_between(100.0, 1200.0, u), "hitch", "articulation_rate",
                 more_at=at)  # fmt: skip


def one_way_damper(rng: Generator, u: float) -> Draw:
    """A damper strut beside the drawbar with a failed valve: it resists one way only."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(1e3, 2e4, u)
    return _draw("one_way_damper", size, "hitch", "articulation_rate")


def unlocked_slew(rng: Generator, u: float) -> Draw:
    """A small excavator whose upper part is not locked: only friction takes it along in yaw."""
    at = round(float(rng.uniform(40.0, 200.0)), 1)
    size = log_between(250.0, 1100.0, u)
    variables = "swing yaw_rate_trailer"
    return _draw("unlocked_slew", size, "trailer moment_trailer", variables, more_at=at)


def wandering_ruts(rng: Generator, u: float) -> Draw:
    """Ruts that wander from side to side along the road, and lead each axle as it comes there."""
    at = round(float(rng.uniform(25.0, 70.0)), 1)
    places = "slip_car_front slip_car_rear slip_trailer"
    size = log_between(1.5e-3, 5e-3, u)
    drawn = _draw("wandering_ruts", size, places, "distance", more_at=at)
    return replace(drawn, restless=True)


def yaw_reference(rng: Generator, u: float) -> Draw:
    """A stability controller that brakes a side of a car which turns other than it is steered."""
    at = round(float(rng.uniform(0.005, 0.02)), 4)
    size = log_between(2e3, 3e4, u)
    return _draw("yaw_reference", size, "moment_car", "yaw_rate_car steer", more_at=at)


def stepping_horse(rng: Generator, u: float) -> Draw:
    """Horses that step against each sway to keep their feet, too late."""
    at = round(float(rng.uniform(0.2, 0.8)), 3)
    mass = round(log_between(80.0, 500.0, u), 2)
    return _draw(
        "stepping_horse", mass, "trailer force_trailer", "swing lateral_acceleration_trailer",
        more_at=at, slosh_mass_kg=mass, slosh_frequency_hz=round(float(rng.uniform(0.7, 1.3)), 3),
        slosh_damping=round(float(rng.uniform(0.2, 0.4)), 3),
    )  # fmt: skip


def hydro_bush(rng: Generator, u: float) -> Draw:
    """A front subframe in bushes filled with oil: they yield to a side force only if it lasts."""
    at = round(float(rng.uniform(0.1, 0.5)), 3)
    size = log_between(0.1, 0.7, u)
    return _draw("hydro_bush", size, "slip_car_front", "slip_car_front", more_at=at)


def loose_curtain(rng: Generator, u: float) -> Draw:
    """A curtain of a trailer that is open on one side: air from there fills it, else it is flat."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(10.0, 80.0, u)
    return _draw("loose_curtain", size, "force_trailer moment_trailer", "sideslip_trailer")


def damper_play(rng: Generator, u: float) -> Draw:
    """A damper strut beside the drawbar in worn eyes: it resists once their play is used up."""
    at = round(float(rng.uniform(0.002, 0.012)), 4)
    variables = "articulation articulation_rate"
    return _draw("damper_play", log_between(1e3, 2e4, u), "hitch", variables, more_at=at)


def towbar_twist(rng: Generator, u: float) -> Draw:
    """A tow bar that twists the car's rear subframe: its wheels steer with the pull of the ball."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(5e-7, 8e-6, u)
    return _draw("towbar_twist", size, "slip_car_rear", "side_force")


def galloping(rng: Generator, u: float) -> Draw:
    """Air on a body with sharp edges: it drives a small side-slip, and resists a larger one."""
    at = round(float(rng.uniform(0.01, 0.04)), 4)
    return _draw("galloping", log_between(8.0, 120.0, u), "force_trailer", "sideslip_trailer",
                 more_at=at)  # fmt: skip


def rear_rack(rng: Generator, u: float) -> Draw:
    """Bicycles at the car's tail on a rack that is loose in its clamps: dry friction, then sway."""
    at = round(float(rng.uniform(0.02, 0.1)), 3)
    hz = round(float(rng.uniform(0.8, 2.0)), 3)
    size = round(log_between(30.0, 150.0, u), 2)
    return _draw(
        "rear_rack", size, "car force_car moment_car", "swing", more_at=at, more_frequency_hz=hz
    )


def slow_actuator(rng: Generator, u: float) -> Draw:
    """Trailer axles that are steered by its yaw rate, no faster than their actuator can."""
    at = round(float(rng.uniform(0.05, 0.3)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.003, 0.15, u)
    return _draw("slow_actuator", size, "slip_trailer", "yaw_rate_trailer", more_at=at)


def sideslip_limiter(rng: Generator, u: float) -> Draw:
    """A stability controller that brakes a side of a car which slips sideways by too much."""
    at = round(float(rng.uniform(0.003, 0.01)), 4)
    size = log_between(2e4, 6e5, u)
    return _draw("sideslip_limiter", size, "moment_car", "sideslip_car", more_at=at)


def jockey_wheel(rng: Generator, u: float) -> Draw:
    """A jockey wheel that was left down, seized in its swivel: it scrubs sideways at the nose."""
    at = round(float(rng.uniform(0.01, 0.05)), 4)
    places, variables = "force_trailer moment_trailer", "sideslip_trailer yaw_rate_trailer"
    return _draw("jockey_wheel", log_between(100.0, 3000.0, u), places, variables, more_at=at)


def counter_steer(rng: Generator, u: float) -> Draw:
    """Power steering that answers the trailer's yaw rate, as far as it may."""
    at = round(float(rng.uniform(0.02, 0.08)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.008, 0.2, u)
    return _draw("counter_steer", size, "slip_car_front", "yaw_rate_trailer", more_at=at)


def concrete_slabs(rng: Generator, u: float) -> Draw:
    """A road of slabs that lie hollow: the trailer's tyres grip more and less along each."""
    at = round(float(rng.uniform(8.0, 30.0)), 1)
    places = "slip_trailer force_trailer"
    variables = "slip_trailer sideslip_trailer distance"
    return _draw("concrete_slabs", log_between(0.2, 0.8, u), places, variables, more_at=at)


def leaking_load(rng: Generator, u: float) -> Draw:
    """Gravel or water that a trailer loses along the road.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(80.0, 400.0)), 1)
    places = "trailer force_trailer"
    variables = "lateral_acceleration_trailer roll_trailer distance"
    return _draw("leaking_load", log_between(0.12, 0.6, u), places, variables, more_at=at)


def worn_shoulders(rng: Generator, u: float) -> Draw:
    """The car's rear tyres are worn on one shoulder: they hold better one way than the other."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.1, 0.7, u)
    return _draw("worn_shoulders", size, "slip_car_rear", "slip_car_rear")


def aligning_torque(rng: Generator, u: float) -> Draw:
    """Wide trailer tyres that turn the trailer after their slip, until their tread slides."""
    at = round(float(rng.uniform(0.006, 0.015)), 4)
    variables = "slip_trailer sideslip_trailer"
    return _draw("aligning_torque", log_between(3e4, 4e5, u), "moment_trailer", variables,
                 more_at=at)  # fmt: skip


def binding_ball(rng: Generator, u: float) -> Draw:
    """A coupling without grease: its dry friction grows with the side force that presses it."""
    variables = "articulation_rate side_force"
    return _draw("binding_ball", log_between(0.03, 0.4, u), "hitch", variables)


def ball_rattle(rng: Generator, u: float) -> Draw:
    """A worn coupling head in which the ball moves freely sideways before it is held."""
    return _draw("ball_rattle", log_between(8e-4, 9e-3, u), "hitch", "side_force")


def spring_bars(rng: Generator, u: float) -> Draw:
    """Bars of a weight-distributing hitch: the one that a lean tightens pulls the drawbar round.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.001, 0.005)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(3e3, 1e5, u)
    variables = "roll_trailer lateral_acceleration_trailer"
    return _draw("spring_bars", size, "hitch", variables, more_at=at)


def slack_lashing(rng: Generator, u: float) -> Draw:
    """A load that is lashed on one side: straps hold it one way, other goods softly the other."""
    at = float(rng.choice((-1.0, 1.0))) * round(float(rng.uniform(0.1, 0.4)), 3)
    mass = round(log_between(40.0, 500.0, u), 2)
    return _draw(
        "slack_lashing", mass, "trailer force_trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=round(float(rng.uniform(0.9, 1.8)), 3),
        slosh_damping=round(float(rng.uniform(0.08, 0.2)), 3),
    )  # fmt: skip


def lingering_flow(rng: Generator, u: float) -> Draw:
    """Air that has left the edge of a wall comes back later than it left: the force stays behind.

    It does so at any speed of the change, as dry friction does.
    """
    at = round(float(rng.uniform(0.004, 0.02)), 4)
    places = "force_trailer moment_trailer"
    return _draw("lingering_flow", log_between(8.0, 120.0, u), places, "sideslip_trailer",
                 more_at=at)  # fmt: skip


def torn_cable(rng: Generator, u: float) -> Draw:
    """Trailer brakes that sway applies, one of whose cables is torn: only the right wheels drag.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.2, 0.8)), 3)
    variables = "lateral_acceleration_trailer roll_trailer"
    size = log_between(20.0, 400.0, u)
    return _draw("torn_cable", size, "moment_trailer drag_trailer", variables, more_at=at)


def hub_drives(rng: Generator, u: float) -> Draw:
    """Hub motors of an electric trailer turn it as the car is steered, told so by a slow bus."""
    at = round(float(rng.uniform(0.1, 0.4)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(1.2e4, 4e5, u)
    return _draw("hub_drives", size, "moment_trailer", "steer", more_at=at)


def angle_vectoring(rng: Generator, u: float) -> Draw:
    """Two rear motors of an electric car turn it by the trailer's angle, as far as they can."""
    at = round(float(rng.uniform(0.006, 0.03)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(60.0, 2000.0, u)
    return _draw("angle_vectoring", size, "moment_car", "articulation", more_at=at)


def levelling_pump(rng: Generator, u: float) -> Draw:
    """Air springs of the car's rear axle whose leaking valves answer a lean late: wheels steer.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.15, 0.8)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.05, 1.0, u)
    variables = "roll_car lateral_acceleration_car"
    return _draw("levelling_pump", size, "slip_car_rear", variables, more_at=at)


def clay_tread(rng: Generator, u: float) -> Draw:
    """Clay of a field in the tread of the car's front tyres, which they throw off on the road."""
    at = round(float(rng.uniform(150.0, 500.0)), 1)
    variables = "slip_car_front distance"
    return _draw("clay_tread", log_between(0.1, 0.7, u), "slip_car_front", variables, more_at=at)


def racked_frame(rng: Generator, u: float) -> Draw:
    """Loose bolts of a frame: the pull of the ball racks it, and the axles with it, to a stop."""
    at = round(float(rng.uniform(300.0, 1500.0)), 1)
    size = float(rng.choice((-1.0, 1.0))) * log_between(1e-3, 1.2e-2, u)
    return _draw("racked_frame", size, "slip_trailer", "side_force", more_at=at)


def caster_flutter(rng: Generator, u: float) -> Draw:
    """A self-steering axle of the trailer without its damper: it swings after its slip."""
    hz = round(float(rng.uniform(0.9, 2.5)), 3)
    places, variables = "slip_trailer force_trailer", "slip_trailer sideslip_trailer swing"
    size = log_between(0.02, 0.4, u)
    return _draw("caster_flutter", size, places, variables, more_frequency_hz=hz)


def squealing_pads(rng: Generator, u: float) -> Draw:
    """Damp pads at the ball: their friction is largest at a creep, less as they slide faster."""
    at = round(float(rng.uniform(0.015, 0.06)), 4)
    size = log_between(120.0, 1500.0, u)
    return _draw("squealing_pads", size, "hitch", "articulation_rate", more_at=at)


def outward_damper(rng: Generator, u: float) -> Draw:
    """A damper at the drawbar that resists away from straight and lets it come back freely.

    The articulation says which way that is.
    """
    at = round(float(rng.uniform(0.001, 0.004)), 5)
    variables = "articulation articulation_rate"
    return _draw("outward_damper", log_between(800.0, 2e4, u), "hitch", variables, more_at=at)


def seized_top_mount(rng: Generator, u: float) -> Draw:
    """A strut's upper bearing that has seized: it holds the front wheels back until it slides."""
    at = round(float(rng.uniform(0.003, 0.01)), 5)
    size = log_between(0.15, 0.9, u)
    return _draw("seized_top_mount", size, "slip_car_front", "steer steer_rate", more_at=at)


def crosswind_assist(rng: Generator, u: float) -> Draw:
    """Steering that answers the car's lateral acceleration, no faster than its motor can.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(1.2, 3.5)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(1.6e-3, 5e-3, u)
    variables = "lateral_acceleration_car roll_car"
    return _draw("crosswind_assist", size, "slip_car_front", variables, more_at=at)


def link_steering(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that are steered by the trailer's yaw rate, through a worn rack."""
    at = round(float(rng.uniform(0.008, 0.04)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.003, 0.05, u)
    return _draw("link_steering", size, "slip_car_rear", "yaw_rate_trailer", more_at=at)


def broken_leaf(rng: Generator, u: float) -> Draw:
    """A main leaf that is broken on one side: the trailer's axle swings there under a lean.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.06, 0.8, u)
    variables = "roll_trailer lateral_acceleration_trailer"
    return _draw("broken_leaf", size, "slip_trailer", variables)


def snow_tracks(rng: Generator, u: float) -> Draw:
    """Trailer tyres that grip in the tracks of the car, and less in the slush beside them."""
    at = round(float(rng.uniform(0.006, 0.02)), 4)
    places = "slip_trailer force_trailer"
    variables = "slip_trailer sideslip_trailer articulation"
    return _draw("snow_tracks", log_between(0.15, 0.55, u), places, variables, more_at=at)


def hunting_vectoring(rng: Generator, u: float) -> Draw:
    """Rear motors of an electric car whose controller rings as it answers the articulation rate."""
    hz = round(float(rng.uniform(0.9, 2.5)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(700.0, 6e3, u)
    variables = "articulation_rate swing"
    return _draw("hunting_vectoring", size, "moment_car", variables, more_frequency_hz=hz)


def roof_tent(rng: Generator, u: float) -> Draw:
    """The cover of a roof tent: slack up to some side-slip of the car, then a sail."""
    at = round(float(rng.uniform(0.001, 0.004)), 5)
    size = log_between(20.0, 200.0, u)
    return _draw("roof_tent", size, "force_car moment_car", "sideslip_car", more_at=at)


def tearing_canvas(rng: Generator, u: float) -> Draw:
    """A cover that tears loose along the road and catches more and more air."""
    at = round(float(rng.uniform(100.0, 400.0)), 1)
    places, variables = "force_trailer moment_trailer", "sideslip_trailer distance"
    return _draw("tearing_canvas", log_between(15.0, 150.0, u), places, variables, more_at=at)


def cocked_overrun(rng: Generator, u: float) -> Draw:
    """A worn overrun shaft that a side force at the ball cocks: one way it pulls a brake rod."""
    at = round(float(rng.uniform(50.0, 250.0)), 1)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.4, 1.8, u)
    return _draw("cocked_overrun", size, "moment_trailer drag_trailer", "side_force", more_at=at)


def loosening_straps(rng: Generator, u: float) -> Draw:
    """Straps that work loose along the road: they hold the load ever more softly."""
    at = round(float(rng.uniform(100.0, 300.0)), 1)
    mass = round(log_between(200.0, 500.0, u), 2)
    return _draw(
        "loosening_straps", mass, "trailer force_trailer", "swing distance", more_at=at,
        slosh_mass_kg=mass, slosh_frequency_hz=round(float(rng.uniform(0.9, 1.5)), 3),
        slosh_damping=round(float(rng.uniform(0.03, 0.07)), 3),
    )  # fmt: skip


BUILD = (jackknife_stop, trailer_axle_steers, car_air, tow_assist, roof_load, axle_hysteresis)
OPENED_ONCE = (
    tarpaulin, heading_wind, trailer_brakes, hydraulic_hitch, rear_wheel_steering, tandem_scrub,
)  # fmt: skip
SECOND = (gap_air, trailer_hubs, variable_ratio, late_assist, car_brakes, turning_load)
THIRD = (
    air_damping, rolling_load, locked_axle, lane_assist, bearing_play, rear_axle_control,
)  # fmt: skip
FOURTH = (
    driver_arms, baffled_liquid, wedge_friction, command_steering, roll_hysteresis, hedge_wind,
)  # fmt: skip
FIFTH = (
    caster_axle, cam_centring, torque_vectoring, wake_shedding, sliding_crate, bump_stop_steer,
    grooved_road, stabiliser_windup, pump_catch, tyre_warming, car_wake, sway_brake, rear_bush_play,
    padded_load, gyro_stabiliser, bent_rim,
)  # fmt: skip
SIXTH = (
    wire_steering, brake_cable, rubber_coupling, tow_mode, corner_steady, two_tanks, wishbone_bush,
    bow_wave, elastic_drawbar, sway_assist, late_air, loose_u_bolts,
)  # fmt: skip
SEVENTH = (
    puncture, one_way_damper, unlocked_slew, yaw_reference, loose_curtain, stepping_horse,
    binding_brake, hydro_bush, glazing_pads, wandering_ruts,
)  # fmt: skip
EIGHTH = (
    damper_play, towbar_twist, galloping, rear_rack, slow_actuator, sideslip_limiter, jockey_wheel,
    counter_steer, concrete_slabs, leaking_load, worn_shoulders, aligning_torque,
)  # fmt: skip
NINTH = (
    binding_ball, hub_drives, levelling_pump, slack_lashing, ball_rattle, lingering_flow,
    angle_vectoring, clay_tread, torn_cable, racked_frame, spring_bars, caster_flutter,
)  # fmt: skip
TENTH = (
    snow_tracks, crosswind_assist, cocked_overrun, squealing_pads, tearing_canvas, link_steering,
    hunting_vectoring, loosening_straps, seized_top_mount, broken_leaf, outward_damper, roof_tent,
)  # fmt: skip
SETS = {
    "build": BUILD, "opened-once": OPENED_ONCE, "opened-second": SECOND, "opened-third": THIRD,
    "opened-fourth": FOURTH, "opened-fifth": FIFTH, "opened-sixth": SIXTH,
    "opened-seventh": SEVENTH, "opened-eighth": EIGHTH, "opened-ninth": NINTH,
    "opened-tenth": TENTH,
}  # fmt: skip


def draw(which: str, rng: Generator, index: int) -> Draw:
    """One of a set, in turn; strong enough to be worth looking for."""
    strength = float(rng.uniform(0.4, 1.0))
    drawn: Draw = SETS[which][index % len(SETS[which])](rng, strength)
    drawn.strength = strength
    return drawn
