"""What is known to act like a law: a hint for its name, and prior weight for the law."""

from __future__ import annotations

#: What is known to act in this way, by place and motion, for a positive and a negative gain.
KNOWN: dict[tuple[str, str], tuple[str, str]] = {
    ("hitch", "articulation"): (
        "a spring: a weight-distributing hitch, a coupling that pulls straight",
        "a moment that folds the combination: a tilted or worn coupling",
    ),
    ("hitch", "articulation_rate"): ("a hydraulic damper", ""),
    ("moment_car", "yaw_rate_car"): (
        "a controller that turns the car in",
        "a stability controller that brakes against the yaw",
    ),
    ("moment_car", "yaw_rate_trailer"): (
        "a controller that follows the trailer's yaw",
        "a trailer-stability controller of the car",
    ),
    ("moment_car", "steer"): ("torque vectoring into the bend", "a differential that resists"),
    ("moment_car", "sideslip_car"): ("air that turns the car in", "air that turns the car out"),
    ("force_car", "sideslip_car"): ("", "air side force on the car"),
    ("moment_trailer", "yaw_rate_trailer"): (
        "",
        "scrub of axles close together, or trailer brakes under a stability controller",
    ),
    ("moment_trailer", "articulation_rate"): ("", "trailer brakes under a stability controller"),
    ("force_trailer", "heading"): ("a steady wind over a road that turns",) * 2,
    ("force_car", "heading"): ("a steady wind over a road that turns",) * 2,
    ("slip_trailer", "articulation"): ("a steered trailer axle", "a steered trailer axle"),
    ("slip_car_front", "steer"): ("steering whose ratio changes over its angle",) * 2,
    ("slip_car_front", "heading_car"): ("", "steering that keeps the lane beside the driver"),
    ("slip_car_front", "slip_car_front"): (
        "",
        "front wheels that give way: worn bearings or bushes",
    ),
    ("slip_car_rear", "slip_car_rear"): ("", "rear wheels that give way: worn bearings or bushes"),
    ("slip_trailer", "slip_trailer"): ("", "wheels that give way: worn bearings or bushes"),
    ("slip_car_rear", "steer"): ("rear-wheel steering, same sense", "rear-wheel steering"),
    ("slip_car_front", "yaw_rate_car"): (
        "steering that follows the yaw",
        "the driver's arms, or steering assistance against the yaw",
    ),
    ("trailer", "swing"): ("a load that is not lashed, a liquid", ""),
    ("car", "swing"): ("a load in the car that is not lashed, a liquid", ""),
    ("trailer", "turn"): ("a load that turns by itself: a boom, a boat on its cradle", ""),
    ("car", "turn"): ("a load in the car that turns by itself", ""),
    ("tyres", "side_force"): ("aligning moments of the tyres (pneumatic trail)", ""),
}
