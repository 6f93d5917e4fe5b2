"""The auxiliary equations, the symbols and the counts of the paper against first principles.

Each function writes down what is printed, derives what should stand there, and returns an Erratum
only if the two differ.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

import numpy as np
import sympy as sp

from analytic.backlash import dead_zone_tanh
from analytic.energies import JOINTS
from analytic.mesh_frequency import ring_mesh_rate, sun_mesh_rate
from analytic.symbols import geared_variables
from crosscheck.paper.errata import transcript
from crosscheck.paper.errata.erratum import Erratum, Trial
from crosscheck.paper.errata.sides import PhysicalSide
from crosscheck.paper.errata.typeset import tex
from crosscheck.paper.stage import paper_stage, without_backlash
from models.arm import Arm
from models.switches import switches


def auxiliary_errata(arm: Arm) -> Iterator[Erratum]:
    """Errata outside the entries of Eqs. 16-22, for this arm."""
    yield from clearance_attracts(arm)
    yield from ring_mesh_frequency(arm)
    yield from phase_of_a_varying_frequency(arm)
    yield from force_without_clearance(arm)
    yield from initial_values()
    yield from masses_and_inertias(arm)
    yield from symbols_used_twice()
    yield from quantities_with_two_symbols()


def clearance_attracts(arm: Arm) -> Iterator[Erratum]:
    """Eq. 6 against Eq. 5, which never pulls: the deepest pull outside contact."""
    stage = paper_stage(arm)
    b, sigma = stage.backlash_m, stage.tanh_sharpness_per_m
    outside = b - np.linspace(0, 10 / sigma, 100001)
    pull = -float(dead_zone_tanh(outside, b, sigma).min())
    if pull > 0:
        yield Erratum(
            where="Eq. 6",
            kind="auxiliary",
            printed="f_k smooth and close to Eq. 5",
            derived=f"f_k < 0 just below x = b: attraction of up to {pull * sigma:.4f} k / sigma",
            size=pull * stage.mesh_stiffness_N_per_m,
            unit="N",
        )


def ring_mesh_frequency(arm: Arm) -> Iterator[Erratum]:
    """Eqs. 12, 13 against the rate at which teeth pass a mesh, seen from the carrier.

    Rolling without slip turns the planet against the carrier (Eq. 3 with x_pr = 0), so its rate
    relative to the carrier is theta_p' + theta_c', counted against the carrier.
    """
    z_p, r_p, r_cp, dtheta = sp.symbols("z_p r_p r_cp dtheta_c", positive=True)
    printed = dtheta * z_p * (r_cp / r_p - 1)
    derived = dtheta * z_p * (r_cp / r_p + 1)
    joint, geometry = paper_stage(arm).joint, paper_stage(arm).geometry
    sun = sun_mesh_rate(joint, geometry)
    rates = {rate: ring_mesh_rate(joint, geometry, rate) for rate in ("eq13", "corrected")}
    numbers = {z_p: joint.planet_teeth, r_p: geometry.r_p, r_cp: geometry.r_cp, dtheta: 1}
    stated, true = (float(e.subs(numbers)) for e in (printed, derived))
    if not np.isclose(stated, sun) and np.isclose(true, sun):
        yield Erratum(
            where="Eq. 13",
            kind="auxiliary",
            printed=str(printed),
            derived=str(derived),
            remark="equal to Eq. 12: both meshes of a stage have one frequency",
            printed_tex=tex(printed),
            derived_tex=tex(derived),
            size=rates["corrected"] - rates["eq13"],
            unit="cycles per carrier turn",
            trial=Trial(
                PhysicalSide(arm, switches(phase="omega_t", ring_rate="eq13")),
                PhysicalSide(arm, switches(phase="omega_t", ring_rate="corrected")),
            ),
        )


def phase_of_a_varying_frequency(arm: Arm) -> Iterator[Erratum]:
    """Eqs. 8, 14: the sine's argument must advance at the meshing frequency."""
    t = sp.Symbol("t", positive=True)
    omega = sp.Function("omega_e")(t)
    excess = sp.simplify(sp.diff(omega * t, t) - omega)
    if excess != 0:
        yield Erratum(
            where="Eqs. 8, 14",
            kind="auxiliary",
            printed="sin(omega_e t)",
            derived="sin(integral of omega_e dt)",
            remark=f"omega_e t advances too fast, by {excess}",
            printed_tex=r"\sin(\omega_e t)",
            derived_tex=r"\sin\left(\int_0^t \omega_e \, dt\right)",
            size=None,
            unit="rad/s",
            trial=Trial(
                PhysicalSide(arm, switches(phase="omega_t", ring_rate="corrected")),
                PhysicalSide(arm, switches(phase="angle", ring_rate="corrected")),
            ),
        )


def force_without_clearance(arm: Arm) -> Iterator[Erratum]:
    """Eq. 15 against Eq. 4: inside the clearance there is no contact, hence no force."""
    stage = paper_stage(arm)
    force_at_edge = stage.mesh_stiffness_N_per_m * stage.backlash_m
    if force_at_edge > 0:
        yield Erratum(
            where="Eq. 15",
            kind="auxiliary",
            printed="F = k (x - e)",
            derived="F = k f_k(x - e, b)",
            remark="as Eq. 4: teeth that are apart do not push",
            printed_tex=r"F = k \, (x - e)",
            derived_tex=r"F = k \, f_k(x - e, b)",
            size=force_at_edge,
            unit="N",
            trial=Trial(
                PhysicalSide(without_backlash(arm), switches()), PhysicalSide(arm, switches())
            ),
        )


def initial_values() -> Iterator[Erratum]:
    """As many initial values as first-order states."""
    printed = len(transcript.INITIAL_VALUES)
    derived = 2 * len(geared_variables(JOINTS).q)
    if printed != derived:
        yield Erratum(
            where="Section 3, initial values",
            kind="count",
            printed=f"{printed} values",
            derived=f"{derived}: six coordinates (Eq. 20) and their rates",
            size=float(derived - printed),
            unit="values",
        )


def masses_and_inertias(arm: Arm) -> Iterator[Erratum]:
    """Table I: no gear's mass can lie, on average, beyond its pitch circle."""
    stage = paper_stage(arm)
    joint, geometry = stage.joint, stage.geometry
    gears = {
        "sun": (stage.sun_equivalent_mass_kg, joint.sun_mass_kg, geometry.r_s, joint.sun_teeth),
        "planet": (
            stage.planet_equivalent_mass_kg,
            joint.planet_mass_kg,
            geometry.r_p,
            joint.planet_teeth,
        ),
    }
    for name, (equivalent, mass, base, teeth) in gears.items():
        pitch = joint.module_m * teeth / 2
        gyration = base * np.sqrt(equivalent / mass) if mass > 0 else np.inf
        if gyration > pitch:
            yield Erratum(
                where=f"Table I, {name}",
                kind="table",
                printed=f"M = {equivalent:g} kg, m = {mass:g} kg",
                derived=(
                    f"radius of gyration {1e3 * gyration:.1f} mm beyond the pitch radius"
                    f" {1e3 * pitch:.1f} mm: the labels M and m look swapped"
                ),
                size=float(gyration - pitch),
                unit="m",
            )


def symbols_used_twice() -> Iterator[Erratum]:
    """One symbol, several quantities."""
    uses: dict[str, list[transcript.Definition]] = defaultdict(list)
    for definition in transcript.DEFINITIONS:
        uses[definition.symbol].append(definition)
    for symbol, definitions in uses.items():
        if len({d.quantity for d in definitions}) > 1:
            yield Erratum(
                where="; ".join(d.where for d in definitions),
                kind="symbol",
                printed=f"{symbol}: " + "; ".join(d.quantity for d in definitions),
                derived="a symbol of its own for each",
                size=float(len({d.quantity for d in definitions})),
                unit="quantities",
            )


def quantities_with_two_symbols() -> Iterator[Erratum]:
    """One quantity, several symbols."""
    names: dict[str, list[transcript.Definition]] = defaultdict(list)
    for definition in transcript.DEFINITIONS:
        names[definition.quantity].append(definition)
    for quantity, definitions in names.items():
        symbols = list(dict.fromkeys(d.symbol for d in definitions))
        if len(symbols) > 1:
            yield Erratum(
                where="; ".join(d.where for d in definitions),
                kind="symbol",
                printed=f"{quantity}: {', '.join(symbols)}",
                derived="one symbol",
                size=float(len(symbols)),
                unit="symbols",
            )
