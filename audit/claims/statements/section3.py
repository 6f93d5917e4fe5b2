"""What decides the statements of Section 3: data, constant torque, the motion under PD control."""

from __future__ import annotations

from crosscheck.audit.claims.measured import MEASURES, pd, static, torque
from crosscheck.audit.experiments import experiments as run
from crosscheck.audit.judging import quantities as q
from crosscheck.audit.judging import rule
from crosscheck.audit.judging.rule import (
    ClaimCriteria,
    Limits,
    limits_above,
    limits_around,
    limits_below,
    limits_from_plot,
)
from crosscheck.audit.measures.events import AT_ONCE_S
from crosscheck.audit.measures.thresholds import DOUBLED, EVIDENT, HALVED, SEVERE, VISIBLE_SHARE
from crosscheck.audit.statics.statics import BENDS
from crosscheck.registry import RIGID_LEVELS

PRINTED_DIGIT = "what rounds to the digit that the paper prints"
THIRTY = Limits(25, 35, PRINTED_DIGIT)
TWENTIETH = limits_below(0.05, "a twentieth: as much as a controller may overshoot unnoticed")
RAPID = limits_below(0.1, "a fifth of the 0.5 s of the run")
CALMED = limits_above(DOUBLED, "at least twice as much at the start as later")
POSITION_RAD = 1e-3  # Section 4.1's scale
SUDDEN_S = 0.1  # two thirds of the time for which an impact's vibration is followed
VANISHED = 0.1

# Words that several statements use, each with one meaning.
EXISTS = limits_above(EVIDENT, "the smallest that Section 3.2 calls a fluctuation")
SEVERELY = limits_above(SEVERE, "four times the rigid arm's own largest acceleration")
GONE = limits_below(VANISHED, "a tenth is left: none of the plots would show it")
LARGER = limits_above(1.0, "the statement's own comparison")
SMALLER = limits_below(1.0, "the statement's own comparison")
KEPT = limits_above(HALVED, "more than half of what there is with varying stiffness")
MOSTLY = limits_above(HALVED, "more than half")
VISIBLE = limits_above(VISIBLE_SHARE, "what is wider than the line of a plot of the whole")
QUICKLY = limits_below(
    SUDDEN_S, "a thirtieth of the run, and a quarter of the way to the next event"
)
SLOWLY = limits_above(SUDDEN_S, "the opposite of what Section 4.2 means by rapidly")
ON_SCALE = limits_below(DOUBLED * POSITION_RAD, "twice the scale that Section 4.1 names")
# Numbers that the paper prints, for claims, figures and fits alike.
SIDE_CHANGE = Limits(0.3, 0.4, "after 0.3 s, and before the next tenth")
RETURN = limits_from_plot(1.5)
FIRST_TWO = Limits(
    10 * (1 - rule.READ_OFF), 40 * (1 + rule.READ_OFF), f"10 to 40, each to {rule.PLOT}"
)
THIRD_SIZE = limits_from_plot(300)

FIRST, SECOND, THIRD = (pd(name) for name in ("first", "second", "third"))
ALL_THREE = (FIRST, SECOND, THIRD)
WITHOUT_ERROR = MEASURES.quantity_of(run.NO_ERROR, "third")
ANY_WITHOUT_ERROR = q.maximum_over_starts(WITHOUT_ERROR)
WITHOUT_BACKLASH, STEADY = (
    MEASURES.quantity_of(item, "third") for item in (run.NO_BACKLASH, run.CONSTANT_STIFFNESS)
)
OWED = q.difference(THIRD, ANY_WITHOUT_ERROR)  # to the tooth error: no start has it without


def restrict_to_third(quantity: q.Quantity) -> q.Quantity:
    """The quantity where the tooth error makes a third fluctuation beyond the controller's own."""
    return q.restrict_above(OWED, EVIDENT, quantity)


_OVERSHOOT = limits_below(0.05, "a well damped step (damping ratio 0.7) overshoots by 4.6 %")
_STABLE = limits_below(0.02, "2 %, the usual settling band")
_DIRECTLY = limits_below(VISIBLE_SHARE, "what a plot of the whole step hides")
_THREE_OF_THREE = limits_above(2.5, "all of three")


def _step_error(joint: int) -> q.Quantity:
    """How far a joint overshoots or sets back on its way up, whichever is more."""
    return q.maximum(pd(f"setback_{joint}"), pd(f"overshoot_{joint}"))


DECIDED: ClaimCriteria = {
    # data and start
    "3-01": (
        torque("torque_gain"),
        limits_around(99 / 27 + 1, 0.02, "the gears' own inertia takes a little of it"),
    ),
    "3-02": (
        torque("force_at_start_N"),
        limits_below(1e-3, "k_m times the 1e-12 m by which starts differ is 1e-4 N"),
    ),
    "3-03": (
        static("initial_values"),
        Limits(11.5, 12.5, "twelve: six coordinates and their rates"),
    ),
    "3-04": (
        static("gyration_over_pitch"),
        limits_below(1.0, "no gear's mass lies, on average, beyond its pitch circle"),
    ),
    # deviations from the rigid arm
    "3.1-01": (
        {level: torque(f"deviation_1_{level}_rad") for level in RIGID_LEVELS},
        Limits(0.015, 0.025, PRINTED_DIGIT),
    ),
    "3.1-02": (
        {level: torque(f"deviation_2_{level}_rad") for level in RIGID_LEVELS},
        Limits(0.005, 0.015, PRINTED_DIGIT),
    ),
    "3.1-03": ({angle: static(f"bent_{angle}_mm") for angle in BENDS}, THIRTY),
    "3.1-04": ({level: torque(f"tip_{level}_mm") for level in RIGID_LEVELS}, THIRTY),
    "3.1-05": ({level: torque(f"stroke_share_{level}") for level in RIGID_LEVELS}, TWENTIETH),
    "3.1-06": (
        {level: torque(f"growth_{level}") for level in RIGID_LEVELS},
        limits_above(DOUBLED, "more than in proportion to the time"),
    ),
    "3.1-07": (
        q.ratio(torque("deviation_1_coupled_rad"), torque("deviation_1_links_rad")),
        limits_above(HALVED, "half of it is left when the rigid model has the gears' inertia"),
    ),
    "3.1-08": ({level: torque(f"relative_{level}") for level in RIGID_LEVELS}, TWENTIETH),
    "3.1-18": (
        MEASURES.quantity_of(run.PLANTED, "planted_shown"),
        limits_above(0.9, "a validation shows nine of ten gross errors"),
    ),
    "3.1-19": (
        {"the shoulder": torque("stroke_1"), "the elbow": torque("stroke_2")},
        limits_around(1.0, 0.5, "half a circle is the nearest of quarter, half and whole"),
    ),
    "3.1-20": ({level: torque(f"own_share_{level}") for level in RIGID_LEVELS}, TWENTIETH),
    # the meshes
    "3.1-09": (
        torque("x_middle_um"),
        limits_around(52, 0.02, "1 µm to either side: " + PRINTED_DIGIT),
    ),
    "3.1-10": (torque("vibration_decay_s"), RAPID),
    "3.1-11": (torque("force_decay"), CALMED),
    "3.1-12": (
        q.ratio(MEASURES.quantity_of(run.CONSTANT_PRELOADED, "ringing_N"), torque("ringing_N")),
        limits_below(HALVED, "most of it is gone without the impact"),
    ),
    "3.1-13": (
        q.ratio(MEASURES.quantity_of(run.CONSTANT_NO_ERROR, "x_ripple_um"), torque("x_ripple_um")),
        limits_below(HALVED, "without the cause less than half is left"),
    ),
    "3.1-14": (torque("x_ripple_um"), limits_from_plot(10)),
    "3.1-15": (torque("x_ripple_over_2E"), limits_from_plot(1)),
    "3.1-16": (
        torque("turns_gained"),
        limits_above(0.5, "one turning point more in the second half"),
    ),
    "3.1-17": (torque("speeding_up"), limits_above(0.95, "it speeds up nearly always")),
    "3.1-21": (torque("others_decay"), CALMED),
    "3.1-22": (torque("others_decay_s"), RAPID),
    # positioning
    "3.2-01": (pd("overshoot_1"), _OVERSHOOT),
    "3.2-02": (pd("overshoot_2"), _OVERSHOOT),
    "3.2-03": (q.maximum(pd("final_1_rad"), pd("final_2_rad")), ON_SCALE),
    "3.2-04": (pd("late_distance_1"), _STABLE),
    "3.2-05": (pd("late_distance_2"), _STABLE),
    "3.2-06": (
        pd("theta_fast_rad"),
        limits_below(
            VISIBLE_SHARE * POSITION_RAD, "a hundredth of the scale of positioning errors"
        ),
    ),
    "3.2-07": (pd("torque_fast_1"), VISIBLE),
    "3.2-08": (pd("torque_fast_2"), VISIBLE),
    "3.2-09": (
        restrict_to_third(pd("torque_follows")),
        limits_above(0.9, "one explains four fifths of the other's variance"),
    ),
    "3.2-10": (
        restrict_to_third(pd("torque_frequency_Hz")),
        limits_above(100.0, "speed loops of servo drives reach some tens of hertz"),
    ),
    "3.2-47": (_step_error(1), _DIRECTLY),
    "3.2-48": (_step_error(2), _DIRECTLY),
    # the course of the motion
    "3.2-11": (q.maximum(SECOND, THIRD), SEVERELY),
    "3.2-12": (
        q.minimum(
            q.scaled_quantity(FIRST, 1 / EVIDENT, "1"),
            q.scaled_quantity(pd("second_over_before"), 1 / DOUBLED, "1"),
            q.scaled_quantity(THIRD, 1 / EVIDENT, "1"),
        ),
        limits_above(
            1.0,
            "the second, as 2.1-02 has it, at least doubles what there was; the others exceed 10",
        ),
    ),
    "3.2-13": (pd("zero_windows"), _THREE_OF_THREE),
    "3.2-14": (pd("apart_windows"), _THREE_OF_THREE),
    "3.2-49": (pd("apart_at_zero"), limits_above(0.9, "a sign that is right nine times of ten")),
    "3.2-15": (
        q.ratio(MEASURES.quantity_of(run.PRELOADED, "first"), FIRST),
        limits_below(HALVED, "most of it is gone without the impact"),
    ),
    "3.2-16": (pd("side_change_s"), SIDE_CHANGE),
    "3.2-17": (
        q.restrict_above(pd("second_over_before"), 1.0, pd("second_delay_s")),
        limits_below(AT_ONCE_S, "four flights across 100 µm: nothing else happens so soon"),
    ),
    "3.2-18": (pd("opposite_share"), MOSTLY),
    "3.2-19": (
        q.scaled_quantity(pd("jump_um"), 1 / (2 * run.DEFAULT_B_UM), "2b"),
        Limits(0.9, 1.1, "the tooth error may add or take 2 E, a tenth of 2 b"),
    ),
    "3.2-50": (q.ratio(MEASURES.quantity_of(run.NO_BACKLASH, "jump_um"), pd("jump_um")), GONE),
    "3.2-51": (pd("flight_s"), limits_below(0.03, "a hundredth of the run's 3 s")),
    "3.2-20": (pd("return_s"), RETURN),
    "3.2-21": (pd("speed_at_return"), limits_below(rule.READ_OFF, rule.PLOT)),
    "3.2-22": (
        pd("fourth_over_before"),
        limits_above(DOUBLED, "twice what was there before is something new"),
    ),
    "3.2-23": (restrict_to_third(q.ratio(pd("fourth"), q.minimum(*ALL_THREE))), SMALLER),
    "3.2-24": (q.maximum(pd("first_decay_s"), pd("second_decay_s")), SLOWLY),
    "3.2-25": (
        restrict_to_third(pd("third_gap_s")),
        limits_above(DOUBLED * SUDDEN_S, "twice as long as an impact's own fluctuation may last"),
    ),
    "3.2-26": (
        restrict_to_third(pd("third_growth")),
        limits_above(DOUBLED, "it has at least doubled since its window began"),
    ),
    # sizes
    "3.2-27": (FIRST, FIRST_TWO),
    "3.2-28": (SECOND, FIRST_TWO),
    "3.2-29": (THIRD, THIRD_SIZE),
    "3.2-30": (q.ratio(THIRD, q.maximum(FIRST, SECOND)), LARGER),
    "3.2-31": (q.maximum(SECOND, OWED), EXISTS),
    "3.2-32": (
        pd("deviation_rad"),
        limits_below(POSITION_RAD, "the scale that Section 4.1 calls negligible"),
    ),
    "3.2-33": (
        pd("speed_fast"),
        limits_above(
            1.0, "the fluctuation is as large as the speed: its direction is not the drive's"
        ),
    ),
    # models that leave one of the gears' effects out
    "3.2-35": (q.ratio(MEASURES.quantity_of(run.NO_BACKLASH, "second"), SECOND), GONE),
    "3.2-36": (restrict_to_third(q.ratio(WITHOUT_BACKLASH, THIRD)), LARGER),
    "3.2-39": (q.restrict_above(THIRD, EVIDENT, q.ratio(WITHOUT_ERROR, THIRD)), GONE),
    "3.2-40": (q.ratio(MEASURES.quantity_of(run.CONSTANT_STIFFNESS, "first"), FIRST), KEPT),
    "3.2-41": (q.ratio(MEASURES.quantity_of(run.CONSTANT_STIFFNESS, "second"), SECOND), KEPT),
    "3.2-42": (restrict_to_third(STEADY), EXISTS),
    "3.2-43": (restrict_to_third(q.ratio(STEADY, THIRD)), SMALLER),
    "3.2-44": (q.difference(STEADY, WITHOUT_ERROR), EXISTS),
    "3.2-45": (q.difference(THIRD, STEADY), EXISTS),
}
