"""What decides the statements of Section 3.2: the motion under PD control, its fluctuations."""

from __future__ import annotations

from crosscheck.audit.claims import quantities as q
from crosscheck.audit.claims.rule import PLOT, READ_OFF, Decided, Limits, above, below, read_off
from crosscheck.audit.experiments import experiments as run
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

FIRST, SECOND, THIRD = (q.pd(name) for name in ("first", "second", "third"))
ALL_THREE = (FIRST, SECOND, THIRD)
WITHOUT_ERROR = q.of(run.NO_ERROR, "third")
ANY_WITHOUT_ERROR = q.of_any_start(WITHOUT_ERROR)
WITHOUT_BACKLASH, STEADY = (q.of(one, "third") for one in (run.NO_BACKLASH, run.CONSTANT_STIFFNESS))
OWED = q.difference(THIRD, ANY_WITHOUT_ERROR)  # to the tooth error: no start has it without


def in_third(quantity: q.Quantity) -> q.Quantity:
    """Where the tooth error makes a third fluctuation: the controller's own vibration is none."""
    return q.where(OWED, EVIDENT, quantity)


_OVERSHOOT = below(0.05, "a well damped step (damping ratio 0.7) overshoots by 4.6 %")
_STABLE = below(0.02, "2 %, the usual settling band")
_DIRECTLY = below(VISIBLE_SHARE, "what a plot of the whole step hides")
_THREE_OF_THREE = above(2.5, "all of three")


def _way(joint: int) -> q.Quantity:
    """What a joint's way up has too much, either way."""
    return q.largest(q.pd(f"setback_{joint}"), q.pd(f"overshoot_{joint}"))


DECIDED: Decided = {
    # positioning
    "3.2-01": (q.pd("overshoot_1"), _OVERSHOOT),
    "3.2-02": (q.pd("overshoot_2"), _OVERSHOOT),
    "3.2-03": (q.largest(q.pd("final_1_rad"), q.pd("final_2_rad")), ON_SCALE),
    "3.2-04": (q.pd("late_distance_1"), _STABLE),
    "3.2-05": (q.pd("late_distance_2"), _STABLE),
    "3.2-06": (
        q.pd("theta_fast_rad"),
        below(VISIBLE_SHARE * POSITION_RAD, "a hundredth of the scale of positioning errors"),
    ),
    "3.2-07": (q.pd("torque_fast_1"), VISIBLE),
    "3.2-08": (q.pd("torque_fast_2"), VISIBLE),
    "3.2-09": (
        in_third(q.pd("torque_follows")),
        above(0.9, "one explains four fifths of the other's variance"),
    ),
    "3.2-10": (
        in_third(q.pd("torque_frequency_Hz")),
        above(100.0, "speed loops of servo drives reach some tens of hertz"),
    ),
    "3.2-47": (_way(1), _DIRECTLY),
    "3.2-48": (_way(2), _DIRECTLY),
    # the course of the motion
    "3.2-11": (q.largest(SECOND, THIRD), SEVERELY),
    "3.2-12": (q.smallest(*ALL_THREE), EXISTS),
    "3.2-13": (q.pd("zero_windows"), _THREE_OF_THREE),
    "3.2-14": (q.pd("apart_windows"), _THREE_OF_THREE),
    "3.2-49": (q.pd("apart_at_zero"), above(0.9, "a sign that is right nine times of ten")),
    "3.2-15": (
        q.over(q.of(run.PRELOADED, "first"), FIRST),
        below(HALVED, "most of it is gone without the impact"),
    ),
    "3.2-16": (q.pd("side_change_s"), SIDE_CHANGE),
    "3.2-17": (
        q.where(q.pd("second_over_before"), 1.0, q.pd("second_delay_s")),
        below(AT_ONCE_S, "four flights across 100 µm: nothing else happens so soon"),
    ),
    "3.2-18": (q.pd("opposite_share"), MOSTLY),
    "3.2-19": (
        q.times(q.pd("jump_um"), 1 / (2 * run.DEFAULT_B_UM), "2b"),
        Limits(0.9, 1.1, "the tooth error may add or take 2 E, a tenth of 2 b"),
    ),
    "3.2-50": (q.over(q.of(run.NO_BACKLASH, "jump_um"), q.pd("jump_um")), GONE),
    "3.2-51": (q.pd("flight_s"), below(0.03, "a hundredth of Fig. 12's 3 s")),
    "3.2-20": (q.pd("return_s"), RETURN),
    "3.2-21": (q.pd("speed_at_return"), below(0.05, "five widths of a plot's line")),
    "3.2-22": (
        q.pd("fourth_over_before"),
        above(DOUBLED, "twice what was there before is something new"),
    ),
    "3.2-23": (in_third(q.over(q.pd("fourth"), q.smallest(*ALL_THREE))), SMALLER),
    "3.2-24": (q.largest(q.pd("first_decay_s"), q.pd("second_decay_s")), SLOWLY),
    "3.2-25": (
        in_third(q.pd("third_gap_s")),
        above(DOUBLED * SUDDEN_S, "twice as long as an impact's own fluctuation may last"),
    ),
    "3.2-26": (
        in_third(q.pd("third_growth")),
        above(DOUBLED, "it has at least doubled since its window began"),
    ),
    # sizes
    "3.2-27": (FIRST, FIRST_TWO),
    "3.2-28": (SECOND, FIRST_TWO),
    "3.2-29": (THIRD, THIRD_SIZE),
    "3.2-30": (q.over(THIRD, q.largest(FIRST, SECOND)), LARGER),
    "3.2-31": (q.largest(SECOND, OWED), EXISTS),
    "3.2-32": (
        q.pd("deviation_rad"),
        below(POSITION_RAD, "the scale that Section 4.1 calls negligible"),
    ),
    "3.2-33": (
        q.pd("speed_fast"),
        above(1.0, "the fluctuation is as large as the speed: its direction is not the drive's"),
    ),
    # models that leave one of the gears' effects out
    "3.2-35": (q.over(q.of(run.NO_BACKLASH, "second"), SECOND), GONE),
    "3.2-36": (in_third(q.over(WITHOUT_BACKLASH, THIRD)), LARGER),
    "3.2-39": (q.where(THIRD, EVIDENT, q.over(WITHOUT_ERROR, THIRD)), GONE),
    "3.2-40": (q.of(run.CONSTANT_STIFFNESS, "first"), EXISTS),
    "3.2-41": (q.of(run.CONSTANT_STIFFNESS, "second"), EXISTS),
    "3.2-42": (in_third(STEADY), EXISTS),
    "3.2-43": (in_third(q.over(STEADY, THIRD)), SMALLER),
    "3.2-44": (q.difference(STEADY, WITHOUT_ERROR), EXISTS),
    "3.2-45": (q.difference(THIRD, STEADY), EXISTS),
}
