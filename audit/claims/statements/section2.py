"""What decides the statements of the paper's Section 2: the model."""

from __future__ import annotations

from dataclasses import replace

from crosscheck.audit.claims.measured import MEASURES, pd, static, torque
from crosscheck.audit.experiments import experiments as run
from crosscheck.audit.judging import quantities as q
from crosscheck.audit.judging.rule import (
    READ_OFF,
    ClaimCriteria,
    limits_above,
    limits_around,
    limits_below,
)
from crosscheck.audit.measures.thresholds import (
    DOUBLED,
    EVIDENT,
    EXACT,
    HALVED,
    MINOR,
    VISIBLE_SHARE,
)
from crosscheck.audit.statics.base_and_gravity import BASE_MASSES
from crosscheck.audit.statics.flights import LIMIT_M
from crosscheck.audit.statics.teeth import CONTACT_RATIOS, COUNTED, SIGMAS

ROUNDING = limits_below(EXACT, "an identity: rounding alone may be left")
SMALL = limits_below(VISIBLE_SHARE, "a line's width in a plot of what it is compared with")
TANH_M = limits_below(5e-8, "a hundredth of the tooth error, the smallest length of the model")
TWICE = limits_above(DOUBLED, "twice as much: no scatter of starts comes near it")


def factor(first: q.Quantity, second: q.Quantity, words: str) -> q.Quantity:
    """The larger over the smaller of two quantities."""
    return replace(q.maximum(q.ratio(first, second), q.ratio(second, first)), words=words, unit="1")


def relative_change(waves: q.Quantity, sine: q.Quantity) -> q.Quantity:
    """The change of a number by the stiffness's harmonics, over the number's size."""
    return q.ratio(q.magnitude(q.difference(waves, sine)), q.magnitude(sine))


DECIDED: ClaimCriteria = {
    # the base, the ratio, the orbit
    "2-01": (
        {mass: static(f"base_tip_{mass}_mm") for mass in BASE_MASSES},
        limits_below(1e3 * LIMIT_M, "what Section 3.1 calls a considerable error of the tip"),
    ),
    "2-02": (static("ratio_error"), ROUNDING),
    "2-03": (
        static("gravity_share"),
        limits_below(1e-3, "a thousandth of the torques that drive the arm"),
    ),
    # backlash
    "2.1-01": (
        pd("apart_share"),
        limits_above(1e-3, "a thousandth of the run: several periods of the mesh's vibration"),
    ),
    "2.1-02": (
        pd("second_over_before"),
        limits_above(DOUBLED, "the change of sides at least doubles what there was before it"),
    ),
    "2.1-03": (
        q.minimum(
            q.ratio(
                MEASURES.quantity_of(run.NO_ERROR, "third"),
                MEASURES.quantity_of(run.NO_ERROR, "second"),
            ),
            q.ratio(
                MEASURES.quantity_of(run.NO_ERROR, "third"),
                MEASURES.quantity_of(run.BACKLASH_NO_ERROR(0.0), "third"),
            ),
        ),
        limits_above(DOUBLED, "an instability at least doubles what the impact left"),
    ),
    "2.1-04": (
        {
            "equal stiffness of all meshes together": q.ratio(
                pd("second"), MEASURES.quantity_of(run.TWO_PLANETS, "second")
            ),
            "equal stiffness of each mesh": q.ratio(
                pd("second"), MEASURES.quantity_of(run.TWO_SOFTER, "second")
            ),
        },
        limits_above(
            1.05, "more than the step from one start to the next changes it at usual damping"
        ),
    ),
    "2.1-05": (
        factor(
            pd("after_start"),
            MEASURES.quantity_of(run.NO_BACKLASH, "after_start"),
            "factor between the largest fluctuations after the start with and without backlash",
        ),
        limits_above(DOUBLED, "leaving it out changes the result by a factor of two, up or down"),
    ),
    "2.1-06": (
        static("free_play_over_2b"),
        limits_around(1.0, 1e-3, "the places that were tried lie closer than that"),
    ),
    "2.1-07": (static("eq5_work"), limits_above(1.2, "a fifth more work")),
    "2.1-08": (
        q.divergence(run.PD),
        limits_above(HALVED, "1 for a run that diverges, 0 for another"),
    ),
    "2.1-09": (static(f"tanh_error_{SIGMAS[0]}_m"), TANH_M),
    "2.1-10": ({sigma: static(f"tanh_error_{sigma}_m") for sigma in SIGMAS}, TANH_M),
    "2.1-11": ({how: static(f"conversion_{how}") for how in COUNTED}, ROUNDING),
    # stiffness
    "2.2-01": (
        MEASURES.quantity_of(run.CONSTANT_NO_ERROR, "stiffness_follows"),
        limits_above(
            HALVED, "halfway between a force set by the load, 0, and by the deflection, 1"
        ),
    ),
    "2.2-02": (
        q.difference(pd("third"), MEASURES.quantity_of(run.CONSTANT_STIFFNESS, "third")),
        limits_above(MINOR, "the least that a plot of the fluctuations shows"),
    ),
    "2.2-03": (
        {ratio: static(f"series_error_{ratio}") for ratio in CONTACT_RATIOS},
        limits_below(0.03, "400 harmonics leave 1 / (π √400) of it; less than twice that"),
    ),
    "2.2-04": (
        relative_change(
            MEASURES.quantity_of(run.CONSTANT_SQUARE, "x_ripple_um"), torque("x_ripple_um")
        ),
        limits_below(READ_OFF, "as well as the paper reads the ripple off a plot"),
    ),
    "2.2-05": ({ratio: static(f"eq8_error_{ratio}") for ratio in CONTACT_RATIOS}, SMALL),
    "2.2-06": (static("gear_rates_spread"), ROUNDING),
    "2.2-07": (pd("mesh_rate_over_speed"), limits_below(1e-3, "three orders of magnitude")),
    "2.2-08": (pd("neglected_in_eq11"), SMALL),
    "2.2-09": (static("eq12_error"), ROUNDING),
    "2.2-10": (static("eq13_error"), ROUNDING),
    "2.2-11": (
        q.maximum(static("contact_ratio_sp"), static("contact_ratio_pr")),
        limits_below(2.0, "from 2 on there are never fewer than two pairs in contact"),
    ),
    "2.2-12": (
        q.restrict_above(
            q.maximum(MEASURES.quantity_of(run.SQUARE, "third"), pd("third")),
            EVIDENT,
            factor(
                MEASURES.quantity_of(run.SQUARE, "third"),
                pd("third"),
                "factor between the third fluctuations with the square wave and with Eq. 8",
            ),
        ),
        limits_below(DOUBLED, "the fluctuation's size is the same but for a factor of two"),
    ),
    "2.2-13": (
        relative_change(
            MEASURES.quantity_of(run.CONSTANT_SQUARE, "theta_1_rad"), torque("theta_1_rad")
        ),
        SMALL,
    ),
    "2.2-14": (
        relative_change(
            MEASURES.quantity_of(run.CONSTANT_SQUARE, "others_ripple_N"), torque("others_ripple_N")
        ),
        limits_below(READ_OFF, "as for the ripple of x_sp, 2.2-04"),
    ),
    "2.2-15": (
        static("force_at_one_deflection"),
        limits_above(
            HALVED, "halfway between a force set by the load, 0, and by the deflection, 1"
        ),
    ),
    "2.2-16": (static("eq11_error"), ROUNDING),
    # tooth error
    "2.3-01": (
        q.ratio(torque("x_ripple_um"), MEASURES.quantity_of(run.CONSTANT_NO_ERROR, "x_ripple_um")),
        TWICE,
    ),
    "2.3-02": (pd("phase_gap_rad"), limits_below(0.1, "a tenth of a radian: a tenth of E")),
    "2.3-03": (
        static("eq15_excess_N"),
        limits_below(1.0, "1 N; the mesh carries 200 N and more under 100 N m"),
    ),
    # the equations
    "2.4-01": (static("energy_gap"), ROUNDING),
    "2.4-02": (static("mass_slip"), ROUNDING),
    "2.4-03": (static("bias_slip"), ROUNDING),
    "2.4-04": (static("force_slip"), ROUNDING),
    "2.4-05": (static("asymmetry"), ROUNDING),
    "2.4-06": (static("least_eigenvalue"), limits_above(EXACT, "above rounding")),
    "2.4-07": (pd("mesh_over_gross"), SMALL),
    "2.4-08": (static("virtual_work_share"), SMALL),
}
