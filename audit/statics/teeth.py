"""What the gears' data say of Sections 2.1 and 2.2: kinematics, contact, clearance, stiffness."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import sympy as sp

from crosscheck.analytic.paper.kinematics import StageGeometry, gear_angles, mesh_displacements
from crosscheck.analytic.paper.mesh_force import EXACT, dead_zone, dead_zone_tanh, mesh_force
from crosscheck.analytic.paper.mesh_frequency import (
    meshing_frequency,
    ring_mesh_rate,
    sun_mesh_frequency,
    sun_mesh_rate,
)
from crosscheck.analytic.paper.stiffness import (
    fundamental_stiffness,
    square_wave,
    square_wave_series,
)
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.measures.stage import PaperStage
from crosscheck.models.arm.arm import Planetary

SIGMAS = ("1e8", "1e7", "1e6", "1e5")  # 1/m, Eq. 6
SINGLE_SINE = "1.5"  # the contact ratio at which Eq. 7's fundamental is a sine without phase
CONTACT_RATIOS = (SINGLE_SINE, "of the sun mesh", "of the ring mesh")
# How theta_p of Eqs. 2 and 3 may count: with the planet's own rate, given that and the carrier's.
COUNTED: dict[str, Callable[[float, float], float]] = {
    "against the carrier": lambda planet, carrier: -planet,
    "with the carrier": lambda planet, carrier: planet,
    "against the carrier, seen from it": lambda planet, carrier: carrier - planet,
}
HARMONICS = 400
ADDENDUM = 1.0  # over the module: the standard tooth, uncorrected


def compute_gearing(stage: PaperStage) -> Numbers:
    """Numbers of ratio, conversion and frequencies against pure rolling; contact ratios."""
    joint, geometry = stage.joint, stage.geometry
    radii = geometry.r_s, geometry.r_p, geometry.r_cp
    sun, planet = gear_angles(0.0, 0.0, 1.0, *radii)
    by_gear = (
        meshing_frequency(sun, 1.0, joint.sun_teeth),
        -meshing_frequency(-planet, 1.0, joint.planet_teeth),
        -meshing_frequency(0.0, 1.0, joint.ring_teeth),
    )
    # Eq. 11 against Eq. 10 with the sun's rate from Eqs. 2-3 solved, teeth deforming.
    deforming = 0.3, -0.2, 1.0  # rates of x_sp, x_pr and the carrier, of any size
    true = meshing_frequency(gear_angles(*deforming, *radii)[0], 1.0, joint.sun_teeth)
    eq11 = sun_mesh_frequency(*deforming, geometry, joint.sun_teeth)
    return {
        "ratio_error": abs(sun / geometry.n - 1),
        "gear_rates_spread": float(np.ptp(by_gear)),
        "eq11_error": abs(eq11 / true - 1),
        "eq12_error": abs(sun_mesh_rate(joint, geometry) / by_gear[0] - 1),
        "eq13_error": abs(ring_mesh_rate(joint, geometry, "eq13") / by_gear[1] - 1),
        "contact_ratio_sp": sun_contact_ratio(joint),
        "contact_ratio_pr": ring_contact_ratio(joint),
        **{f"conversion_{name}": conversion_error(joint, geometry, name) for name in COUNTED},
    }


def conversion_error(joint: Planetary, geometry: StageGeometry, counted: str) -> float:
    """Largest error of Eqs. 2-3 against flanks' speeds of approach, over the sun's base radius.

    Over three motions that make up any other: sun, planet or carrier turning alone.
    """
    radii = geometry.r_s, geometry.r_p, geometry.r_cp
    errors = []
    for sun, planet, carrier in np.eye(3):
        theta_p = COUNTED[counted](planet, carrier)
        printed = mesh_displacements(sun, theta_p, carrier, *radii)
        errors += np.abs(np.subtract(printed, approach_rates(joint, sun, planet, carrier))).tolist()
    return max(errors) / geometry.r_s


def approach_rates(
    joint: Planetary, sun: float, planet: float, carrier: float
) -> tuple[float, float]:
    """Rates [m/s] at which the driving flanks of sun and planet, planet and ring are pressed.

    From absolute rates [rad/s], ring at rest, by the velocities of material points at the pitch
    points, along the lines of action; the planet's centre lies on the x axis.
    """
    alpha = math.radians(joint.pressure_angle_deg)
    half = joint.module_m / 2
    centre = half * (joint.sun_teeth + joint.planet_teeth)
    inner, outer = half * joint.sun_teeth, half * joint.ring_teeth

    def planet_point(x: float) -> complex:
        return 1j * (carrier * centre + planet * (x - centre))

    at_sun = 1j * sun * inner - planet_point(inner)
    at_ring = -planet_point(outer)
    # The sun pushes the planet forwards, the planet the ring backwards.
    along_sun, along_ring = np.exp(1j * (np.pi / 2 + alpha)), np.exp(1j * (np.pi / 2 - alpha))
    return _component(at_sun, along_sun), _component(at_ring, along_ring)


def _component(velocity: complex, direction: complex) -> float:
    return float((velocity * np.conj(direction)).real)


def sun_contact_ratio(joint: Planetary) -> float:
    """Contact ratio of the sun mesh, external, with a standard addendum: path over base pitch."""
    sun, planet = (_reach(joint, teeth, 1) for teeth in (joint.sun_teeth, joint.planet_teeth))
    return (sun + planet - _base_circle_distance(joint)) / _base_pitch(joint)


def ring_contact_ratio(joint: Planetary) -> float:
    """Contact ratio of the ring mesh, internal: the ring's tips lie inside its pitch circle."""
    planet, ring = _reach(joint, joint.planet_teeth, 1), _reach(joint, joint.ring_teeth, -1)
    return (planet - ring + _base_circle_distance(joint)) / _base_pitch(joint)


def _reach(joint: Planetary, teeth: int, side: int) -> float:
    """Length [m] of the line of action from a gear's base circle to its tip circle."""
    pitch = joint.module_m * teeth / 2
    tip = pitch + side * ADDENDUM * joint.module_m
    return math.sqrt(tip**2 - (pitch * math.cos(math.radians(joint.pressure_angle_deg))) ** 2)


def _base_circle_distance(joint: Planetary) -> float:
    """Length [m] of the line of action between the base circles: both meshes have one distance."""
    distance = joint.module_m * (joint.sun_teeth + joint.planet_teeth) / 2
    return distance * math.sin(math.radians(joint.pressure_angle_deg))


def _base_pitch(joint: Planetary) -> float:
    return math.pi * joint.module_m * math.cos(math.radians(joint.pressure_angle_deg))


def compute_clearance(stage: PaperStage) -> Numbers:
    """Eqs. 4-6, 15: the backlash, the smooth stand-in's error, the force that Eq. 15 invents."""
    b = stage.backlash_m
    x = np.linspace(-3 * b, 3 * b, 60001)
    exact = dead_zone(x, b)
    free = x[exact == 0]

    def largest_error(sigma: float) -> float:
        return float(np.abs(dead_zone_tanh(x, b, sigma) - exact).max())

    # On the longest way through Eq. 5: every comparison, and the longest of its lines.
    x_, b_ = sp.symbols("x b", positive=True)
    lines, comparisons = (x_ - b_, sp.S.Zero, x_ + b_), (x_ > b_, x_ > -b_)
    eq5 = len(comparisons) + int(max(sp.count_ops(line) for line in lines))
    return {
        "free_play_over_2b": float(np.ptp(free) / (2 * b)),
        "eq15_excess_N": stage.mesh_stiffness_N_per_m * float(np.abs(x - exact).max()),
        "eq5_work": eq5 / _eq6_operations(),
        **{f"tanh_error_{sigma}_m": largest_error(float(sigma)) for sigma in SIGMAS},
    }


def _eq6_operations() -> int:
    """The number of Eq. 6's operations, repeated parts counted once and a tanh as one."""
    x, b, sigma = sp.symbols("x b sigma", positive=True)
    right, left = sp.tanh(sigma * (x - b)), sp.tanh(sigma * (x + b))
    smooth = x + x / 2 * (right - left) - b / 2 * (right + left)
    shared, rest = sp.cse(smooth)
    return int(sp.count_ops([expression for _, expression in shared]) + sp.count_ops(rest))


def compare_stiffness_wave(stage: PaperStage) -> Numbers:
    """Numbers of Eqs. 7-8 against the wave of Fig. 5, swing such that the fundamental is k_a.

    Errors of Eq. 7 over the swing, and of Eq. 8 over its own sine, at every contact ratio.
    """
    cycle = (np.arange(20000) + 0.5) / 20000
    k_m, k_a = stage.mesh_stiffness_N_per_m, stage.mesh_stiffness_amplitude_N_per_m
    swing = math.pi * k_a
    # d ln F / d ln k from the softest to the stiffest, the teeth pressed together by E.
    ends, b = fundamental_stiffness(np.array([-1.0, 1.0]), k_m, k_a), stage.backlash_m
    force = mesh_force(EXACT, b + stage.tooth_error_m, ends, b, stage.tanh_sharpness_per_m)
    elasticity = float(np.diff(np.log(force))[0] / np.diff(np.log(ends))[0])
    numbers: Numbers = {"force_at_one_deflection": elasticity}
    joint = stage.joint
    ratios = float(SINGLE_SINE), sun_contact_ratio(joint), ring_contact_ratio(joint)
    for text, ratio in zip(CONTACT_RATIOS, ratios, strict=True):
        low = k_m - swing * (ratio - 1)
        wave = square_wave(cycle, low, low + swing, ratio)
        first, many = (
            square_wave_series(cycle, low, low + swing, ratio, count) for count in (1, HARMONICS)
        )
        eq8 = fundamental_stiffness(np.sin(2 * np.pi * cycle), k_m, np.ptp(first) / 2)
        numbers[f"series_error_{text}"] = _rms(many - wave) / swing
        numbers[f"eq8_error_{text}"] = _rms(eq8 - first) / _rms(first - first.mean())
    return numbers


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def virtual_work(stage: PaperStage, torque: float) -> float:
    """Largest torque [N m] on theta from a stage's springs because k and e vary with theta.

    Of V = k f^2 / 2, f = x - e - b: at the deflection that carries the torque [N m, output side].
    """
    joint, geometry = stage.joint, stage.geometry
    force = torque / geometry.n / geometry.r_s / joint.planet_count
    k = stage.mesh_stiffness_N_per_m
    by_error = force * stage.tooth_error_m
    by_stiffness = (force / k) ** 2 / 2 * stage.mesh_stiffness_amplitude_N_per_m
    rates = sun_mesh_rate(joint, geometry) + ring_mesh_rate(joint, geometry, "corrected")
    return joint.planet_count * rates * math.hypot(by_error, by_stiffness)
