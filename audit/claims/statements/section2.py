"""The statements of the paper's Section 2: the model."""

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
from crosscheck.audit.claims.rule import READ_OFF, Claim, about, above, below
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


FRAME = (
    Claim(
        "2-01",
        None,
        "The floating base is so heavy that its movement is not obvious: a fixed base will do.",
        each(BASE_MASSES, lambda mass: of(STATIC, f"base_tip_{mass}_mm")),
        below(1e3 * LIMIT_M, "what Section 3.1 calls a considerable error of the tip"),
        "base's mass over the arm's",
        "a cube of 2 m, free to shift and to turn, the arm driven by PD control and by 100 N m",
    ),
    Claim(
        "2-02",
        None,
        "The reduction ratio is n = z_r / z_s + 1.",
        of(STATIC, "ratio_error"),
        ROUNDING,
    ),
    Claim(
        "2-03",
        None,
        "In orbit, gravity can be left out.",
        of(STATIC, "gravity_share"),
        below(1e-3, "a thousandth of the torques that drive the arm"),
        reading="in free fall gravity's gradient is left, here 400 km above the Earth",
    ),
)

BACKLASH = (
    Claim(
        "2.1-01",
        13,
        "Backlash interrupts the meshing force.",
        of(PD, "apart_share"),
        above(1e-3, "a thousandth of the run: several periods of the mesh's vibration"),
    ),
    Claim(
        "2.1-02",
        14,
        "Backlash excites fluctuation.",
        of(PD, "second_over_before"),
        above(DOUBLED, "the change of sides at least doubles what there was before it"),
    ),
    Claim(
        "2.1-03",
        14,
        "The fluctuation that backlash excites may end in instability.",
        smallest(
            over(of(NO_ERROR, "third"), of(NO_ERROR, "second")),
            over(of(NO_ERROR, "third"), of(BACKLASH_NO_ERROR(0.0), "third")),
        ),
        above(DOUBLED, "an instability at least doubles what the impact left"),
        reading="without tooth error: long after the change of sides there is more than at it, and"
        " more than without backlash",
    ),
    Claim(
        "2.1-04",
        16,
        "Several pairs meshing at once make the effect of backlash worse.",
        {
            "equal stiffness of all meshes together": over(
                of(PD, "second"), of(TWO_PLANETS, "second")
            ),
            "equal stiffness of each mesh": over(of(PD, "second"), of(TWO_SOFTER, "second")),
        },
        above(1.05, "more than the step from one start to the next changes it at usual damping"),
        "what is held equal when a planet is taken out",
        "effect of backlash: the fluctuation when the teeth change sides",
    ),
    Claim(
        "2.1-05",
        14,
        "Backlash cannot be left out of a planetary gear train's model.",
        factor(
            of(PD, "after_start"),
            of(NO_BACKLASH, "after_start"),
            "factor between the largest fluctuations after the start with and without backlash",
        ),
        above(DOUBLED, "leaving it out changes the result by a factor of two, up or down"),
    ),
    Claim(
        "2.1-06",
        4,
        "The clearance of a mesh is 2b (Eqs. 4, 5).",
        of(STATIC, "free_play_over_2b"),
        about(1.0, 1e-3, "the places that were tried lie closer than that"),
    ),
    Claim(
        "2.1-07",
        4,
        "Eq. 5 takes significantly longer to compute than its smooth stand-in.",
        of(STATIC, "eq5_work"),
        above(1.2, "a fifth more work"),
        reading="per step of the Runge-Kutta method that the paper uses, of fixed length: the same"
        " number of evaluations with either equation",
    ),
    Claim(
        "2.1-08",
        4,
        "Eq. 5's discontinuous points may make the numerical solution diverge.",
        diverged(PD),
        above(HALVED, "1 for a run that diverges, 0 for another"),
        reading="Eq. 5 has corners, and no point at which it is discontinuous",
    ),
    Claim(
        "2.1-09",
        4,
        "Eq. 6 is accurate enough when sigma is large enough.",
        of(STATIC, f"tanh_error_{SIGMAS[0]}_m"),
        TANH_M,
    ),
    Claim(
        "2.1-10",
        4,
        "Eq. 6 can stand in for Eq. 5.",
        each(SIGMAS, lambda sigma: of(STATIC, f"tanh_error_{sigma}_m")),
        TANH_M,
        "sigma of Eq. 6 [1/m]",
    ),
    Claim(
        "2.1-11",
        None,
        "Eqs. 2 and 3 turn rotations into displacements along the lines of action.",
        each(list(COUNTED), lambda how: of(STATIC, f"conversion_{how}")),
        ROUNDING,
        "how theta_p counts",
        "compared with the speeds at which the flanks of turning gears approach each other",
    ),
)

STIFFNESS = (
    Claim(
        "2.2-01",
        5,
        "The mesh force rises with two pairs of teeth engaged and falls with one.",
        of(CONSTANT_NO_ERROR, "stiffness_follows"),
        above(HALVED, "halfway between a force set by the load, 0, and by the deflection, 1"),
        reading="at a given load: under constant torque, tooth error left out",
    ),
    Claim(
        "2.2-02",
        5,
        "The varying stiffness also excites fluctuation.",
        difference(of(PD, "third"), of(CONSTANT_STIFFNESS, "third")),
        above(MINOR, "the least that a plot of the fluctuations shows"),
    ),
    Claim(
        "2.2-03",
        5,
        "Eq. 7 is the Fourier series of the square wave of Fig. 5.",
        each(CONTACT_RATIOS, lambda ratio: of(STATIC, f"series_error_{ratio}")),
        below(0.03, "400 harmonics leave 1 / (π √400) of it; less than twice that"),
        "contact ratio",
    ),
    Claim(
        "2.2-04",
        5,
        "The fundamental alone is sufficient for the stiffness: for the ripple of x_sp.",
        changed_by(of(CONSTANT_SQUARE, "x_ripple_um"), of(CONSTANT, "x_ripple_um")),
        below(READ_OFF, "as well as the paper reads the ripple off a plot"),
        reading="contact ratio 1.5, at which Eq. 8 is the wave's fundamental; 15 harmonics",
    ),
    Claim(
        "2.2-05",
        5,
        "Eq. 8, a sine without phase, is the fundamental of Eq. 7.",
        each(CONTACT_RATIOS, lambda ratio: of(STATIC, f"eq8_error_{ratio}")),
        SMALL,
        "contact ratio",
        "with standard teeth where the contact ratio is that of a mesh",
    ),
    Claim(
        "2.2-06",
        None,
        "Eq. 10, speed relative to the carrier times teeth, holds for sun, planet and ring alike.",
        of(STATIC, "gear_rates_spread"),
        ROUNDING,
    ),
    Claim(
        "2.2-07",
        None,
        "x_sp' and x_pr' are several orders of magnitude below theta_c'.",
        of(PD, "mesh_rate_over_speed"),
        below(1e-3, "three orders of magnitude"),
        reading="once the start is over; m/s beside rad/s, as the paper has it: other units give"
        " another answer",
    ),
    Claim(
        "2.2-08",
        None,
        "x_sp' and x_pr' can be left out of Eq. 11.",
        of(PD, "neglected_in_eq11"),
        SMALL,
        reading="at their largest once the start is over; the phase takes 4 b z_s / r_s of them at"
        " most",
    ),
    Claim(
        "2.2-09", None, "Eq. 12 gives the sun mesh's frequency.", of(STATIC, "eq12_error"), ROUNDING
    ),
    Claim(
        "2.2-10",
        None,
        "Eq. 13 gives the ring mesh's frequency, similarly.",
        of(STATIC, "eq13_error"),
        ROUNDING,
    ),
    Claim(
        "2.2-11",
        5,
        "The contact ratio of a pair of gears is below 2.",
        largest(of(STATIC, "contact_ratio_sp"), of(STATIC, "contact_ratio_pr")),
        below(2.0, "from 2 on there are never fewer than two pairs in contact"),
        reading="this gear set with standard teeth, addendum one module, no correction",
    ),
    Claim(
        "2.2-12",
        5,
        "The fundamental alone is sufficient for the stiffness: for the third fluctuation.",
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
        reading="contact ratio 1.5, at which Eq. 8 is the wave's fundamental; 15 harmonics",
    ),
    Claim(
        "2.2-13",
        5,
        "The fundamental alone is sufficient for the stiffness: for the shoulder's angle.",
        changed_by(of(CONSTANT_SQUARE, "theta_1_rad"), of(CONSTANT, "theta_1_rad")),
        SMALL,
        reading="contact ratio 1.5, at which Eq. 8 is the wave's fundamental; 15 harmonics",
    ),
    Claim(
        "2.2-14",
        5,
        "The fundamental alone is sufficient for the stiffness: for the other pairs' mesh forces.",
        changed_by(of(CONSTANT_SQUARE, "others_ripple_N"), of(CONSTANT, "others_ripple_N")),
        below(READ_OFF, "as for the ripple of x_sp, 2.2-04"),
        reading="contact ratio 1.5, at which Eq. 8 is the wave's fundamental; 15 harmonics",
    ),
    Claim(
        "2.2-15",
        5,
        "At a given deflection the mesh force rises with two pairs engaged and falls with one.",
        of(STATIC, "force_at_one_deflection"),
        above(HALVED, "halfway between a force set by the load, 0, and by the deflection, 1"),
    ),
    Claim(
        "2.2-16", None, "Eq. 11 follows from Eqs. 2, 3 and 10.", of(STATIC, "eq11_error"), ROUNDING
    ),
)

TOOTH_ERROR = (
    Claim(
        "2.3-01",
        8,
        "Tooth error excites fluctuation in the meshing.",
        over(of(CONSTANT, "x_ripple_um"), of(CONSTANT_NO_ERROR, "x_ripple_um")),
        TWICE,
    ),
    Claim(
        "2.3-02",
        14,
        "The tooth error is E sin(omega_e t), omega_e the current meshing frequency (Eq. 14).",
        of(PD, "phase_gap_rad"),
        below(0.1, "a tenth of a radian: a tenth of E"),
    ),
    Claim(
        "2.3-03",
        13,
        "Mesh forces are k (x - e) (Eq. 15).",
        of(STATIC, "eq15_excess_N"),
        below(1.0, "1 N; the mesh carries 200 N and more under 100 N m"),
    ),
)

EQUATIONS = (
    Claim(
        "2.4-01",
        None,
        "Eqs. 16 to 19 are the kinetic energy of joints and links.",
        of(STATIC, "energy_gap"),
        ROUNDING,
    ),
    Claim(
        "2.4-02",
        None,
        "The listed M follows from Eqs. 16 to 19.",
        of(STATIC, "mass_slip"),
        ROUNDING,
    ),
    Claim(
        "2.4-03",
        None,
        "The listed C follows from Eqs. 16 to 19.",
        of(STATIC, "bias_slip"),
        ROUNDING,
    ),
    Claim(
        "2.4-04",
        None,
        "The listed F is that of virtual work.",
        of(STATIC, "force_slip"),
        ROUNDING,
        reading="of mesh forces and torques; what k and e do on theta is 2.4-08",
    ),
    Claim("2.4-05", None, "M is an inertia matrix: symmetric.", of(STATIC, "asymmetry"), ROUNDING),
    Claim(
        "2.4-06",
        None,
        "M is an inertia matrix: positive definite.",
        of(STATIC, "least_eigenvalue"),
        above(EXACT, "above rounding"),
    ),
    Claim(
        "2.4-07",
        12,
        "The teeth's deformation is small against the gross motion.",
        of(PD, "mesh_over_gross"),
        SMALL,
    ),
    Claim(
        "2.4-08",
        None,
        "The mesh forces hold all of the springs' potential energy that matters.",
        of(STATIC, "virtual_work_share"),
        SMALL,
        reading="what they leave out: springs whose k and e vary with theta push theta as well",
    ),
)

CLAIMS = (*FRAME, *BACKLASH, *STIFFNESS, *TOOTH_ERROR, *EQUATIONS)
