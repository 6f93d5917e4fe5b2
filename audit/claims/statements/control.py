"""The statements of the paper's Section 3.2: the motion under PD control, and its fluctuations."""

from __future__ import annotations

from crosscheck.audit.claims.quantities import (
    Quantity,
    difference,
    largest,
    of,
    of_any_start,
    over,
    smallest,
    times,
    where,
)
from crosscheck.audit.claims.rule import PLOT, READ_OFF, Claim, Limits, above, below, read_off
from crosscheck.audit.experiments.experiments import (
    DEFAULT_B_UM,
    NO_BACKLASH,
    NO_ERROR,
    PD,
    PRELOADED,
)
from crosscheck.audit.measures.events import AT_ONCE_S
from crosscheck.audit.measures.thresholds import DOUBLED, EVIDENT, HALVED, SEVERE, VISIBLE_SHARE

POSITION_RAD = 1e-3  # Section 4.1's scale
SUDDEN_S = 0.1  # two thirds of the time for which an impact's vibration is followed
VANISHED = 0.1

# Words that several statements use, each with one meaning.
EXISTS = above(EVIDENT, "the smallest that Section 3.2 calls a fluctuation")
SEVERELY = above(SEVERE, "four times the rigid arm's own largest acceleration")
GONE = below(VANISHED, "a tenth is left: none of the plots would show it")
LARGER = above(1.0, "the statement's own comparison")
SMALLER = below(1.0, "the statement's own comparison")
MOSTLY = above(HALVED, "more than half")
VISIBLE = above(VISIBLE_SHARE, "what is wider than the line of a plot of the whole")
QUICKLY = below(SUDDEN_S, "a thirtieth of the run, and a quarter of the way to the next event")
SLOWLY = above(SUDDEN_S, "the opposite of what Section 4.2 means by rapidly")
ON_SCALE = below(DOUBLED * POSITION_RAD, "twice the scale that Section 4.1 names")
# Numbers that the paper prints, for claims, figures and fits alike.
SIDE_CHANGE = Limits(0.3, 0.4, "after 0.3 s, and before the next tenth")
RETURN = read_off(1.5)
FIRST_TWO = Limits(10 * (1 - READ_OFF), 40 * (1 + READ_OFF), f"10 to 40, each to {PLOT}")
THIRD_SIZE = read_off(300)

FIRST, SECOND, THIRD = (of(PD, name) for name in ("first", "second", "third"))
ALL_THREE = (FIRST, SECOND, THIRD)
WITHOUT_ERROR = of(NO_ERROR, "third")
ANY_WITHOUT_ERROR = of_any_start(WITHOUT_ERROR)
OWED = difference(THIRD, ANY_WITHOUT_ERROR)  # to the tooth error: no start has it without


def in_third(quantity: Quantity) -> Quantity:
    """Where the tooth error makes a third fluctuation: the controller's own vibration is none."""
    return where(OWED, EVIDENT, quantity)


_OVERSHOOT = below(0.05, "a well damped step (damping ratio 0.7) overshoots by 4.6 %")
_STABLE = below(0.02, "2 %, the usual settling band")
_STABLE_READING = "within a band from 2.6 s on, not: settling at 2.6 s"
_DIRECTLY = below(VISIBLE_SHARE, "what a plot of the whole step hides")
_THREE_OF_THREE = above(2.5, "all of three")
_WAY = "to 30 degrees: neither back on the way nor beyond it"


def _way(joint: int) -> Quantity:
    """What a joint's way up has too much, either way."""
    return largest(of(PD, f"setback_{joint}"), of(PD, f"overshoot_{joint}"))


POSITIONING = (
    Claim(
        "3.2-01",
        10,
        "P = 1000, D = 400 move the shoulder without considerable overshoot.",
        of(PD, "overshoot_1"),
        _OVERSHOOT,
    ),
    Claim(
        "3.2-02",
        10,
        "P = 1000, D = 400 move the elbow without considerable overshoot.",
        of(PD, "overshoot_2"),
        _OVERSHOOT,
    ),
    Claim(
        "3.2-03",
        10,
        "Both joints reach 30 degrees.",
        largest(of(PD, "final_1_rad"), of(PD, "final_2_rad")),
        ON_SCALE,
    ),
    Claim(
        "3.2-04",
        10,
        "The shoulder is stable after 2.6 s.",
        of(PD, "late_distance_1"),
        _STABLE,
        reading=_STABLE_READING,
    ),
    Claim(
        "3.2-05",
        10,
        "The elbow is stable after 2.6 s.",
        of(PD, "late_distance_2"),
        _STABLE,
        reading=_STABLE_READING,
    ),
    Claim(
        "3.2-06",
        10,
        "The angular displacement does not fluctuate.",
        of(PD, "theta_fast_rad"),
        below(VISIBLE_SHARE * POSITION_RAD, "a hundredth of the scale of positioning errors"),
    ),
    Claim(
        "3.2-07",
        11,
        "The shoulder's torque fluctuates at high frequency.",
        of(PD, "torque_fast_1"),
        VISIBLE,
    ),
    Claim(
        "3.2-08",
        11,
        "The elbow's torque fluctuates at high frequency.",
        of(PD, "torque_fast_2"),
        VISIBLE,
    ),
    Claim(
        "3.2-09",
        11,
        "The torque's fluctuation follows the acceleration's.",
        in_third(of(PD, "torque_follows")),
        above(0.9, "one explains four fifths of the other's variance"),
        reading="their sizes grow and shrink together; Eq. 23 has no acceleration to follow",
    ),
    Claim(
        "3.2-10",
        11,
        "A stable output needs a servo motor with high-frequency response.",
        in_third(of(PD, "torque_frequency_Hz")),
        above(100.0, "speed loops of servo drives reach some tens of hertz"),
    ),
    Claim("3.2-47", 10, "The shoulder goes up directly.", _way(1), _DIRECTLY, reading=_WAY),
    Claim("3.2-48", 10, "The elbow goes up directly.", _way(2), _DIRECTLY, reading=_WAY),
)

COURSE = (
    Claim(
        "3.2-11",
        14,
        "The shoulder's acceleration fluctuates severely.",
        largest(SECOND, THIRD),
        SEVERELY,
        reading="once the start is over: its first value is what any load would do to idle teeth",
    ),
    Claim(
        "3.2-12",
        14,
        "There are three fluctuations in the first 1.2 s.",
        smallest(*ALL_THREE),
        EXISTS,
    ),
    Claim(
        "3.2-13",
        14,
        "In all three the acceleration is at times reduced to zero.",
        of(PD, "zero_windows"),
        _THREE_OF_THREE,
        reading="by the fluctuation: the rigid arm's own acceleration passes zero near 0.2 s",
    ),
    Claim(
        "3.2-14",
        13,
        "In all three the gear pairs are at times out of contact.",
        of(PD, "apart_windows"),
        _THREE_OF_THREE,
    ),
    Claim(
        "3.2-49",
        14,
        "Zero acceleration means that the gear pairs are out of contact.",
        of(PD, "apart_at_zero"),
        above(0.9, "a sign that is right nine times of ten"),
    ),
    Claim(
        "3.2-15",
        14,
        "The starting impact excites the first fluctuation.",
        over(of(PRELOADED, "first"), FIRST),
        below(HALVED, "most of it is gone without the impact"),
        reading="it stays away where the teeth carry the load from the start",
    ),
    Claim(
        "3.2-16",
        13,
        "Mesh displacement and force change sign after 0.3 s.",
        of(PD, "side_change_s"),
        SIDE_CHANGE,
    ),
    Claim(
        "3.2-17",
        14,
        "The second fluctuation occurs when they change sign.",
        where(of(PD, "second_over_before"), 1.0, of(PD, "second_delay_s")),
        below(AT_ONCE_S, "four flights across 100 µm: nothing else happens so soon"),
        reading="asked where it exceeds what is left of the first fluctuation",
    ),
    Claim(
        "3.2-18",
        12,
        "The gear pairs then mesh on the opposite side.",
        of(PD, "opposite_share"),
        MOSTLY,
        reading="they stay there; that a negative force is one of the other side is Eq. 5",
    ),
    Claim(
        "3.2-19",
        12,
        "The sudden change of the displacement has the backlash's size.",
        times(of(PD, "jump_um"), 1 / (2 * DEFAULT_B_UM), "2b"),
        Limits(0.9, 1.1, "the tooth error may add or take 2 E, a tenth of 2 b"),
    ),
    Claim(
        "3.2-50",
        12,
        "The sudden change of the displacement is caused by the backlash.",
        over(of(NO_BACKLASH, "jump_um"), of(PD, "jump_um")),
        GONE,
    ),
    Claim(
        "3.2-51",
        12,
        "The change of the displacement is sudden.",
        of(PD, "flight_s"),
        below(0.03, "a hundredth of Fig. 12's 3 s"),
    ),
    Claim("3.2-20", 13, "The pair returns to its first side at 1.5 s.", of(PD, "return_s"), RETURN),
    Claim(
        "3.2-21",
        13,
        "By then the velocity has gradually fallen to zero.",
        of(PD, "speed_at_return"),
        below(0.05, "five widths of a plot's line"),
    ),
    Claim(
        "3.2-22",
        14,
        "The return produces a fourth fluctuation.",
        of(PD, "fourth_over_before"),
        above(DOUBLED, "twice what was there before is something new"),
    ),
    Claim(
        "3.2-23",
        14,
        "The fourth is smaller than the previous three.",
        in_third(over(of(PD, "fourth"), smallest(*ALL_THREE))),
        SMALLER,
    ),
    Claim(
        "3.2-24",
        14,
        "The impacts' fluctuations cannot converge quickly.",
        largest(of(PD, "first_decay_s"), of(PD, "second_decay_s")),
        SLOWLY,
        reading="from the impact on; where the controller takes the damping away, see H6",
    ),
    Claim(
        "3.2-25",
        14,
        "The third does not follow a sudden excitation.",
        in_third(of(PD, "third_gap_s")),
        above(DOUBLED * SUDDEN_S, "twice as long as an impact's own fluctuation may last"),
    ),
    Claim(
        "3.2-26",
        14,
        "The third shows a trend of instability.",
        in_third(of(PD, "third_growth")),
        above(DOUBLED, "it has at least doubled since its window began"),
    ),
)

SIZES = (
    Claim("3.2-27", 14, "The first fluctuation reaches 10 to 40 rad/s².", FIRST, FIRST_TWO),
    Claim(
        "3.2-28",
        14,
        "The second fluctuation reaches 10 to 40 rad/s².",
        SECOND,
        FIRST_TWO,
        reading="the largest there, whatever drives it; whether the impact does, 3.2-17 asks",
    ),
    Claim("3.2-29", 14, "The third reaches 300 rad/s².", THIRD, THIRD_SIZE),
    Claim(
        "3.2-30",
        14,
        "Internal excitation is more severe than meshing impacts.",
        over(THIRD, largest(FIRST, SECOND)),
        LARGER,
    ),
    Claim(
        "3.2-31",
        14,
        "Clearance and tooth error cause a considerable fluctuation of acceleration.",
        largest(SECOND, OWED),
        EXISTS,
        reading="the second, at the change of sides, or what of the third is owed to the error",
    ),
    Claim(
        "3.2-32",
        14,
        "Backlash and tooth error have limited influence on positioning accuracy.",
        of(PD, "deviation_rad"),
        below(POSITION_RAD, "the scale that Section 4.1 calls negligible"),
    ),
    Claim(
        "3.2-33",
        11,
        "The output velocity becomes uncontrollable.",
        of(PD, "speed_fast"),
        above(1.0, "the fluctuation is as large as the speed: its direction is not the drive's"),
    ),
)

CLAIMS = (*POSITIONING, *COURSE, *SIZES)
