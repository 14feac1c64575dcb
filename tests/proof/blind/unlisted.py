"""170 kinds of physics that no library lists: six to build on, the rest to open once.

Written down before the discovery was tried on any of them (the third and the fourth six on
2026-11-23, the fifth six on 2026-11-24, each after the six before had been opened and learnt from;
the next sixteen on 2026-11-26 by someone who had not seen how laws are searched for, the next
twelve the same day by someone who knew of the search what DESIGN.md and CHANGELOG.md say, the next
ten on 2026-11-27 from what happens to trailers on the road, by someone who had seen of the search
some lines of DESIGN.md and CHANGELOG.md and the package's plant, `plant_law.h`; the next twelve the
same day, from the same, by someone who had seen of the search nothing but the words of places and
variables and the titles of changes to it; three times twelve more that day in the same way; on
2026-11-28 the ten that people who build or mend trailers would name first, by someone who had seen
of the search nothing but the words of places and variables; and the same day ten more of what they,
or those who look into accidents, would name, by someone who had seen of it these words, the titles
of the last five changes and the library of effects; and ten of what an engineer who has towed for
thirty years would expect first, by someone who had seen of it these words; and on 2026-11-29 twelve
of what is common on the road, by someone who had seen of it nothing but these words, and twelve of
what a chassis engineer meets, with all kinds before in view, by someone who had seen of it these
words and some titles of changes).
Kinds from the eighth set on are in `unlisted_newer.py`.
A kind counts as found where a law is claimed at one of its places and of one of its variables
(`answer["places"]`, `["variables"]`, in the words of `discovered` in a diagnosis.json): in a swing
two variables in phase are one. Values of the file are exact and all sensors there: within
tolerances many of these are no more than a value.
"""

from __future__ import annotations

from dataclasses import replace

from effects import Draw, log_between
from numpy.random import Generator
from unlisted_kind import named
from unlisted_newer import (
    EIGHTH,
    ELEVENTH,
    FIFTEENTH,
    FOURTEENTH,
    NINTH,
    SIXTEENTH,
    TENTH,
    THIRTEENTH,
    TWELFTH,
)


def jackknife_stop(rng: Generator, u: float) -> Draw:
    """Rubber or bodywork that is touched beyond some degrees."""
    at = round(float(rng.uniform(0.01, 0.04)), 4)
    size = log_between(2e3, 2e5, u)
    return named("jackknife_stop", size, "hitch", "articulation", more_at=at)


def trailer_axle_steers(rng: Generator, u: float) -> Draw:
    """A trailer's axles that are steered by the drawbar, into the bend or out of it."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.005, 0.2, u)
    return named("trailer_axle_steers", size, "slip_trailer", "articulation")


def car_air(rng: Generator, u: float) -> Draw:
    """Air on the car's side."""
    return named("car_air", log_between(1.0, 30.0, u), "force_car moment_car", "sideslip_car")


def tow_assist(rng: Generator, u: float) -> Draw:
    """Power steering that answers the articulation rate."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.001, 0.04, u)
    return named("tow_assist", size, "slip_car_front", "articulation_rate")


def roof_load(rng: Generator, u: float) -> Draw:
    """A load on the roof that is not lashed."""
    hz = round(float(rng.uniform(0.8, 2.0)), 3)
    return named("roof_load", log_between(10.0, 150.0, u), "car", "swing", more_frequency_hz=hz)


def axle_hysteresis(rng: Generator, u: float) -> Draw:
    """Axles of the trailer that give way in worn bushes, with dry friction."""
    at = round(float(rng.uniform(0.005, 0.03)), 4)
    size = log_between(0.02, 0.6, u)
    variables = "articulation articulation_rate"
    return named("axle_hysteresis", size, "slip_trailer", variables, more_at=at)


def tarpaulin(rng: Generator, u: float) -> Draw:
    """Air on a tarpaulin that bulges with a swing of its own."""
    hz = round(float(rng.uniform(0.8, 2.0)), 3)
    return named(
        "tarpaulin", log_between(1.0, 30.0, u), "force_trailer moment_trailer trailer",
        "sideslip_trailer articulation yaw_rate_trailer swing", more_frequency_hz=hz,
    )  # fmt: skip


def heading_wind(rng: Generator, u: float) -> Draw:
    """A steady wind over an open road: its part across the trailer goes with the heading."""
    return named("heading_wind", log_between(300.0, 2e4, u), "force_trailer", "heading")


def trailer_brakes(rng: Generator, u: float) -> Draw:
    """A stability controller in the trailer that begins at a yaw rate."""
    at = round(float(rng.uniform(0.01, 0.06)), 4)
    size = log_between(300.0, 2e4, u)
    return named("trailer_brakes", size, "moment_trailer", "yaw_rate_trailer", more_at=at)


def hydraulic_hitch(rng: Generator, u: float) -> Draw:
    """A hydraulic damper at the drawbar: its moment goes with the square of the rate."""
    return named("hydraulic_hitch", log_between(300.0, 2e4, u), "hitch", "articulation_rate")


def rear_wheel_steering(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that are steered with the front ones."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.005, 0.2, u)
    return named("rear_wheel_steering", size, "slip_car_rear", "steer")


def tandem_scrub(rng: Generator, u: float) -> Draw:
    """Tyres of a tandem that scrub: a moment of nearly one size against each turn."""
    size = log_between(30.0, 1500.0, u)
    return named("tandem_scrub", size, "moment_trailer", "yaw_rate_trailer")


def gap_air(rng: Generator, u: float) -> Draw:
    """Air in the gap between the bodies: a side force on the trailer with the articulation."""
    return named("gap_air", log_between(1.0, 60.0, u), "force_trailer", "articulation")


def trailer_hubs(rng: Generator, u: float) -> Draw:
    """Driven hubs of the trailer that work against its swing, as strong as they can."""
    at = round(float(rng.uniform(0.01, 0.1)), 4)
    size = log_between(50.0, 2500.0, u)
    return named("trailer_hubs", size, "moment_trailer", "articulation_rate", more_at=at)


def variable_ratio(rng: Generator, u: float) -> Draw:
    """Steering that is more direct, or less, away from its middle."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.1, 6.0, u)
    return named("variable_ratio", size, "slip_car_front", "steer")


def late_assist(rng: Generator, u: float) -> Draw:
    """Steering assistance that answers the articulation late."""
    at = round(float(rng.uniform(0.1, 0.5)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.003, 0.15, u)
    variables = "articulation articulation_rate"
    return named("late_assist", size, "slip_car_front", variables, more_at=at)


def car_brakes(rng: Generator, u: float) -> Draw:
    """A controller of the car that brakes one side beyond an articulation rate."""
    at = round(float(rng.uniform(0.01, 0.06)), 4)
    size = log_between(300.0, 2e4, u)
    return named("car_brakes", size, "moment_car", "articulation_rate", more_at=at)


def turning_load(rng: Generator, u: float) -> Draw:
    """A load in the trailer that turns by itself: a boom, a boat on its cradle."""
    hz = round(float(rng.uniform(0.5, 1.5)), 3)
    size = log_between(20.0, 600.0, u)
    variables = "swing yaw_rate_trailer"
    return named("turning_load", size, "trailer moment_trailer", variables, more_frequency_hz=hz)


def air_damping(rng: Generator, u: float) -> Draw:
    """Air that slows a turn of the trailer: it goes with speed times yaw rate."""
    return named("air_damping", log_between(4.0, 300.0, u), "moment_trailer", "yaw_rate_trailer")


def rolling_load(rng: Generator, u: float) -> Draw:
    """A load that rolls between two boards, free in the middle."""
    at = round(float(rng.uniform(0.005, 0.05)), 4)
    hz = round(float(rng.uniform(0.8, 2.0)), 3)
    mass = round(log_between(15.0, 300.0, u), 2)
    return named(
        "rolling_load", mass, "trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=hz,
    )  # fmt: skip


def locked_axle(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that turn alike: a moment against bends, until one of them slips."""
    at = round(float(rng.uniform(5e-4, 5e-3)), 5)
    size = log_between(50.0, 2500.0, u)
    return named("locked_axle", size, "moment_car", "yaw_rate_car", more_at=at)


def lane_assist(rng: Generator, u: float) -> Draw:
    """Front wheels that are steered back to the road's heading beside the driver."""
    return named("lane_assist", log_between(0.005, 0.3, u), "slip_car_front", "heading heading_car")


def bearing_play(rng: Generator, u: float) -> Draw:
    """Worn wheel bearings of the trailer: its wheels turn a little with each side force."""
    size = log_between(2e-4, 1e-2, u)
    variables = "slip_trailer sideslip_trailer articulation yaw_rate_trailer"
    return named("bearing_play", size, "slip_trailer force_trailer", variables)


def rear_axle_control(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that are steered with its yaw rate, late."""
    at = round(float(rng.uniform(0.05, 0.3)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.002, 0.1, u)
    variables = "yaw_rate_car"
    return named("rear_axle_control", size, "slip_car_rear", variables, more_at=at)


def driver_arms(rng: Generator, u: float) -> Draw:
    """Arms and steering wheel that swing beside the angle sensor, driven by the car's yaw rate."""
    hz = round(float(rng.uniform(0.6, 2.0)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.002, 0.06, u)
    variables = "yaw_rate_car swing"
    return named("driver_arms", size, "slip_car_front", variables, more_frequency_hz=hz)


def baffled_liquid(rng: Generator, u: float) -> Draw:
    """A liquid between baffles: its damping grows with its own rate."""
    at = round(float(rng.uniform(0.05, 0.4)), 3)
    hz = round(float(rng.uniform(0.5, 1.4)), 3)
    mass = round(log_between(15.0, 400.0, u), 2)
    return named(
        "baffled_liquid", mass, "trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=hz, slosh_damping=0.01,
    )  # fmt: skip


def wedge_friction(rng: Generator, u: float) -> Draw:
    """A worn coupling whose friction grows with the articulation."""
    size = log_between(500.0, 2e4, u)
    return named("wedge_friction", size, "hitch", "articulation articulation_rate")


def command_steering(rng: Generator, u: float) -> Draw:
    """Axles of the trailer that are steered by the yaw rate of the car."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.002, 0.1, u)
    return named("command_steering", size, "slip_trailer", "yaw_rate_car")


def roll_hysteresis(rng: Generator, u: float) -> Draw:
    """Trailer axles that are steered by roll, through worn bushes with dry friction."""
    at = round(float(rng.uniform(0.002, 0.015)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.03, 1.0, u)
    return named("roll_hysteresis", size, "slip_trailer", "roll_trailer", more_at=at)


def hedge_wind(rng: Generator, u: float) -> Draw:
    """A side wind through the gaps of a hedge: it comes and goes along the road."""
    at = round(float(rng.uniform(40.0, 160.0)), 1)
    size = log_between(20.0, 1000.0, u)
    return named("hedge_wind", size, "force_trailer", "distance", more_at=at)


def caster_axle(rng: Generator, u: float) -> Draw:
    """A self-steering axle of the trailer: its wheels turn after their slip, held by a damper."""
    at = round(float(rng.uniform(0.1, 0.8)), 3)
    size = log_between(0.1, 0.7, u)
    variables = "slip_trailer sideslip_trailer"
    return named("caster_axle", size, "slip_trailer force_trailer", variables, more_at=at)


def tyre_warming(rng: Generator, u: float) -> Draw:
    """Treads of the trailer's tyres that soften as they are worked, and recover."""
    at = round(float(rng.uniform(1.0, 5.0)), 2)
    size = log_between(0.05, 0.6, u)
    variables = "slip_trailer sideslip_trailer"
    return named("tyre_warming", size, "slip_trailer force_trailer", variables, more_at=at)


def rear_bush_play(rng: Generator, u: float) -> Draw:
    """Worn bushes of the car's rear axle: its wheels give way to a side force, up to a stop."""
    gain = float(rng.uniform(0.3, 0.8))
    size = log_between(2e-4, 1e-2, u)
    at = round(size / gain, 6)
    return named("rear_bush_play", size, "slip_car_rear", "slip_car_rear", more_at=at)


def bump_stop_steer(rng: Generator, u: float) -> Draw:
    """Rear axle of a car that the nose load has lowered: it steers once a bump stop is touched.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.002, 0.012)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.05, 0.6, u)
    variables = "roll_car lateral_acceleration_car"
    return named("bump_stop_steer", size, "slip_car_rear", variables, more_at=at)


def bent_rim(rng: Generator, u: float) -> Draw:
    """One rear wheel of the car wobbles as it turns."""
    return named("bent_rim", log_between(0.004, 0.03, u), "slip_car_rear", "distance")


def cam_centring(rng: Generator, u: float) -> Draw:
    """Cams at the drawbar that hold it straight, no more than so strongly."""
    at = round(float(rng.uniform(0.005, 0.03)), 4)
    return named("cam_centring", log_between(60.0, 3000.0, u), "hitch", "articulation", more_at=at)


def stabiliser_windup(rng: Generator, u: float) -> Draw:
    """Friction pads at the ball whose arm gives way before they slide."""
    at = round(float(rng.uniform(0.004, 0.03)), 4)
    variables = "articulation articulation_rate"
    return named("stabiliser_windup", log_between(60.0, 800.0, u), "hitch", variables, more_at=at)


def sliding_crate(rng: Generator, u: float) -> Draw:
    """A crate on the trailer's floor that slides where friction does not hold it."""
    at = round(float(rng.uniform(0.5, 2.0)), 3)
    mass = round(log_between(20.0, 400.0, u), 2)
    variables = "swing lateral_acceleration_trailer"
    return named(
        "sliding_crate", mass, "trailer force_trailer", variables, more_at=at, slosh_mass_kg=mass,
        slosh_damping=0.0,
    )  # fmt: skip


def padded_load(rng: Generator, u: float) -> Draw:
    """A horse, or a boat, between pads that stiffen the more they are pressed."""
    at = round(float(rng.uniform(0.05, 0.2)), 3)
    hz = round(float(rng.uniform(0.5, 1.2)), 3)
    mass = round(log_between(60.0, 500.0, u), 2)
    return named(
        "padded_load", mass, "trailer force_trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=hz, slosh_damping=round(float(rng.uniform(0.15, 0.4)), 3),
    )  # fmt: skip


def pump_catch(rng: Generator, u: float) -> Draw:
    """A worn power steering pump: the front wheels stay behind when steered quickly."""
    at = round(float(rng.uniform(0.005, 0.03)), 4)
    size = log_between(0.02, 0.2, u)
    return named("pump_catch", size, "slip_car_front", "steer_rate steer", more_at=at)


def torque_vectoring(rng: Generator, u: float) -> Draw:
    """A rear differential that drives the outer wheel as the driver steers, as far as it can."""
    at = round(float(rng.uniform(0.005, 0.03)), 4)
    size = log_between(100.0, 2500.0, u)
    return named("torque_vectoring", size, "moment_car", "steer", more_at=at)


def sway_brake(rng: Generator, u: float) -> Draw:
    """Trailer brakes, both sides alike, that a lateral acceleration of the trailer applies.

    The force acts along the trailer; across it nothing acts but the pull of the hitch.
    """
    at = round(float(rng.uniform(0.5, 1.5)), 3)
    variables = "lateral_acceleration_trailer roll_trailer"
    size = log_between(150.0, 3500.0, u)
    return named("sway_brake", size, "drag_trailer", variables, more_at=at)


def wake_shedding(rng: Generator, u: float) -> Draw:
    """Eddies shed in turn from both sides of the trailer's rear: a swing that sustains itself."""
    at = round(float(rng.uniform(8.0, 16.0)), 2)
    size = log_between(0.2, 2.0, u)
    places, variables = "force_trailer moment_trailer trailer", "swing distance"
    drawn = named("wake_shedding", size, places, variables, more_at=at)
    return replace(drawn, restless=True)


def car_wake(rng: Generator, u: float) -> Draw:
    """The car's wake, which its side-slip moves across the trailer's front."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(6.0, 80.0, u)
    return named("car_wake", size, "force_trailer moment_trailer", "sideslip_car")


def grooved_road(rng: Generator, u: float) -> Draw:
    """Grooves along the road, which all tyres follow as long as they cross them slowly."""
    at = round(float(rng.uniform(0.02, 0.08)), 4)
    places = "slip_car_front slip_car_rear slip_trailer"
    variables = "heading heading_car heading_trailer"
    return named("grooved_road", log_between(0.005, 0.3, u), places, variables, more_at=at)


def gyro_stabiliser(rng: Generator, u: float) -> Draw:
    """A gyroscope in the trailer on a damped gimbal: a moment against turns that do not last."""
    at = round(float(rng.uniform(0.15, 1.0)), 3)
    size = log_between(2e3, 3e4, u)
    return named("gyro_stabiliser", size, "moment_trailer", "yaw_rate_trailer", more_at=at)


def wire_steering(rng: Generator, u: float) -> Draw:
    """Axles of a trailer that are steered by hydraulics after the car's front wheels, late."""
    at = round(float(rng.uniform(0.15, 0.6)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.3, 1.5, u)
    return named("wire_steering", size, "slip_trailer", "steer", more_at=at)


def brake_cable(rng: Generator, u: float) -> Draw:
    """A brake cable that is too short: the right wheels drag as the drawbar turns to one side."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(1500.0, 4e4, u)
    return named("brake_cable", size, "moment_trailer drag_trailer", "articulation")


def rubber_coupling(rng: Generator, u: float) -> Draw:
    """A coupling in rubber and oil: it resists a turn, and gives way to one that lasts."""
    at = round(float(rng.uniform(0.15, 1.0)), 3)
    size = log_between(2e3, 3e4, u)
    variables = "articulation articulation_rate"
    return named("rubber_coupling", size, "hitch", variables, more_at=at)


def tow_mode(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that are steered with the articulation, as far as they can."""
    at = round(float(rng.uniform(0.008, 0.04)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.01, 0.3, u)
    return named("tow_mode", size, "slip_car_rear", "articulation", more_at=at)


def corner_steady(rng: Generator, u: float) -> Draw:
    """A corner steady that has come loose: it drags on the road as the trailer leans to its side.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.003, 0.012)), 4)
    variables = "roll_trailer lateral_acceleration_trailer"
    size = log_between(3e3, 1e5, u)
    return named("corner_steady", size, "moment_trailer drag_trailer", variables, more_at=at)


def two_tanks(rng: Generator, u: float) -> Draw:
    """Liquid in two tanks, one ahead of the axles and one behind, not equally full."""
    ahead = round(float(rng.uniform(0.5, 0.9)), 3)
    behind = round(ahead * float(rng.uniform(1.3, 2.0)), 3)
    mass = round(log_between(20.0, 400.0, u), 2)
    return named(
        "two_tanks", mass, "trailer", "swing", more_frequency_hz=behind, slosh_mass_kg=mass,
        slosh_frequency_hz=ahead, slosh_position_m=1.2,
        slosh_damping=round(float(rng.uniform(0.02, 0.06)), 3),
    )  # fmt: skip


def wishbone_bush(rng: Generator, u: float) -> Draw:
    """A torn bush of a front wishbone: the wheels give way to a side force beyond its preload."""
    at = round(float(rng.uniform(0.001, 0.006)), 4)
    size = log_between(0.08, 0.6, u)
    return named("wishbone_bush", size, "slip_car_front", "slip_car_front", more_at=at)


def bow_wave(rng: Generator, u: float) -> Draw:
    """Air that a tall trailer holds up before it presses on the car's tail as it turns."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(1.5, 30.0, u)
    return named("bow_wave", size, "force_car moment_car", "articulation")


def elastic_drawbar(rng: Generator, u: float) -> Draw:
    """A drawbar that is cracked at its root gives way sideways to the force at the ball."""
    return named("elastic_drawbar", log_between(5e5, 2.5e4, u), "hitch", "side_force")


def sway_assist(rng: Generator, u: float) -> Draw:
    """A stability controller of the car that brakes its sides in turn once a swing has grown."""
    at = round(float(rng.uniform(0.004, 0.015)), 4)
    size = log_between(1.2e3, 2e4, u)
    return named("sway_assist", size, "moment_car", "yaw_rate_car", more_at=at)


def late_air(rng: Generator, u: float) -> Draw:
    """Air on a long body: the flow beside it needs some metres to follow the side-slip."""
    at = round(float(rng.uniform(4.0, 16.0)), 2)
    places = "force_trailer moment_trailer"
    return named("late_air", log_between(2.0, 60.0, u), places, "sideslip_trailer", more_at=at)


def loose_u_bolts(rng: Generator, u: float) -> Draw:
    """Loose bolts of the trailer's leaf springs: axles turn in their seats, with dry friction."""
    at = round(float(rng.uniform(0.002, 0.015)), 4)
    size = log_between(0.03, 0.6, u)
    places, variables = "slip_trailer force_trailer", "slip_trailer sideslip_trailer"
    return named("loose_u_bolts", size, places, variables, more_at=at)


def puncture(rng: Generator, u: float) -> Draw:
    """Tyres on the trailer's left that lose their air, and with it stiffness, along the road."""
    at = round(float(rng.uniform(60.0, 300.0)), 1)
    places = "slip_trailer force_trailer"
    variables = "slip_trailer sideslip_trailer distance"
    return named("puncture", log_between(0.1, 0.8, u), places, variables, more_at=at)


def binding_brake(rng: Generator, u: float) -> Draw:
    """Brakes on the trailer's right that bind, and the more so the hotter they become."""
    at = round(float(rng.uniform(80.0, 400.0)), 1)
    size = log_between(200.0, 3000.0, u)
    return named("binding_brake", size, "moment_trailer drag_trailer", "distance", more_at=at)


def glazing_pads(rng: Generator, u: float) -> Draw:
    """Pads of a stabiliser at the ball that glaze as they rub: their friction fades."""
    at = round(float(rng.uniform(0.05, 0.3)), 3)
    return named("glazing_pads", log_between(100.0, 1200.0, u), "hitch", "articulation_rate",
                 more_at=at)  # fmt: skip


def one_way_damper(rng: Generator, u: float) -> Draw:
    """A damper strut beside the drawbar with a failed valve: it resists one way only."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(1e3, 2e4, u)
    return named("one_way_damper", size, "hitch", "articulation_rate")


def unlocked_slew(rng: Generator, u: float) -> Draw:
    """A small excavator whose upper part is not locked: only friction takes it along in yaw."""
    at = round(float(rng.uniform(40.0, 200.0)), 1)
    size = log_between(250.0, 1100.0, u)
    variables = "swing yaw_rate_trailer"
    return named("unlocked_slew", size, "trailer moment_trailer", variables, more_at=at)


def wandering_ruts(rng: Generator, u: float) -> Draw:
    """Ruts that wander from side to side along the road, and lead each axle as it comes there."""
    at = round(float(rng.uniform(25.0, 70.0)), 1)
    places = "slip_car_front slip_car_rear slip_trailer"
    size = log_between(1.5e-3, 5e-3, u)
    drawn = named("wandering_ruts", size, places, "distance", more_at=at)
    return replace(drawn, restless=True)


def yaw_reference(rng: Generator, u: float) -> Draw:
    """A stability controller that brakes a side of a car which turns other than it is steered."""
    at = round(float(rng.uniform(0.005, 0.02)), 4)
    size = log_between(2e3, 3e4, u)
    return named("yaw_reference", size, "moment_car", "yaw_rate_car steer", more_at=at)


def stepping_horse(rng: Generator, u: float) -> Draw:
    """Horses that step against each sway to keep their feet, too late."""
    at = round(float(rng.uniform(0.2, 0.8)), 3)
    mass = round(log_between(80.0, 500.0, u), 2)
    return named(
        "stepping_horse", mass, "trailer force_trailer", "swing lateral_acceleration_trailer",
        more_at=at, slosh_mass_kg=mass, slosh_frequency_hz=round(float(rng.uniform(0.7, 1.3)), 3),
        slosh_damping=round(float(rng.uniform(0.2, 0.4)), 3),
    )  # fmt: skip


def hydro_bush(rng: Generator, u: float) -> Draw:
    """A front subframe in bushes filled with oil: they yield to a side force only if it lasts."""
    at = round(float(rng.uniform(0.1, 0.5)), 3)
    size = log_between(0.1, 0.7, u)
    return named("hydro_bush", size, "slip_car_front", "slip_car_front", more_at=at)


def loose_curtain(rng: Generator, u: float) -> Draw:
    """A curtain of a trailer that is open on one side: air from there fills it, else it is flat."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(10.0, 80.0, u)
    return named("loose_curtain", size, "force_trailer moment_trailer", "sideslip_trailer")


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
SETS = {
    "build": BUILD, "opened-once": OPENED_ONCE, "opened-second": SECOND, "opened-third": THIRD,
    "opened-fourth": FOURTH, "opened-fifth": FIFTH, "opened-sixth": SIXTH,
    "opened-seventh": SEVENTH, "opened-eighth": EIGHTH, "opened-ninth": NINTH,
    "opened-tenth": TENTH, "opened-eleventh": ELEVENTH, "opened-twelfth": TWELFTH,
    "opened-thirteenth": THIRTEENTH, "opened-fourteenth": FOURTEENTH,
    "opened-fifteenth": FIFTEENTH, "opened-sixteenth": SIXTEENTH,
}  # fmt: skip


def draw(which: str, rng: Generator, index: int) -> Draw:
    """One of a set, in turn; strong enough to be worth looking for."""
    strength = float(rng.uniform(0.4, 1.0))
    drawn: Draw = SETS[which][index % len(SETS[which])](rng, strength)
    drawn.strength = strength
    return drawn
