"""What the rigid-body plant is built from: bodies, suspensions, tyres, and the switchable physics.

Nothing here is shared with the other models of this package: the plant makes data against which
they are judged. Axes are ISO 8855, units SI. Axles are in the order car front, car rear,
trailer front, trailer rear; wheels FL, FR, RL, RR of the car, then the same of the trailer.
"""

from __future__ import annotations

from dataclasses import dataclass, field

GRAVITY = 9.81
AXLES = ("car_front", "car_rear", "trailer_front", "trailer_rear")
WHEELS = ("fl", "fr", "rl", "rr", "t_fl", "t_fr", "t_rl", "t_rr")

DAMPER_KINDS = ("linear", "bilinear", "normal", "failure_1", "failure_2")
"""The five kinds of damper of Table 6-1."""

TYRE_LAWS = ("linear", "magic_formula", "brush")


@dataclass(frozen=True)
class Damper:
    """A damper at one wheel (Table 6-1), force at the wheel over the speed of compression.

    kind
        ``linear``: F = c v. ``bilinear``: rebound stiffer than compression by `ratio`, the mean
        slope kept. ``normal``: bilinear up to `knee_m_s`, beyond it `degression` of that slope.
        ``failure_1``: normal, but the first `lost_travel_m` of each compression stroke gives
        only `lost_factor` of the force. ``failure_2``: that at the start of both strokes.
    coefficient_ns_m, ratio, knee_m_s, degression, lost_travel_m, lost_factor
        See above; N s/m, 1, m/s, 1, m, 1.
    """

    kind: str = "linear"
    coefficient_ns_m: float = 1800.0
    ratio: float = 2.0
    knee_m_s: float = 0.12
    degression: float = 0.4
    lost_travel_m: float = 0.008
    lost_factor: float = 0.05


@dataclass(frozen=True)
class Axle:
    """One axle: place, tyre stiffness of both wheels together, track, suspension at the wheel."""

    to_cog_m: float
    """Ahead of the body's centre of gravity; negative behind it."""
    cornering_stiffness_n_rad: float
    track_m: float
    unsprung_mass_kg: float
    spring_n_m: float
    roll_bar_n_m: float
    """Anti-roll bar, N per m of difference of the two wheels' compressions."""
    damper: Damper
    tyre_vertical_stiffness_n_m: float = 220e3
    tyre_vertical_damping_ns_m: float = 60.0


@dataclass(frozen=True)
class Body:
    """A sprung body with its two axles; mass and inertias include the wheels."""

    mass_kg: float
    yaw_inertia_kgm2: float
    roll_inertia_kgm2: float
    pitch_inertia_kgm2: float
    cog_height_m: float
    hitch_to_cog_m: float
    """Distance of the ball, behind the car's COG or ahead of the trailer's."""
    front: Axle
    rear: Axle
    roll_gain_rad_m_s2: float
    """Planar bodies only: roll per lateral acceleration, of a roll that carries no inertia."""
    roll_frequency_hz: float = 12.0
    roll_damping_ratio: float = 0.7
    front_share: float = 0.55
    """Planar bodies only: of the roll moment, what the front axle carries."""


@dataclass(frozen=True)
class Combination:
    """The car, its trailer and what joins them."""

    car: Body
    trailer: Body
    steering_ratio: float = 15.0
    nose_load_n: float = 700.0
    ball_height_m: float = 0.42
    wheel_radius_m: float = 0.31


@dataclass(frozen=True)
class HarmonicLoad:
    """Generator of an axle load at twice the yaw frequency (section 6.2, Eq. 6.1).

    The car's yaw rate squared, less its mean, divided by that mean so that the size of the sway
    cancels, delayed, and put on the left wheel when the yaw rate is negative, else on the right.
    Amplitude (N) over time and delay (s) over time are inputs of the run.
    """

    axle: str = "car_rear"


MORE = (
    "jackknife_stop", "trailer_axle_steers", "car_air", "tow_assist", "roof_load",
    "axle_hysteresis", "tarpaulin", "heading_wind", "trailer_brakes", "hydraulic_hitch",
    "rear_wheel_steering", "tandem_scrub", "gap_air", "trailer_hubs", "variable_ratio",
    "late_assist", "car_brakes", "turning_load", "air_damping", "rolling_load", "locked_axle",
    "lane_assist", "bearing_play", "rear_axle_control", "driver_arms", "baffled_liquid",
    "wedge_friction", "command_steering", "roll_hysteresis", "hedge_wind", "caster_axle",
    "tyre_warming", "rear_bush_play", "bump_stop_steer", "bent_rim", "cam_centring",
    "stabiliser_windup", "sliding_crate", "padded_load", "pump_catch", "torque_vectoring",
    "sway_brake", "wake_shedding", "car_wake", "grooved_road", "gyro_stabiliser",
    "wire_steering", "brake_cable", "rubber_coupling", "tow_mode", "corner_steady", "two_tanks",
    "wishbone_bush", "bow_wave", "elastic_drawbar", "sway_assist", "late_air", "loose_u_bolts",
    "puncture", "binding_brake", "glazing_pads", "one_way_damper", "unlocked_slew",
    "wandering_ruts", "yaw_reference", "stepping_horse", "hydro_bush", "loose_curtain",
    "damper_play", "towbar_twist", "galloping", "rear_rack", "slow_actuator", "sideslip_limiter",
    "jockey_wheel", "counter_steer", "concrete_slabs", "leaking_load", "worn_shoulders",
    "aligning_torque", "binding_ball", "ball_rattle", "spring_bars", "slack_lashing",
    "lingering_flow", "torn_cable", "hub_drives", "angle_vectoring", "levelling_pump",
    "clay_tread", "racked_frame", "caster_flutter", "squealing_pads", "outward_damper",
    "seized_top_mount", "crosswind_assist", "link_steering", "broken_leaf", "snow_tracks",
    "hunting_vectoring", "roof_tent", "tearing_canvas", "cocked_overrun", "loosening_straps",
    "brinelled_ring", "stepper_rear", "gap_pump", "leaky_link", "bent_arm", "solenoid_brakes",
    "servo_ball", "rocking_hull", "quick_rear", "creeping_clamp", "rag_joint", "curve_brake",
    "locker_corner", "hanging_load", "bump_steer", "working_frame", "late_rear_steering",
    "slack_tarpaulin", "tilted_head", "puddles", "roll_protection", "subframe_rubber",
    "soft_tyre", "greasy_ball", "crooked_joint", "soft_verge", "leaning_stack", "loose_hub",
    "broken_link", "slipping_neck", "open_door", "shimmy", "lorry_ruts", "standing_water",
    "bump_stop_grip", "loose_hands", "worn_pad", "track_rod_end", "hopping_wheels",
    "buckled_wheel", "skew_joints", "slow_puncture", "late_correction", "rut_walls",
    "rolled_under", "one_wheel_brake", "stop_overload", "wind_shadow", "wet_stretches",
    "sliding_box", "loose_subframe", "gap_headwind", "sticky_beam", "worn_spot",
    "aged_tyres", "camera_rear", "bistable_wake", "open_crack", "controlled_joint",
    "binding_rack", "tailgate_crate", "caster_lock", "passing_lorry", "wallowing_tail",
    "lane_departure", "braking_driver",
)  # fmt: skip
"""Physics that no library of effects lists; sizes (and `more_at`, `more_frequency_hz`):

- moment about the ball beyond an articulation, N m/rad (rad)
- angle of the trailer's axles per articulation
- side area of the car times the slope of its air force, m2/rad
- angle of the front wheels per articulation rate, s
- mass on the car that swings sideways, kg (Hz)
- angle of the trailer's axles per articulation, through dry friction (rad at which it slides)
- the same of a tarpaulin as of the car, that follows the side-slip with a swing, m2/rad (Hz)
- side force on the trailer at a heading of 90 deg, N
- yaw moment on the trailer beyond a yaw rate, N m s/rad (rad/s)
- moment at the ball per squared articulation rate, N m s2/rad2
- angle of the car's rear wheels per angle of the front ones
- dry yaw moment on the trailer, N m
- area times the slope of the trailer's air force over the articulation, m2/rad
- yaw moment on the trailer against a large articulation rate, N m (rad/s of its half)
- angle of the front wheels per squared angle of theirs, 1/rad
- angle of the front wheels per articulation, late (s)
- yaw moment on the car beyond an articulation rate, N m s/rad (rad/s)
- inertia in the trailer that turns by itself, kg m2 (Hz); the trailer's own is beside it
- yaw moment on the trailer per speed and yaw rate, N s2/rad
- nothing of its own: the cargo of `slosh_mass_kg` rolls freely between two boards (m either way)
- yaw moment on the car against a large yaw rate over the speed, N m (rad/m of its three quarters)
- angle of the front wheels back to the road per heading of the car
- angle of the trailer's axles with their slip, rad at most
- angle of the car's rear wheels per yaw rate, s, late (s)
- angle of the front wheels per yaw rate of the car, s, behind a swing (Hz)
- nothing of its own: the cargo is a liquid, damped by the square of its rate (m to stop in)
- dry friction at the ball per articulation, N m/rad
- angle of the trailer's axles per yaw rate of the car, s
- angle of the trailer's axles per roll of the trailer, by dry friction (rad at which it slides)
- side force on the trailer that comes and goes along the road, N (m of its period)
- angle d of the trailer's axles after the slip a of their middle: d = k z, T dz/dt = a - z (s)
- share of the trailer tyres' slip a that they lose as they are worked: k w, dw/dt = (tanh(|a| /
  0.02 rad) - w)/T (s)
- angle of the car's rear wheels with their slip a: k tanh(a/a0), rad (rad)
- angle of the car's rear wheels per roll of the car p beyond p0: k (|p| - p0) sign p (rad)
- angle of the car's rear left wheel, k sin of the angle by which it has rolled, rad
- moment about the ball against the articulation g: k tanh(g/g0), N m (rad)
- dry friction at the ball behind a spring: k z/g0, dz/dt = dg/dt - |dg/dt| z/g0, N m (rad)
- nothing of its own: the cargo slides on the floor, m a0 tanh(v / 1 cm/s) (m/s2 at which it does)
- nothing of its own: the cargo's spring stiffens, 1 + (q/q0)^2 (m to twice the stiffness)
- angle of the front wheels lost to their rate r beyond r0: k (|r| - r0) sign r, s (rad/s)
- yaw moment on the car with the angle d of its front wheels: k tanh(d/d0), N m (rad)
- drag of all trailer wheels per lateral acceleration a of the trailer beyond a0: k (|a| - a0),
  0.15 s late, N s2/m (m/s2)
- area A of eddies at the trailer's rear, F = A p q with the dynamic pressure p, 2 m behind its COG:
  d2q/dt2 + 0.3 w (q^2 - 1) dq/dt + w^2 q = 5 a, w = 2 pi v/L, a lateral acceleration, m2 (m, L)
- area times the slope of the trailer's air force over the car's side-slip, 2.5 m ahead of its COG,
  m2/rad
- angle of all wheels against the heading h of their body: k h0 tanh(h/h0) (rad)
- yaw moment on the trailer against its yaw rate r: k (r - z), T dz/dt = r - z, N m s/rad (s)
- angle of the trailer's axles after the angle d of the car's front wheels: k z, T dz/dt = d - z (s)
- drag of the trailer's right wheels with the articulation g to one side: |k| max(g sign k, 0),
  N/rad
- moment about the ball against the articulation g: k (g - z), T dz/dt = g - z, N m/rad (s)
- angle of the car's rear wheels with the articulation g: k g0 tanh(g/g0) (rad)
- drag at the trailer's rear right corner, 2 m behind its COG and 0.9 m beside it, as it leans
  there: k max(p - p0, 0), p its roll, N/rad (rad)
- nothing of its own: half of the cargo moves 1.2 m ahead of the trailer's COG, the other half as
  far behind it, with a frequency of its own (Hz)
- angle of the car's front wheels with their slip a beyond a0: k (|a| - a0) sign a (rad)
- area times the slope of the air force on the car with the articulation, 2 m behind its COG, m2/rad
- stiffness of the drawbar, planar bodies only: the ball's place across the trailer gives way to its
  side force F: F = k (y + 4 ms dy/dt), N/m
- yaw moment on the car against its yaw rate r once it swings: k r min(max(z/z0 - 1, 0), 1),
  0.6 s dz/dt = |r| - z, N m s/rad (rad/s)
- area times the slope of the trailer's air force over a side-slip b that the flow follows over some
  way: F = k p z, (L/v) dz/dt = b - z, 1 m ahead of its COG, m2/rad (m)
- angle of the trailer's axles with the slip a of their middle, through dry friction: k z,
  dz/dt = da/dt - |da/dt| z/a0 (rad at which it slides)
- share of the slip that the tyres on the trailer's left lose at last: k z after a distance s,
  z = 1 - exp(-s/s0) (m)
- drag of the trailer's right wheels after a distance s: k (1 - exp(-s/s0)), N (m)
- dry friction at the ball, k/(1 + z/z0) after an angle z that it has rubbed, dz/dt = |dg/dt|, N m
  (rad)
- moment about the ball against an articulation rate q to one side: |k| max(q sign k, 0), N m s/rad
- inertia in the trailer that only friction takes along in yaw, kg m2 (N m); the trailer's own is
  beside it
- angle of all wheels, planar bodies only: k sin(2 pi s/L), s the way of their axle, rad (m)
- yaw moment on the car against its yaw rate r, less what the angle d of its front wheels asks for,
  beyond r0: k (|e| - r0) sign e, e = r - v d/(2.7 m (1 + (v/28 m/s)^2)), N m s/rad (rad/s)
- nothing of its own: the cargo's spring holds it at a stance z that follows the trailer's lateral
  acceleration a late, T dz/dt = 0.15 m tanh(a/(1 m/s2)) - z (s)
- angle of the car's front wheels against their slip a, unless it lasts: k (a - z), T dz/dt = a - z
  (s)
- area times the slope of the trailer's air force with a side-slip b to one side:
  |k| max(b sign k, 0), 1 m behind its COG, m2/rad
- moment about the ball of a damper behind a stiff strut with play, against the articulation g:
  100 kN m/rad e, e = (|g - z| - g0) sign(g - z) beyond the play, else 0, k dz/dt the same moment,
  N m s/rad (rad either way)
- angle of the car's rear wheels, planar bodies only, with the side force of the car on the
  trailer, 30 ms late, rad/N
- area times the slope of the trailer's air force with the side-slip b, x = b/b0:
  F = k p b0 x (1 - x^2)/(1 + x^2), m2/rad (rad where it turns)
- mass above the ball, of the car, that swings sideways with dry friction and no other damping, kg
  (m/s2, Hz)
- angle of the trailer's axles with its yaw rate r: k z, dz/dt = (r - z)/(0.1 s), no more than r1, s
  (rad/s2)
- yaw moment on the car with its side-slip b beyond b0: k (|b| - b0) sign b, N m/rad (rad)
- side force 0.6 m behind the ball against the slip a there: k tanh(a/a0), N (rad)
- angle of the car's front wheels with the trailer's yaw rate r: k r0 tanh(r/r0), s (rad/s)
- share of the slip that the trailer's tyres lose and gain, k sin(2 pi s/L) after a distance s (m)
- share of its mass m that a planar trailer has lost after a distance s: its lateral acceleration a
  asks for less force, by k (1 - exp(-s/s0)) m a at its COG (m)
- angle of the car's rear wheels with the size of their slip a: k |a|
- yaw moment on the trailer with the mean slip a of its tyres: k a/(1 + (a/a0)^2), N m/rad (rad)
- dry friction at the ball per side force of the car on the trailer, planar bodies only, 30 ms late,
  m
- play of the ball across the trailer either way, planar bodies only; beyond it 400 kN/m hold it, m
- moment about the ball with the roll p of the trailer beyond p0: k (|p| - p0) sign p, N m/rad (rad)
- nothing of its own: the cargo's spring has the share |s| of its stiffness to the side of the sign
  of s (s)
- area times the slope of the trailer's air force over a side-slip b with hysteresis: F = k p z,
  dz/dt = db/dt - |db/dt| z/b0, 1 m ahead of its COG, m2/rad (rad)
- drag of each right wheel of the trailer with its lateral acceleration a beyond a0: k (|a| - a0),
  0.15 s late, N s2/m (m/s2)
- yaw moment on the trailer with the angle d of the car's front wheels: k z, T dz/dt = d - z,
  N m/rad (s)
- yaw moment on the car with the articulation g: k tanh(g/g0), N m (rad)
- angle of the car's rear wheels after the roll p of the car: k z, T dz/dt = p - z (s)
- share of the slip that the car's front tyres lose after a distance s: k exp(-s/s0) (m)
- angle of the trailer's axles with the side force F of the car on the trailer, planar bodies only,
  30 ms late: k tanh(F/F0), rad (N)
- angle of the trailer's axles after the slip a of their middle: k z, z behind a swing with a
  damping ratio of 0.15 (Hz)
- dry friction at the ball that falls with the articulation rate q: k/(1 + (q/q0)^2), N m (rad/s)
- moment about the ball against an articulation rate q away from an articulation g of nought:
  k q (1 + sign q tanh(g/g0))/2, N m s/rad (rad)
- angle of the car's front wheels held back from their own, d, by dry friction: -k z,
  dz/dt = dd/dt - |dd/dt| z/d0 (rad at which it slides)
- angle of the front wheels with the lateral acceleration a of a planar car: k z,
  dz/dt = (a - z)/(0.1 s), no more than a1, rad s2/m (m/s3)
- angle of the car's rear wheels after the trailer's yaw rate r through play: k z, z follows r 20 ms
  late once it is more than r0 away, s (rad/s either way)
- angle of the trailer's axles with the roll p of the trailer to one side: |k| max(p sign k, 0)
- share of the slip that the trailer's tyres lose with the articulation g: k tanh((g/g0)^2) (rad)
- yaw moment on the car after the articulation rate q: k z, a swing that q drives, damped by 0.15,
  N m s/rad (Hz)
- area times the slope of the air force on the car over a side-slip b beyond b0, 1 m behind its
  COG: F = k p (|b| - b0) sign b, m2/rad (rad)
- area times the slope of the trailer's air force over its side-slip after a distance s, 1 m behind
  its COG: k (1 - exp(-s/s0)), m2/rad (m)
- drag of each left wheel of the trailer, planar bodies only, with the side force F of the car on
  the trailer to one side, 30 ms late: |k| max(F sign k - F0, 0) (N)
- nothing of its own: the cargo's spring loses 0.85 of its stiffness over a distance s, by
  1 - exp(-s/s0) (m)
- moment about the ball with the articulation g: k sin(2 pi g/g0), N m (rad of its period)
- angle of the car's rear wheels after its yaw rate r in steps: k z, z follows the nearest multiple
  of r0 50 ms late, s (rad/s)
- area times the slope of the air force on the car with the articulation rate q: F = k p q 2 m/v,
  2 m behind its COG, m2/rad
- angle of the trailer's axles with the articulation g: k (g - z), T dz/dt = g - z (s)
- angle of the car's front wheels with the size of the roll p of the car: k |p|
- yaw moment on the trailer against its yaw rate r: k z sign r, (0.3 s) dz/dt = 1 - z where |r| is
  beyond r0, else -z, N m (rad/s)
- moment about the ball with the trailer's yaw rate r: k tanh(z/r0), (50 ms) dz/dt = r - z, N m
  (rad/s)
- nothing of its own: the cargo's spring pulls as q0 tanh(q/q0) (m)
- angle of the car's rear wheels with the rate r of the angle of the front ones: k r0 tanh(r/r0), s
  (rad/s)
- angle z of the trailer's axles after the slip a of their middle: dz/dt = k (|a| - a0) sign a while
  |a| is beyond a0, 1/s (rad)
- angle of the car's front wheels beside their own, d: k (z - d), z behind a swing that d drives,
  damped by 0.15 (Hz)
- yaw moment on the car with its lateral acceleration a, planar bodies only: k z,
  (0.15 s) dz/dt = (|a| - a0) sign a - z, beyond a0, else -z, N s2 (m/s2)
- moment about the ball with the articulation g to one side: k max(g sign k - g0, 0), N m/rad (rad)
- nothing of its own: the cargo's spring is 11 times as stiff beyond q0, as walls (m)
- angle of the car's front wheels with the roll p of the car: k p^3, 1/rad2
- angle of the trailer's axles, planar bodies only, with the side force F of the car on the trailer,
  30 ms late, by dry friction: k z, dz/dt = dF/dt - |dF/dt| z/F0, rad/N (N at which it slides)
- angle of the car's rear wheels with the angle d of the front ones: k z, T dz/dt = d - z (s)
- area times the slope of the trailer's air force over a side-slip b beyond b0, 1 m behind its COG:
  F = k p (|b| - b0) sign b, m2/rad (rad)
- dry friction at the ball per roll of the trailer, N m/rad
- share of the slip that the car's front tyres lose and regain after a distance s:
  k (1 + sin(2 pi s/L))/2 (m)
- drag of each wheel of the trailer on the outer side, planar bodies only, with its lateral
  acceleration a beyond a0: k (|a| - a0), 0.15 s late, N s2/m (m/s2)
- angle of the car's rear wheels with their slip a: k z, T dz/dt = a - z (s)
- share of the slip that the trailer's tyres lose with its roll p to one side:
  |k| tanh(max(p sign k, 0)/p0) (rad)
- dry friction at the ball with the articulation g to one side: |k| (1 + sign k tanh(g/g0))/2, N m
  (rad)
- angle of the car's front wheels with the angle w of the steering wheel: k sin(w)^2, rad
- drag of each right wheel of the trailer after a distance s: k max(sin(2 pi s/L), 0), N (m)
- nothing of its own: of what holds the cargo, by its place q, 0.6 is dry friction: 0.4 q + 0.6 z,
  dz/dt = dq/dt - |dq/dt| z/q0 (m at which it slides)
- yaw moment on the car with the size of the slip a of its front tyres: k |a|, N m/rad
- angle of the car's rear wheels with its roll p: k z p, z goes from 0 to 1 within 50 ms once |p| is
  beyond p0, and stays (rad)
- compliance of the ball across the trailer, planar bodies only, with dry friction beside it:
  F = (y + 4 ms dy/dt)/k + F0 z/(0.2 mm), dz/dt = dy/dt - |dy/dt| z/(0.2 mm), m/N (N)
- area times the slope of the air force on a door 2.5 m behind the trailer's COG, over the side-slip
  b there: F = k p (b - z), z turns after b with a swing of a period L/v, damped by 0.2, m2/rad
  (m, L)
- angle of the car's front wheels that swings by itself: k q/2, with their slip a:
  d2q/dt2 + 0.3 w (q^2 - 1) dq/dt + w^2 q = 5 w^2 a, rad (Hz)
- angle of all wheels, planar bodies only, by the place y of their axle across the road, x = y/y0:
  -2 k x/(1 + x^2), rad (m of its largest); the course m of the road follows that of the car's COG,
  c, 2.5 s late, and of that COG dy/dt = v sin(c - m) - y/(2.5 s)
- drag of the car's front left wheel after a distance s: k (v/(25 m/s))^2 max(sin(2 pi s/L), 0),
  N (m)
- share of the slip that the car's rear tyres lose with its roll p beyond p0:
  k tanh(|p|/p0 - 1) (rad)
- angle of the car's front wheels with their slip a: k z, T dz/dt = a - z (s)
- dry friction at the ball with an articulation rate to one side, |k|, to the other a share of it,
  N m (the share)
- angle of the car's front left wheel with its slip a: k tanh(a/a0), rad (rad)
- share of the slip that the car's rear tyres lose after a distance s: k max(sin(2 pi s/L), 0) (m)
- angle of the trailer's front right wheel, k sin of the angle by which it has rolled, rad
- angle of all wheels, planar bodies only: k cos(pi s/L)^64, s the way of their axle, rad (m)
- share of the slip that the car's rear right tyre loses at last: k z after a distance s,
  z = 1 - exp(-s/s0) (m)
- angle of the car's front wheels against its yaw rate r: -k z, (T/2) dz/dt = y - z,
  (T/2) dy/dt = r - y, s (s)
- angle of the trailer's axles, planar bodies only, by the place y of each beside the car's track:
  -k tanh((|y| - y0)/(5 cm)) sign y beyond y0, rad (m either way); of that track's direction m, of
  the course c of the car's COG and of the way l between both COGs (l/2v) dm/dt = c - m
- share of the slip a that the trailer's tyres of one side lose while their force is inwards: |k|
  where a sign k > 0, of the left ones with k > 0, else of the right ones
- yaw moment on the car against its yaw rate r: -k z, (0.15 s) dz/dt = (|r| - r0) sign r - z beyond
  r0, else -z, N m s/rad (rad/s)
- share of the slip that the trailer's tyres lose with its roll p beyond p0: k x^2/(1 + x^2),
  x = |p|/p0 - 1 (rad)
- area times the slope of the trailer's air force over the articulation g: F = k p g |g|, 2.5 m
  ahead of its COG, m2/rad2
- share of the slip that all tyres lose, planar bodies only: k max(sin(2 pi s/L), 0), s the way of
  their axle (m)
- nothing of its own: the cargo slides on the floor, m (0.5 m/s2) tanh(v/1 cm/s), and is held only
  beyond a place of q0 (m either way)
- angle of the car's front wheels with their slip a, through dry friction: k z,
  dz/dt = da/dt - |da/dt| z/a0 (rad at which it slides)
- area times the slope of the trailer's air force over its side-slip after a distance s, 2.5 m ahead
  of its COG: k (1 + sin(2 pi s/L))/2, m2/rad (m)
- angle of the rear wheels of a planar car with its roll p, by dry friction: k z,
  dz/dt = dp/dt - |dp/dt| z/p0 (rad at which it slides)
- dry friction at the ball with the articulation g: k x^2/(1 + x^2), x = g/g0, N m (rad)
- share of the slip a that the trailer's tyres lose: k x^2/(1 + x^2), x = a/a0 (rad)
- angle of the car's rear wheels with the articulation as it was last seen, every T: k z (s)
- area of the trailer's tail times the part z of the dynamic pressure p by which its wake lies to
  one side, 2 m behind its COG: F = -k p z, (4 m/v) dz/dt = tanh(2 z + 0.533 b/b0) - z, its
  side-slip b, m2 (rad at which it turns over)
- stiffness of the drawbar, planar bodies only: the ball's place y across the trailer gives way to
  its side force F to the side of the sign of k: F = |k| (y + 4 ms dy/dt), to the other side with
  2 MN/m, N/m
- moment about the ball against the articulation rate q with the car's yaw rate r: k z q,
  (0.1 s) dz/dt = |r| - z, N m s2/rad2
- angle of the car's front wheels that is lost to friction as they slip by a and are steered with a
  rate r: -k |a| tanh(r/r0) (rad/s)
- mass above the ball, of the car, that slides with dry friction, and is held beyond 5 cm either way
  by walls, damped by 0.3, kg (m/s2, Hz)
- share of the slip a that the trailer's tyres lose once their axles' pin is up: k z, z goes to 1
  within 30 ms where |a| of their middle is beyond a0, to 0 where it is below a0/3 (rad)
- side force of the air about lorries, one every T, N: F = k u exp((1 - u^2)/2), u the time since
  one was beside the trailer's COG over 0.4 s, (3 m) tanh u ahead of it (s)
- angle of the car's rear wheels after its roll p: k z, z behind a swing with a damping ratio of
  0.15 (Hz)
- angle of the car's front wheels by its place y across the lane beyond y0: -k (|y| - y0) sign y,
  rad/m (m); the lane's course follows that of the car's COG, c, 2.5 s late, m, and
  dy/dt = v sin(c - m) - y/(2.5 s)
- drag of the car's front left wheel for k > 0, else of the right one, with its yaw rate r: |k| z,
  (T/2) dz/dt = y - z, (T/2) dy/dt = max(|r| - 0.02 rad/s, 0) - y, N s/rad (s)
"""


@dataclass(frozen=True)
class Physics:
    """Everything that can be switched on; the defaults are the healthy planar combination.

    full
        Bodies with heave, pitch and roll on suspensions. Off: bodies move in the plane, wheel
        loads follow from the quasi-static balance of roll, split by `Body.front_share`.
    tyre_law, peak_friction, shape
        ``linear`` F = C alpha; ``magic_formula`` F = D sin(c atan(C alpha/(c D))),
        D = mu F_z (Pacejka); ``brush`` the cubic of Fiala.
    load_degression
        C(F_z) = C0 r (1 - d (r - 1)), r = F_z/F_z0.
    relaxation_m
        Relaxation length of each axle: (s/v) d(alpha')/dt + alpha' = alpha.
    steering_stiffness_n_rad
        Road wheel angle = steering wheel angle / ratio - F_yf/K_s (Eq. 5.3); 0 is rigid.
    free_play_rad, free_play_law
        Play at the steering wheel, ``backlash`` (the road wheels stay until the gap is used up)
        or ``aligned`` (tyre forces hold the road wheels at the soft side of the gap).
    hitch_friction_nm, hitch_damping_nms_rad, hitch_spring_nm_rad
        Moments about the ball's vertical axis against the articulation.
    side_force_coefficient, yaw_moment_coefficient
        Air on the trailer: Y = -c_y (rho/2) v^2 A beta, N = -c_n (rho/2) v^2 A (1 m) beta, with
        beta its side-slip angle, A = 5 m2.
    drag_area_m2
        c_w A of car and trailer: air drag at both centres of gravity.
    roll_steer
        Steer of each axle per roll of its body.
    axle_load
        Harmonic axle load, see :class:`HarmonicLoad`.
    damper_factor
        Of each wheel, in time when the run's input says so.
    slosh_mass_kg, slosh_frequency_hz, slosh_damping, slosh_position_m
        A mass in the trailer that can move sideways on a spring (part of the trailer's mass).
    yaw_moment_nms_rad
        A controller's moment on the car, -k times its yaw rate.
    wheel_drag_n
        Drag of the trailer's front right wheel, as from a dragging brake.
    more, more_size, more_at, more_frequency_hz
        One kind of `MORE`, its size, where it begins or ends, and a frequency of its own.
    """

    full: bool = False
    tyre_law: str = "linear"
    peak_friction: float = 1.0
    shape: float = 1.5
    load_degression: float = 0.0
    relaxation_m: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    steering_stiffness_n_rad: float = 0.0
    free_play_rad: float = 0.0
    free_play_law: str = "backlash"
    hitch_friction_nm: float = 0.0
    hitch_damping_nms_rad: float = 0.0
    hitch_spring_nm_rad: float = 0.0
    side_force_coefficient: float = 0.0
    yaw_moment_coefficient: float = 0.0
    drag_area_m2: tuple[float, float] = (0.0, 0.0)
    roll_steer: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    axle_load: HarmonicLoad | None = None
    damper_factor: tuple[float, ...] = (1.0,) * 8
    slosh_mass_kg: float = 0.0
    slosh_frequency_hz: float = 0.9
    slosh_damping: float = 0.05
    slosh_position_m: float = 0.0
    yaw_moment_nms_rad: float = 0.0
    wheel_drag_n: float = 0.0
    more: str = ""
    more_size: float = 0.0
    more_at: float = 0.0
    more_frequency_hz: float = 1.0


def _axle(place: float, stiffness: float, track: float, spring: float, bar: float) -> Axle:
    return Axle(place, stiffness, track, 40.0, spring, bar, Damper())


def reference_combination() -> Combination:
    """The combination of Tables A and B; heights and suspensions are typical values."""
    car = Body(
        mass_kg=1955.0,
        yaw_inertia_kgm2=2690.0,
        roll_inertia_kgm2=620.0,
        pitch_inertia_kgm2=2550.0,
        cog_height_m=0.62,
        hitch_to_cog_m=2.166,
        front=_axle(1.302, 109.3e3, 1.5, 27e3, 16e3),
        rear=_axle(-1.383, 185.2e3, 1.5, 30e3, 8e3),
        roll_gain_rad_m_s2=0.009,
    )
    trailer = Body(
        mass_kg=1880.0,
        yaw_inertia_kgm2=10350.0,
        roll_inertia_kgm2=1250.0,
        pitch_inertia_kgm2=9900.0,
        cog_height_m=0.8,
        hitch_to_cog_m=5.073,
        front=_axle(0.124, 131.2e3, 2.0, 55e3, 0.0),
        rear=_axle(-0.526, 124.4e3, 2.0, 55e3, 0.0),
        roll_gain_rad_m_s2=0.012,
        front_share=0.5,
    )
    return Combination(car, trailer)


def static_loads(combination: Combination) -> tuple[float, float, float, float]:
    """Axle loads at rest, N, in the order of `AXLES`; the nose load is given."""
    nose = combination.nose_load_n
    car, trailer = combination.car, combination.trailer

    def pair(body: Body, force: float, lever: float) -> tuple[float, float]:
        """Loads of both axles under the weight and a force down at `lever` ahead of the COG."""
        base = body.front.to_cog_m - body.rear.to_cog_m
        total = body.mass_kg * GRAVITY + force
        front = (force * lever - total * body.rear.to_cog_m) / base
        return front, total - front

    return *pair(car, nose, -car.hitch_to_cog_m), *pair(trailer, -nose, trailer.hitch_to_cog_m)


@dataclass(frozen=True)
class Inputs:
    """What a run is driven by; each value is an array over `time_s` (evenly spaced) or absent.

    steering_wheel_rad, speed_m_s : the driver's, required.
    car_side_force_n, trailer_side_force_n : gusts, positive left, at the COG.
    bank_rad : cross-fall; positive lifts the left side, so the weight pulls right.
    friction_factor : on the peak friction of every tyre.
    stiffness_factor : axle name to factor on its cornering stiffness.
    harmonic_n, harmonic_delay_s : of the axle load generator.
    damper_fade : 1 where `Physics.damper_factor` acts in full, 0 where it does not.
    """

    time_s: object
    steering_wheel_rad: object
    speed_m_s: object
    car_side_force_n: object = None
    trailer_side_force_n: object = None
    bank_rad: object = None
    friction_factor: object = None
    stiffness_factor: dict[str, object] = field(default_factory=dict)
    harmonic_n: object = None
    harmonic_delay_s: object = None
    damper_fade: object = None
