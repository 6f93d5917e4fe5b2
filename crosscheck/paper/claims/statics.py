"""Numbers that Section 2's statements rest on and that need no simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from analytic.backlash import dead_zone, dead_zone_tanh
from analytic.kinematics import gear_angles
from analytic.mesh_frequency import meshing_frequency, ring_mesh_rate, sun_mesh_rate
from analytic.model import PhysicalModel
from analytic.paper_model import EnergiesModel, PrintedModel
from analytic.stiffness import fundamental, square_wave, square_wave_series
from crosscheck.checks.weights import joint_mass, link_mass
from crosscheck.paper.errata import transcript
from crosscheck.paper.stage import PaperStage, paper_stage
from crosscheck.studies.study import Numbers
from models.arm import Arm
from models.interface import Model
from models.loading import load_arm, load_scenario
from models.switches import switches

SCENARIO = "constant-torque"  # in which equations are compared
SIGMAS = ("1e8", "1e7", "1e6", "1e5")  # 1/m, Eq. 6
CONTACT_RATIOS = ("1.5", "1.3", "1.7")
BASE_MASSES = ("5", "50", "500", "5000")  # over the arm's mass
POSES, SEED = 20, 20150401
HARMONICS = 400
TARGET_RAD = math.radians(30)
EXTREME_M = 6e-3  # Section 4.1's largest clearance
BENDS = ("0", "45", "90", "135")  # elbow angle [deg] at which joint errors are taken to the tip


@dataclass(frozen=True)
class Statics:
    """The ``statics`` of a built-in arm."""

    arm: str

    @property
    def inputs(self) -> str:
        records = (load_arm(self.arm), load_scenario(SCENARIO))
        return "\n".join([self.arm, *(record.model_dump_json() for record in records)])

    @property
    def cost(self) -> float:
        return 2.0

    def answer(self) -> Numbers:
        return statics(load_arm(self.arm))


def statics(arm: Arm) -> Numbers:
    """All numbers of an arm that follow from its data alone."""
    stage = paper_stage(arm)
    return {
        **_gearing(stage),
        **_clearance(stage),
        **_stiffness_wave(stage),
        **_equations(arm),
        **_base(arm),
        "gyration_over_pitch": _gyration(stage),
        "initial_values": float(len(transcript.INITIAL_VALUES)),
        "tooth_thickness_share": EXTREME_M / (math.pi * stage.joint.module_m / 2),
        "error_over_backlash": stage.tooth_error_m / stage.backlash_m,
        **{f"bent_{angle}_mm": _tip_shift(arm, math.radians(float(angle))) for angle in BENDS},
    }


def _gearing(stage: PaperStage) -> Numbers:
    """Reduction ratio from rolling without slip; meshing frequencies over the carrier's rate."""
    joint, geometry = stage.joint, stage.geometry
    sun, planet = gear_angles(0.0, 0.0, 1.0, geometry.r_s, geometry.r_p, geometry.r_cp)
    by_gear = (
        meshing_frequency(sun, 1.0, joint.sun_teeth),
        -meshing_frequency(-planet, 1.0, joint.planet_teeth),
        -meshing_frequency(0.0, 1.0, joint.ring_teeth),
    )
    printed = ring_mesh_rate(joint, geometry, "eq13")
    return {
        "ratio_error": abs(sun / geometry.n - 1),
        "gear_rates_spread": float(np.ptp(by_gear)),
        "eq12": sun_mesh_rate(joint, geometry),
        "eq12_error": abs(sun_mesh_rate(joint, geometry) / by_gear[0] - 1),
        "eq13": printed,
        "eq13_error": abs(printed / by_gear[1] - 1),
    }


def _clearance(stage: PaperStage) -> Numbers:
    """Eqs. 4-6 and 15: free play, the smooth stand-in's error, the force that Eq. 15 invents."""
    b = stage.backlash_m
    x = np.linspace(-3 * b, 3 * b, 60001)
    exact = dead_zone(x, b)
    free = x[exact == 0]
    numbers: Numbers = {
        "free_play_over_2b": float(np.ptp(free) / (2 * b)),
        "eq15_excess_N": stage.mesh_stiffness_N_per_m * float(np.abs(x - exact).max()),
    }
    for sigma in SIGMAS:
        error = np.abs(dead_zone_tanh(x, b, float(sigma)) - exact).max()
        numbers[f"tanh_error_{sigma}_m"] = float(error)
        numbers[f"tanh_cost_{sigma}"] = _evaluations(b, None) / _evaluations(b, float(sigma))
    return numbers


def _evaluations(b: float, sigma: float | None) -> int:
    """Right sides that DOP853 needs for one mesh rattling in its clearance, 5 ms."""
    mass, stiffness, damping, push = 0.5, 3e8, 1e2, 500.0

    def right_side(_: float, y: np.ndarray) -> tuple[float, float]:
        zone = dead_zone(y[0], b) if sigma is None else dead_zone_tanh(y[0], b, sigma)
        return y[1], (push - stiffness * zone - damping * y[1]) / mass

    return int(
        solve_ivp(right_side, (0, 0.005), (-b, 0.0), "DOP853", rtol=1e-6, atol=(1e-12, 1e-9)).nfev
    )


def _stiffness_wave(stage: PaperStage) -> Numbers:
    """Eqs. 7-8 against the wave of Fig. 5, swing chosen so that the fundamental is k_a."""
    cycle = (np.arange(20000) + 0.5) / 20000
    swing = math.pi * stage.mesh_stiffness_amplitude_N_per_m
    numbers: Numbers = {}
    for text in CONTACT_RATIOS:
        ratio = float(text)
        low = stage.mesh_stiffness_N_per_m - swing * (ratio - 1)
        wave = square_wave(cycle, low, low + swing, ratio)
        series = [
            square_wave_series(cycle, low, low + swing, ratio, count) for count in (1, HARMONICS)
        ]
        eq8 = fundamental(
            np.sin(2 * np.pi * cycle), stage.mesh_stiffness_N_per_m, np.ptp(series[0]) / 2
        )
        numbers |= {
            f"series_error_{text}": _rms(series[1] - wave) / swing,
            f"first_harmonic_share_{text}": float(np.var(series[0]) / np.var(wave)),
            f"eq8_error_{text}": _rms(eq8 - series[0]) / _rms(series[0] - series[0].mean()),
        }
    return numbers


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _equations(arm: Arm) -> Numbers:
    """Eqs. 16-22 at random states: printed against energies against true velocities."""
    scenario = load_scenario(SCENARIO)
    chosen = switches(phase="omega_t")
    printed, energies, physical = (
        model(arm, scenario, chosen) for model in (PrintedModel, EnergiesModel, PhysicalModel)
    )
    generator = np.random.default_rng(SEED)
    scale = np.tile([1e-4, 1e-4, 1.0], 2)
    states = [(scale * q, scale * v) for q, v in generator.normal(size=(POSES, 2, 6))]
    eigenvalues = [np.linalg.eigvalsh(printed.mass_matrix(q)).min() for q, _ in states]
    masses = [printed.mass_matrix(q) for q, _ in states]
    return {
        "least_eigenvalue": float(min(eigenvalues)),
        "asymmetry": float(max(np.abs(mass - mass.T).max() for mass in masses)),
        "mass_slip": _mass_gap(printed, energies, states),
        "energy_gap": _mass_gap(energies, physical, states),
        "bias_slip": _largest_gap(
            [printed.bias(q, v) for q, v in states], [energies.bias(q, v) for q, v in states]
        ),
        "force_slip": _largest_gap(
            [printed.generalized_force(0.1, q, v) for q, v in states],
            [energies.generalized_force(0.1, q, v) for q, v in states],
        ),
    }


States = list[tuple[np.ndarray, np.ndarray]]


def _mass_gap(one: Model, other: Model, states: States) -> float:
    return _largest_gap(
        [one.mass_matrix(q) for q, _ in states], [other.mass_matrix(q) for q, _ in states]
    )


def _largest_gap(one: list[np.ndarray], other: list[np.ndarray]) -> float:
    """Largest difference, over the largest entry of the second."""
    return float(np.abs(np.subtract(one, other)).max() / np.abs(other).max())


def _gyration(stage: PaperStage) -> float:
    """Sun's radius of gyration over its pitch radius, as the reading has mass and inertia."""
    joint = stage.joint
    share = stage.sun_equivalent_mass_kg / joint.sun_mass_kg
    return stage.geometry.r_s * math.sqrt(share) / (joint.module_m * joint.sun_teeth / 2)


def _base(arm: Arm) -> Numbers:
    """Shift [mm] of a free base, not turning, when both joints go from 0 to 30 degrees."""
    masses = _masses(arm)
    moved = masses @ (_centres(arm, TARGET_RAD) - _centres(arm, 0.0))
    return {
        f"base_shift_{text}_mm": float(1e3 * abs(moved) / (masses.sum() * (1 + float(text))))
        for text in BASE_MASSES
    }


def _masses(arm: Arm) -> np.ndarray:
    """Links, elbow joint (m_j), payload [kg]."""
    return np.array([*map(link_mass, arm.links), joint_mass(arm.joints[1]), arm.payload_mass_kg])


def _centres(arm: Arm, angle: float) -> np.ndarray:
    """Their centres [m] as complex numbers, both joints at the angle [rad]."""
    inner, outer = arm.links
    upper, fore = np.exp(1j * angle), np.exp(2j * angle)
    elbow = inner.length_m * upper
    return np.array(
        [inner.com_m * upper, elbow + outer.com_m * fore, elbow, elbow + outer.length_m * fore]
    )


def _tip_shift(arm: Arm, elbow: float) -> float:
    """Tip displacement [mm] of 0.02 rad at the shoulder and 0.01 rad at the elbow."""
    inner, outer = (link.length_m for link in arm.links)
    forearm = outer * np.exp(1j * elbow)
    return float(1e3 * abs(0.02 * (inner + forearm) + 0.01 * forearm))
