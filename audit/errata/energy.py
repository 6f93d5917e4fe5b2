"""The paper's kinetic energies against those of the bodies that they stand for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import sympy as sp

from crosscheck.analytic.derivation import symbols
from crosscheck.analytic.derivation.bodies import Body, carried_bodies, link_bodies, spinning_bodies
from crosscheck.analytic.derivation.forms import mass_matrix
from crosscheck.analytic.derivation.lagrange import build_mass_terms
from crosscheck.analytic.paper.energies import JOINTS, kinetic_energies, remove_sine_squares
from crosscheck.audit.errata.entry_differences import are_equal_entries

CHAIN = symbols.build_symbolic_chain([True] * JOINTS)  # the paper's arm


@dataclass(frozen=True)
class EnergyDifference:
    """A kinetic energy that the paper gives and what its bodies have.

    missing_energy: derived minus printed energy [J], in the rates of the paper's coordinates; body:
    the body concerned.
    """

    where: str
    body: str
    printed: sp.Expr
    derived: sp.Expr

    @property
    def missing_energy(self) -> sp.Expr:
        """What the paper leaves out [J]."""
        return sp.expand(self.derived - self.printed)


def as_printed(energy: sp.Expr) -> sp.Expr:
    """An energy in the rates of the gears and with their inertias, as Eqs. 16-19 are written."""
    variables = symbols.geared_variables(JOINTS)
    given: dict[sp.Expr, sp.Expr] = {}
    for joint in range(1, JOINTS + 1):
        stage = symbols.stage_symbols(joint)
        dx_sp, dx_pr, dtheta = variables.v[3 * joint - 3 : 3 * joint]
        sun, planet = (sp.Symbol(f"dtheta_{gear}{joint}") for gear in "sp")
        given[dx_sp] = stage.r_s * sun - stage.r_p * planet - stage.r_cp * dtheta
        given[dx_pr] = stage.r_p * planet - stage.r_cp * dtheta
        for name, mass, radius in (("s", stage.M_s, stage.r_s), ("p", stage.M_p, stage.r_p)):
            given[mass] = sp.Symbol(f"I_{name}{joint}") / radius**2
        given[stage.N] = sp.Integer(3)
    return sp.factor(sp.expand(energy.subs(given, simultaneous=True)))


def true_energies() -> dict[str, dict[str, sp.Expr]]:
    """The kinetic energy [J] of each body, by the paper's equation that covers it.

    Eq. 17 carries the elbow joint's masses along with link 1, Eq. 18 turns them.
    """
    shoulder, elbow = (
        [*carried_bodies(CHAIN, joint), *spinning_bodies(CHAIN, joint)] for joint in (1, 2)
    )
    return {
        "Eq. 16": _energies(shoulder),
        "Eq. 17": _energies(
            [*link_bodies(CHAIN, 1), *(replace(body, inertia=sp.S.Zero) for body in elbow)]
        ),
        "Eq. 18": _energies([replace(body, mass=sp.S.Zero, centre=()) for body in elbow]),
        "Eq. 19": _energies(link_bodies(CHAIN, 2)),
    }


def find_energy_differences() -> Iterator[EnergyDifference]:
    """Every body whose share of an energy is not in the paper's expression for it.

    A printed term belongs to the body whose inertia parameters it holds, and no other's; what
    belongs to none is reported as a body that does not exist.
    """
    true_by_equation = true_energies()
    for where, printed in kinetic_energies().items():
        unclaimed = set(sp.Add.make_args(remove_sine_squares(printed)))
        for body, derived in true_by_equation[where].items():
            inertias = _parameters(derived)
            body_terms = {x for x in unclaimed if _parameters(x) and _parameters(x) <= inertias}
            unclaimed -= body_terms
            stated = sp.Add(*body_terms)
            if not are_equal_entries(stated, derived):
                yield EnergyDifference(where, body, stated, derived)
        if unclaimed:
            yield EnergyDifference(where, "no body", sp.Add(*unclaimed), sp.S.Zero)


def _parameters(expression: sp.Expr) -> frozenset[sp.Symbol]:
    """The masses and inertias of stages, links and payload in an expression."""
    inertial = {symbols.m_payload}
    for stage in map(symbols.stage_symbols, (1, 2)):
        inertial |= {
            stage.M_s,
            stage.M_p,
            stage.M_c,
            stage.m,
            stage.I_l,
            stage.m_s,
            stage.m_p,
            stage.m_c,
            stage.m_r,
            stage.J_r,
        }
    return frozenset(expression.free_symbols & inertial)


def _energies(bodies: list[Body]) -> dict[str, sp.Expr]:
    """The kinetic energy [J] of each body that has any, by the body's name."""
    variables = symbols.geared_variables(JOINTS)
    rates = sp.Matrix(variables.v)
    shares: dict[str, sp.Expr] = {}
    for body in bodies:
        mass = sp.Matrix(mass_matrix(build_mass_terms([body], CHAIN.angles[1:]), variables.q))
        energy = sp.expand((rates.T * mass * rates)[0] / 2)
        if energy != 0:
            shares[body.name] = shares.get(body.name, sp.S.Zero) + energy
    return shares
