"""What the experiments measure: every number once, with what it means and where it looks.

Accelerations are the detailed arm's less those of the rigid arm at level `coupled`; mesh quantities
are those of the shoulder's sun-planet pair, first planet. The measures are in ``sampling``: ``pd``
(``transient`` and ``whole``), ``torque`` (``constant_torque``, ``back_and_forth``), ``statics``.
"""

from __future__ import annotations

from typing import NamedTuple

from crosscheck.audit.experiments.torque import ERROR_WINDOWS_S
from crosscheck.audit.measures.events import AT_ONCE_S
from crosscheck.audit.statics.statics import BENDS
from crosscheck.audit.statics.surroundings import BASE_MASSES
from crosscheck.audit.statics.teeth import CONTACT_RATIOS, COUNTED, SIGMAS
from crosscheck.registry import RIGID_LEVELS

FIRST, SECOND, THIRD = "0 to 0.25 s", "0.1 s from the side change", "0.5 to 1.2 s"
PEAK = "Hann window over 0.1 s around the third's peak"
THREE, FLIGHT = "the first three fluctuations", "the side change"
AT_ONCE = f"{AT_ONCE_S:g} s from the side change"
WHOLE, LATE, RETURN = "whole run", "after 0.1 s", "1.3 to 2.4 s"
LATER = "from 0.25 s"


class Number(NamedTuple):
    """words: a noun phrase; window: the part of the run."""

    words: str
    unit: str
    window: str = ""


_PD = {
    "first": Number("first fluctuation", "rad/s²", FIRST),
    "first_decay_s": Number(
        "time in which the first fluctuation falls to a tenth", "s", "0.15 s from the start"
    ),
    "side_change_s": Number("first contact of the opposite flanks", "s", "from 0.25 s"),
    "after_start": Number("largest fluctuation after the start", "rad/s²", "0.25 to 1.2 s"),
    "second": Number("second fluctuation", "rad/s²", SECOND),
    "second_over_before": Number(
        "second fluctuation over that of the 0.05 s before the teeth part", "1", SECOND
    ),
    "second_decay_s": Number(
        "time in which the second fluctuation falls to a tenth", "s", "0.15 s from the side change"
    ),
    "second_delay_s": Number("onset of the second fluctuation after the side change", "s", SECOND),
    "second_force_N": Number("mesh force of the impact at the side change", "N", AT_ONCE),
    "bouncing_s": Number("time for which the teeth bounce after the side change", "s", SECOND),
    "opposite_share": Number(
        "share of the contact that is on the opposite flanks", "1", "from the side change to 1.2 s"
    ),
    "jump_um": Number("way of x_sp at the side change", "µm", FLIGHT),
    "flight_s": Number("time of free flight at the side change", "s", FLIGHT),
    "third": Number("third fluctuation", "rad/s²", THIRD),
    "third_elbow": Number("third fluctuation of the elbow", "rad/s²", THIRD),
    "third_growth": Number(
        "third fluctuation over what it is in its window's first 0.1 s", "1", THIRD
    ),
    "third_onset_s": Number(
        "time at which the third fluctuation reaches half its size", "s", THIRD
    ),
    "third_gap_s": Number("onset of the third fluctuation after the side change", "s", THIRD),
    "third_force_N": Number("mesh force in the third fluctuation", "N", THIRD),
    "third_force_fast_N": Number(
        "fast part of the mesh force in the third fluctuation", "N", THIRD
    ),
    "torque_fast_1": Number("fast part of the shoulder's torque over its largest", "1", THIRD),
    "torque_fast_2": Number("fast part of the elbow's torque over its largest", "1", THIRD),
    "torque_follows": Number("correlation of the envelopes of torque and acceleration", "1", THIRD),
    "torque_frequency_Hz": Number(
        "dominant frequency of the shoulder's torque's fast part", "Hz", PEAK
    ),
    "speed_fast": Number("fast part of the shoulder's speed over its mean", "1", THIRD),
    "theta_fast_rad": Number("fast part of the shoulder's angle", "rad", THIRD),
    "side_changes": Number("changes of side in the third fluctuation", "1", THIRD),
    "apart_share": Number("share of the time in which the teeth are apart", "1", WHOLE),
    "zero_windows": Number(
        "of the three fluctuations, those that take the acceleration past zero", "1", THREE
    ),
    "apart_windows": Number("of the three fluctuations, those in which the teeth part", "1", THREE),
    "apart_at_zero": Number(
        "share of the moments of zero acceleration in which the teeth are apart", "1", THREE
    ),
    "mesh_rate_over_speed": Number(
        "largest x_sp' or x_pr' over largest theta_c', numbers in SI units", "m", LATER
    ),
    "neglected_in_eq11": Number(
        "largest x_sp' + x_pr' over largest 2 r_c cos(alpha) theta_c'", "1", LATER
    ),
    "mesh_over_gross": Number(
        "largest x_sp or x_pr over the carrier's path 2 r_c cos(alpha) theta", "1", WHOLE
    ),
    "phase_gap_rad": Number(
        "largest distance of omega_e t from the angle that has passed the mesh", "rad", WHOLE
    ),
    "deviation_rad": Number("deviation from the rigid arm with the gears' inertia", "rad", WHOLE),
    "gap_end_rad": Number("distance from the rigid arm with the gears' inertia", "rad", "3 s"),
    "lyapunov_per_s": Number("largest Lyapunov exponent", "1/s", THIRD),
    "planets_apart_m": Number("largest distance between planets of a stage", "m", WHOLE),
    "return_s": Number("return of the teeth to their first side", "s", RETURN),
    "fourth": Number("fourth fluctuation", "rad/s²", "0.4 s from the return"),
    "fourth_over_before": Number(
        "fluctuation after the return over that before", "1", "0.1 s on either side"
    ),
    "speed_at_return": Number("shoulder's speed at the return over its largest", "1", RETURN),
}


def _spectral(joint: str, name: str) -> dict[str, Number]:
    return {
        f"line{joint}": Number(f"largest line of the {name}'s acceleration", "rad/s²", PEAK),
        f"frequency{joint}_Hz": Number(f"dominant frequency of the {name}", "Hz", PEAK),
        f"overtones{joint}": Number(
            f"how many of 2, 3, 4 times its dominant frequency stand out of the {name}'s spectrum",
            "1",
            PEAK,
        ),
        f"low_share{joint}": Number(f"share of the {name}'s energy below 500 Hz", "1", PEAK),
        f"line_share{joint}": Number(
            f"share of the {name}'s energy within 50 Hz of its largest line", "1", PEAK
        ),
        f"static_over_line{joint}": Number(
            f"the {name}'s 0 Hz over its largest fast line", "1", PEAK
        ),
    }


def _positions(joint: str, name: str) -> dict[str, Number]:
    return {
        f"final_{joint}_rad": Number(f"the {name}'s distance from 30°", "rad", "3 s"),
        f"overshoot_{joint}": Number(f"the {name}'s overshoot over 30°", "1", WHOLE),
        f"setback_{joint}": Number(
            f"the {name}'s largest way backwards before its largest angle over 30°", "1", WHOLE
        ),
        f"late_distance_{joint}": Number(
            f"the {name}'s largest distance from 30° over 30°", "1", "from 2.6 s on"
        ),
    }


_CONSTANT = {
    "x_middle_um": Number("middle of the range of x_sp", "µm", LATE),
    "x_ripple_um": Number("ripple of x_sp, peak to peak", "µm", LATE),
    "x_ripple_over_2E": Number("ripple of x_sp over the tooth error's 2 E", "1", LATE),
    "vibration_decay_s": Number(
        "time in which the vibration of the mesh force falls to a tenth", "s", WHOLE
    ),
    "force_at_start_N": Number("mesh force at t = 0", "N", "0 s"),
    "ringing_N": Number("vibration of the mesh force", "N", "0 to 0.1 s"),
    "force_decay": Number("swing of the mesh force before 0.1 s over that after", "1", WHOLE),
    "others_decay": Number(
        "swing of a mesh force before 0.1 s over that after, least of the three other pairs",
        "1",
        WHOLE,
    ),
    "others_decay_s": Number(
        "time in which the vibration of the other pairs' mesh forces falls to a tenth", "s", WHOLE
    ),
    "others_ripple_N": Number("largest ripple of the other pairs' mesh forces", "N", LATE),
    "stroke_1": Number("way of the shoulder over half a circle", "1", WHOLE),
    "stroke_2": Number("way of the elbow over half a circle", "1", WHOLE),
    "theta_1_rad": Number("the shoulder's angle at the end", "rad", "0.5 s"),
    "turns_gained": Number(
        "turning points of the ripple of x_sp after 0.25 s less those before", "1", WHOLE
    ),
    "speeding_up": Number("share of the time in which the shoulder speeds up", "1", WHOLE),
    "stiffness_follows": Number("per cent of mesh force per per cent of stiffness", "1", LATE),
    "torque_gain": Number("mesh torque on the carrier over the motor's", "1", LATE),
}


def _of_level(level: str) -> dict[str, Number]:
    beside = f"the rigid arm `{level}`"
    return {
        f"deviation_1_{level}_rad": Number(f"deviation of theta_1 from {beside}", "rad", WHOLE),
        f"deviation_2_{level}_rad": Number(f"deviation of theta_2 from {beside}", "rad", WHOLE),
        f"tip_{level}_mm": Number(f"distance of the tip from that of {beside}", "mm", WHOLE),
        f"growth_{level}": Number(
            f"the tip's distance from {beside}, second half over first", "1", WHOLE
        ),
        f"relative_{level}": Number(
            f"larger deviation from {beside} over the largest angle", "1", WHOLE
        ),
        f"stroke_share_{level}": Number(f"larger deviation from {beside} over pi", "1", WHOLE),
        f"own_share_{level}": Number(
            f"the shoulder's deviation from {beside} over its own way", "1", WHOLE
        ),
    }


_SWINGS = {
    f"{kind}_{name}": Number(words, "rad", f"{begin:g} to {end:g} s")
    for name, (begin, end) in ERROR_WINDOWS_S.items()
    for kind, words in (
        ("error", "shoulder's error against the rigid arm"),
        ("own", "a rigid arm's error that starts 1e-6 rad off"),
    )
}

_STATIC = {
    "ratio_error": Number("error of n = z_r / z_s + 1 against rolling without slip", "1"),
    "gear_rates_spread": Number(
        "spread of the three gears' meshing frequencies over the carrier's speed", "1"
    ),
    "eq11_error": Number("error of Eq. 11 against Eqs. 2, 3 and 10", "1"),
    "eq12_error": Number("error of Eq. 12 against Eq. 10 and rolling without slip", "1"),
    "eq13_error": Number("error of Eq. 13 against Eq. 10 and rolling without slip", "1"),
    "free_play_over_2b": Number("width of the force-free range over 2b", "1"),
    "eq15_excess_N": Number("force that Eq. 15 adds to Eq. 4's within and beyond the play", "N"),
    "least_eigenvalue": Number("smallest eigenvalue of the printed M over random poses", "mixed"),
    "asymmetry": Number("largest difference of opposite entries of the printed M", "mixed"),
    "mass_slip": Number("largest difference of printed M from Eqs. 16-19 over the largest", "1"),
    "energy_gap": Number("largest entry of M that Eqs. 16-19 miss over the largest of M", "1"),
    "bias_slip": Number("largest difference of printed C q' from Eqs. 16-19, relative", "1"),
    "force_slip": Number("largest difference of printed F from virtual work, relative", "1"),
    "gyration_over_pitch": Number("sun's radius of gyration over its pitch radius", "1"),
    "initial_values": Number("initial values listed, for twelve first-order states", "1"),
    "tooth_thickness_share": Number("6 mm over the tooth thickness at the pitch circle", "1"),
    "error_over_backlash": Number("E over b", "1"),
    "contact_ratio_sp": Number("contact ratio of sun and planet, standard teeth", "1"),
    "contact_ratio_pr": Number("contact ratio of planet and ring, standard teeth", "1"),
    "eq5_work": Number("operations of Eq. 5 over those of Eq. 6, a tanh counted as one", "1"),
    "force_at_one_deflection": Number(
        "per cent of mesh force per per cent of stiffness at one deflection", "1"
    ),
    "gravity_share": Number("torque of gravity's gradient in a low orbit over 100 N m", "1"),
    "virtual_work_share": Number(
        "torque of the springs because k and e vary with theta, over the driving torque", "1"
    ),
    "planted_shown": Number(
        "share of the entries of Eqs. 21, 22 whose loss moves an angle by 0.01 rad", "1"
    ),
}
_CONVERSIONS = {
    f"conversion_{how}": Number(
        f"error of Eqs. 2, 3 against the flanks' approach, theta_p counted {how}", "1"
    )
    for how in COUNTED
}
_BENDS = {
    f"bent_{angle}_mm": Number(f"tip's way by 0.02 and 0.01 rad, elbow at {angle}°", "mm")
    for angle in BENDS
}


_APPROXIMATED = {
    f"tanh_error_{sigma}_m": Number(
        f"largest error of Eq. 6 against Eq. 5 at sigma {sigma} 1/m", "m"
    )
    for sigma in SIGMAS
}


def _series(ratio: str) -> dict[str, Number]:
    return {
        f"series_error_{ratio}": Number(
            f"rms error of Eq. 7 over the wave's swing, contact ratio {ratio}", "1"
        ),
        f"eq8_error_{ratio}": Number(
            f"rms error of Eq. 8 over that of its sine, contact ratio {ratio}", "1"
        ),
    }


_BASES = {
    f"base_tip_{mass}_mm": Number(
        f"the tip's distance from that on a fixed base, base of {mass} times the arm's mass", "mm"
    )
    for mass in BASE_MASSES
}

_PARTS = (
    *(_PD, _CONSTANT, _SWINGS, _STATIC, _CONVERSIONS, _BENDS, _APPROXIMATED, _BASES),
    *(_spectral(*joint) for joint in (("", "shoulder"), ("_elbow", "elbow"))),
    *(_positions(*joint) for joint in (("1", "shoulder"), ("2", "elbow"))),
    *map(_of_level, RIGID_LEVELS),
    *map(_series, CONTACT_RATIOS),
)
MEASURED: dict[str, Number] = {name: number for part in _PARTS for name, number in part.items()}
