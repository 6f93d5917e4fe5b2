"""The statements of the paper's Section 3.1: data, start, constant torque."""

from __future__ import annotations

from crosscheck.paper.claims.quantities import CONSTANT, CONSTANT_NO_ERROR, STATIC
from crosscheck.paper.claims.rule import Claim, Limits, about, above, below, each, of, ratio
from crosscheck.paper.claims.section2 import DOUBLED, EXACT, HALVED, TORQUE_SHARE
from crosscheck.paper.claims.statics import BENDS
from crosscheck.registry import RIGID_LEVELS

READ_OFF = 0.25
# What rounds to the digit that the paper prints.
TWO_HUNDREDTHS, ONE_HUNDREDTH, THIRTY = Limits(0.015, 0.025), Limits(0.005, 0.015), Limits(25, 35)
TOLERABLE = 0.05  # of the half-circle stroke
SLIGHT = 0.05  # of the largest angle
RATIO = 99 / 27 + 1
LEVEL = "the rigid baseline"
RAPID_S = 0.1
MOSTLY = 0.95

START = (
    Claim(
        "3",
        None,
        "The gearbox amplifies the torque by the reduction ratio.",
        "mesh torque on the carrier over the motor's, constant torque",
        "1",
        of(CONSTANT("torque_gain")),
        about(RATIO, TORQUE_SHARE),
    ),
    Claim(
        "3",
        8,
        "At the start the teeth are just touching, without force.",
        "mesh force at t = 0",
        "N",
        of(CONSTANT("force_at_start_N")),
        below(EXACT),
    ),
    Claim(
        "3",
        None,
        "The initial values listed for the detailed model are its state.",
        "initial values listed, for twelve first-order states",
        "1",
        of(STATIC("initial_values")),
        Limits(11.5, 12.5),
    ),
    Claim(
        "3",
        None,
        "Table I: M is an inertia over a squared radius and m a mass.",
        "sun's radius of gyration over its pitch radius",
        "1",
        of(STATIC("gyration_over_pitch")),
        below(1.0),
    ),
)

DEVIATIONS = (
    Claim(
        "3.1",
        6,
        "The first link deviates by 0.02 rad from the rigid model.",
        "largest deviation of theta_1 in 0.5 s",
        "rad",
        each(RIGID_LEVELS, lambda level: of(CONSTANT(f"deviation_1_{level}_rad"))),
        TWO_HUNDREDTHS,
        LEVEL,
    ),
    Claim(
        "3.1",
        6,
        "The second link deviates by 0.01 rad from the rigid model.",
        "largest deviation of theta_2 in 0.5 s",
        "rad",
        each(RIGID_LEVELS, lambda level: of(CONSTANT(f"deviation_2_{level}_rad"))),
        ONE_HUNDREDTH,
        LEVEL,
    ),
    Claim(
        "3.1",
        6,
        "Deviations of 0.02 and 0.01 rad put the tip off by about 30 mm.",
        "tip displacement by these two angles",
        "mm",
        each(BENDS, lambda angle: of(STATIC(f"bent_{angle}_mm"))),
        THIRTY,
        "the elbow's angle [deg]",
    ),
    Claim(
        "3.1",
        6,
        "The tip is off by about 30 mm.",
        "largest tip deviation from the rigid model in 0.5 s",
        "mm",
        each(RIGID_LEVELS, lambda level: of(CONSTANT(f"tip_{level}_mm"))),
        THIRTY,
        LEVEL,
    ),
    Claim(
        "3.1",
        6,
        "The errors are tolerable against the half-circle stroke.",
        "larger joint deviation over pi",
        "1",
        each(RIGID_LEVELS, lambda level: of(CONSTANT(f"stroke_share_{level}"))),
        below(TOLERABLE),
        LEVEL,
    ),
    Claim(
        "3.1",
        6,
        "The errors accumulate over time.",
        "largest tip deviation in the second half over that in the first",
        "1",
        each(RIGID_LEVELS, lambda level: of(CONSTANT(f"growth_{level}"))),
        above(DOUBLED),
        LEVEL,
    ),
    Claim(
        "3.1",
        7,
        "The deviation from the rigid model shows the influence of the gear meshing.",
        "deviation left when the rigid model has the gears' masses and inertias, over all of it",
        "1",
        ratio(CONSTANT("deviation_1_coupled_rad"), CONSTANT("deviation_1_links_rad")),
        above(HALVED),
    ),
    Claim(
        "3.1",
        6,
        "The detailed model's response differs slightly from the rigid model's.",
        "largest joint deviation over the largest joint angle",
        "1",
        each(RIGID_LEVELS, lambda level: of(CONSTANT(f"relative_{level}"))),
        below(SLIGHT),
        LEVEL,
    ),
)

MESH = (
    Claim(
        "3.1",
        8,
        "x_sp converges to 52 um.",
        "middle of the range of x_sp after 0.1 s",
        "um",
        of(CONSTANT("x_middle_um")),
        about(52, 0.02),
    ),
    Claim(
        "3.1",
        8,
        "x_sp vibrates at the beginning and converges rapidly.",
        "time in which the vibration of F_sp / k falls to a tenth",
        "s",
        of(CONSTANT("vibration_decay_s")),
        below(RAPID_S),
    ),
    Claim(
        "3.1",
        9,
        "F_sp follows the same trend: it vibrates and converges.",
        "swing before 0.1 s over swing after",
        "1",
        of(CONSTANT("force_decay")),
        above(DOUBLED),
    ),
    Claim(
        "3.1",
        9,
        "A starting impact causes it.",
        "largest mesh force over its mean after 0.1 s",
        "1",
        of(CONSTANT("force_overshoot")),
        above(1.2),
    ),
    Claim(
        "3.1",
        8,
        "The fluctuation of x_sp that follows is due to the tooth error.",
        "ripple of x_sp after 0.1 s without tooth error over that with it",
        "1",
        ratio(CONSTANT_NO_ERROR("x_ripple_um"), CONSTANT("x_ripple_um")),
        below(HALVED),
    ),
    Claim(
        "3.1",
        8,
        "Its magnitude is about 10 um.",
        "ripple of x_sp after 0.1 s, peak to peak",
        "um",
        of(CONSTANT("x_ripple_um")),
        about(10, READ_OFF),
    ),
    Claim(
        "3.1",
        8,
        "That is similar to the given tooth error.",
        "ripple over the tooth error's own 2 E",
        "1",
        of(CONSTANT("x_ripple_over_2E")),
        about(1, READ_OFF),
    ),
    Claim(
        "3.1",
        8,
        "Its frequency rises with time.",
        "turning points of the ripple in the second half less those in the first",
        "1",
        of(CONSTANT("turns_gained")),
        above(0.5),
    ),
    Claim(
        "3.1",
        8,
        "The frequency rises because the shoulder speeds up.",
        "share of the 0.5 s in which the shoulder speeds up",
        "1",
        of(CONSTANT("speeding_up")),
        above(MOSTLY),
    ),
)

CLAIMS = (*START, *DEVIATIONS, *MESH)
