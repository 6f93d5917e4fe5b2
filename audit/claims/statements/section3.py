"""The statements of the paper's Sections 3 and 3.1: data, start, constant torque."""

from __future__ import annotations

from crosscheck.audit.claims.quantities import each, of, over
from crosscheck.audit.claims.rule import Claim, Limits, about, above, below, read_off
from crosscheck.audit.experiments.experiments import (
    CONSTANT,
    CONSTANT_NO_ERROR,
    CONSTANT_PRELOADED,
    PLANTED,
    STATIC,
)
from crosscheck.audit.measures.thresholds import DOUBLED, HALVED
from crosscheck.audit.statics.statics import BENDS
from crosscheck.registry import RIGID_LEVELS

PRINTED_DIGIT = "what rounds to the digit that the paper prints"
THIRTY = Limits(25, 35, PRINTED_DIGIT)
TWENTIETH = below(0.05, "a twentieth: as much as a controller may overshoot unnoticed")
RAPID = below(0.1, "a fifth of the 0.5 s that Fig. 8 shows")
BASELINE = "the rigid baseline"
CALMED = above(DOUBLED, "at least twice as much at the start as later")

START = (
    Claim(
        "3-01",
        None,
        "The gearbox amplifies the torque by the reduction ratio.",
        of(CONSTANT, "torque_gain"),
        about(99 / 27 + 1, 0.02, "the gears' own inertia takes a little of it"),
    ),
    Claim(
        "3-02",
        8,
        "At the start the teeth are just touching, without force.",
        of(CONSTANT, "force_at_start_N"),
        below(1e-3, "k_m times the 1e-12 m by which starts differ is 1e-4 N"),
    ),
    Claim(
        "3-03",
        None,
        "The initial values listed for the detailed model are its state.",
        of(STATIC, "initial_values"),
        Limits(11.5, 12.5, "twelve: six coordinates and their rates"),
    ),
    Claim(
        "3-04",
        None,
        "Table I: M is an inertia over a squared radius and m a mass.",
        of(STATIC, "gyration_over_pitch"),
        below(1.0, "no gear's mass lies, on average, beyond its pitch circle"),
    ),
)

DEVIATIONS = (
    Claim(
        "3.1-01",
        6,
        "The first link deviates by 0.02 rad from the rigid model.",
        each(RIGID_LEVELS, lambda level: of(CONSTANT, f"deviation_1_{level}_rad")),
        Limits(0.015, 0.025, PRINTED_DIGIT),
        BASELINE,
    ),
    Claim(
        "3.1-02",
        6,
        "The second link deviates by 0.01 rad from the rigid model.",
        each(RIGID_LEVELS, lambda level: of(CONSTANT, f"deviation_2_{level}_rad")),
        Limits(0.005, 0.015, PRINTED_DIGIT),
        BASELINE,
    ),
    Claim(
        "3.1-03",
        6,
        "Deviations of 0.02 and 0.01 rad put the tip off by about 30 mm.",
        each(BENDS, lambda angle: of(STATIC, f"bent_{angle}_mm")),
        THIRTY,
        "the elbow's angle [°]",
    ),
    Claim(
        "3.1-04",
        6,
        "The tip is off by about 30 mm.",
        each(RIGID_LEVELS, lambda level: of(CONSTANT, f"tip_{level}_mm")),
        THIRTY,
        BASELINE,
    ),
    Claim(
        "3.1-05",
        6,
        "The errors are tolerable against a stroke of half a circle.",
        each(RIGID_LEVELS, lambda level: of(CONSTANT, f"stroke_share_{level}")),
        TWENTIETH,
        BASELINE,
    ),
    Claim(
        "3.1-06",
        6,
        "The errors accumulate over time.",
        each(RIGID_LEVELS, lambda level: of(CONSTANT, f"growth_{level}")),
        above(DOUBLED, "more than in proportion to the time"),
        BASELINE,
    ),
    Claim(
        "3.1-07",
        7,
        "The deviation from the rigid model shows the influence of the gear meshing.",
        over(of(CONSTANT, "deviation_1_coupled_rad"), of(CONSTANT, "deviation_1_links_rad")),
        above(HALVED, "half of it is left when the rigid model has the gears' inertia"),
    ),
    Claim(
        "3.1-08",
        6,
        "The detailed model's response differs slightly from the rigid model's.",
        each(RIGID_LEVELS, lambda level: of(CONSTANT, f"relative_{level}")),
        TWENTIETH,
        BASELINE,
    ),
    Claim(
        "3.1-18",
        7,
        "That detailed and rigid model agree validates the detailed model's equations.",
        of(PLANTED, "planted_shown"),
        above(0.9, "a validation shows nine of ten gross errors"),
        reading="gross: an entry of M, C q' or F is left out; shown: an angle moves by 0.01 rad,"
        " the least deviation that is called slight, or nothing can be run",
    ),
    Claim(
        "3.1-19",
        6,
        "The arm's working stroke is half a circle.",
        {"the shoulder": of(CONSTANT, "stroke_1"), "the elbow": of(CONSTANT, "stroke_2")},
        about(1.0, 0.5, "half a circle is the nearest of quarter, half and whole"),
        "joint",
        "the stroke in the run whose errors are compared with it",
    ),
    Claim(
        "3.1-20",
        6,
        "The shoulder's error is tolerable against its own way in this run.",
        each(RIGID_LEVELS, lambda level: of(CONSTANT, f"own_share_{level}")),
        TWENTIETH,
        BASELINE,
    ),
)

MESH = (
    Claim(
        "3.1-09",
        8,
        "x_sp converges to 52 µm.",
        of(CONSTANT, "x_middle_um"),
        about(52, 0.02, "1 µm to either side: " + PRINTED_DIGIT),
    ),
    Claim(
        "3.1-10",
        8,
        "x_sp vibrates at the beginning and converges rapidly.",
        of(CONSTANT, "vibration_decay_s"),
        RAPID,
        reading="the vibration of F_sp, which is that of x_sp less the tooth error",
    ),
    Claim(
        "3.1-11",
        9,
        "F_sp follows the same trend: it vibrates and converges.",
        of(CONSTANT, "force_decay"),
        CALMED,
    ),
    Claim(
        "3.1-12",
        9,
        "A starting impact causes it.",
        over(of(CONSTANT_PRELOADED, "ringing_N"), of(CONSTANT, "ringing_N")),
        below(HALVED, "most of it is gone without the impact"),
        reading="it stays away where the teeth carry the load from the start; that a load which"
        " is let go overshoots shows no impact",
    ),
    Claim(
        "3.1-13",
        8,
        "The fluctuation of x_sp that follows is due to the tooth error.",
        over(of(CONSTANT_NO_ERROR, "x_ripple_um"), of(CONSTANT, "x_ripple_um")),
        below(HALVED, "without the cause less than half is left"),
    ),
    Claim(
        "3.1-14",
        8,
        "Its magnitude is about 10 µm.",
        of(CONSTANT, "x_ripple_um"),
        read_off(10),
        reading="peak to peak",
    ),
    Claim(
        "3.1-15",
        8,
        "That is similar to the given tooth error.",
        of(CONSTANT, "x_ripple_over_2E"),
        read_off(1),
        reading="peak to peak of the error's wave, 2 E",
    ),
    Claim(
        "3.1-16",
        8,
        "Its frequency rises with time.",
        of(CONSTANT, "turns_gained"),
        above(0.5, "one turning point more in the second half"),
    ),
    Claim(
        "3.1-17",
        8,
        "The frequency rises because the shoulder speeds up.",
        of(CONSTANT, "speeding_up"),
        above(0.95, "it speeds up nearly always"),
    ),
    Claim(
        "3.1-21",
        9,
        "The other pairs of gears follow the same trend: they vibrate and converge.",
        of(CONSTANT, "others_decay"),
        CALMED,
    ),
    Claim(
        "3.1-22",
        9,
        "The other pairs of gears follow the same trend: they converge rapidly.",
        of(CONSTANT, "others_decay_s"),
        RAPID,
    ),
)

CLAIMS = (*START, *DEVIATIONS, *MESH)
