"""The errata finder: what the paper prints against its own premises and first principles."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations_with_replacement
from operator import call

import numpy as np
import sympy as sp

from crosscheck.analytic.derivation.forms import Form, christoffel_bias
from crosscheck.analytic.derivation.symbols import rational_values, stage_symbols
from crosscheck.analytic.paper import mesh_frequency
from crosscheck.analytic.paper.energies import JOINTS, build_energies_form
from crosscheck.analytic.paper.mesh_frequency import ring_behind_sun, sun_lag
from crosscheck.analytic.paper.model import PrintedModel
from crosscheck.analytic.paper.printed import build_printed_form
from crosscheck.audit.errata import differences
from crosscheck.audit.errata.erratum import (
    Erratum,
    PaperSide,
    Side,
    compute_effect,
    tex,
    write_sides,
)
from crosscheck.audit.experiments.study import Question, Records
from crosscheck.audit.measures.stage import PaperStage, paper_stage
from crosscheck.audit.measures.undefined import float_or_none
from crosscheck.audit.statics import teeth
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import make_layout
from crosscheck.models.experiment.scenario import Scenario, switches
from crosscheck.models.loading import load_arm, load_scenario

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
            **write_sides(printed, derived),
            remark="equal to Eq. 12: both meshes of a stage have one frequency",
            size=corrected_rate - printed_rate,
            unit="cycles per carrier turn",
            trial=_switch_trial(arm, ("omega_t", "eq13"), ("omega_t", "corrected")),
            denies=("2.2-10",),
        )


def _switch_trial(arm: Arm, *laws: tuple[str, str]) -> tuple[Side, Side]:
    """The physical model under two laws: of the mesh phase, and of the ring's rate."""
    printed, right = (
        PaperSide(arm, chosen=switches(phase=phase, ring_rate=rate)) for phase, rate in laws
    )
    return printed, right


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
            remark="omega_e t advances too fast, by t times the rate of omega_e. With the integral"
            " k and e depend on theta, so rows 3 and 6 of Eq. 22 then lack the springs' own torque,"
            f" {work:.2g} N m under {TORQUE_N_M:g} N m",
            printed_tex=r"\sin(\omega_e t)",
            derived_tex=r"\sin\left(\int_0^t \omega_e \, dt\right)",
            trial=_switch_trial(arm, ("omega_t", "corrected"), ("angle", "corrected")),
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
            remark="for teeth as thick as their gaps, which the text does not say. One phase for"
            " all planets is right here, since z_s / 3 is whole. One for sun and ring is wrong,"
            " since z_p is even",
            size=behind,
            unit="cycles between sun and ring mesh",
            trial=(PaperSide(arm), PaperSide(phased)),
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
            size=-force_at_edge,
            unit="N at x - e = b",
            denies=("2.3-03",),
        )


SCHEMA_VERSION = 4
Values = dict[sp.Symbol, sp.Rational]  # of a form's parameters
RING_REMARK = (
    "Table I labels the ring M_ri, an inertia over a squared radius. Difference and effects are"
    " those of a thin ring of this mass at its base radius; the arm's file, and so run, has 0"
)
# The claims that the entries follow from the energies and from virtual work.
CLAIMS_ON_ENTRIES = {"mass_matrix": "2.4-02", "bias": "2.4-03", "force": "2.4-04"}
LAYOUT = make_layout([True] * JOINTS)  # of Eq. 20
EFFECT_S = 0.5
EFFECT_SCENARIOS = ("constant-torque", "pd")
RECORD_EVERY = 2  # 50 kHz: ten records in a cycle of the fastest mesh mode


@dataclass(frozen=True)
class ErrataQuestion(Question[list[Erratum]]):
    """A question: a built-in arm's errata of equations, their effects simulated for so long [s]."""

    cost = 15.0

    arm: str
    duration_s: float

    def records(self) -> Records:
        return load_arm(self.arm), *map(load_scenario, EFFECT_SCENARIOS)

    def answer(self) -> list[Erratum]:
        return simulate_errata(load_arm(self.arm), lambda where: None, self.duration_s)


def find_errata(arm: Arm) -> list[Erratum]:
    """Every erratum of an equation, entries of Eqs. 21-22 first.

    Raises InputError for an arm that the paper's equations do not cover.
    """
    PrintedModel(arm, load_scenario("pd"))  # refuses arms other than the paper's kind
    entries = find_entry_errata(arm, build_printed_form(), build_energies_form())
    return [*entries, *find_energy_errata(arm), *find_equation_errata(arm)]


def find_entry_errata(arm: Arm, printed: Form, derived: Form) -> Iterator[Erratum]:
    """Errata of entries of M and F, and of rows of C q', that do not follow from the energies.

    Size: derived minus printed at theta = 0 and unit rates, forces and torques; its unit by whether
    rows and columns are displacements [m] or angles.
    """
    at_zero = rational_values(arm) | dict.fromkeys(derived.q, sp.S.Zero)
    for difference in differences.find_entry_differences(printed, derived):
        row, column = difference.entries[0]
        size = _number(difference.derived - difference.printed, at_zero)
        is_mass, force_unit = difference.matrix == "mass_matrix", ("N", "N m")
        unit = _describe_entry(row, column) if is_mass else force_unit[int(LAYOUT.angular[row])]
        corrected_form = differences.replace_entries(printed, derived, difference)
        yield Erratum(
            id=_slug(difference.location),
            where=difference.location,
            printed=f"... {difference.printed}",
            derived=f"... {difference.derived}",
            printed_tex=tex(difference.printed),
            derived_tex=tex(difference.derived),
            size=size,
            unit=unit,
            trial=(PaperSide(arm, printed), PaperSide(arm, corrected_form)),
            denies=(CLAIMS_ON_ENTRIES[difference.matrix],),
        )


def _describe_entry(row: int, column: int) -> str:
    """Unit and names of an entry of M, in the paper and in a cross-check."""
    unit = ("kg", "kg m", "kg m^2")[int(LAYOUT.angular[[row, column]].sum())]
    name = f"M_{row + 1}{column + 1}"
    return f"{unit} in {name} = M[{LAYOUT.names[row]}, {LAYOUT.names[column]}]"


def _slug(where: str) -> str:
    """An id of letters, digits and hyphens: Eq. 21, M_34 = M_43 becomes eq21-m-34-m-43."""
    return "-".join(re.findall(r"[a-z]+|[0-9]+", where.lower())).replace("eq-", "eq", 1)


def _number(expression: sp.Expr, values: Values) -> float:
    value = expression.xreplace(values)
    return float(value.xreplace(dict.fromkeys(value.free_symbols, sp.S.One)))


def find_energy_errata(arm: Arm) -> Iterator[Erratum]:
    """Errata of bodies whose kinetic energy Eqs. 16-19 do not state.

    Size: what is missing of the first entry of M that it changes, at theta = 0; then of the others.
    """
    values, form = rational_values(arm), build_energies_form()
    for difference in differences.find_energy_differences():
        missing = difference.missing_energy
        stated = _add_thin_ring(values, missing)
        added = sp.hessian(missing.xreplace(stated), form.v)
        sizes = {
            _describe_entry(*place): _number(added[place], dict.fromkeys(form.q, sp.S.Zero))
            for place in combinations_with_replacement(range(len(form.q)), 2)
            if added[place] != 0
        }
        (unit, size), *others = sizes.items()
        # The bias is linear in the mass matrix, and few entries of what is added are not 0.
        corrected_form = replace(
            form,
            mass_matrix=sp.ImmutableMatrix(form.mass_matrix + added),
            bias=sp.ImmutableMatrix(form.bias + christoffel_bias(added, form.q, form.v)),
        )
        printed, derived = map(differences.as_printed, (difference.printed, difference.derived))
        where = f"{difference.where}, {difference.body}"
        yield Erratum(
            id=_slug(where),
            where=where,
            **write_sides(printed, derived),
            remark="" if stated == values else RING_REMARK,
            size=size,
            unit=unit,
            others=dict(others),
            trial=(PaperSide(arm, form), PaperSide(arm, corrected_form)),
            denies=("2.4-01",),
        )


def _add_thin_ring(values: Values, missing: sp.Expr) -> Values:
    """The values, with a ring's inertia where it matters: its 10 kg at its base radius."""
    guessed = dict(values)
    for joint in range(1, JOINTS + 1):
        stage = stage_symbols(joint)
        if stage.J_r in missing.free_symbols and values[stage.J_r] == 0:
            radius = values[stage.r_s] + 2 * values[stage.r_p]
            guessed[stage.J_r] = values[stage.m_r] * radius**2
    return guessed


def simulate_errata(
    arm: Arm, progress: Callable[[str], None], duration_s: float = EFFECT_S
) -> list[Erratum]:
    """Every erratum of an equation with its simulated effects, the largest effect first.

    ``progress`` hears of each trial.
    """
    simulated_errata, run = [], cache(call)
    for erratum in find_errata(arm):
        progress(erratum.id)
        effects = {
            scenario.name: compute_effect(erratum.trial, scenario, run)
            for scenario in load_effect_scenarios(duration_s)
            if erratum.trial is not None
        }
        size = float_or_none(erratum.size)
        simulated_errata.append(replace(erratum, size=size, trial=None, effects=effects))

    def largest_theta_rad(erratum: Erratum) -> float:
        return max((effect.theta_rad for effect in erratum.effects.values()), default=0.0)

    return sorted(simulated_errata, key=largest_theta_rad, reverse=True)


def load_effect_scenarios(duration_s: float = EFFECT_S) -> list[Scenario]:
    """The constant torque, which stays on one flank, and PD, which in 0.5 s does not."""
    update = {"duration_s": duration_s, "record_every": RECORD_EVERY}
    return [load_scenario(name).model_copy(update=update) for name in EFFECT_SCENARIOS]
