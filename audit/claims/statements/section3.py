"""What decides the statements of the paper's Sections 3 and 3.1: data, start, constant torque."""

from __future__ import annotations

from crosscheck.audit.claims import quantities as q
from crosscheck.audit.claims.rule import Decided, Limits, about, above, below, read_off
from crosscheck.audit.experiments import experiments as run
from crosscheck.audit.measures.thresholds import DOUBLED, HALVED
from crosscheck.audit.statics.statics import BENDS
from crosscheck.registry import RIGID_LEVELS

PRINTED_DIGIT = "what rounds to the digit that the paper prints"
THIRTY = Limits(25, 35, PRINTED_DIGIT)
TWENTIETH = below(0.05, "a twentieth: as much as a controller may overshoot unnoticed")
RAPID = below(0.1, "a fifth of the 0.5 s that Fig. 8 shows")
CALMED = above(DOUBLED, "at least twice as much at the start as later")

DECIDED: Decided = {
    # data and start
    "3-01": (
        q.torque("torque_gain"),
        about(99 / 27 + 1, 0.02, "the gears' own inertia takes a little of it"),
    ),
    "3-02": (
        q.torque("force_at_start_N"),
        below(1e-3, "k_m times the 1e-12 m by which starts differ is 1e-4 N"),
    ),
    "3-03": (
        q.static("initial_values"),
        Limits(11.5, 12.5, "twelve: six coordinates and their rates"),
    ),
    "3-04": (
        q.static("gyration_over_pitch"),
        below(1.0, "no gear's mass lies, on average, beyond its pitch circle"),
    ),
    # deviations from the rigid arm
    "3.1-01": (
        {level: q.torque(f"deviation_1_{level}_rad") for level in RIGID_LEVELS},
        Limits(0.015, 0.025, PRINTED_DIGIT),
    ),
    "3.1-02": (
        {level: q.torque(f"deviation_2_{level}_rad") for level in RIGID_LEVELS},
        Limits(0.005, 0.015, PRINTED_DIGIT),
    ),
    "3.1-03": ({angle: q.static(f"bent_{angle}_mm") for angle in BENDS}, THIRTY),
    "3.1-04": ({level: q.torque(f"tip_{level}_mm") for level in RIGID_LEVELS}, THIRTY),
    "3.1-05": ({level: q.torque(f"stroke_share_{level}") for level in RIGID_LEVELS}, TWENTIETH),
    "3.1-06": (
        {level: q.torque(f"growth_{level}") for level in RIGID_LEVELS},
        above(DOUBLED, "more than in proportion to the time"),
    ),
    "3.1-07": (
        q.over(q.torque("deviation_1_coupled_rad"), q.torque("deviation_1_links_rad")),
        above(HALVED, "half of it is left when the rigid model has the gears' inertia"),
    ),
    "3.1-08": ({level: q.torque(f"relative_{level}") for level in RIGID_LEVELS}, TWENTIETH),
    "3.1-18": (
        q.of(run.PLANTED, "planted_shown"),
        above(0.9, "a validation shows nine of ten gross errors"),
    ),
    "3.1-19": (
        {"the shoulder": q.torque("stroke_1"), "the elbow": q.torque("stroke_2")},
        about(1.0, 0.5, "half a circle is the nearest of quarter, half and whole"),
    ),
    "3.1-20": ({level: q.torque(f"own_share_{level}") for level in RIGID_LEVELS}, TWENTIETH),
    # the meshes
    "3.1-09": (q.torque("x_middle_um"), about(52, 0.02, "1 µm to either side: " + PRINTED_DIGIT)),
    "3.1-10": (q.torque("vibration_decay_s"), RAPID),
    "3.1-11": (q.torque("force_decay"), CALMED),
    "3.1-12": (
        q.over(q.of(run.CONSTANT_PRELOADED, "ringing_N"), q.torque("ringing_N")),
        below(HALVED, "most of it is gone without the impact"),
    ),
    "3.1-13": (
        q.over(q.of(run.CONSTANT_NO_ERROR, "x_ripple_um"), q.torque("x_ripple_um")),
        below(HALVED, "without the cause less than half is left"),
    ),
    "3.1-14": (q.torque("x_ripple_um"), read_off(10)),
    "3.1-15": (q.torque("x_ripple_over_2E"), read_off(1)),
    "3.1-16": (q.torque("turns_gained"), above(0.5, "one turning point more in the second half")),
    "3.1-17": (q.torque("speeding_up"), above(0.95, "it speeds up nearly always")),
    "3.1-21": (q.torque("others_decay"), CALMED),
    "3.1-22": (q.torque("others_decay_s"), RAPID),
}
