"""The auxiliary equations of the paper against first principles.

Each function derives what should stand where something else is printed, and yields an Erratum only
if the two differ; texts/errata.toml has the words.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import sympy as sp

from crosscheck.analytic.paper import mesh_frequency
from crosscheck.analytic.paper.backlash import dead_zone, dead_zone_tanh
from crosscheck.analytic.paper.kinematics import gear_angles
from crosscheck.analytic.paper.mesh_phasing import ring_behind_sun, sun_lag
from crosscheck.audit.errata.erratum import Erratum, ErratumPair, PhysicalModelFactory, tex
from crosscheck.audit.measures.stage import PaperStage, paper_stage
from crosscheck.audit.statics import teeth
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.experiment.scenario import SinusoidDrive, switches
from crosscheck.models.loading import load_scenario

TORQUE_N_M = 100.0  # Section 3.1's


def find_equation_errata(arm: Arm) -> Iterator[Erratum]:
    """Errata of Eqs. 2 to 15, 22 and of the drives, for this arm."""
    stage = paper_stage(arm)
    yield from find_displacement_errata(stage)
    yield from find_gear_sense_errata(stage)
    yield from find_ring_rate_errata(arm, stage)
    yield from find_phase_errata(arm, stage)
    yield from find_clearance_errata(stage)
    yield from find_time_force_errata(stage)
    yield from find_drive_errata()


def find_displacement_errata(stage: PaperStage) -> Iterator[Erratum]:
    """Errata of Eqs. 2 to 6: what presses the teeth, and their clearance."""
    # Eqs. 2, 3 hold for one way to count theta_p, which the paper does not name.
    errors = [teeth.conversion_error(stage.joint, stage.geometry, how) for how in teeth.COUNTED]
    if max(errors) > min(errors):
        yield Erratum("eq2-sense", size=max(errors))
    # Eq. 5 at its two edges: its value on both sides, and its slope.
    b, sigma = stage.backlash_m, stage.tanh_sharpness_per_m
    beside = b * np.array([1 - 1e-9, 1 + 1e-9])
    jump, slope = np.ptp(dead_zone(beside, b)) / b, np.ptp(dead_zone(beside, b)) / np.ptp(beside)
    if jump < 1e-6 < slope:
        yield Erratum("discontinuous-points", size=0.0)
    # Eq. 6 against Eq. 5, which never pulls: the deepest pull outside contact.
    outside = b - np.linspace(0, 10 / sigma, 100001)
    pull = -float(dead_zone_tanh(outside, b, sigma).min())
    if pull > 0:
        yield Erratum("eq6-attracts", size=pull * sigma, quoted={"pull": pull * sigma})


def find_gear_sense_errata(stage: PaperStage) -> Iterator[Erratum]:
    """Erratum of Eq. 10 if its three gears, in the sense of Eqs. 2-3, give one mesh three rates.

    Rates are over theta_c', in pure rolling.
    """
    joint, geometry = stage.joint, stage.geometry
    sun, planet = gear_angles(0.0, 0.0, 1.0, geometry.r_s, geometry.r_p, geometry.r_cp)
    rates = {
        "sun": mesh_frequency.meshing_frequency(sun, 1.0, joint.sun_teeth),
        "planet": mesh_frequency.meshing_frequency(planet, 1.0, joint.planet_teeth),
        "ring": mesh_frequency.meshing_frequency(0.0, 1.0, joint.ring_teeth),
    }
    spread = float(np.ptp(list(rates.values())))
    if spread > 1e-9 * max(rates.values()):
        yield Erratum("eq10-sense", size=spread, quoted=rates)


def find_ring_rate_errata(arm: Arm, stage: PaperStage) -> Iterator[Erratum]:
    """Erratum of Eqs. 12, 13 against the rate of teeth through a mesh, seen from the carrier.

    Pure rolling turns the planet against the carrier (Eq. 3 with x_pr = 0), so its rate
    relative to the carrier is theta_p' + theta_c', counted against the carrier.
    """
    z_p, r_p, r_cp, dtheta = sp.symbols("z_p r_p r_cp dtheta_c", positive=True)
    printed = dtheta * z_p * (r_cp / r_p - 1)
    derived = dtheta * z_p * (r_cp / r_p + 1)
    joint, geometry = stage.joint, stage.geometry
    numbers = {z_p: joint.planet_teeth, r_p: geometry.r_p, r_cp: geometry.r_cp, dtheta: 1}
    stated, true = (float(e.subs(numbers)) for e in (printed, derived))
    sun = mesh_frequency.sun_mesh_rate(joint, geometry)
    printed_rate, corrected_rate = (
        mesh_frequency.ring_mesh_rate(joint, geometry, rate) for rate in ("eq13", "corrected")
    )
    if not np.isclose(stated, sun) and np.isclose(true, sun):
        yield Erratum(
            "eq13-rate",
            printed_tex=tex(printed),
            derived_tex=tex(derived),
            size=corrected_rate - printed_rate,
            trial=ErratumPair(
                PhysicalModelFactory(arm, switches(phase="omega_t", ring_rate="eq13")),
                PhysicalModelFactory(arm, switches(phase="omega_t", ring_rate="corrected")),
            ),
        )


def find_phase_errata(arm: Arm, stage: PaperStage) -> Iterator[Erratum]:
    """Errata of Eqs. 8, 14: the sine must advance at the mesh's frequency, and every mesh's own.

    Both have no phase, Fig. 5 a gamma: what the numbers of teeth say of it.
    """
    t = sp.Symbol("t", positive=True)
    omega = sp.Function("omega_e")(t)
    if sp.expand(sp.diff(omega * t, t) - omega) != 0:
        yield Erratum(
            "eq8-eq14-phase",
            printed_tex=r"\sin(\omega_e t)",
            derived_tex=r"\sin\left(\int_0^t \omega_e \, dt\right)",
            quoted={"work": teeth.virtual_work(stage, TORQUE_N_M), "torque": TORQUE_N_M},
            trial=ErratumPair(
                PhysicalModelFactory(arm, switches(phase="omega_t", ring_rate="corrected")),
                PhysicalModelFactory(arm, switches(phase="angle", ring_rate="corrected")),
            ),
        )
    joint = stage.joint
    between_planets = max(sun_lag(joint, planet) % 1.0 for planet in range(joint.planet_count))
    behind = ring_behind_sun(joint)
    if between_planets or behind:
        joints = list(arm.joints)
        for place, other in enumerate(arm.joints):
            if isinstance(other, Planetary):
                lag = {"phase_rad": 2 * math.pi * behind}
                late = {"ring_mesh": other.ring_mesh.model_copy(update=lag)}
                joints[place] = other.model_copy(update=late)
        phased = arm.model_copy(update={"joints": tuple(joints)})
        yield Erratum(
            "eq8-eq14-one-phase",
            size=behind,
            quoted={"between_planets": between_planets},
            trial=ErratumPair(PhysicalModelFactory(arm), PhysicalModelFactory(phased)),
        )


def find_clearance_errata(stage: PaperStage) -> Iterator[Erratum]:
    """Erratum of Eq. 15 against Eq. 4: inside the clearance no contact, hence no force.

    Nobody simulated Eq. 15 as printed, so it has no trial: the paper's runs vary the clearance.
    """
    force_at_edge = stage.mesh_stiffness_N_per_m * stage.backlash_m
    if force_at_edge > 0:
        yield Erratum(
            "eq15-clearance",
            printed_tex=r"F = k \, (x - e)",
            derived_tex=r"F = k \, f_k(x - e, b)",
            size=force_at_edge,
        )


def find_time_force_errata(stage: PaperStage) -> Iterator[Erratum]:
    """Erratum of Eq. 21's F(q, q'): how far its mesh force swings with time, by e alone."""
    swing = 2 * stage.mesh_stiffness_N_per_m * stage.tooth_error_m
    if swing > 0:
        yield Erratum("eq21-time", size=swing)


def find_drive_errata() -> Iterator[Erratum]:
    """Erratum of sin(20 pi sqrt(t)) at 0: what RK4's quadrature misses of its first step."""
    scenario = load_scenario("back-and-forth")
    drive = scenario.drive
    assert isinstance(drive, SinusoidDrive)
    t, rate = sp.symbols("t rate", positive=True)
    if sp.limit(sp.diff(sp.sin(rate * sp.sqrt(t)), t), t, 0, "+") == sp.oo:
        at_half, at_end = math.sqrt(0.5), 1.0
        missed = 1 - (4 * at_half + at_end) / 6 / (2 / 3)
        turn = float(np.max(drive.rate_rad_per_s)) * math.sqrt(scenario.step_s)
        first = float(np.max(drive.amplitude_N_m)) * math.sin(turn)
        numbers = {"torque": first, "step_us": 1e6 * scenario.step_s}
        yield Erratum("drive-root", size=missed, quoted=numbers)
