"""What decides the statements of the paper's Section 2: the model."""

from __future__ import annotations

from dataclasses import replace

from crosscheck.audit.claims.quantities import (
    Quantity,
    difference,
    diverged,
    each,
    largest,
    of,
    over,
    size,
    smallest,
    where,
)
from crosscheck.audit.claims.rule import READ_OFF, Decided, about, above, below
from crosscheck.audit.experiments.experiments import (
    BACKLASH_NO_ERROR,
    CONSTANT,
    CONSTANT_NO_ERROR,
    CONSTANT_SQUARE,
    CONSTANT_STIFFNESS,
    NO_BACKLASH,
    NO_ERROR,
    PD,
    SQUARE,
    STATIC,
    TWO_PLANETS,
    TWO_SOFTER,
)
from crosscheck.audit.hypotheses.evidence.flights import LIMIT_M
from crosscheck.audit.measures.thresholds import (
    DOUBLED,
    EVIDENT,
    EXACT,
    HALVED,
    MINOR,
    VISIBLE_SHARE,
)
from crosscheck.audit.statics.surroundings import BASE_MASSES
from crosscheck.audit.statics.teeth import CONTACT_RATIOS, COUNTED, SIGMAS

ROUNDING = below(EXACT, "an identity: rounding alone may be left")
SMALL = below(VISIBLE_SHARE, "a line's width in a plot of what it is compared with")
TANH_M = below(5e-8, "a hundredth of the tooth error, the smallest length of the model")
TWICE = above(DOUBLED, "twice as much: no scatter of starts comes near it")


def factor(one: Quantity, other: Quantity, words: str) -> Quantity:
    """The larger over the smaller of two."""
    return replace(largest(over(one, other), over(other, one)), words=words, unit="1")


def changed_by(waves: Quantity, sine: Quantity) -> Quantity:
    """Change of a number by the stiffness's harmonics, over the number's size."""
    return over(size(difference(waves, sine)), size(sine))


DECIDED: Decided = {
    # the base, the ratio, the orbit
    "2-01": (
        each(BASE_MASSES, lambda mass: of(STATIC, f"base_tip_{mass}_mm")),
        below(1e3 * LIMIT_M, "what Section 3.1 calls a considerable error of the tip"),
    ),
    "2-02": (of(STATIC, "ratio_error"), ROUNDING),
    "2-03": (
        of(STATIC, "gravity_share"),
        below(1e-3, "a thousandth of the torques that drive the arm"),
    ),
    # backlash
    "2.1-01": (
        of(PD, "apart_share"),
        above(1e-3, "a thousandth of the run: several periods of the mesh's vibration"),
    ),
    "2.1-02": (
        of(PD, "second_over_before"),
        above(DOUBLED, "the change of sides at least doubles what there was before it"),
    ),
    "2.1-03": (
        smallest(
            over(of(NO_ERROR, "third"), of(NO_ERROR, "second")),
            over(of(NO_ERROR, "third"), of(BACKLASH_NO_ERROR(0.0), "third")),
        ),
        above(DOUBLED, "an instability at least doubles what the impact left"),
    ),
    "2.1-04": (
        {
            "equal stiffness of all meshes together": over(
                of(PD, "second"), of(TWO_PLANETS, "second")
            ),
            "equal stiffness of each mesh": over(of(PD, "second"), of(TWO_SOFTER, "second")),
        },
        above(1.05, "more than the step from one start to the next changes it at usual damping"),
    ),
    "2.1-05": (
        factor(
            of(PD, "after_start"),
            of(NO_BACKLASH, "after_start"),
            "factor between the largest fluctuations after the start with and without backlash",
        ),
        above(DOUBLED, "leaving it out changes the result by a factor of two, up or down"),
    ),
    "2.1-06": (
        of(STATIC, "free_play_over_2b"),
        about(1.0, 1e-3, "the places that were tried lie closer than that"),
    ),
    "2.1-07": (of(STATIC, "eq5_work"), above(1.2, "a fifth more work")),
    "2.1-08": (diverged(PD), above(HALVED, "1 for a run that diverges, 0 for another")),
    "2.1-09": (of(STATIC, f"tanh_error_{SIGMAS[0]}_m"), TANH_M),
    "2.1-10": (each(SIGMAS, lambda sigma: of(STATIC, f"tanh_error_{sigma}_m")), TANH_M),
    "2.1-11": (each(list(COUNTED), lambda how: of(STATIC, f"conversion_{how}")), ROUNDING),
    # stiffness
    "2.2-01": (
        of(CONSTANT_NO_ERROR, "stiffness_follows"),
        above(HALVED, "halfway between a force set by the load, 0, and by the deflection, 1"),
    ),
    "2.2-02": (
        difference(of(PD, "third"), of(CONSTANT_STIFFNESS, "third")),
        above(MINOR, "the least that a plot of the fluctuations shows"),
    ),
    "2.2-03": (
        each(CONTACT_RATIOS, lambda ratio: of(STATIC, f"series_error_{ratio}")),
        below(0.03, "400 harmonics leave 1 / (π √400) of it; less than twice that"),
    ),
    "2.2-04": (
        changed_by(of(CONSTANT_SQUARE, "x_ripple_um"), of(CONSTANT, "x_ripple_um")),
        below(READ_OFF, "as well as the paper reads the ripple off a plot"),
    ),
    "2.2-05": (each(CONTACT_RATIOS, lambda ratio: of(STATIC, f"eq8_error_{ratio}")), SMALL),
    "2.2-06": (of(STATIC, "gear_rates_spread"), ROUNDING),
    "2.2-07": (of(PD, "mesh_rate_over_speed"), below(1e-3, "three orders of magnitude")),
    "2.2-08": (of(PD, "neglected_in_eq11"), SMALL),
    "2.2-09": (of(STATIC, "eq12_error"), ROUNDING),
    "2.2-10": (of(STATIC, "eq13_error"), ROUNDING),
    "2.2-11": (
        largest(of(STATIC, "contact_ratio_sp"), of(STATIC, "contact_ratio_pr")),
        below(2.0, "from 2 on there are never fewer than two pairs in contact"),
    ),
    "2.2-12": (
        where(
            largest(of(SQUARE, "third"), of(PD, "third")),
            EVIDENT,
            factor(
                of(SQUARE, "third"),
                of(PD, "third"),
                "factor between the third fluctuations with the square wave and with Eq. 8",
            ),
        ),
        below(DOUBLED, "the fluctuation's size is the same but for a factor of two"),
    ),
    "2.2-13": (changed_by(of(CONSTANT_SQUARE, "theta_1_rad"), of(CONSTANT, "theta_1_rad")), SMALL),
    "2.2-14": (
        changed_by(of(CONSTANT_SQUARE, "others_ripple_N"), of(CONSTANT, "others_ripple_N")),
        below(READ_OFF, "as for the ripple of x_sp, 2.2-04"),
    ),
    "2.2-15": (
        of(STATIC, "force_at_one_deflection"),
        above(HALVED, "halfway between a force set by the load, 0, and by the deflection, 1"),
    ),
    "2.2-16": (of(STATIC, "eq11_error"), ROUNDING),
    # tooth error
    "2.3-01": (over(of(CONSTANT, "x_ripple_um"), of(CONSTANT_NO_ERROR, "x_ripple_um")), TWICE),
    "2.3-02": (of(PD, "phase_gap_rad"), below(0.1, "a tenth of a radian: a tenth of E")),
    "2.3-03": (
        of(STATIC, "eq15_excess_N"),
        below(1.0, "1 N; the mesh carries 200 N and more under 100 N m"),
    ),
    # the equations
    "2.4-01": (of(STATIC, "energy_gap"), ROUNDING),
    "2.4-02": (of(STATIC, "mass_slip"), ROUNDING),
    "2.4-03": (of(STATIC, "bias_slip"), ROUNDING),
    "2.4-04": (of(STATIC, "force_slip"), ROUNDING),
    "2.4-05": (of(STATIC, "asymmetry"), ROUNDING),
    "2.4-06": (of(STATIC, "least_eigenvalue"), above(EXACT, "above rounding")),
    "2.4-07": (of(PD, "mesh_over_gross"), SMALL),
    "2.4-08": (of(STATIC, "virtual_work_share"), SMALL),
}
