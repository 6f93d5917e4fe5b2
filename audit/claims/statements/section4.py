"""The statements of the paper's Sections 4 and 4.1: the size of the backlash."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.audit.claims.quantities import (
    Choices,
    Known,
    Quantity,
    along,
    greatest,
    least,
    of,
    over,
    over_family,
    rank,
    rank_among,
    smallest,
    spread,
    times,
    where,
)
from crosscheck.audit.claims.rule import Claim, Limits, about, above, below, read_off
from crosscheck.audit.claims.statements.control import (
    GONE,
    LARGER,
    MOSTLY,
    ON_SCALE,
    THIRD,
    VANISHED,
    in_third,
)
from crosscheck.audit.experiments.experiments import (
    BACK,
    BACK_EVEN,
    BACKLASH,
    CHAOTIC_UM,
    DEFAULT_B_UM,
    NEIGHBOURS,
    NO_BACKLASH,
    PD,
    PRELOADED,
    STATIC,
    TURNING,
    WIDE,
    Family,
)
from crosscheck.audit.measures.thresholds import DOUBLED, EVIDENT, MINOR, SEVERE

CLEAR_RANK = 0.75
SMALL = 5.0  # um

FALLS = below(-CLEAR_RANK, "chance gives that in 2 of 100 where there are seven sizes")
RISES = above(CLEAR_RANK, "chance gives that in 2 of 100 where there are seven sizes")
SEEN = above(MINOR, "nothing smaller is seen in a plot of 300")
FREQUENCY = read_off(1500)

MOST, LEAST = greatest(BACKLASH, "third"), least(BACKLASH, "third")
AT_SMALL, NONE = of(BACKLASH(SMALL), "third"), of(NO_BACKLASH, "third")

SWINGS = "drive's argument and duration of the run"
_FIRST = ("0.4", "0.6", "0.8", "1")
# By the run's length: ends of the 0.2 s in which errors are measured [s].
ENDS = {"1": _FIRST, "2": (*_FIRST, "1.2", "1.4", "1.6", "1.8", "2")}
ON_AND_ON = above(1.0, "it grows on from each 0.2 s to the next")
_DRIVES = {"sin(20π√t)": BACK, "sin(20πt)": BACK_EVEN}


def swings(quantity: Callable[[Family, str], Quantity]) -> Choices:
    """For both arguments of Fig. 15's drive and for runs of 1 and 2 s."""
    return {
        f"{words}, {seconds} s": quantity(family, seconds)
        for words, family in _DRIVES.items()
        for seconds in ("1", "2")
    }


def accumulation(family: Family, seconds: str, of_what: str, less: float | None) -> Quantity:
    """Smallest growth of an error [rad] from one 0.2 s to the next, up to so many seconds.

    of_what: in words; of the default backlash, less that of another size [um] if one is named.
    """

    def errors(known: Known, size_um: float) -> np.ndarray:
        return np.array([known[family(size_um)][f"error_{end}_s"] for end in ENDS[seconds]])

    def formula(known: Known) -> np.ndarray:
        found = errors(known, DEFAULT_B_UM) - (0.0 if less is None else errors(known, less))
        return np.min(found[1:] / found[:-1], axis=0)

    return Quantity(
        f"accumulation({family.kind}, {seconds} s, {less})",
        f"smallest factor from one 0.2 s to the next of {of_what}",
        "1",
        formula,
        f"0.2 to {seconds} s",
    )


def in_order(family: Family, seconds: str) -> Quantity:
    """Least rank correlation of the error with b in any 0.2 s up to so many seconds."""
    return smallest(*(rank(family, f"error_{end}_s") for end in ENDS[seconds]))


def growth(family: Family, kind: str, seconds: str) -> Quantity:
    """Of an error at the end over that from 0.1 to 0.3 s, with the default backlash."""
    source = family(DEFAULT_B_UM)
    return over(of(source, f"{kind}_{seconds}_s"), of(source, f"{kind}_early"))


def itself(family: Family, seconds: str) -> Quantity:
    """The smaller of the error's accumulation and half its growth over the rigid arm's own."""
    own = over(growth(family, "error", seconds), growth(family, "own", seconds))
    return smallest(accumulation(family, seconds, "the error", None), times(own, 1 / DOUBLED, "1"))


def larger_of(family: Family, one: str, other: str, known: Known) -> np.ndarray:
    """Of two numbers along a family, (members, starts); of what is undefined the other."""
    return np.fmax(along(family, one, known)[1], along(family, other, known)[1])


def _worst(known: Known) -> np.ndarray:
    return larger_of(BACKLASH, "second_force_N", "third_force_N", known)


def _at_large(name: str) -> Quantity:
    """A number at b = 1000 um, where there is a fluctuation."""
    return _where_large(of(BACKLASH(CHAOTIC_UM), name))


def _where_large(quantity: Quantity) -> Quantity:
    """Where there is a fluctuation at b = 1000 um."""
    return in_third(where(of(BACKLASH(CHAOTIC_UM), "third"), EVIDENT, quantity))


_WORST = "largest mesh force of impact and third fluctuation"
EDGES = Quantity(
    "least of the edges over least(backlash: second_force_N, third_force_N)",
    f"{_WORST} at the better of the smallest and largest b over the least of all b",
    "1",
    lambda known: np.minimum(_worst(known)[0], _worst(known)[-1]) / _worst(known).min(axis=0),
)
DEFAULT = Quantity(
    "default over least(backlash: second_force_N, third_force_N)",
    f"{_WORST} at b = 50 µm over the least of all b",
    "1",
    lambda known: (
        np.fmax(known[PD]["second_force_N"], known[PD]["third_force_N"]) / _worst(known).min(axis=0)
    ),
)
_AS_GOOD = "within 5 % one clearance is as good as another"

BEGINNING = (
    Claim(
        "4-02",
        16,
        "Fluctuations from the start cannot be avoided.",
        smallest(least(BACKLASH, "first"), of(PRELOADED, "first")),
        SEEN,
        reading="whatever the clearance, and from teeth that carry their load already: 3.2-15",
    ),
    Claim(
        "4-03",
        16,
        "Fluctuations from meshing impacts cannot be avoided.",
        over_family("least of those with", "smallest", BACKLASH, "second", np.fmin.reduce),
        SEEN,
        reading="whatever the clearance, where the teeth change sides at all",
    ),
)

POSITION = (
    Claim(
        "4.1-01",
        10,
        "With a clearance of 100 µm the positioning error stays on a 0.001 rad scale.",
        of(PD, "deviation_rad"),
        ON_SCALE,
    ),
    Claim(
        "4.1-02",
        10,
        "With a clearance of 6 mm the positioning error stays on a 0.001 rad scale.",
        of(WIDE, "deviation_rad"),
        ON_SCALE,
    ),
    Claim(
        "4.1-03",
        None,
        "6 mm is nearly a third of the tooth thickness.",
        of(STATIC, "tooth_thickness_share"),
        about(1 / 3, 0.1, "nearly: a tenth of it"),
    ),
    Claim(
        "4.1-04",
        10,
        "In closed loop the final error converges to zero, even with 6 mm.",
        of(WIDE, "gap_end_rad"),
        below(1e-4, "a tenth of the scale that counts as negligible"),
        reading="what the gears add: the rigid arm is 0.001 rad short at 3 s itself",
    ),
    Claim(
        "4.1-05",
        15,
        "Driven back and forth, the error accumulates.",
        swings(lambda family, s: accumulation(family, s, "the error", None)),
        ON_AND_ON,
        SWINGS,
    ),
    Claim(
        "4.1-06",
        15,
        "That error grows with the backlash.",
        swings(in_order),
        above(0.95, "all sizes in order; chance gives that in 1 of 720 where there are six"),
        SWINGS,
        "at all times, as H3 asks it: the largest of every 0.2 s",
    ),
    Claim(
        "4.1-07",
        15,
        "The error of the backlash itself accumulates over the swings.",
        swings(itself),
        above(1.0, "it grows on, and to twice what the rigid arm makes of any small error"),
        SWINGS,
        "what the rigid arm makes of any small error is not the backlash's, see H3",
    ),
    Claim(
        "4.1-28",
        10,
        "A closed loop erases the error whenever the links turn back.",
        over(of(TURNING, "gap_end_rad"), of(TURNING, "deviation_rad")),
        below(VANISHED, "a tenth is left for the next swing"),
        reading="links that start at 1 rad/s away from 30 degrees and turn back under Eq. 23, with"
        " the widest clearance; 3 s",
    ),
)

IMPACT = (
    Claim(
        "4.1-08",
        16,
        "A larger clearance makes the meshing impact more severe.",
        rank_among(BACKLASH, "second_force_N", "side_change_s", 0.0),
        RISES,
    ),
    Claim(
        "4.1-09",
        16,
        "The impact occurs later with a larger clearance.",
        rank_among(BACKLASH, "side_change_s", "side_change_s", 0.0),
        RISES,
    ),
    Claim(
        "4.1-10",
        16,
        "The impact lasts shorter with a larger clearance.",
        rank_among(BACKLASH, "bouncing_s", "side_change_s", 0.0),
        FALLS,
    ),
    Claim(
        "4.1-11",
        16,
        "A larger clearance needs more time to come into contact again.",
        rank_among(BACKLASH, "flight_s", "side_change_s", 0.0),
        RISES,
    ),
)

FLUCTUATION = (
    Claim(
        "4.1-12",
        17,
        "Backlash has a strong effect on the size of the fluctuation.",
        in_third(spread(BACKLASH, "third")),
        above(DOUBLED, "a change that no scatter explains"),
    ),
    Claim(
        "4.1-13",
        17,
        "With small clearances it is similar to that without.",
        in_third(over(AT_SMALL, NONE)),
        Limits(0.5, 2.0, "alike to a factor of two"),
    ),
    Claim(
        "4.1-14",
        17,
        "Internal excitation recedes as the clearance grows.",
        in_third(rank(BACKLASH, "third")),
        FALLS,
    ),
    Claim(
        "4.1-15",
        17,
        "Its mesh force recedes as the clearance grows.",
        in_third(rank(BACKLASH, "third_force_fast_N")),
        FALLS,
    ),
    Claim(
        "4.1-16",
        17,
        "With a small clearance the contact keeps changing sides.",
        in_third(of(BACKLASH(SMALL), "side_changes")),
        above(70, "every 10 ms: one in fifteen periods of 1500 Hz"),
    ),
    Claim(
        "4.1-17", 17, "A smaller clearance is not better.", in_third(over(AT_SMALL, THIRD)), LARGER
    ),
    Claim(
        "4.1-18",
        17,
        "A suitable clearance suppresses severe fluctuation.",
        in_third(where(MOST, SEVERE, over(LEAST, MOST))),
        GONE,
    ),
)

SPECTRA = (
    Claim(
        "4.1-19",
        18,
        "The shoulder fluctuates at about 1500 Hz.",
        in_third(of(PD, "frequency_Hz")),
        FREQUENCY,
    ),
    Claim(
        "4.1-20",
        18,
        "The elbow fluctuates at about 1500 Hz.",
        in_third(of(PD, "frequency_elbow_Hz")),
        FREQUENCY,
    ),
    Claim(
        "4.1-21",
        18,
        "Several doubled frequencies appear as well.",
        in_third(of(PD, "overtones")),
        above(1.5, "several are two at least"),
        reading="multiples of the dominant frequency whose line is four times the median around it",
    ),
    Claim(
        "4.1-22",
        18,
        "The elbow's acceleration is much larger than the shoulder's.",
        in_third(over(of(PD, "line_elbow"), of(PD, "line"))),
        above(DOUBLED, "much: at least twice"),
    ),
    Claim(
        "4.1-23",
        18,
        "The frequency drifts down as the clearance grows.",
        in_third(rank_among(BACKLASH, "frequency_Hz", "third", EVIDENT)),
        FALLS,
    ),
    Claim(
        "4.1-24",
        18,
        "Above 500 µm the fluctuation is chaotic.",
        _where_large(of(NEIGHBOURS, "lyapunov_per_s")),
        above(23.0, "neighbouring motions part tenfold in every tenth of a second"),
        reading="at b = 1000 µm; chaos is a positive largest Lyapunov exponent",
    ),
    Claim(
        "4.1-30",
        18,
        "Above 500 µm the spectrum is continuous.",
        _at_large("line_share"),
        below(0.2, "no line holds a fifth of the energy"),
        reading="at b = 1000 µm; whether a smaller clearance gives lines, 4.1-29 asks",
    ),
    Claim(
        "4.1-29",
        18,
        "Up to 500 µm it is a vibration with a frequency of its own.",
        in_third(of(PD, "line_share")),
        MOSTLY,
        reading="at b = 50 µm: one line holds more than half of the energy",
    ),
    Claim(
        "4.1-25",
        18,
        "Above 500 µm the spectrum lies at low frequencies.",
        _at_large("low_share"),
        MOSTLY,
        reading="below 500 Hz, a third of 1500",
    ),
    Claim(
        "4.1-26",
        17,
        "Neither the largest nor the smallest clearance is suitable.",
        EDGES,
        above(1.05, _AS_GOOD),
    ),
    Claim("4.1-27", 17, "About 50 µm is suitable for this arm.", DEFAULT, below(1.05, _AS_GOOD)),
)

CLAIMS = (*BEGINNING, *POSITION, *IMPACT, *FLUCTUATION, *SPECTRA)
RETIRED = (("4-01", "says again, with the same formula, what 3.2-36 says"),)
