"""What the paper's energies and entries say, and what they should."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal, get_args

import sympy as sp

from crosscheck.analytic.derivation import symbols
from crosscheck.analytic.derivation.bodies import Body, carried_bodies, link_bodies, spinning_bodies
from crosscheck.analytic.derivation.forms import Form, mass_matrix
from crosscheck.analytic.derivation.lagrange import build_mass_terms
from crosscheck.analytic.derivation.symbols import stage_symbols
from crosscheck.analytic.paper.energies import JOINTS, kinetic_energies, remove_sine_squares

Matrix = Literal["mass_matrix", "bias", "force"]  # of a Form


@dataclass(frozen=True)
class EntryDifference:
    """Entries of one matrix of a form that differ from the derived ones in the same way.

    entries: row and column counted from 0;
    printed, derived: the terms that only one side has.
    """

    matrix: Matrix
    entries: tuple[tuple[int, int], ...]
    printed: sp.Expr
    derived: sp.Expr

    @property
    def location(self) -> str:
        """The place of the entries in the paper's notation, counted from 1."""
        if self.matrix == "mass_matrix":
            names = [f"M_{row + 1}{column + 1}" for row, column in self.entries]
            return f"Eq. 21, {' = '.join(names)}"
        row = self.entries[0][0] + 1
        return f"Eq. 21, row {row} of C q'" if self.matrix == "bias" else f"Eq. 22, F_{row}"


def are_equal_entries(first: sp.Expr, second: sp.Expr) -> bool:
    """Whether two entries are equal given the geometry of a planetary stage.

    That is three planets, r_cp = r_s + r_p and n = 2 r_cp / r_s.
    """
    geometry: dict[sp.Symbol, sp.Expr] = {}
    for stage in map(stage_symbols, (1, 2)):
        geometry[stage.N] = sp.Integer(3)
        geometry[stage.n] = 2 * stage.r_cp / stage.r_s
        geometry[stage.r_p] = stage.r_cp - stage.r_s
    return sp.expand(sp.expand(first - second).subs(geometry)) == 0


def find_entry_differences(printed: Form, derived: Form) -> list[EntryDifference]:
    """Every entry in which the printed form differs from the derived one.

    M and F are compared entry by entry; C is not unique, so the force C q' is compared by rows.
    M_ij and M_ji are one difference if they differ in the same way.
    """
    entry_differences = []
    for matrix in get_args(Matrix):
        printed_matrix, derived_matrix = getattr(printed, matrix), getattr(derived, matrix)
        for row, column in product(range(printed_matrix.rows), range(printed_matrix.cols)):
            sides = printed_matrix[row, column], derived_matrix[row, column]
            if not are_equal_entries(*sides):
                left, right = (set(sp.Add.make_args(sp.expand(side))) for side in sides)
                unshared_terms = sp.Add(*(left - right)), sp.Add(*(right - left))
                entry_differences.append(EntryDifference(matrix, ((row, column),), *unshared_terms))
    merged_differences = []
    for difference in entry_differences:
        row, column = difference.entries[0]
        mirror = replace(difference, entries=((column, row),))
        if row == column or mirror not in entry_differences or difference.matrix != "mass_matrix":
            merged_differences.append(difference)
        elif row < column:
            merged_differences.append(replace(difference, entries=((row, column), (column, row))))
    return merged_differences


def replace_entries(printed: Form, derived: Form, difference: EntryDifference) -> Form:
    """The printed form with this one difference put right."""
    matrix = sp.Matrix(getattr(printed, difference.matrix))
    for row, column in difference.entries:
        matrix[row, column] = getattr(derived, difference.matrix)[row, column]
    return replace(printed, **{difference.matrix: sp.ImmutableMatrix(matrix)})


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
        inertial |= {*stage[:8], stage.m, stage.I_l}  # the first are those of the gears
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
