"""Equations of motion of any kind that ``derivation.terms`` can hold, as text.

M, bias and force stand in the coordinates of a model's layout, entry by entry. Runs of an arm's own
bodies use the shorter text of crosscheck.analytic.kernel.text.links.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crosscheck.analytic.derivation.gears import Gears
from crosscheck.analytic.derivation.terms import Terms
from crosscheck.analytic.kernel.structure import Lines, Structure, common_structure
from crosscheck.analytic.kernel.text.functions import cosine, sine
from crosscheck.analytic.kernel.text.meshes import (
    PER_TURN,
    mesh_forces,
    stiffness_and_error,
    torque,
)
from crosscheck.models.arm.layout import Layout
from crosscheck.models.experiment.drive import DriveData

Entry = tuple[int, ...]


@dataclass(frozen=True)
class TermStructure(Structure):
    """The structure of a model from terms: where those of M, bias and force stand; see Terms.

    angles: places of the joint angles; angle_sums: angle sums w . q; mass, bias, weight: indices of
    each term; drives (row, joint) and pushes (row, mesh): entries that are not 0 of what torques
    and mesh forces do; differences (place, place taken away or -1): every mesh's displacement;
    friction_joints: joints with friction.
    """

    size: int
    angles: tuple[int, ...]
    angle_sums: tuple[tuple[float, ...], ...]
    mass: tuple[Entry, ...]
    bias: tuple[Entry, ...]
    weight: tuple[Entry, ...]
    drives: tuple[Entry, ...]
    pushes: tuple[Entry, ...]
    differences: tuple[Entry, ...]
    friction_joints: tuple[int, ...]

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the layout's coordinates, in its order."""
        names = [f"x{place}" for place in range(self.size)]
        for joint, place in enumerate(self.angles, 1):
            names[place] = f"theta{joint}"
        return tuple(names)

    def acceleration(self) -> Lines:
        """Lines from a member's coordinates and rates to its accelerations and mesh forces."""
        yield from equations(self)
        yield from _solve(self)


def build_term_structure(
    layout: Layout,
    gears: Gears,
    drive: DriveData,
    terms: Terms,
) -> TermStructure:
    """The structure of a model from its terms; see TermEquations."""
    common = common_structure(layout.theta.tolist(), gears, drive)
    return TermStructure(
        *common,
        size=len(layout),
        angles=tuple(map(int, terms.theta)),
        angle_sums=_entries(terms.angle_sums),
        mass=_entries(terms.mass),
        bias=_entries(terms.bias),
        weight=_entries(terms.weight),
        drives=_entries(np.argwhere(terms.drive_map)),
        pushes=_entries(np.argwhere(terms.mesh_map)),
        differences=tuple(zip(gears.x_index.tolist(), gears.subtract_index.tolist(), strict=True)),
        friction_joints=tuple(np.flatnonzero(terms.friction).tolist()),
    )


def _entries(table: np.ndarray) -> tuple[Entry, ...]:
    return tuple(map(tuple, table.tolist()))


def equations(s: TermStructure) -> Lines:
    """Lines of M as ``M{i}_{j}``, bias ``h{i}`` and force ``f{i}``; entries that are 0 are not."""
    yield from _waves(s)
    yield from _sums(
        "M", [(f"{i}_{j}", f"mass_{k}" + _by(s, "c", w)) for k, (i, j, w) in _each(s.mass)]
    )
    yield from _sums(
        "h",
        [
            (str(i), f"bias_{k} * s_w{w} * {_rate(s, a)} * {_rate(s, b)}")
            for k, (i, w, a, b) in _each(s.bias)
        ],
    )
    yield from _forces(s)


def _each(entries: Sequence[Entry]) -> list[tuple[int, Entry]]:
    return list(enumerate(entries))


def _is_still(s: TermStructure, wave: int) -> bool:
    """Whether a wave's angle is 0 at every state."""
    return not any(s.angle_sums[wave])


def _by(s: TermStructure, function: str, wave: int) -> str:
    return "" if _is_still(s, wave) else f" * {function}_w{wave}"


def _rate(s: TermStructure, place: int) -> str:
    return f"v_{s.coordinates[place]}"


def _waves(s: TermStructure) -> Lines:
    """Lines of cosines and sines of the waves that some term has."""
    cosines = {w for *_, w in s.mass} | {w for _, w in s.weight}
    sines = {w for _, w, *_ in s.bias} | {w for _, w in s.weight}
    for number, wave in enumerate(s.angle_sums):
        angle = " + ".join(
            f"{factor!r} * q_{s.coordinates[place]}" for place, factor in enumerate(wave) if factor
        )
        if number in cosines and angle:
            yield from cosine(f"c_w{number}", f"({angle}) * {PER_TURN}")
        if number in sines:
            yield from sine(f"s_w{number}", f"({angle or '0.0'}) * {PER_TURN}")


def _sums(name: str, terms: Sequence[tuple[str, str]]) -> Lines:
    """Lines of every entry, the sum of its terms in their order."""
    terms_by_entry = defaultdict[str, list[str]](list)
    for place, term in terms:
        terms_by_entry[place].append(term)
    for place, parts in terms_by_entry.items():
        yield f"{name}{place} = {' + '.join(parts)}"


def _forces(s: TermStructure) -> Lines:
    """Lines of F - D v of Eqs. 21-22, friction, weight and conservative springs' torques."""
    for j in s.joints:
        yield from torque(s, j)
    numbers = {mesh: number for number, mesh in enumerate(s.meshes)}
    for mesh, number in numbers.items():
        where, less = s.differences[number]
        for kind in ("q", "v"):
            taken = f" - {kind}_{s.coordinates[less]}" if less >= 0 else ""
            yield f"{'x' if kind == 'q' else 'v'}_{mesh} = {kind}_{s.coordinates[where]}{taken}"
    for j, stage in s.geared_joints:
        yield from stiffness_and_error(s, j, stage)
        yield from mesh_forces(s, j, stage)
    named = {number: mesh for mesh, number in numbers.items()}
    terms = [(str(row), f"driven{row}_{joint} * T{joint + 1}") for row, joint in s.drives]
    terms += [(str(row), f"pushed{row}_{mesh} * F_{named[mesh]}") for row, mesh in s.pushes]
    for k, (row, w) in _each(s.weight):
        terms += [(str(row), f"weight_c{k}" + _by(s, "c", w)), (str(row), f"weight_s{k} * s_w{w}")]
    yield from _sums("f", terms)
    yield from _remaining_forces(s, numbers, {int(row) for row, _ in terms})


def _remaining_forces(s: TermStructure, numbers: dict[str, int], begun: set[int]) -> Lines:
    """Lines that add friction, dampers and conservative springs to the forces."""
    changes = [(s.angles[j], f"-(friction{j + 1} * v_theta{j + 1})") for j in s.friction_joints]
    for mesh, number in numbers.items():
        where, less = s.differences[number]
        changes.append((where, f"-D_{mesh}"))
        if less >= 0:
            changes.append((less, f"D_{mesh}"))
    if s.conservative:
        changes += [(s.angles[j - 1], f"on_theta{j}") for j, _ in s.geared_joints]
    for row, change in changes:
        yield f"f{row} = " + (f"f{row} + {change}" if row in begun else change)
        begun.add(row)
    yield from (f"f{row} = 0.0" for row in range(s.size) if row not in begun)


def name_results(s: TermStructure) -> dict[str, tuple[str, ...]]:
    """Names of the entries of M, row by row, of bias, force and acceleration; 0 where none is."""
    places = range(s.size)
    in_mass, in_bias = {entry[:2] for entry in s.mass}, {entry[0] for entry in s.bias}
    return {
        "mass_matrix": tuple(
            f"M{i}_{j}" if (i, j) in in_mass else "0.0" for i in places for j in places
        ),
        "bias": tuple(f"h{i}" if i in in_bias else "0.0" for i in places),
        "force": tuple(f"f{i}" for i in places),
        "acceleration": tuple(f"a_{x}" for x in s.coordinates),
    }


def _solve(s: TermStructure) -> Lines:
    """Lines that solve M q'' = f - h by elimination, displacements first.

    Of a gear's row few entries are not 0. The pivot is the diagonal's wherever it has an entry: an
    arm's own M is positive definite. A form with an erratum may lack one, and takes the first row
    that has.
    """
    columns = sorted(range(s.size), key=lambda place: place in s.angles)
    filled, rows, pivots = {(i, j) for i, j, _ in s.mass}, list(columns), dict[int, int]()
    has_bias = {entry[0] for entry in s.bias}
    for i in range(s.size):
        yield f"r{i} = f{i}" + (f" - h{i}" if i in has_bias else "")
    yield from (f"U{i}_{j} = M{i}_{j}" for i, j in sorted(filled))
    for place, p in enumerate(columns):
        below = [i for i in rows if (i, p) in filled]
        pivot = p if p in below else below[0] if below else rows[0]
        pivots[p] = pivot
        rows.remove(pivot)
        yield f"inv{p} = 1.0 / " + (f"U{pivot}_{p}" if below else "0.0")
        beyond = [j for j in columns[place + 1 :] if (pivot, j) in filled]
        for i in below:
            if i == pivot:
                continue
            yield f"L{i} = U{i}_{p} * inv{p}"
            for j in beyond:
                begun = f"U{i}_{j}" if (i, j) in filled else "0.0"
                yield f"U{i}_{j} = {begun} - L{i} * U{pivot}_{j}"
                filled.add((i, j))
            yield f"r{i} = r{i} - L{i} * r{pivot}"
    for place, p in reversed(list(enumerate(columns))):
        beyond = [j for j in columns[place + 1 :] if (pivots[p], j) in filled]
        left = "".join(f" - U{pivots[p]}_{j} * a_{s.coordinates[j]}" for j in beyond)
        yield f"a_{s.coordinates[p]} = (r{pivots[p]}{left}) * inv{p}"
