"""The statements of the paper's Sections 4 and 4.1: the size of the backlash."""

from __future__ import annotations

import numpy as np

from crosscheck.paper.claims.control import EXISTS, MINOR, POSITION_RAD
from crosscheck.paper.claims.quantities import BACK, BACKLASH, NO_BACKLASH, PD, STATIC
from crosscheck.paper.claims.rule import (
    CLEAR_RANK,
    Claim,
    Formula,
    Known,
    about,
    above,
    along,
    below,
    difference,
    each,
    greatest,
    least,
    of,
    over,
    rank,
    ratio,
    size,
    spread,
    where,
)
from crosscheck.paper.claims.section2 import DOUBLED, HALVED, SEVERE

MANY_SIDES = 2.0
CLOSED_LOOP_RAD = 1e-4
SUPPRESSED = 0.1
CONTINUOUS = 0.2  # of the energy in one line, at most
GREATER = 2.0
OVERTONE = 0.01
SUITABLE = 1.05  # over the least that any backlash reaches
SECONDS = ("1", "2")
DURATION = "duration of the run [s]"

falls, rises = below(-CLEAR_RANK), above(CLEAR_RANK)


def worst(n: Known) -> np.ndarray:
    """Larger mesh force [N] of impact and third fluctuation, for every backlash ascending."""
    impact, third = along(BACKLASH, "second_force_N", n)[1], along(BACKLASH, "third_force_N", n)[1]
    return np.maximum(impact, third)


def edges_over_least(n: Known) -> float:
    """Smaller of the worst forces at the least and the largest backlash, over the least of all."""
    forces = worst(n)
    return float(np.minimum(forces[0], forces[-1]) / forces.min())


def default_over_least(n: Known) -> float:
    """Worst force at b = 50 um over the least of all backlashes."""
    default = np.maximum(n[BACKLASH(50)("second_force_N")], n[BACKLASH(50)("third_force_N")])
    return float(default / worst(n).min())


def growth_over_own(second: str) -> Formula:
    """Growth of the back-and-forth error since 0.1 to 0.3 s over the rigid arm's own."""

    error, own = (
        ratio(BACK(50)(f"{kind}_{second}_s"), BACK(50)(f"{kind}_early"))
        for kind in ("error", "own")
    )
    return over(error, own)


def severe_least_over_greatest(n: Known) -> float:
    """Smallest over largest third fluctuation of all backlashes; nan unless one is severe."""
    largest = greatest(BACKLASH, "third")(n)
    return float(least(BACKLASH, "third")(n) / largest) if largest > SEVERE else float("nan")


BEGINNING = (
    Claim(
        "4",
        17,
        "Backlash weakens the self-excited fluctuation.",
        "third fluctuation without backlash over that with it, where there is one",
        "1",
        where(NO_BACKLASH("third"), EXISTS, ratio(NO_BACKLASH("third"), PD("third"))),
        above(1.0),
    ),
    Claim(
        "4",
        16,
        "Fluctuations from the start cannot be avoided.",
        "smallest first fluctuation of all backlashes",
        "rad/s²",
        least(BACKLASH, "first"),
        above(MINOR),
    ),
    Claim(
        "4",
        16,
        "Fluctuations from meshing impacts cannot be avoided.",
        "smallest second fluctuation of all backlashes",
        "rad/s²",
        least(BACKLASH, "second"),
        above(MINOR),
    ),
)

POSITION = (
    Claim(
        "4.1",
        10,
        "With a clearance of 100 um the positioning error stays on a 0.001 rad scale.",
        "largest deviation from the rigid arm with the gears' inertia",
        "rad",
        of(PD("deviation_rad")),
        below(DOUBLED * POSITION_RAD),
    ),
    Claim(
        "4.1",
        10,
        "With a clearance of 6 mm the positioning error stays on a 0.001 rad scale.",
        "largest deviation from the rigid arm with the gears' inertia",
        "rad",
        of(BACKLASH(3000)("deviation_rad")),
        below(DOUBLED * POSITION_RAD),
    ),
    Claim(
        "4.1",
        None,
        "6 mm is nearly a third of the tooth thickness.",
        "6 mm over the tooth thickness at the pitch circle, pi m / 2",
        "1",
        of(STATIC("tooth_thickness_share")),
        about(1 / 3, 0.1),
    ),
    Claim(
        "4.1",
        10,
        "In closed loop the final error converges to zero, even with 6 mm.",
        "final error of theta_1 with 6 mm less that with 100 um",
        "rad",
        size(difference(BACKLASH(3000)("final_1_rad"), PD("final_1_rad"))),
        below(CLOSED_LOOP_RAD),
    ),
    Claim(
        "4.1",
        15,
        "Driven back and forth, the error accumulates.",
        "largest error of the last 0.2 s over that from 0.1 to 0.3 s",
        "1",
        each(SECONDS, lambda s: ratio(BACK(50)(f"error_{s}_s"), BACK(50)("error_early"))),
        above(DOUBLED),
        DURATION,
    ),
    Claim(
        "4.1",
        15,
        "That error grows with the backlash.",
        "rank correlation of the error in the last 0.2 s with b",
        "1",
        each(SECONDS, lambda s: rank(BACK, f"error_{s}_s")),
        rises,
        DURATION,
    ),
    Claim(
        "4.1",
        15,
        "The error of the backlash itself accumulates over the swings.",
        "growth of the error over that of a rigid arm started 1e-6 rad off",
        "1",
        each(SECONDS, growth_over_own),
        above(DOUBLED),
        DURATION,
    ),
)

IMPACT = (
    Claim(
        "4.1",
        16,
        "A larger clearance makes the meshing impact more severe.",
        "rank correlation of the impact's mesh force with b",
        "1",
        rank(BACKLASH, "second_force_N"),
        rises,
    ),
    Claim(
        "4.1",
        16,
        "The impact occurs later with a larger clearance.",
        "rank correlation of the side change's time with b",
        "1",
        rank(BACKLASH, "side_change_s"),
        rises,
    ),
    Claim(
        "4.1",
        16,
        "The impact lasts shorter with a larger clearance.",
        "rank correlation of its time of decay with b",
        "1",
        rank(BACKLASH, "second_decay_s"),
        falls,
    ),
    Claim(
        "4.1",
        16,
        "A larger clearance needs more time to come into contact again.",
        "rank correlation of the free flight's time with b",
        "1",
        rank(BACKLASH, "flight_s"),
        rises,
    ),
)

FLUCTUATION = (
    Claim(
        "4.1",
        17,
        "Backlash has a strong effect on the size of the fluctuation.",
        "largest over smallest third fluctuation of all backlashes, where there is one",
        "1",
        where(PD("third"), EXISTS, spread(BACKLASH, "third")),
        above(DOUBLED),
    ),
    Claim(
        "4.1",
        17,
        "With small clearances it is similar to that without.",
        "third fluctuation at b = 5 um over that at b = 0, where there is one",
        "1",
        where(BACKLASH(5)("third"), EXISTS, ratio(BACKLASH(5)("third"), NO_BACKLASH("third"))),
        about(1.0, HALVED),
    ),
    Claim(
        "4.1",
        17,
        "Internal excitation recedes as the clearance grows.",
        "rank correlation of the third fluctuation with b, where there is one",
        "1",
        where(PD("third"), EXISTS, rank(BACKLASH, "third")),
        falls,
    ),
    Claim(
        "4.1",
        17,
        "Its mesh force recedes as the clearance grows.",
        "rank correlation of the fast mesh force with b, where there is a fluctuation",
        "1",
        where(PD("third"), EXISTS, rank(BACKLASH, "third_force_fast_N")),
        falls,
    ),
    Claim(
        "4.1",
        17,
        "With a small clearance the contact keeps changing sides.",
        "side changes in the third fluctuation at b = 5 um",
        "1",
        of(BACKLASH(5)("side_changes")),
        above(MANY_SIDES),
    ),
    Claim(
        "4.1",
        17,
        "A smaller clearance is not better.",
        "third fluctuation at b = 5 um over that at 50 um, where there is one",
        "1",
        where(BACKLASH(5)("third"), EXISTS, ratio(BACKLASH(5)("third"), PD("third"))),
        above(1.0),
    ),
    Claim(
        "4.1",
        17,
        "A suitable clearance suppresses severe fluctuation.",
        "smallest over largest third fluctuation of all backlashes, where 5 um fluctuates severely",
        "1",
        severe_least_over_greatest,
        below(SUPPRESSED),
    ),
)

SPECTRA = (
    Claim(
        "4.1",
        18,
        "The shoulder fluctuates at about 1500 Hz.",
        "dominant frequency, where there is a third fluctuation",
        "Hz",
        where(PD("third"), EXISTS, of(PD("frequency_Hz"))),
        about(1500, 0.1),
    ),
    Claim(
        "4.1",
        18,
        "The elbow fluctuates at about 1500 Hz.",
        "dominant frequency, where there is a third fluctuation",
        "Hz",
        where(PD("third"), EXISTS, of(PD("frequency_elbow_Hz"))),
        about(1500, 0.1),
    ),
    Claim(
        "4.1",
        18,
        "Doubled frequencies appear as well.",
        "line at twice the frequency over the first, where there is a third fluctuation",
        "1",
        where(PD("third"), EXISTS, of(PD("overtone"))),
        above(OVERTONE),
    ),
    Claim(
        "4.1",
        18,
        "The elbow's acceleration is much larger than the shoulder's.",
        "third fluctuation of the elbow over the shoulder's, where there is one",
        "1",
        where(PD("third"), EXISTS, ratio(PD("third_elbow"), PD("third"))),
        above(GREATER),
    ),
    Claim(
        "4.1",
        18,
        "The frequency drifts down as the clearance grows.",
        "rank correlation of the frequency with b, where there is a third fluctuation",
        "1",
        where(PD("third"), EXISTS, rank(BACKLASH, "frequency_Hz")),
        falls,
    ),
    Claim(
        "4.1",
        18,
        "Above 500 um the fluctuation is chaotic, its spectrum continuous.",
        "energy share of the largest line at b = 1000 um, where there is a fluctuation",
        "1",
        where(BACKLASH(1000)("third"), EXISTS, of(BACKLASH(1000)("line_share"))),
        below(CONTINUOUS),
    ),
    Claim(
        "4.1",
        18,
        "Above 500 um the spectrum lies at low frequencies.",
        "energy share below 500 Hz at b = 1000 um, where there is a fluctuation",
        "1",
        where(BACKLASH(1000)("third"), EXISTS, of(BACKLASH(1000)("low_share"))),
        above(HALVED),
    ),
    Claim(
        "4.1",
        17,
        "Neither the largest nor the smallest clearance is suitable.",
        "worst mesh force at the better extreme over the least of all backlashes",
        "1",
        edges_over_least,
        above(SUITABLE),
    ),
    Claim(
        "4.1",
        17,
        "About 50 um is suitable for this arm.",
        "worst mesh force at 50 um over the least of all backlashes",
        "1",
        default_over_least,
        below(SUITABLE),
    ),
)

CLAIMS = (*BEGINNING, *POSITION, *IMPACT, *FLUCTUATION, *SPECTRA)
