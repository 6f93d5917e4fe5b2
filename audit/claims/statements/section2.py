"""What decides the statements of the paper's Section 2: the model."""

from __future__ import annotations

from dataclasses import replace

from crosscheck.audit.claims import quantities as q
from crosscheck.audit.claims.rule import (
    READ_OFF,
    ClaimCriteria,
    limits_above,
    limits_around,
    limits_below,
)
from crosscheck.audit.experiments import experiments as run
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
        {mass: q.static(f"base_tip_{mass}_mm") for mass in BASE_MASSES},
        limits_below(1e3 * LIMIT_M, "what Section 3.1 calls a considerable error of the tip"),
    ),
    "2-02": (q.static("ratio_error"), ROUNDING),
    "2-03": (
        q.static("gravity_share"),
        limits_below(1e-3, "a thousandth of the torques that drive the arm"),
    ),
    # backlash
    "2.1-01": (
        q.pd("apart_share"),
        limits_above(1e-3, "a thousandth of the run: several periods of the mesh's vibration"),
    ),
    "2.1-02": (
        q.pd("second_over_before"),
        limits_above(DOUBLED, "the change of sides at least doubles what there was before it"),
    ),
    "2.1-03": (
        q.minimum(
            q.ratio(q.quantity_of(run.NO_ERROR, "third"), q.quantity_of(run.NO_ERROR, "second")),
            q.ratio(
                q.quantity_of(run.NO_ERROR, "third"),
                q.quantity_of(run.BACKLASH_NO_ERROR(0.0), "third"),
            ),
        ),
        limits_above(DOUBLED, "an instability at least doubles what the impact left"),
    ),
    "2.1-04": (
        {
            "equal stiffness of all meshes together": q.ratio(
                q.pd("second"), q.quantity_of(run.TWO_PLANETS, "second")
            ),
            "equal stiffness of each mesh": q.ratio(
                q.pd("second"), q.quantity_of(run.TWO_SOFTER, "second")
            ),
        },
        limits_above(
            1.05, "more than the step from one start to the next changes it at usual damping"
        ),
    ),
    "2.1-05": (
        factor(
            q.pd("after_start"),
            q.quantity_of(run.NO_BACKLASH, "after_start"),
            "factor between the largest fluctuations after the start with and without backlash",
        ),
        limits_above(DOUBLED, "leaving it out changes the result by a factor of two, up or down"),
    ),
    "2.1-06": (
        q.static("free_play_over_2b"),
        limits_around(1.0, 1e-3, "the places that were tried lie closer than that"),
    ),
    "2.1-07": (q.static("eq5_work"), limits_above(1.2, "a fifth more work")),
    "2.1-08": (
        q.divergence(run.PD),
        limits_above(HALVED, "1 for a run that diverges, 0 for another"),
    ),
    "2.1-09": (q.static(f"tanh_error_{SIGMAS[0]}_m"), TANH_M),
    "2.1-10": ({sigma: q.static(f"tanh_error_{sigma}_m") for sigma in SIGMAS}, TANH_M),
    "2.1-11": ({how: q.static(f"conversion_{how}") for how in COUNTED}, ROUNDING),
    # stiffness
    "2.2-01": (
        q.quantity_of(run.CONSTANT_NO_ERROR, "stiffness_follows"),
        limits_above(
            HALVED, "halfway between a force set by the load, 0, and by the deflection, 1"
        ),
    ),
    "2.2-02": (
        q.difference(q.pd("third"), q.quantity_of(run.CONSTANT_STIFFNESS, "third")),
        limits_above(MINOR, "the least that a plot of the fluctuations shows"),
    ),
    "2.2-03": (
        {ratio: q.static(f"series_error_{ratio}") for ratio in CONTACT_RATIOS},
        limits_below(0.03, "400 harmonics leave 1 / (π √400) of it; less than twice that"),
    ),
    "2.2-04": (
        relative_change(q.quantity_of(run.CONSTANT_SQUARE, "x_ripple_um"), q.torque("x_ripple_um")),
        limits_below(READ_OFF, "as well as the paper reads the ripple off a plot"),
    ),
    "2.2-05": ({ratio: q.static(f"eq8_error_{ratio}") for ratio in CONTACT_RATIOS}, SMALL),
    "2.2-06": (q.static("gear_rates_spread"), ROUNDING),
    "2.2-07": (q.pd("mesh_rate_over_speed"), limits_below(1e-3, "three orders of magnitude")),
    "2.2-08": (q.pd("neglected_in_eq11"), SMALL),
    "2.2-09": (q.static("eq12_error"), ROUNDING),
    "2.2-10": (q.static("eq13_error"), ROUNDING),
    "2.2-11": (
        q.maximum(q.static("contact_ratio_sp"), q.static("contact_ratio_pr")),
        limits_below(2.0, "from 2 on there are never fewer than two pairs in contact"),
    ),
    "2.2-12": (
        q.restrict_above(
            q.maximum(q.quantity_of(run.SQUARE, "third"), q.pd("third")),
            EVIDENT,
            factor(
                q.quantity_of(run.SQUARE, "third"),
                q.pd("third"),
                "factor between the third fluctuations with the square wave and with Eq. 8",
            ),
        ),
        limits_below(DOUBLED, "the fluctuation's size is the same but for a factor of two"),
    ),
    "2.2-13": (
        relative_change(q.quantity_of(run.CONSTANT_SQUARE, "theta_1_rad"), q.torque("theta_1_rad")),
        SMALL,
    ),
    "2.2-14": (
        relative_change(
            q.quantity_of(run.CONSTANT_SQUARE, "others_ripple_N"), q.torque("others_ripple_N")
        ),
        limits_below(READ_OFF, "as for the ripple of x_sp, 2.2-04"),
    ),
    "2.2-15": (
        q.static("force_at_one_deflection"),
        limits_above(
            HALVED, "halfway between a force set by the load, 0, and by the deflection, 1"
        ),
    ),
    "2.2-16": (q.static("eq11_error"), ROUNDING),
    # tooth error
    "2.3-01": (
        q.ratio(q.torque("x_ripple_um"), q.quantity_of(run.CONSTANT_NO_ERROR, "x_ripple_um")),
        TWICE,
    ),
    "2.3-02": (q.pd("phase_gap_rad"), limits_below(0.1, "a tenth of a radian: a tenth of E")),
    "2.3-03": (
        q.static("eq15_excess_N"),
        limits_below(1.0, "1 N; the mesh carries 200 N and more under 100 N m"),
    ),
    # the equations
    "2.4-01": (q.static("energy_gap"), ROUNDING),
    "2.4-02": (q.static("mass_slip"), ROUNDING),
    "2.4-03": (q.static("bias_slip"), ROUNDING),
    "2.4-04": (q.static("force_slip"), ROUNDING),
    "2.4-05": (q.static("asymmetry"), ROUNDING),
    "2.4-06": (q.static("least_eigenvalue"), limits_above(EXACT, "above rounding")),
    "2.4-07": (q.pd("mesh_over_gross"), SMALL),
    "2.4-08": (q.static("virtual_work_share"), SMALL),
}
