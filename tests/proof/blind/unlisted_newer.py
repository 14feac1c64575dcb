"""Kinds of physics that no library lists from the eighth set on; all sets are in `unlisted.py`."""

from __future__ import annotations

from dataclasses import replace

from effects import Draw, log_between
from numpy.random import Generator
from unlisted_kind import named


def damper_play(rng: Generator, u: float) -> Draw:
    """A damper strut beside the drawbar in worn eyes: it resists once their play is used up."""
    at = round(float(rng.uniform(0.002, 0.012)), 4)
    variables = "articulation articulation_rate"
    return named("damper_play", log_between(1e3, 2e4, u), "hitch", variables, more_at=at)


def towbar_twist(rng: Generator, u: float) -> Draw:
    """A tow bar that twists the car's rear subframe: its wheels steer with the pull of the ball."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(5e-7, 8e-6, u)
    return named("towbar_twist", size, "slip_car_rear", "side_force")


def galloping(rng: Generator, u: float) -> Draw:
    """Air on a body with sharp edges: it drives a small side-slip, and resists a larger one."""
    at = round(float(rng.uniform(0.01, 0.04)), 4)
    return named("galloping", log_between(8.0, 120.0, u), "force_trailer", "sideslip_trailer",
                 more_at=at)  # fmt: skip


def rear_rack(rng: Generator, u: float) -> Draw:
    """Bicycles at the car's tail on a rack that is loose in its clamps: dry friction, then sway."""
    at = round(float(rng.uniform(0.02, 0.1)), 3)
    hz = round(float(rng.uniform(0.8, 2.0)), 3)
    size = round(log_between(30.0, 150.0, u), 2)
    return named(
        "rear_rack", size, "car force_car moment_car", "swing", more_at=at, more_frequency_hz=hz
    )


def slow_actuator(rng: Generator, u: float) -> Draw:
    """Trailer axles that are steered by its yaw rate, no faster than their actuator can."""
    at = round(float(rng.uniform(0.05, 0.3)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.003, 0.15, u)
    return named("slow_actuator", size, "slip_trailer", "yaw_rate_trailer", more_at=at)


def sideslip_limiter(rng: Generator, u: float) -> Draw:
    """A stability controller that brakes a side of a car which slips sideways by too much."""
    at = round(float(rng.uniform(0.003, 0.01)), 4)
    size = log_between(2e4, 6e5, u)
    return named("sideslip_limiter", size, "moment_car", "sideslip_car", more_at=at)


def jockey_wheel(rng: Generator, u: float) -> Draw:
    """A jockey wheel that was left down, seized in its swivel: it scrubs sideways at the nose."""
    at = round(float(rng.uniform(0.01, 0.05)), 4)
    places, variables = "force_trailer moment_trailer", "sideslip_trailer yaw_rate_trailer"
    return named("jockey_wheel", log_between(100.0, 3000.0, u), places, variables, more_at=at)


def counter_steer(rng: Generator, u: float) -> Draw:
    """Power steering that answers the trailer's yaw rate, as far as it may."""
    at = round(float(rng.uniform(0.02, 0.08)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.008, 0.2, u)
    return named("counter_steer", size, "slip_car_front", "yaw_rate_trailer", more_at=at)


def concrete_slabs(rng: Generator, u: float) -> Draw:
    """A road of slabs that lie hollow: the trailer's tyres grip more and less along each."""
    at = round(float(rng.uniform(8.0, 30.0)), 1)
    places = "slip_trailer force_trailer"
    variables = "slip_trailer sideslip_trailer distance"
    return named("concrete_slabs", log_between(0.2, 0.8, u), places, variables, more_at=at)


def leaking_load(rng: Generator, u: float) -> Draw:
    """Gravel or water that a trailer loses along the road.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(80.0, 400.0)), 1)
    places = "trailer force_trailer"
    variables = "lateral_acceleration_trailer roll_trailer distance"
    return named("leaking_load", log_between(0.12, 0.6, u), places, variables, more_at=at)


def worn_shoulders(rng: Generator, u: float) -> Draw:
    """The car's rear tyres are worn on one shoulder: they hold better one way than the other."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.1, 0.7, u)
    return named("worn_shoulders", size, "slip_car_rear", "slip_car_rear")


def aligning_torque(rng: Generator, u: float) -> Draw:
    """Wide trailer tyres that turn the trailer after their slip, until their tread slides."""
    at = round(float(rng.uniform(0.006, 0.015)), 4)
    variables = "slip_trailer sideslip_trailer"
    return named("aligning_torque", log_between(3e4, 4e5, u), "moment_trailer", variables,
                 more_at=at)  # fmt: skip


def binding_ball(rng: Generator, u: float) -> Draw:
    """A coupling without grease: its dry friction grows with the side force that presses it."""
    variables = "articulation_rate side_force"
    return named("binding_ball", log_between(0.03, 0.4, u), "hitch", variables)


def ball_rattle(rng: Generator, u: float) -> Draw:
    """A worn coupling head in which the ball moves freely sideways before it is held."""
    return named("ball_rattle", log_between(8e-4, 9e-3, u), "hitch", "side_force")


def spring_bars(rng: Generator, u: float) -> Draw:
    """Bars of a weight-distributing hitch: the one that a lean tightens pulls the drawbar round.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.001, 0.005)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(3e3, 1e5, u)
    variables = "roll_trailer lateral_acceleration_trailer"
    return named("spring_bars", size, "hitch", variables, more_at=at)


def slack_lashing(rng: Generator, u: float) -> Draw:
    """A load that is lashed on one side: straps hold it one way, other goods softly the other."""
    at = float(rng.choice((-1.0, 1.0))) * round(float(rng.uniform(0.1, 0.4)), 3)
    mass = round(log_between(40.0, 500.0, u), 2)
    return named(
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
    return named("lingering_flow", log_between(8.0, 120.0, u), places, "sideslip_trailer",
                 more_at=at)  # fmt: skip


def torn_cable(rng: Generator, u: float) -> Draw:
    """Trailer brakes that sway applies, one of whose cables is torn: only the right wheels drag.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.2, 0.8)), 3)
    variables = "lateral_acceleration_trailer roll_trailer"
    size = log_between(20.0, 400.0, u)
    return named("torn_cable", size, "moment_trailer drag_trailer", variables, more_at=at)


def hub_drives(rng: Generator, u: float) -> Draw:
    """Hub motors of an electric trailer turn it as the car is steered, told so by a slow bus."""
    at = round(float(rng.uniform(0.1, 0.4)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(1.2e4, 4e5, u)
    return named("hub_drives", size, "moment_trailer", "steer", more_at=at)


def angle_vectoring(rng: Generator, u: float) -> Draw:
    """Two rear motors of an electric car turn it by the trailer's angle, as far as they can."""
    at = round(float(rng.uniform(0.006, 0.03)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(60.0, 2000.0, u)
    return named("angle_vectoring", size, "moment_car", "articulation", more_at=at)


def levelling_pump(rng: Generator, u: float) -> Draw:
    """Air springs of the car's rear axle whose leaking valves answer a lean late: wheels steer.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.15, 0.8)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.05, 1.0, u)
    variables = "roll_car lateral_acceleration_car"
    return named("levelling_pump", size, "slip_car_rear", variables, more_at=at)


def clay_tread(rng: Generator, u: float) -> Draw:
    """Clay of a field in the tread of the car's front tyres, which they throw off on the road."""
    at = round(float(rng.uniform(150.0, 500.0)), 1)
    variables = "slip_car_front distance"
    return named("clay_tread", log_between(0.1, 0.7, u), "slip_car_front", variables, more_at=at)


def racked_frame(rng: Generator, u: float) -> Draw:
    """Loose bolts of a frame: the pull of the ball racks it, and the axles with it, to a stop."""
    at = round(float(rng.uniform(300.0, 1500.0)), 1)
    size = float(rng.choice((-1.0, 1.0))) * log_between(1e-3, 1.2e-2, u)
    return named("racked_frame", size, "slip_trailer", "side_force", more_at=at)


def caster_flutter(rng: Generator, u: float) -> Draw:
    """A self-steering axle of the trailer without its damper: it swings after its slip."""
    hz = round(float(rng.uniform(0.9, 2.5)), 3)
    places, variables = "slip_trailer force_trailer", "slip_trailer sideslip_trailer swing"
    size = log_between(0.02, 0.4, u)
    return named("caster_flutter", size, places, variables, more_frequency_hz=hz)


def squealing_pads(rng: Generator, u: float) -> Draw:
    """Damp pads at the ball: their friction is largest at a creep, less as they slide faster."""
    at = round(float(rng.uniform(0.015, 0.06)), 4)
    size = log_between(120.0, 1500.0, u)
    return named("squealing_pads", size, "hitch", "articulation_rate", more_at=at)


def outward_damper(rng: Generator, u: float) -> Draw:
    """A damper at the drawbar that resists away from straight and lets it come back freely.

    The articulation says which way that is.
    """
    at = round(float(rng.uniform(0.001, 0.004)), 5)
    variables = "articulation articulation_rate"
    return named("outward_damper", log_between(800.0, 2e4, u), "hitch", variables, more_at=at)


def seized_top_mount(rng: Generator, u: float) -> Draw:
    """A strut's upper bearing that has seized: it holds the front wheels back until it slides."""
    at = round(float(rng.uniform(0.003, 0.01)), 5)
    size = log_between(0.15, 0.9, u)
    return named("seized_top_mount", size, "slip_car_front", "steer steer_rate", more_at=at)


def crosswind_assist(rng: Generator, u: float) -> Draw:
    """Steering that answers the car's lateral acceleration, no faster than its motor can.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(1.2, 3.5)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(1.6e-3, 5e-3, u)
    variables = "lateral_acceleration_car roll_car"
    return named("crosswind_assist", size, "slip_car_front", variables, more_at=at)


def link_steering(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that are steered by the trailer's yaw rate, through a worn rack."""
    at = round(float(rng.uniform(0.008, 0.04)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.003, 0.05, u)
    return named("link_steering", size, "slip_car_rear", "yaw_rate_trailer", more_at=at)


def broken_leaf(rng: Generator, u: float) -> Draw:
    """A main leaf that is broken on one side: the trailer's axle swings there under a lean.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.06, 0.8, u)
    variables = "roll_trailer lateral_acceleration_trailer"
    return named("broken_leaf", size, "slip_trailer", variables)


def snow_tracks(rng: Generator, u: float) -> Draw:
    """Trailer tyres that grip in the tracks of the car, and less in the slush beside them."""
    at = round(float(rng.uniform(0.006, 0.02)), 4)
    places = "slip_trailer force_trailer"
    variables = "slip_trailer sideslip_trailer articulation"
    return named("snow_tracks", log_between(0.15, 0.55, u), places, variables, more_at=at)


def hunting_vectoring(rng: Generator, u: float) -> Draw:
    """Rear motors of an electric car whose controller rings as it answers the articulation rate."""
    hz = round(float(rng.uniform(0.9, 2.5)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(700.0, 6e3, u)
    variables = "articulation_rate swing"
    return named("hunting_vectoring", size, "moment_car", variables, more_frequency_hz=hz)


def roof_tent(rng: Generator, u: float) -> Draw:
    """The cover of a roof tent: slack up to some side-slip of the car, then a sail."""
    at = round(float(rng.uniform(0.001, 0.004)), 5)
    size = log_between(20.0, 200.0, u)
    return named("roof_tent", size, "force_car moment_car", "sideslip_car", more_at=at)


def tearing_canvas(rng: Generator, u: float) -> Draw:
    """A cover that tears loose along the road and catches more and more air."""
    at = round(float(rng.uniform(100.0, 400.0)), 1)
    places, variables = "force_trailer moment_trailer", "sideslip_trailer distance"
    return named("tearing_canvas", log_between(15.0, 150.0, u), places, variables, more_at=at)


def cocked_overrun(rng: Generator, u: float) -> Draw:
    """A worn overrun shaft that a side force at the ball cocks: one way it pulls a brake rod."""
    at = round(float(rng.uniform(50.0, 250.0)), 1)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.4, 1.8, u)
    return named("cocked_overrun", size, "moment_trailer drag_trailer", "side_force", more_at=at)


def loosening_straps(rng: Generator, u: float) -> Draw:
    """Straps that work loose along the road: they hold the load ever more softly."""
    at = round(float(rng.uniform(100.0, 300.0)), 1)
    mass = round(log_between(200.0, 500.0, u), 2)
    return named(
        "loosening_straps", mass, "trailer force_trailer", "swing distance", more_at=at,
        slosh_mass_kg=mass, slosh_frequency_hz=round(float(rng.uniform(0.9, 1.5)), 3),
        slosh_damping=round(float(rng.uniform(0.03, 0.07)), 3),
    )  # fmt: skip


def brinelled_ring(rng: Generator, u: float) -> Draw:
    """A turntable whose balls have dented its race: it snaps from dent to dent as it turns."""
    at = round(float(rng.uniform(0.006, 0.03)), 4)
    return named("brinelled_ring", log_between(60.0, 1200.0, u), "hitch", "articulation",
                 more_at=at)  # fmt: skip


def servo_ball(rng: Generator, u: float) -> Draw:
    """A motor at the ball that works against the trailer's yaw rate, as strong as it can."""
    at = round(float(rng.uniform(0.02, 0.08)), 4)
    return named("servo_ball", log_between(270.0, 3000.0, u), "hitch", "yaw_rate_trailer",
                 more_at=at)  # fmt: skip


def rag_joint(rng: Generator, u: float) -> Draw:
    """A rag joint of the steering column that is soaked in oil: the wheels swing after the hand."""
    hz = round(float(rng.uniform(0.9, 1.3)), 3)
    size = log_between(0.3, 0.9, u)
    return named("rag_joint", size, "slip_car_front", "steer swing", more_frequency_hz=hz)


def bent_arm(rng: Generator, u: float) -> Draw:
    """A steering arm bent at a kerb: a lean to either side steers the front wheels one way.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.08, 0.4, u)
    return named("bent_arm", size, "slip_car_front", "roll_car lateral_acceleration_car")


def quick_rear(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that are steered as quickly as the front ones are, to a limit."""
    at = round(float(rng.uniform(0.03, 0.1)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(9e-3, 0.18, u)
    return named("quick_rear", size, "slip_car_rear", "steer_rate", more_at=at)


def stepper_rear(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that a motor steers with its yaw rate in steps."""
    at = round(float(rng.uniform(0.008, 0.03)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(6e-3, 0.12, u)
    return named("stepper_rear", size, "slip_car_rear", "yaw_rate_car", more_at=at)


def leaky_link(rng: Generator, u: float) -> Draw:
    """Trailer axles that cylinders at the drawbar steer, which leak: no angle lasts."""
    at = round(float(rng.uniform(0.4, 1.5)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.03, 0.3, u)
    return named("leaky_link", size, "slip_trailer", "articulation articulation_rate", more_at=at)


def creeping_clamp(rng: Generator, u: float) -> Draw:
    """Axle clamps that creep while a tyre force is beyond their grip, and stay where they are."""
    at = round(float(rng.uniform(0.001, 0.006)), 4)
    size = log_between(0.5, 10.0, u)
    places, variables = "slip_trailer force_trailer", "slip_trailer sideslip_trailer"
    return named("creeping_clamp", size, places, variables, more_at=at)


def curve_brake(rng: Generator, u: float) -> Draw:
    """Brakes of one side of the car that a lateral acceleration applies, late.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.2, 0.7)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(400.0, 2000.0, u)
    variables = "lateral_acceleration_car roll_car"
    return named("curve_brake", size, "moment_car", variables, more_at=at)


def solenoid_brakes(rng: Generator, u: float) -> Draw:
    """Trailer brakes that are on or off: on beyond a yaw rate, and a while longer."""
    at = round(float(rng.uniform(0.01, 0.05)), 4)
    size = log_between(300.0, 3500.0, u)
    return named("solenoid_brakes", size, "moment_trailer", "yaw_rate_trailer", more_at=at)


def gap_pump(rng: Generator, u: float) -> Draw:
    """Air that the trailer's face presses out of the gap behind a van as the gap closes."""
    size = log_between(14.0, 110.0, u)
    return named("gap_pump", size, "force_car moment_car", "articulation_rate")


def rocking_hull(rng: Generator, u: float) -> Draw:
    """A boat that rolls from one side of its V of rollers to the other: a pull of one size."""
    at = round(float(rng.uniform(0.02, 0.08)), 4)
    mass = round(log_between(250.0, 500.0, u), 2)
    return named(
        "rocking_hull", mass, "trailer force_trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=round(float(rng.uniform(0.7, 1.1)), 3),
        slosh_damping=round(float(rng.uniform(0.03, 0.07)), 3),
    )  # fmt: skip


def locker_corner(rng: Generator, u: float) -> Draw:
    """The corner of a gas locker that a tow bar touches as the drawbar turns to one side."""
    at = round(float(rng.uniform(0.008, 0.02)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(8e3, 6e4, u)
    return named("locker_corner", size, "hitch", "articulation", more_at=at)


def tilted_head(rng: Generator, u: float) -> Draw:
    """A coupling head that jams on its ball as the trailer leans: dry friction that grows so.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    variables = "articulation_rate roll_trailer lateral_acceleration_trailer"
    return named("tilted_head", log_between(1e4, 6e4, u), "hitch", variables)


def bump_steer(rng: Generator, u: float) -> Draw:
    """Track rods at a wrong height: front wheels steer little at a small lean, much at a large one.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    size = float(rng.choice((-1.0, 1.0))) * log_between(100.0, 400.0, u)
    return named("bump_steer", size, "slip_car_front", "roll_car lateral_acceleration_car")


def puddles(rng: Generator, u: float) -> Draw:
    """Water that lies here and there: the car's front tyres float on it and clear it for others."""
    at = round(float(rng.uniform(25.0, 80.0)), 1)
    variables = "slip_car_front distance"
    return named("puddles", log_between(0.2, 0.8, u), "slip_car_front", variables, more_at=at)


def subframe_rubber(rng: Generator, u: float) -> Draw:
    """A rear subframe in soft rubber: its wheels give way to a side force, late."""
    at = round(float(rng.uniform(0.08, 0.3)), 3)
    size = log_between(0.12, 0.35, u)
    return named("subframe_rubber", size, "slip_car_rear", "slip_car_rear", more_at=at)


def late_rear_steering(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that a motor steers after the front ones, late."""
    at = round(float(rng.uniform(0.1, 0.3)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.2, 0.6, u)
    return named("late_rear_steering", size, "slip_car_rear", "steer", more_at=at)


def working_frame(rng: Generator, u: float) -> Draw:
    """A riveted frame whose joints work: the ball racks the axles, with dry friction."""
    at = round(float(rng.uniform(700.0, 1500.0)), 1)
    size = float(rng.choice((-1.0, 1.0))) * log_between(8e-6, 2e-5, u)
    return named("working_frame", size, "slip_trailer", "side_force", more_at=at)


def roll_protection(rng: Generator, u: float) -> Draw:
    """Roll protection of a trailer: it brakes the outer wheels beyond a lateral acceleration.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.4, 1.0)), 3)
    variables = "lateral_acceleration_trailer roll_trailer"
    size = log_between(100.0, 500.0, u)
    return named("roll_protection", size, "moment_trailer drag_trailer", variables, more_at=at)


def hanging_load(rng: Generator, u: float) -> Draw:
    """Sides of beef on rails: they swing as a pendulum until they touch the walls."""
    at = round(float(rng.uniform(0.05, 0.12)), 3)
    mass = round(log_between(280.0, 500.0, u), 2)
    return named(
        "hanging_load", mass, "trailer force_trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=round(float(rng.uniform(0.45, 0.65)), 3),
        slosh_damping=round(float(rng.uniform(0.03, 0.08)), 3),
    )  # fmt: skip


def slack_tarpaulin(rng: Generator, u: float) -> Draw:
    """A tarpaulin that is not stretched: slack up to some side-slip, then the wind fills it."""
    at = round(float(rng.uniform(0.002, 0.006)), 4)
    places = "force_trailer moment_trailer"
    return named("slack_tarpaulin", log_between(60.0, 250.0, u), places, "sideslip_trailer",
                 more_at=at)  # fmt: skip


def greasy_ball(rng: Generator, u: float) -> Draw:
    """Grease on one side of the ball: pads of a stabiliser hold as long as they turn on the other.

    The articulation says which side that is.
    """
    at = round(float(rng.uniform(0.001, 0.005)), 5)
    size = float(rng.choice((-1.0, 1.0))) * log_between(250.0, 1500.0, u)
    variables = "articulation_rate articulation"
    return named("greasy_ball", size, "hitch", variables, more_at=at)


def slipping_neck(rng: Generator, u: float) -> Draw:
    """A detachable ball neck that is not locked: it slips sideways in its seat, with friction."""
    at = round(float(rng.uniform(80.0, 200.0)), 1)
    return named("slipping_neck", log_between(2.2e-5, 6e-5, u), "hitch", "side_force", more_at=at)


def broken_link(rng: Generator, u: float) -> Draw:
    """A link of the car's rear axle that breaks at the first hard lean: then it steers by leaning.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.006, 0.011)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.08, 0.4, u)
    variables = "roll_car lateral_acceleration_car"
    return named("broken_link", size, "slip_car_rear", variables, more_at=at)


def shimmy(rng: Generator, u: float) -> Draw:
    """Worn kingpins: the front wheels shimmy by themselves, to and fro, once they are touched."""
    hz = round(float(rng.uniform(2.0, 4.0)), 3)
    drawn = named("shimmy", log_between(9e-3, 1.8e-2, u), "slip_car_front", "swing slip_car_front",
                  more_frequency_hz=hz)  # fmt: skip
    return replace(drawn, restless=True)


def soft_tyre(rng: Generator, u: float) -> Draw:
    """Tyres with too little air on one side of the trailer: it holds less as it leans on them.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.005, 0.015)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.2, 0.65, u)
    variables = "slip_trailer sideslip_trailer roll_trailer lateral_acceleration_trailer"
    return named("soft_tyre", size, "slip_trailer force_trailer", variables, more_at=at)


def crooked_joint(rng: Generator, u: float) -> Draw:
    """A joint of the steering column put together a quarter turn wrong: it favours one side."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.1, 0.14, u)
    return named("crooked_joint", size, "slip_car_front", "steer")


def leaning_stack(rng: Generator, u: float) -> Draw:
    """Sacks that are stacked high: the stack leans, and comes back late for their friction.

    This friction is a part of what holds the stack.
    """
    at = round(float(rng.uniform(0.01, 0.04)), 4)
    mass = round(log_between(300.0, 500.0, u), 2)
    return named(
        "leaning_stack", mass, "trailer force_trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=round(float(rng.uniform(0.8, 1.3)), 3),
        slosh_damping=round(float(rng.uniform(0.03, 0.07)), 3),
    )  # fmt: skip


def loose_hub(rng: Generator, u: float) -> Draw:
    """A front hub of the car that is loose: side forces tilt its disc, which drags on its pads."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(5e4, 1.6e5, u)
    return named("loose_hub", size, "moment_car", "slip_car_front")


def open_door(rng: Generator, u: float) -> Draw:
    """A back door that has come open: a rudder which the air turns into its flow, with a swing.

    As a vane's, its swing takes a length of road, not a time.
    """
    at = round(float(rng.uniform(16.0, 32.0)), 2)
    places, variables = "force_trailer moment_trailer", "sideslip_trailer yaw_rate_trailer swing"
    return named("open_door", log_between(8.0, 60.0, u), places, variables, more_at=at)


def soft_verge(rng: Generator, u: float) -> Draw:
    """A verge that is soft in stretches: it drags on the right wheels of the wider trailer."""
    at = round(float(rng.uniform(50.0, 150.0)), 1)
    size = log_between(250.0, 900.0, u)
    drawn = named("soft_verge", size, "moment_trailer drag_trailer", "distance", more_at=at)
    return replace(drawn, restless=True)


def lorry_ruts(rng: Generator, u: float) -> Draw:
    """Ruts of heavy lorries: their walls push an axle back by its place across them.

    They go where the driver means to: that place is what the heading has summed to of late.
    """
    at = round(float(rng.uniform(0.08, 0.3)), 3)
    places = "slip_car_front slip_car_rear slip_trailer"
    variables = "heading heading_car heading_trailer"
    return named("lorry_ruts", log_between(2e-4, 8e-3, u), places, variables, more_at=at)


def standing_water(rng: Generator, u: float) -> Draw:
    """Water in hollows of the road's left: it drags on the front wheel that throws it aside."""
    at = round(float(rng.uniform(50.0, 150.0)), 1)
    size = log_between(150.0, 1500.0, u)
    drawn = named("standing_water", size, "moment_car", "distance", more_at=at)
    return replace(drawn, restless=True)


def bump_stop_grip(rng: Generator, u: float) -> Draw:
    """Rear axle of a car on its bump stops: its tyres carry all of a lean beyond, and hold less.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.003, 0.01)), 4)
    variables = "slip_car_rear roll_car lateral_acceleration_car"
    size = log_between(0.06, 0.6, u)
    return named("bump_stop_grip", size, "slip_car_rear", variables, more_at=at)


def loose_hands(rng: Generator, u: float) -> Draw:
    """Power steering that a loose hand does not support: the wheels turn after their slip, late."""
    at = round(float(rng.uniform(0.08, 0.3)), 3)
    size = log_between(0.05, 0.5, u)
    return named("loose_hands", size, "slip_car_front", "slip_car_front", more_at=at)


def worn_pad(rng: Generator, u: float) -> Draw:
    """A stabiliser at the ball with one worn pad: it holds more one way of turning."""
    at = round(float(rng.uniform(0.1, 0.5)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(60.0, 450.0, u)
    return named("worn_pad", size, "hitch", "articulation_rate", more_at=at)


def track_rod_end(rng: Generator, u: float) -> Draw:
    """A worn track rod end of one front wheel: it gives way to its side force, up to a stop."""
    gain = float(rng.uniform(0.3, 0.8))
    size = log_between(8e-4, 1e-2, u)
    at = round(size / gain, 6)
    return named("track_rod_end", size, "slip_car_front", "slip_car_front", more_at=at)


def hopping_wheels(rng: Generator, u: float) -> Draw:
    """Worn dampers of the car's rear axle: on rough stretches its wheels hop and hold less."""
    at = round(float(rng.uniform(50.0, 150.0)), 1)
    variables = "slip_car_rear distance"
    size = log_between(0.08, 0.5, u)
    return named("hopping_wheels", size, "slip_car_rear", variables, more_at=at)


def buckled_wheel(rng: Generator, u: float) -> Draw:
    """A wheel of the trailer, buckled at a kerb and loose on its nuts, wobbles as it rolls."""
    size = log_between(2e-2, 6e-2, u)
    drawn = named("buckled_wheel", size, "slip_trailer force_trailer", "distance")
    return replace(drawn, restless=True)


def skew_joints(rng: Generator, u: float) -> Draw:
    """Expansion joints that lie askew: they kick each axle sideways as it comes there."""
    at = round(float(rng.uniform(8.0, 25.0)), 1)
    places = "slip_car_front slip_car_rear slip_trailer"
    size = float(rng.choice((-1.0, 1.0))) * log_between(6e-3, 3e-2, u)
    drawn = named("skew_joints", size, places, "distance", more_at=at)
    return replace(drawn, restless=True)


def slow_puncture(rng: Generator, u: float) -> Draw:
    """A nail in the car's rear right tyre: it loses its air, and with it stiffness, on the way."""
    at = round(float(rng.uniform(80.0, 400.0)), 1)
    variables = "slip_car_rear distance"
    size = log_between(0.08, 0.7, u)
    return named("slow_puncture", size, "slip_car_rear", variables, more_at=at)


def late_correction(rng: Generator, u: float) -> Draw:
    """Steering that corrects the car's yaw rate beside the driver's hands, some time later."""
    at = round(float(rng.uniform(0.15, 0.4)), 3)
    size = log_between(4e-3, 5e-2, u)
    return named("late_correction", size, "slip_car_front", "yaw_rate_car", more_at=at)


def rut_walls(rng: Generator, u: float) -> Draw:
    """Ruts in which the car runs, wider than the trailer's track: it is free until a wall is met.

    An axle leaves the car's track by as much as it slips, which goes with lateral acceleration and
    so with roll: all of these are the same here.
    """
    at = round(float(rng.uniform(0.01, 0.04)), 4)
    places = "slip_trailer force_trailer"
    variables = "slip_trailer sideslip_trailer lateral_acceleration_trailer roll_trailer"
    return named("rut_walls", log_between(3e-3, 3e-2, u), places, variables, more_at=at)


def rolled_under(rng: Generator, u: float) -> Draw:
    """A soft tyre on one side of the trailer: pushed inwards, it rolls under and holds less."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.1, 0.7, u)
    places, variables = "slip_trailer force_trailer", "slip_trailer sideslip_trailer"
    return named("rolled_under", size, places, variables)


def one_wheel_brake(rng: Generator, u: float) -> Draw:
    """A stability controller that brakes one wheel of the car beyond a yaw rate, late."""
    at = round(float(rng.uniform(0.01, 0.03)), 4)
    return named("one_wheel_brake", log_between(5e3, 4.5e4, u), "moment_car", "yaw_rate_car",
                 more_at=at)  # fmt: skip


def stop_overload(rng: Generator, u: float) -> Draw:
    """The trailer's axle on its rubber stops: tyres that carry all of a lean beyond hold less.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.003, 0.01)), 4)
    size = log_between(0.12, 0.7, u)
    variables = "slip_trailer sideslip_trailer roll_trailer lateral_acceleration_trailer"
    return named("stop_overload", size, "slip_trailer force_trailer", variables, more_at=at)


def wind_shadow(rng: Generator, u: float) -> Draw:
    """Air on the trailer's nose as it leaves the car's wind shadow: ever more, the further."""
    places = "force_trailer moment_trailer"
    return named("wind_shadow", log_between(450.0, 700.0, u), places, "articulation")


def wet_stretches(rng: Generator, u: float) -> Draw:
    """Wet stretches of a road: each axle's tyres hold less while they are on one."""
    at = round(float(rng.uniform(40.0, 150.0)), 1)
    places = "slip_car_front slip_car_rear slip_trailer force_trailer"
    variables = "slip_car_front slip_car_rear slip_trailer sideslip_trailer distance"
    return named("wet_stretches", log_between(0.06, 0.5, u), places, variables, more_at=at)


def sliding_box(rng: Generator, u: float) -> Draw:
    """A box that slides on a smooth floor, with friction, until a net catches it."""
    at = round(float(rng.uniform(0.02, 0.08)), 3)
    mass = round(log_between(250.0, 500.0, u), 2)
    return named(
        "sliding_box", mass, "trailer force_trailer", "swing", more_at=at, slosh_mass_kg=mass,
        slosh_frequency_hz=round(float(rng.uniform(1.0, 1.6)), 3), slosh_damping=0.0,
    )  # fmt: skip


def loose_subframe(rng: Generator, u: float) -> Draw:
    """Loose bolts of the front subframe: wheels give way to side forces, with dry friction."""
    at = round(float(rng.uniform(0.002, 0.01)), 4)
    size = log_between(0.02, 0.25, u)
    return named("loose_subframe", size, "slip_car_front", "slip_car_front", more_at=at)


def gap_headwind(rng: Generator, u: float) -> Draw:
    """A headwind between cuttings: the air on the trailer's side-slip comes and goes."""
    at = round(float(rng.uniform(80.0, 250.0)), 1)
    places, variables = "force_trailer moment_trailer", "sideslip_trailer distance"
    return named("gap_headwind", log_between(20.0, 80.0, u), places, variables, more_at=at)


def sticky_beam(rng: Generator, u: float) -> Draw:
    """A twist beam of the car in sticking bushes: a lean steers its wheels, with dry friction.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    at = round(float(rng.uniform(0.002, 0.008)), 4)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.08, 0.8, u)
    variables = "roll_car lateral_acceleration_car"
    return named("sticky_beam", size, "slip_car_rear", variables, more_at=at)


def worn_spot(rng: Generator, u: float) -> Draw:
    """A ball worn where it sits when straight: its friction grasps only away from there."""
    at = round(float(rng.uniform(0.004, 0.015)), 4)
    variables = "articulation_rate articulation"
    return named("worn_spot", log_between(120.0, 1200.0, u), "hitch", variables, more_at=at)


def aged_tyres(rng: Generator, u: float) -> Draw:
    """Tyres of a trailer that are too old: their hard rubber begins to slide early."""
    at = round(float(rng.uniform(0.008, 0.02)), 4)
    places, variables = "slip_trailer force_trailer", "slip_trailer sideslip_trailer"
    return named("aged_tyres", log_between(0.08, 0.7, u), places, variables, more_at=at)


def camera_rear(rng: Generator, u: float) -> Draw:
    """Rear wheels of the car that are steered with the articulation, as a camera last saw it."""
    at = round(float(rng.uniform(0.12, 0.35)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.01, 0.2, u)
    variables = "articulation articulation_rate"
    return named("camera_rear", size, "slip_car_rear", variables, more_at=at)


def bistable_wake(rng: Generator, u: float) -> Draw:
    """A wake that lies to one side of a blunt tail, and turns over beyond a side-slip."""
    at = round(float(rng.uniform(0.004, 0.015)), 4)
    places = "force_trailer moment_trailer"
    return named("bistable_wake", log_between(0.1, 1.2, u), places, "sideslip_trailer", more_at=at)


def open_crack(rng: Generator, u: float) -> Draw:
    """A crack at the drawbar's root: it opens under a side force one way, else it is shut."""
    size = float(rng.choice((-1.0, 1.0))) * log_between(1.5e5, 1.2e4, u)
    return named("open_crack", size, "hitch", "side_force")


def controlled_joint(rng: Generator, u: float) -> Draw:
    """A damper at the ball whose valve closes with the car's yaw rate."""
    size = log_between(3e3, 1e5, u)
    return named("controlled_joint", size, "hitch", "articulation_rate yaw_rate_car")


def binding_rack(rng: Generator, u: float) -> Draw:
    """A steering rack in a worn bush: the more side force, the more friction as it is moved."""
    at = round(float(rng.uniform(0.005, 0.02)), 4)
    variables = "slip_car_front steer_rate"
    return named("binding_rack", log_between(0.06, 0.6, u), "slip_car_front", variables,
                 more_at=at)  # fmt: skip


def tailgate_crate(rng: Generator, u: float) -> Draw:
    """A crate of tools at the car's tailgate, which slides from wall to wall."""
    at = round(float(rng.uniform(0.3, 1.0)), 3)
    hz = round(float(rng.uniform(2.0, 4.0)), 3)
    size = round(log_between(40.0, 200.0, u), 2)
    return named(
        "tailgate_crate", size, "car force_car moment_car", "swing", more_at=at,
        more_frequency_hz=hz,
    )  # fmt: skip


def caster_lock(rng: Generator, u: float) -> Draw:
    """A self-steering axle whose pin a side force lifts: it drops back where there is none."""
    at = round(float(rng.uniform(0.005, 0.015)), 4)
    places, variables = "slip_trailer force_trailer", "slip_trailer sideslip_trailer"
    return named("caster_lock", log_between(0.06, 0.6, u), places, variables, more_at=at)


def passing_lorry(rng: Generator, u: float) -> Draw:
    """Lorries of a convoy that come past in turn: air pushes at the tail, then pulls at the nose.

    They come by time, which at a steady speed is the distance.
    """
    at = round(float(rng.uniform(4.0, 8.0)), 2)
    size = float(rng.choice((-1.0, 1.0))) * log_between(100.0, 900.0, u)
    drawn = named("passing_lorry", size, "force_trailer moment_trailer", "distance", more_at=at)
    return replace(drawn, restless=True)


def wallowing_tail(rng: Generator, u: float) -> Draw:
    """Dead dampers under the nose load: the car's rear wallows, and its beam axle steers so.

    Bodies roll with their lateral acceleration, so both are the same here.
    """
    hz = round(float(rng.uniform(0.9, 1.6)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(0.03, 0.4, u)
    variables = "roll_car lateral_acceleration_car swing"
    return named("wallowing_tail", size, "slip_car_rear", variables, more_frequency_hz=hz)


def lane_departure(rng: Generator, u: float) -> Draw:
    """Steering back to the middle of a lane beside the driver, once the car is off it by so much.

    That place is what the heading has summed to of late.
    """
    at = round(float(rng.uniform(0.03, 0.1)), 3)
    size = log_between(5e-3, 8e-2, u)
    return named("lane_departure", size, "slip_car_front", "heading heading_car", more_at=at)


def braking_driver(rng: Generator, u: float) -> Draw:
    """A driver who brakes as the car swings, some time later; one of its front brakes is seized."""
    at = round(float(rng.uniform(0.25, 0.6)), 3)
    size = float(rng.choice((-1.0, 1.0))) * log_between(3e3, 4.5e4, u)
    return named("braking_driver", size, "moment_car", "yaw_rate_car", more_at=at)


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
ELEVENTH = (
    brinelled_ring, stepper_rear, gap_pump, leaky_link, bent_arm, solenoid_brakes, servo_ball,
    rocking_hull, quick_rear, creeping_clamp, rag_joint, curve_brake,
)  # fmt: skip
TWELFTH = (
    locker_corner, hanging_load, bump_steer, working_frame, late_rear_steering, slack_tarpaulin,
    tilted_head, puddles, roll_protection, subframe_rubber,
)  # fmt: skip
THIRTEENTH = (
    soft_tyre, greasy_ball, crooked_joint, soft_verge, leaning_stack, loose_hub, broken_link,
    slipping_neck, open_door, shimmy,
)  # fmt: skip
FOURTEENTH = (
    lorry_ruts, standing_water, bump_stop_grip, loose_hands, worn_pad, track_rod_end,
    hopping_wheels, buckled_wheel, skew_joints, slow_puncture,
)  # fmt: skip
FIFTEENTH = (
    late_correction, rut_walls, rolled_under, one_wheel_brake, stop_overload, wind_shadow,
    wet_stretches, sliding_box, loose_subframe, gap_headwind, sticky_beam, worn_spot,
)  # fmt: skip
SIXTEENTH = (
    aged_tyres, camera_rear, bistable_wake, open_crack, controlled_joint, binding_rack,
    tailgate_crate, caster_lock, passing_lorry, wallowing_tail, lane_departure, braking_driver,
)  # fmt: skip
