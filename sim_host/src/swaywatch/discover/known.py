"""Devices known to act like a law: a hint for its name, and prior weight for the law."""

from __future__ import annotations

#: What is known to act in this way, by place and motion, for a positive and a negative gain.
KNOWN: dict[tuple[str, str], tuple[str, str]] = {
    ("hitch", "articulation"): (
        "a spring: a weight-distributing hitch, a self-centring coupling",
        "a negative spring, which folds the combination: a tilted or worn coupling",
    ),
    ("hitch", "articulation_rate"): ("a hydraulic damper", ""),
    ("hitch", "roll_trailer"): ("bars or a drawbar that a lean tightens",) * 2,
    ("hitch", "lateral_acceleration_trailer"): ("bars or a drawbar that a lean tightens",) * 2,
    ("moment_car", "yaw_rate_car"): (
        "a controller that increases the yaw rate (torque vectoring)",
        "yaw damping by a stability controller",
    ),
    ("moment_car", "yaw_rate_trailer"): (
        "a controller that acts with the trailer yaw rate",
        "trailer stability control of the car",
    ),
    ("moment_car", "steer"): (
        "torque vectoring into the bend",
        "a locked or limited-slip differential",
    ),
    ("moment_car", "sideslip_car"): ("aerodynamic yaw moment",) * 2,
    ("force_car", "sideslip_car"): ("", "aerodynamic side force on the car"),
    ("moment_trailer", "yaw_rate_trailer"): (
        "",
        "scrub of axles close together, or trailer brakes under a stability controller",
    ),
    ("moment_trailer", "articulation_rate"): ("", "trailer brakes under a stability controller"),
    ("force_trailer", "sideslip_car"): ("the car's wake over the trailer",) * 2,
    ("moment_trailer", "sideslip_car"): ("the car's wake over the trailer",) * 2,
    ("force_trailer", "sideslip_trailer"): ("air on the trailer that is late, or separates",) * 2,
    ("moment_trailer", "sideslip_trailer"): ("air on the trailer that is late, or separates",) * 2,
    ("slip_car_rear", "heading_car"): ("", "grooves along the road"),
    ("slip_trailer", "heading"): ("", "grooves along the road"),
    ("slip_car_front", "steer_rate"): (
        "a steering that runs ahead",
        "a steering that stays behind where it is turned quickly",
    ),
    ("slip_car_rear", "roll_car"): ("a bump stop that steers the axle",) * 2,
    ("slip_trailer", "roll_trailer"): ("a bump stop that steers the axles",) * 2,
    ("force_trailer", "heading"): ("a steady wind on a curved road",) * 2,
    ("force_car", "heading"): ("a steady wind on a curved road",) * 2,
    ("slip_trailer", "articulation"): ("a steered trailer axle",) * 2,
    ("slip_trailer", "yaw_rate_car"): ("a trailer axle steered by the car",) * 2,
    ("slip_car_front", "steer"): ("a variable steering ratio",) * 2,
    ("slip_car_front", "heading_car"): ("", "lane keeping assistance"),
    ("slip_car_front", "slip_car_front"): (
        "",
        "compliance of the front wheels: worn bearings or bushes",
    ),
    ("slip_car_rear", "slip_car_rear"): (
        "",
        "compliance of the rear wheels: worn bearings or bushes",
    ),
    ("slip_trailer", "slip_trailer"): ("", "compliance of the wheels: worn bearings or bushes"),
    ("slip_car_rear", "steer"): (
        "rear-wheel steering, in phase",
        "rear-wheel steering, out of phase",
    ),
    ("slip_car_front", "yaw_rate_car"): (
        "steering assistance in the sense of the yaw rate",
        "the driver's arms, or steering assistance against the yaw rate",
    ),
    ("slip_car_rear", "hitch_force"): ("a tow bar or a subframe that the ball twists",) * 2,
    ("slip_car_front", "hitch_force"): ("a body or a subframe that the ball twists",) * 2,
    ("slip_trailer", "hitch_force"): ("a frame that the ball twists",) * 2,
    ("slip_car_front", "lateral_acceleration_car"): ("side force compliance of the axle",) * 2,
    ("slip_car_rear", "lateral_acceleration_car"): ("side force compliance of the axle",) * 2,
    ("slip_trailer", "lateral_acceleration_trailer"): ("side force compliance of the axles",) * 2,
    ("moment_car", "slip_car_front"): ("aligning moment of the front tyres",) * 2,
    ("moment_car", "slip_car_rear"): ("aligning moment of the rear tyres",) * 2,
    ("moment_trailer", "slip_trailer"): ("aligning moment of the trailer's tyres",) * 2,
    ("at_trailer", "sideslip_there"): (
        "",
        "something that scrubs over the road: a jockey wheel left down, a stand, a skid",
    ),
    ("at_car", "sideslip_there"): ("", "something that scrubs over the road"),
    ("at_car", "sideslip_car"): ("", "air on the car: a roof box, a tent, a load on the roof"),
    ("at_trailer", "sideslip_trailer"): ("air on the trailer that separates, or fills a cover",)
    * 2,
    ("at_trailer", "sideslip_car"): ("the car's wake over the trailer",) * 2,
    ("axles", "distance"): ("ruts or tracks that wander from side to side",) * 2,
    ("ball", "hitch_force"): ("a ball that moves in a worn or unlocked coupling",) * 2,
    ("force_trailer", "distance"): ("wind beside the road, between houses or hedges",) * 2,
    ("force_car", "distance"): ("wind beside the road, between houses or hedges",) * 2,
    ("moment_trailer", "distance"): ("brakes on one side that bind",) * 2,
    ("moment_car", "distance"): ("brakes on one side that bind",) * 2,
    ("trailer", "swing"): ("an unsecured load, a liquid", ""),
    ("car", "swing"): ("an unsecured load in the car, a liquid", ""),
    ("trailer", "turn"): (
        "a load that oscillates about its vertical axis: a boom, a boat on its cradle",
        "",
    ),
    ("car", "turn"): ("a load in the car that oscillates about its vertical axis", ""),
    ("tyres", "side_force"): ("aligning moments of the tyres (pneumatic trail)", ""),
}
