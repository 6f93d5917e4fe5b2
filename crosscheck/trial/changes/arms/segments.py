"""The terms of every entry in the user's coordinates, by the arm's letters.

A term of M is a body's mass times two levers, or an inertia; of the bias what Christoffel's symbols
make of it; of the force a weight, or a signal: a torque, the force of a mesh, the rate of a damper.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.derivation.bodies import Body, build_bodies, rigid_bodies
from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.efforts import drive_rows, mesh_rows
from crosscheck.analytic.derivation.lagrange import build_mass_terms, build_weight_terms
from crosscheck.analytic.derivation.stage import Stage
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import MESHES, Layout
from crosscheck.models.experiment.scenario import Switches
from crosscheck.trial.changes.arms.letters import collect_arm_values, damper_name
from crosscheck.trial.changes.arms.polynomial import (
    Monomial,
    Polynomial,
    add_polynomials,
    as_polynomial,
    build_letter_chain,
    letter,
)
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.judge.entries import EntryPlace, Part

ROUNDING = 1e-13  # largest entry of a map that was meant to be 0, relative to its row
LARGEST_DENOMINATOR = 1000  # largest denominator of a ratio of whole numbers
SHORTEST = 1e-13  # largest number that is rounding of a sum, relative to the largest number
AngleSum = tuple[int, ...]  # whole multiples of the joint angles of q, the first one positive


class TermKey(NamedTuple):
    """The factor after a coefficient: a signal times the cosine or sine of a joint angle sum.

    function ``cos`` of wave 0 is 1. signal: '' (none), an output torque ``T_1``, a mesh force of a
    planet ``F_sp1`` (``F_sp1_2``: planet 2), a rate of the user's ``phi_1'``, a damper's rate in
    contact ``D_sp1``, what springs do to an angle ``Q_sp1``.
    """

    wave: AngleSum
    function: str = "cos"
    signal: str = ""


class Product(NamedTuple):
    """A term of an entry: number * powers of letters, before a key."""

    key: TermKey
    monomial: Monomial

    @property
    def letters(self) -> tuple[str, ...]:
        """Names of the quantities that the product has."""
        return tuple(name for name, _ in self.monomial.powers)


EntryTerms = tuple[Product, ...]
Coefficients = defaultdict[tuple[EntryPlace, TermKey], list[Any]]


@dataclass(frozen=True, eq=False)
class ReferenceTerms:
    """The terms that belong in each entry, in the coordinates ``names``.

    An entry of the bias is that of v_j v_k, j <= k, both halves together. turns (joints, n):
    d theta / d x, of polynomials; angles: the same in numbers. A place that is not in ``entries``
    is 0.
    """

    names: tuple[str, ...]
    turns: np.ndarray
    angles: np.ndarray
    entries: Mapping[EntryPlace, EntryTerms]

    @property
    def joints(self) -> int:
        """Number of joints of the arm."""
        return len(self.angles)

    def entry(self, place: EntryPlace) -> EntryTerms:
        """The correct terms of an entry; none if it is 0."""
        return self.entries.get(place, ())

    def drop_letters(self, absent: Set[str]) -> ReferenceTerms:
        """The terms without those that have a letter of these."""
        entries = {
            place: tuple(product for product in entry if absent.isdisjoint(product.letters))
            for place, entry in self.entries.items()
        }
        return replace(self, entries=entries)

    @cached_property
    def angle_sums(self) -> tuple[AngleSum, ...]:
        """Every angle sum that occurs anywhere, 0 first."""
        sums = {product.key.wave for entry in self.entries.values() for product in entry}
        return tuple(sorted(sums | {(0,) * self.joints}, key=lambda w: (sum(map(abs, w)), w)))


def build_reference_terms(
    frame: Frame,
    arm: Arm,
    chosen: Switches,
    level: str = "",
    *,
    has_gravity: bool = False,
    columns: np.ndarray | None = None,
) -> ReferenceTerms:
    """The reference terms of a geared model, or of a rigid one at a level.

    has_gravity: whether the weights are a part of their own, with the opposite sign, and not in the
    force; columns: dq/dx as ``find_columns`` finds it. Raises ValueError if the map is not linear.
    """
    chain, is_geared = build_letter_chain(arm, frame.layout), bool(frame.layout.mesh_joints)
    bodies = build_bodies(chain) if is_geared else rigid_bodies(chain, level or "coupled")
    columns = find_columns(frame, arm) if columns is None else columns
    turns = columns[frame.layout.theta]
    parts = [
        _mass_terms(chain, bodies, columns, turns),
        _effort_terms(chain, arm, chosen, columns, frame.names),
        _weight_terms(chain, bodies, arm, columns, has_gravity),
    ]
    entries: dict[EntryPlace, EntryTerms] = {}
    for part in parts:
        for place, products in _group_entries(part).items():
            entries[place] = entries.get(place, ()) + products
    turns, values = np.vectorize(as_polynomial, [object])(turns), collect_arm_values(arm)
    angles = np.array([[entry.value(values) for entry in row] for row in turns])
    return ReferenceTerms(frame.names, turns, angles, entries)


def find_columns(frame: Frame, arm: Arm) -> np.ndarray:
    """The matrix dq/dx (n, n) in ratios of whole numbers and letters of each row's own joint.

    Its numbers where one is none of these; what rounding left of a 0 is 0. Raises ValueError if the
    map is not linear.
    """
    if frame.matrix is None:
        raise ValueError("the map is not linear")
    stages, values = build_letter_chain(arm, frame.layout).stages, collect_arm_values(arm)
    entries = list[Any]()
    for row, meant in zip(frame.matrix, frame.layout.coordinates, strict=True):
        nothing, stage = ROUNDING * float(np.abs(row).max()), stages[meant.joint - 1]
        forms = _list_forms(stage) if isinstance(stage, Stage) else []
        numbers = [(form, form.value(values)) for form in forms]
        entries += [_find_form(v, numbers) if abs(v) > nothing else 0 for v in row.tolist()]
    if any(entry is None for entry in entries):
        entries = [int(v) if v.is_integer() else v for v in frame.matrix.ravel().tolist()]
    return np.array(entries, dtype=object).reshape(frame.matrix.shape)


def _find_form(value: float, numbers: Sequence[tuple[Polynomial, float]]) -> Any:
    """A number as a ratio, or a form with its sign; None if it is neither.

    One over a motor's ratio is that, and no ratio of its own.
    """
    ratio = Fraction(value).limit_denominator(LARGEST_DENOMINATOR)
    is_motors = bool(numbers) and abs(value) == numbers[-1][1] != 1
    if float(ratio) == value and not is_motors:
        return ratio
    equal = [form for form, n in numbers if abs(abs(value) - n) <= ROUNDING * n]
    return None if not equal else equal[0] if value > 0 else -equal[0]


def _list_forms(stage: Stage) -> list[Polynomial]:
    """Quantities of a stage that people put in a map of its joint, simplest first; last 1/n."""
    r_s, r_p, r_cp, n = stage.r_s, stage.r_p, stage.r_cp, stage.n
    radii = [r_s, r_p, r_cp, 2 * r_s, 2 * r_p, 2 * r_cp, r_s + 2 * r_p]
    inverses = (each**-1 for each in (r_s, r_p, r_cp))
    return [*radii, n, *inverses, r_p / r_s, r_s / r_p, 2 * r_cp / r_s, n**-1]


def _list_places(row: np.ndarray) -> list[int]:
    return [place for place, entry in enumerate(row) if entry]


def _mass_terms(
    chain: Chain, bodies: Sequence[Body], columns: np.ndarray, turns: np.ndarray
) -> Coefficients:
    """Terms of S^T M S with S = dq/dx, and of the bias by Christoffel's symbols of it."""
    mass: defaultdict[tuple[int, int, AngleSum], list[Any]] = defaultdict(list)
    for (a, b, whole), coefficient in build_mass_terms(bodies, chain.angles[1:]).items():
        wave = tuple(whole[place] for place in chain.layout.theta)
        for i in _list_places(columns[a]):
            left = coefficient * columns[a, i]
            for j in _list_places(columns[b]):
                mass[i, j, wave].append(left * columns[b, j])
    sums = [
        (EntryPlace("mass_matrix", i, j), TermKey(wave), add_polynomials(map(as_polynomial, parts)))
        for (i, j, wave), parts in mass.items()
    ]
    terms: Coefficients = defaultdict(list, {(place, key): [total] for place, key, total in sums})
    terms.update((at, [total]) for at, total in derive_bias(sums, turns).items())
    return terms


def derive_bias(
    mass: Iterable[tuple[EntryPlace, TermKey, Any]], turns: np.ndarray
) -> dict[tuple[EntryPlace, TermKey], Any]:
    """The bias that Christoffel's symbols make of M, by numbers or polynomials before its waves.

    turns (joints, n): d theta / d x. In row i dM_ij/dx_k counts once, and half of dM_jk/dx_i with
    the opposite sign.
    """
    bias = dict[tuple[EntryPlace, TermKey], Any]()

    @cache
    def differentiate(wave: AngleSum) -> np.ndarray:
        return np.array(wave, dtype=object) @ turns

    for place, key, coefficient in mass:
        i, j = place.index
        sign, function = (-1, "sin") if key.function == "cos" else (1, "cos")
        other, slopes = key._replace(function=function), differentiate(key.wave)
        for k in map(int, np.flatnonzero(slopes)):
            slope = sign * coefficient * slopes[k]
            for row, rates, value in ((i, (j, k), slope), (k, (i, j), slope / -2)):
                at = EntryPlace("bias", row, rates=(min(rates), max(rates))), other
                bias[at] = bias.get(at, 0) + value
    return bias


def _weight_terms(
    chain: Chain, bodies: Sequence[Body], arm: Arm, columns: np.ndarray, has_gravity: bool
) -> Coefficients:
    """Forces of the weights, which have the opposite sign where they are a part of their own."""
    terms: Coefficients = defaultdict(list)
    g_x, g_y = (
        letter(f"g_{axis}") if g else 0 for axis, g in zip("xy", arm.gravity_m_per_s2, strict=True)
    )
    part: Part = "gravity" if has_gravity else "force"
    weights = build_weight_terms(bodies, chain.angles[1:], (g_x, g_y)) if g_x or g_y else {}
    for (a, whole), pair in weights.items():
        wave = tuple(whole[place] for place in chain.layout.theta)
        for function, coefficient in zip(("cos", "sin"), pair, strict=True):
            for i in _list_places(columns[a]) if coefficient else ():
                force = (-1 if has_gravity else 1) * coefficient * columns[a, i]
                terms[EntryPlace(part, i), TermKey(wave, function)].append(force)
    return terms


class ForcedMesh(NamedTuple):
    """A mesh with a force of its own: its joint (from 0), planet (from 0), and names.

    force, damper, work: signals; damping: letter of its damping, of ``planets`` together.
    """

    joint: int
    planet: int
    pair: str
    force: str
    damper: str
    work: str
    damping: str
    planets: int


def rate_name(coordinate: str) -> str:
    """The name of the signal that is a coordinate's rate."""
    return f"{coordinate}'"


def list_meshes(arm: Arm, layout: Layout) -> list[ForcedMesh]:
    """All meshes of an arm, in the order of crosscheck.analytic.derivation.gears."""
    meshes = []
    for place in layout.mesh_joints:
        joint, number = arm.joints[place], place + 1
        assert isinstance(joint, Planetary)  # as joints with mesh displacements are
        count = joint.planet_count if layout.free else 1
        for planet in range(count):
            suffix = f"{number}_{planet + 1}" if layout.free else f"{number}"
            for pair in ("sp", "pr"):
                force, damper, work = (f"{kind}_{pair}{suffix}" for kind in "FDQ")
                name = damper_name(pair, joint, number, planet)
                mesh = ForcedMesh(place, planet, pair, force, damper, work, name, count)
                meshes.append(mesh)
    return meshes


def _effort_terms(
    chain: Chain, arm: Arm, chosen: Switches, columns: np.ndarray, names: Sequence[str]
) -> Coefficients:
    """Forces of drive, meshes, dampers and friction (see docs/explanation/equations.md)."""
    terms: Coefficients = defaultdict(list)
    layout, still = chain.layout, (0,) * len(chain.stages)

    def push(row: np.ndarray, factor: Any, signal: str) -> None:
        for i in range(len(names)):
            total = sum(entry * columns[a, i] for a, entry in enumerate(row) if entry)
            if total:
                terms[EntryPlace("force", i), TermKey(still, signal=signal)].append(factor * total)

    def damp(row: np.ndarray, factor: Any) -> None:
        """A force along a row, by a factor of the rate of that row."""
        rates = row @ columns
        for k in _list_places(rates):
            push(row, factor * rates[k], rate_name(names[k]))

    for number, row in enumerate(drive_rows(chain), start=1):
        push(row, 1, f"T_{number}")
    for mesh, row in zip(list_meshes(arm, layout), mesh_rows(chain), strict=True):
        push(row, 1, mesh.force)
        displacement = layout.displacement(MESHES[mesh.pair == "pr"], mesh.joint, mesh.planet)
        moved = np.array([int(entry) for entry in displacement], dtype=object)
        factor = letter(mesh.damping) * Fraction(-1, mesh.planets)
        if chosen.damping == "contact":
            push(moved, factor, mesh.damper)
        else:
            damp(moved, factor)
        if chosen.mesh_work == "conservative":
            push(chain.row("theta", mesh.joint + 1), 1, mesh.work)
    for number, joint in enumerate(arm.joints, start=1):
        if joint.friction_N_m_s_per_rad:
            damp(chain.row("theta", number), -1 * letter(f"c{number}"))
    return terms


def _group_entries(terms: Coefficients) -> dict[EntryPlace, EntryTerms]:
    """The entries by place, without what cancelled, in as few terms as r_cp = r_s + r_p allows."""
    totals = {at: add_polynomials(map(as_polynomial, parts)) for at, parts in terms.items()}
    sizes = (abs(float(n)) for entry in totals.values() for n in entry.terms.values())
    nothing = SHORTEST * max(sizes, default=0.0)
    entries: defaultdict[EntryPlace, list[Product]] = defaultdict(list)
    for (place, key), total in sorted(totals.items(), key=_order):
        left = {
            p: n for p, n in total.terms.items() if not isinstance(n, float) or abs(n) > nothing
        }
        monomials = _shorten(Polynomial(left)).monomials
        entries[place] += [Product(key, monomial) for monomial in monomials]
    return {place: tuple(products) for place, products in entries.items() if products}


def _order(item: tuple[tuple[EntryPlace, TermKey], Any]) -> tuple[Any, ...]:
    """Entries in the order of rows, columns and rates; the terms of a force as they are made."""
    place, key = item[0]
    return place.row, place.column or 0, place.rates or (), () if key.signal else key.wave


def _shorten(entry: Polynomial) -> Polynomial:
    names = {name for powers in entry.terms for name, _ in powers}
    for number in sorted(name[4:] for name in names if name.startswith("r_cp")):
        r_s, r_p, r_cp = (letter(f"{radius}{number}") for radius in ("r_s", "r_p", "r_cp"))
        instead = {"r_cp": r_s + r_p, "r_s": r_cp - r_p, "r_p": r_cp - r_s}
        others = [entry.replace_letter(f"{name}{number}", by) for name, by in instead.items()]
        entry = min((entry, *others), key=lambda each: len(each.terms))
    return entry


def evaluate_wave(key: TermKey, angles: np.ndarray, unit: float = 1.0) -> np.ndarray:
    """The cosine or sine (...) at joint angles (..., joints), each multiplied by a unit."""
    angle = unit * (angles @ np.array(key.wave, dtype=float))
    return np.sin(angle) if key.function == "sin" else np.cos(angle)


def evaluate_entry(
    entry: Iterable[Product],
    values: Mapping[str, float],
    angles: np.ndarray,
    signals: Mapping[str, np.ndarray] | None = None,
) -> np.ndarray:
    """An entry's values (K,) at joint angles (K, joints), by an arm's quantities and signals."""
    total = np.zeros(len(angles))
    for key, monomial in entry:
        signal = (signals or {})[key.signal] if key.signal else 1.0
        total += monomial.value(values) * evaluate_wave(key, angles) * signal
    return total
