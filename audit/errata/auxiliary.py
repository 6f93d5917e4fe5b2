"""The laws of the meshes, Eqs. 8 and 13 to 15, against first principles.

Each function derives what should stand where something else is printed, and yields an Erratum only
if the two differ.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import sympy as sp

from crosscheck.analytic.paper import mesh_frequency
from crosscheck.analytic.paper.mesh_phasing import ring_behind_sun, sun_lag
from crosscheck.audit.errata.erratum import Erratum, ErratumPair, PhysicalModelFactory, tex
from crosscheck.audit.measures.stage import PaperStage, paper_stage
from crosscheck.audit.statics import teeth
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.experiment.scenario import switches

TORQUE_N_M = 100.0  # Section 3.1's


def find_equation_errata(arm: Arm) -> Iterator[Erratum]:
    """Errata of Eqs. 8 and 13 to 15, for this arm."""
    stage = paper_stage(arm)
    yield from find_ring_rate_errata(arm, stage)
    yield from find_phase_errata(arm, stage)
    yield from find_clearance_errata(stage)


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
            where="Eq. 13",
            printed=str(printed),
            derived=str(derived),
            remark="equal to Eq. 12: both meshes of a stage have one frequency",
            printed_tex=tex(printed),
            derived_tex=tex(derived),
            size=corrected_rate - printed_rate,
            unit="cycles per carrier turn",
            trial=ErratumPair(
                PhysicalModelFactory(arm, switches(phase="omega_t", ring_rate="eq13")),
                PhysicalModelFactory(arm, switches(phase="omega_t", ring_rate="corrected")),
            ),
            denies=("2.2-10",),
        )


def find_phase_errata(arm: Arm, stage: PaperStage) -> Iterator[Erratum]:
    """Errata of Eqs. 8, 14: the sine must advance at the mesh's frequency, and every mesh's own.

    Both have no phase, Fig. 5 a gamma: what the numbers of teeth say of it.
    """
    t = sp.Symbol("t", positive=True)
    omega = sp.Function("omega_e")(t)
    if sp.expand(sp.diff(omega * t, t) - omega) != 0:
        work = teeth.virtual_work(stage, TORQUE_N_M)
        yield Erratum(
            "eq8-eq14-phase",
            where="Eqs. 8, 14",
            printed="sin(omega_e t)",
            derived="sin(integral of omega_e dt)",
            remark="omega_e t advances too fast, by t times the rate of omega_e; with the integral"
            " k and e depend on theta, so rows 3 and 6 of Eq. 22 then owe the springs' own work,"
            f" {work:.2g} N m under {TORQUE_N_M:g} N m",
            printed_tex=r"\sin(\omega_e t)",
            derived_tex=r"\sin\left(\int_0^t \omega_e \, dt\right)",
            trial=ErratumPair(
                PhysicalModelFactory(arm, switches(phase="omega_t", ring_rate="corrected")),
                PhysicalModelFactory(arm, switches(phase="angle", ring_rate="corrected")),
            ),
            denies=("2.3-02",),
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
            where="Eqs. 8, 14; gamma in Fig. 5",
            printed="one phase for sun mesh, ring mesh and all planets; gamma is named and no"
            " equation has it",
            derived=f"from the numbers of teeth: planets {between_planets:g} cycles apart, ring"
            " half a cycle behind sun",
            remark="for teeth as thick as their gaps, which the text does not say; z_s / 3 is"
            " whole, so one phase for all planets is right here; z_p is even, so one phase for sun"
            " and ring is not",
            size=behind,
            unit="cycles between sun and ring mesh",
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
            where="Eq. 15",
            printed="F = k (x - e)",
            derived="F = k f_k(x - e, b)",
            remark="as Eq. 4: teeth that are apart do not push; a misprint, as the paper's runs"
            " have the clearance, so no effect is simulated",
            printed_tex=r"F = k \, (x - e)",
            derived_tex=r"F = k \, f_k(x - e, b)",
            size=force_at_edge,
            unit="N",
            denies=("2.3-03",),
        )
