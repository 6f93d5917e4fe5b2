"""The statements of the paper's abstract and Section 2."""

from __future__ import annotations

from crosscheck.paper.claims.quantities import (
    BACK,
    CONSTANT,
    CONSTANT_NO_ERROR,
    CONSTANT_STIFFNESS,
    NO_BACKLASH,
    NO_ERROR,
    PD,
    STATIC,
    TWO_PLANETS,
)
from crosscheck.paper.claims.rule import (
    Claim,
    about,
    above,
    below,
    difference,
    diverges,
    each,
    largest,
    of,
    over,
    ratio,
    where,
)
from crosscheck.paper.claims.statics import BASE_MASSES, CONTACT_RATIOS, SIGMAS

SEVERE = 100.0  # rad/s^2: four times the rigid arm's own largest acceleration
EVIDENT = 10.0  # rad/s^2: the smallest that the paper calls a fluctuation in Section 3.2
VISIBLE_SHARE = 0.01  # of a torque, a speed, a force: what a plot shows
HALVED, DOUBLED = 0.5, 2.0
EXACT = 1e-9  # rounding
SEVERAL_ORDERS = 1e-3
CONSIDERABLE_MM = 30.0  # Section 3.1's word for this error at the tip
TORQUE_SHARE = 0.02  # the gears' own inertia takes a little
TANH_M = 5e-8  # a hundredth of the tooth error
SUFFICIENT = 0.95  # of a wave's variance
CORRELATED = 0.5

ABSTRACT = (
    Claim(
        "Abstract",
        15,
        "Backlash makes positioning errors accumulate when the joints rotate back and forth.",
        "shoulder's error in the last 0.2 s with b = 50 um over that without backlash",
        "1",
        each(
            ("1", "2"),
            lambda s: ratio(BACK(50)(f"error_{s}_s"), BACK(0)(f"error_{s}_s")),
        ),
        above(DOUBLED),
        "duration of the run [s]",
    ),
    Claim(
        "Abstract",
        14,
        "Tooth error is the main cause of severe acceleration fluctuations.",
        "part of the third fluctuation that vanishes with the tooth error",
        "rad/s²",
        difference(PD("third"), NO_ERROR("third")),
        above(SEVERE),
    ),
    Claim(
        "Abstract",
        13,
        "Tooth error is the main cause of severe meshing force impacts.",
        "fast mesh force after 0.5 s without tooth error over that with it",
        "1",
        ratio(NO_ERROR("third_force_fast_N"), PD("third_force_fast_N")),
        below(HALVED),
    ),
    Claim(
        "Abstract",
        11,
        "The fluctuations make the torque unsteady.",
        "fast part of the torque after 0.5 s over its largest value, larger of both joints",
        "1",
        largest(PD("torque_fast_1"), PD("torque_fast_2")),
        above(VISIBLE_SHARE),
    ),
)

FRAME = (
    Claim(
        "2",
        None,
        "The floating base is so heavy that its movement is not obvious: a fixed base will do.",
        "shift of a free base, kept from turning, over the PD motion",
        "mm",
        each(BASE_MASSES, lambda m: of(STATIC(f"base_shift_{m}_mm"))),
        below(CONSIDERABLE_MM),
        "base mass over the arm's",
    ),
    Claim(
        "2",
        None,
        "The reduction ratio is n = z_r / z_s + 1.",
        "error of n against rolling without slip",
        "1",
        of(STATIC("ratio_error")),
        below(EXACT),
    ),
)

BACKLASH = (
    Claim(
        "2.1",
        13,
        "Backlash interrupts the meshing force.",
        "share of the PD run in which the teeth are apart",
        "1",
        of(PD("apart_share")),
        above(1e-3),
    ),
    Claim(
        "2.1",
        14,
        "Backlash excites fluctuation.",
        "second fluctuation less that without backlash",
        "rad/s²",
        difference(PD("second"), NO_BACKLASH("second")),
        above(1.0),
    ),
    Claim(
        "2.1",
        14,
        "The fluctuation that backlash excites may end in instability.",
        "growth of the fluctuation after 0.5 s without tooth error, where there is one",
        "1",
        where(NO_ERROR("third"), above(EVIDENT), of(NO_ERROR("third_growth"))),
        above(DOUBLED),
    ),
    Claim(
        "2.1",
        16,
        "Several pairs meshing at once make the effect of backlash worse.",
        "second fluctuation with three planets over that with two",
        "1",
        ratio(PD("second"), TWO_PLANETS("second")),
        above(1.05),
    ),
    Claim(
        "2.1",
        14,
        "Backlash cannot be left out of a planetary gear train's model.",
        "largest fluctuation, third or second, with backlash over that without",
        "1",
        over(
            largest(PD("second"), PD("third")),
            largest(NO_BACKLASH("second"), NO_BACKLASH("third")),
        ),
        above(DOUBLED),
    ),
    Claim(
        "2.1",
        4,
        "The clearance of a mesh is 2b (Eqs. 4, 5).",
        "width of the force-free range over 2b",
        "1",
        of(STATIC("free_play_over_2b")),
        about(1.0, 1e-3),
    ),
    Claim(
        "2.1",
        4,
        "Eq. 5 takes significantly longer to compute than its smooth stand-in.",
        "evaluations that an adaptive integrator needs with Eq. 5 over those with Eq. 6",
        "1",
        each(SIGMAS, lambda sigma: of(STATIC(f"tanh_cost_{sigma}"))),
        above(1.2),
        "sigma of Eq. 6 [1/m]",
    ),
    Claim(
        "2.1",
        4,
        "Eq. 5's corners may make the numerical solution diverge.",
        "runs with the exact dead zone that diverge, of one per cell",
        "1",
        diverges(PD),
        above(HALVED),
    ),
    Claim(
        "2.1",
        4,
        "Eq. 6 is accurate enough when sigma is large enough.",
        f"largest error of Eq. 6 against Eq. 5 at sigma = {SIGMAS[0]} 1/m",
        "m",
        of(STATIC(f"tanh_error_{SIGMAS[0]}_m")),
        below(TANH_M),
    ),
    Claim(
        "2.1",
        4,
        "Eq. 6 can stand in for Eq. 5.",
        "largest error of Eq. 6 against Eq. 5",
        "m",
        each(SIGMAS, lambda sigma: of(STATIC(f"tanh_error_{sigma}_m"))),
        below(TANH_M),
        "sigma of Eq. 6 [1/m]",
    ),
)

STIFFNESS = (
    Claim(
        "2.2",
        5,
        "The mesh force rises with two pairs of teeth engaged and falls with one.",
        "correlation of mesh force and stiffness under constant torque, tooth error left out",
        "1",
        of(CONSTANT_NO_ERROR("stiffness_correlation")),
        above(CORRELATED),
    ),
    Claim(
        "2.2",
        5,
        "The varying stiffness also excites fluctuation.",
        "third fluctuation less that with constant stiffness",
        "rad/s²",
        difference(PD("third"), CONSTANT_STIFFNESS("third")),
        above(1.0),
    ),
    Claim(
        "2.2",
        5,
        "Eq. 7 is the Fourier series of the square wave of Fig. 5.",
        "root mean square error with 400 harmonics, over the wave's swing",
        "1",
        each(CONTACT_RATIOS, lambda e: of(STATIC(f"series_error_{e}"))),
        below(0.03),
        "contact ratio",
    ),
    Claim(
        "2.2",
        5,
        "The fundamental alone is sufficient for the stiffness.",
        "share of the square wave's variance in the fundamental",
        "1",
        each(CONTACT_RATIOS, lambda e: of(STATIC(f"first_harmonic_share_{e}"))),
        above(SUFFICIENT),
        "contact ratio",
    ),
    Claim(
        "2.2",
        5,
        "Eq. 8, a sine without phase, is the fundamental of Eq. 7.",
        "root mean square error of Eq. 8 over that of its sine",
        "1",
        each(CONTACT_RATIOS, lambda e: of(STATIC(f"eq8_error_{e}"))),
        below(VISIBLE_SHARE),
        "contact ratio",
    ),
    Claim(
        "2.2",
        None,
        "Eq. 10, speed relative to the carrier times teeth, holds for sun, planet and ring alike.",
        "spread of the three gears' meshing frequencies over the carrier's speed",
        "1",
        of(STATIC("gear_rates_spread")),
        below(EXACT),
    ),
    Claim(
        "2.2",
        None,
        "x_sp' and x_pr' are several orders of magnitude below theta_c'.",
        "largest x_sp' or x_pr' [m/s] over largest theta_c' [rad/s], numbers in SI units",
        "m",
        of(PD("mesh_rate_over_speed")),
        below(SEVERAL_ORDERS),
    ),
    Claim(
        "2.2",
        None,
        "x_sp' and x_pr' can be left out of Eq. 11.",
        "largest x_sp' + x_pr' over largest 2 r_c cos(alpha) theta_c' over the PD run",
        "1",
        of(PD("neglected_in_eq11")),
        below(VISIBLE_SHARE),
    ),
    Claim(
        "2.2",
        None,
        "Eq. 12 gives the sun mesh's frequency.",
        "error of Eq. 12 against Eq. 10 and rolling without slip",
        "1",
        of(STATIC("eq12_error")),
        below(EXACT),
    ),
    Claim(
        "2.2",
        None,
        "Eq. 13 gives the ring mesh's frequency, similarly.",
        "error of Eq. 13 against Eq. 10 and rolling without slip",
        "1",
        of(STATIC("eq13_error")),
        below(EXACT),
    ),
)

TOOTH_ERROR = (
    Claim(
        "2.3",
        8,
        "Tooth error excites fluctuation in the meshing.",
        "ripple of x_sp under constant torque with tooth error over that without",
        "1",
        ratio(CONSTANT("x_ripple_um"), CONSTANT_NO_ERROR("x_ripple_um")),
        above(DOUBLED),
    ),
    Claim(
        "2.3",
        14,
        "The tooth error is E sin(omega_e t), omega_e the current meshing frequency (Eq. 14).",
        "largest distance of omega_e t from the angle that has passed the mesh, PD run",
        "rad",
        of(PD("phase_gap_rad")),
        below(0.1),
    ),
    Claim(
        "2.3",
        13,
        "Mesh forces are k (x - e) (Eq. 15).",
        "force that Eq. 15 adds to Eq. 4's within and beyond the clearance",
        "N",
        of(STATIC("eq15_excess_N")),
        below(1.0),
    ),
)

EQUATIONS = (
    Claim(
        "2.4",
        None,
        "Eqs. 16 to 19 are the kinetic energy of joints and links.",
        "largest entry of M missing against true absolute velocities, over the largest of M",
        "1",
        of(STATIC("energy_gap")),
        below(EXACT),
    ),
    Claim(
        "2.4",
        None,
        "The listed M follows from Eqs. 16 to 19.",
        "largest difference over the largest entry",
        "1",
        of(STATIC("mass_slip")),
        below(EXACT),
    ),
    Claim(
        "2.4",
        None,
        "The listed C follows from Eqs. 16 to 19.",
        "largest difference of the force C q' over its largest entry",
        "1",
        of(STATIC("bias_slip")),
        below(EXACT),
    ),
    Claim(
        "2.4",
        None,
        "The listed F is that of virtual work.",
        "largest difference over the largest entry",
        "1",
        of(STATIC("force_slip")),
        below(EXACT),
    ),
    Claim(
        "2.4",
        None,
        "M is an inertia matrix: symmetric.",
        "largest difference of opposite entries of the printed M",
        "mixed",
        of(STATIC("asymmetry")),
        below(EXACT),
    ),
    Claim(
        "2.4",
        None,
        "M is an inertia matrix: positive definite.",
        "smallest eigenvalue of the printed M over random poses",
        "mixed",
        of(STATIC("least_eigenvalue")),
        above(EXACT),
    ),
    Claim(
        "2.4",
        12,
        "The teeth's deformation is small against the gross motion.",
        "largest x_sp or x_pr over the carrier's path 2 r_c cos(alpha) theta, PD run",
        "1",
        of(PD("mesh_over_gross")),
        below(VISIBLE_SHARE),
    ),
)

CLAIMS = (*ABSTRACT, *FRAME, *BACKLASH, *STIFFNESS, *TOOTH_ERROR, *EQUATIONS)
