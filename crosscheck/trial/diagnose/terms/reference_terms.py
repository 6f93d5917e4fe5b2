"""The reference's own terms of every entry, in the user's coordinates and the arm's symbols.

Those of its force depend on signals: torques, forces of meshes, rates of dampers.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
import sympy as sp

from crosscheck.analytic.derivation.bodies import Body, build_bodies
from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.efforts import drive_rows, mesh_rows
from crosscheck.analytic.derivation.gears import build_gears
from crosscheck.analytic.derivation.lagrange import MassTerms, build_mass_terms, build_weight_terms
from crosscheck.analytic.derivation.rigid import rigid_bodies
from crosscheck.analytic.derivation.symbols import build_arm_chain
from crosscheck.analytic.paper.mesh_force import is_in_contact, mesh_force, phase_force
from crosscheck.analytic.paper.mesh_frequency import mesh_phase
from crosscheck.analytic.paper.stiffness import stiffness, stiffness_slope
from crosscheck.analytic.paper.tooth_error import total_error
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import MESHES, Layout
from crosscheck.models.experiment.scenario import Switches
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.diagnose.terms import polynomial as poly
from crosscheck.trial.diagnose.terms.polynomial import (
    AngleSum,
    EntryTerms,
    Polynomial,
    Product,
    TermKey,
)
from crosscheck.trial.diagnose.terms.values import collect_arm_values, damper_name
from crosscheck.trial.judge.entries import EntryPlace, Part

SHORTEST = 1e-13  # largest number that is rounding of a sum, relative to the largest number


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
        """The terms that belong in an entry; none where it is 0."""
        return self.entries.get(place, ())

    def drop_symbols(self, absent: Set[str]) -> ReferenceTerms:
        """The terms without those that have a symbol of these."""
        if not absent:
            return self
        entries = {
            place: tuple(product for product in entry if absent.isdisjoint(product.symbols))
            for place, entry in self.entries.items()
        }
        return replace(self, entries=entries)

    @cached_property
    def angle_sums(self) -> tuple[AngleSum, ...]:
        """Every angle sum that occurs anywhere, 0 first."""
        sums = {product.key.wave for entry in self.entries.values() for product in entry}
        return tuple(sorted(sums | {(0,) * self.joints}, key=lambda w: (sum(map(abs, w)), w)))

    @cached_property
    def signals(self) -> tuple[str, ...]:
        """Every signal of the force's entries."""
        signals = (product.key.signal for entry in self.entries.values() for product in entry)
        return tuple(dict.fromkeys(filter(None, signals)))


def build_reference_terms(
    frame: Frame, arm: Arm, chosen: Switches, level: str = "", *, has_gravity: bool = False
) -> ReferenceTerms:
    """The reference terms of a geared model, or of a rigid one at a level.

    has_gravity: whether the weights are a part of their own, with the opposite sign, and not in the
    force. Raises ValueError if the map is not linear.
    """
    (chain, bodies), columns = build_reference_bodies(frame, arm, level), _columns(frame)
    mass = _transform_mass_terms(build_mass_terms(bodies, chain.angles[1:]), columns, frame.layout)
    turns = columns[frame.layout.theta]
    ordered = sorted(mass.items(), key=lambda item: item[0])
    entries = _group_entries(
        {(EntryPlace("mass_matrix", i, j), TermKey(wave)): c for (i, j, wave), c in ordered}
    )
    entries |= _bias_entries(mass, turns)
    force, weight = (
        build_force_coefficients(chain, arm, chosen),
        build_weight_coefficients(chain, bodies, arm),
    )
    if has_gravity:
        held = {key: -1 * coefficient for key, coefficient in weight.items()}
        entries |= _force_entries("gravity", ForceCoefficients(held, []), columns, frame)
    else:
        force.driven.update(weight)
    entries |= _force_entries("force", force, columns, frame)
    turns, values = np.vectorize(poly.as_polynomial, [object])(turns), collect_arm_values(arm)
    angles = np.array(
        [[float(sum(m.value(values) for m in entry.monomials)) for entry in row] for row in turns]
    )
    return ReferenceTerms(frame.names, turns, angles, entries)


def build_reference_bodies(frame: Frame, arm: Arm, level: str) -> tuple[Chain, list[Body]]:
    """The chain in polynomials, and the bodies of a geared model or of a rigid one at a level."""
    chain = _polynomial_chain(arm, frame.layout)
    geared = frame.layout.mesh_joints
    return chain, build_bodies(chain) if geared else rigid_bodies(chain, level or "coupled")


def _force_entries(
    part: Part, force: ForceCoefficients, columns: np.ndarray, frame: Frame
) -> dict[EntryPlace, EntryTerms]:
    """Terms of a force in x, S^T f with S = dq/dx, rates by those of x."""
    total: defaultdict[tuple[int, TermKey], list[Any]] = defaultdict(list)
    for (a, key), coefficient in force.driven.items():
        for i in _nonzero_places(columns[a]):
            total[i, key].append(coefficient * columns[a, i])
    still = (0,) * len(frame.layout.theta)
    for a, b, coefficient in force.damped:
        for i in _nonzero_places(columns[a]):
            left = coefficient * columns[a, i]
            for k in _nonzero_places(columns[b]):
                key = TermKey(still, signal=rate_name(frame.names[k]))
                total[i, key].append(left * columns[b, k])
    return _group_entries(
        {(EntryPlace(part, i), key): c for (i, key), c in _reduce_sums(total).items()}
    )


def _polynomial_chain(arm: Arm, layout: Layout) -> Chain:
    """The chain of arm_chain, with polynomials in place of sympy's symbols."""

    def polynomial(value: sp.Expr) -> Any:
        return poly.symbol(value.name) if value.is_Symbol else int(value)

    symbol_chain = build_arm_chain(arm, layout)
    stages = [
        stage._replace(**{n: polynomial(value) for n, value in stage._asdict().items()})
        for stage in symbol_chain.stages
    ]
    return Chain(tuple(stages), polynomial(symbol_chain.payload), layout)


def _columns(frame: Frame) -> np.ndarray:
    """The matrix dq/dx (n, n) of numbers or polynomials. Raises ValueError if it is no constant."""
    if frame.matrix is None:
        raise ValueError("the map is not linear")
    symbolic_entries = (
        [poly.from_sympy(entry) for entry in frame.symbolic] if frame.symbolic is not None else []
    )
    polynomials = [entry for entry in symbolic_entries if entry is not None]
    # A number where it is one.
    entries: list[Any] = [sum(p.terms.values()) if {*p.terms} <= {()} else p for p in polynomials]
    if len(entries) < frame.matrix.size:
        entries = [int(v) if v.is_integer() else v for v in frame.matrix.ravel().tolist()]
    return np.array(entries, dtype=object).reshape(frame.matrix.shape)


def _transform_mass_terms(mass: MassTerms, columns: np.ndarray, layout: Layout) -> MassTerms:
    """Terms of the mass matrix in x, S^T M S with S = dq/dx, over joint angles alone."""
    total: defaultdict[tuple[int, int, AngleSum], list[Any]] = defaultdict(list)
    for (a, b, wave), coefficient in mass.items():
        turned = tuple(wave[place] for place in layout.theta)
        for i in _nonzero_places(columns[a]):
            left = coefficient * columns[a, i]
            for j in _nonzero_places(columns[b]):
                total[i, j, turned].append(left * columns[b, j])
    return _reduce_sums(total)


def _nonzero_places(row: np.ndarray) -> list[int]:
    return [place for place, entry in enumerate(row) if entry]


def _reduce_sums(parts: Mapping[Any, Sequence[Any]]) -> dict[Any, Polynomial]:
    """Sums without what cancelled, in the fewest terms that r_cp = r_s + r_p allows."""
    every = {
        place: poly.add_polynomials(map(poly.as_polynomial, entry))
        for place, entry in parts.items()
    }
    sizes = (abs(float(n)) for entry in every.values() for n in entry.terms.values())
    nothing = SHORTEST * max(sizes, default=0.0)
    sums = {place: entry.drop_small_terms(nothing) for place, entry in every.items()}
    return {place: _shortest_form(entry) for place, entry in sums.items() if entry}


def _shortest_form(entry: Polynomial) -> Polynomial:
    names = {name for powers in entry.terms for name, _ in powers}
    for number in sorted(name[4:] for name in names if name.startswith("r_cp")):
        r_s, r_p, r_cp = (poly.symbol(f"{radius}{number}") for radius in ("r_s", "r_p", "r_cp"))
        instead = {
            f"r_cp{number}": r_s + r_p,
            f"r_s{number}": r_cp - r_p,
            f"r_p{number}": r_cp - r_s,
        }
        others = [entry.replace_symbol(name, other) for name, other in instead.items()]
        entry = min((entry, *others), key=lambda each: len(each.terms))
    return entry


def _group_entries(terms: Mapping[tuple[EntryPlace, TermKey], Any]) -> dict[EntryPlace, EntryTerms]:
    """The entries by place, out of coefficients by place and key."""
    entries: defaultdict[EntryPlace, list[Product]] = defaultdict(list)
    for (place, key), entry in terms.items():
        entries[place] += [
            Product(key, monomial) for monomial in poly.as_polynomial(entry).monomials
        ]
    return {place: tuple(products) for place, products in entries.items()}


def _bias_entries(mass: MassTerms, turns: np.ndarray) -> dict[EntryPlace, EntryTerms]:
    """Terms of the bias in any x: Christoffel's symbols of M, as ``derivation.lagrange`` has."""
    total: defaultdict[tuple[int, int, int, AngleSum], list[Any]] = defaultdict(list)
    for (i, j, wave), coefficient in mass.items():
        slopes = sum(entry * turns[joint] for joint, entry in enumerate(wave) if entry)
        for k in _nonzero_places(slopes) if any(wave) else ():
            slope = -1 * coefficient * slopes[k]
            total[i, min(j, k), max(j, k), wave].append(slope)
            total[k, min(i, j), max(i, j), wave].append(slope * Fraction(-1, 2))
    terms = {}
    for (i, j, k, wave), coefficient in sorted(
        _reduce_sums(total).items(), key=lambda item: item[0]
    ):
        terms[EntryPlace("bias", i, rates=(j, k)), TermKey(wave, "sin")] = coefficient
    return _group_entries(terms)


Columns = Mapping[str, np.ndarray]  # signals by name, (K,) each


class ForceCoefficients(NamedTuple):
    """The coefficients of a force.

    driven: by row and key; damped: (row, rate, coefficient) on rates of q.
    """

    driven: dict[tuple[int, TermKey], Any]
    damped: Sequence[tuple[int, int, Any]]


class ForcedMesh(NamedTuple):
    """A mesh with a force of its own: its joint (from 0), planet (from 0), and names.

    force, damper, work: signals; damping: poly.symbol of its damping, of ``planets`` together.
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
        for planet in range(joint.planet_count if layout.free else 1):
            suffix = f"{number}_{planet + 1}" if layout.free else f"{number}"
            for pair in ("sp", "pr"):
                force, damper, work = (f"{kind}_{pair}{suffix}" for kind in "FDQ")
                damping_name = damper_name(pair, joint, number, planet)
                count = joint.planet_count if layout.free else 1
                meshes.append(
                    ForcedMesh(place, planet, pair, force, damper, work, damping_name, count)
                )
    return meshes


def build_force_coefficients(chain: Chain, arm: Arm, chosen: Switches) -> ForceCoefficients:
    """Forces of drive, meshes, dampers and friction (see docs/explanation/equations.md)."""
    layout = chain.layout
    still = (0,) * len(chain.stages)
    driven: dict[tuple[int, TermKey], Any] = {}
    damped: list[tuple[int, int, Any]] = []
    for number, row in enumerate(drive_rows(chain), start=1):
        _add(driven, row, 1, TermKey(still, signal=f"T_{number}"))
    meshes = list_meshes(arm, layout)
    for mesh, row in zip(meshes, mesh_rows(chain), strict=True):
        _add(driven, row, 1, TermKey(still, signal=mesh.force))
        moved = layout.displacement(MESHES[mesh.pair == "pr"], mesh.joint, mesh.planet)
        damper = poly.symbol(mesh.damping) * Fraction(-1, mesh.planets)
        moved = np.array([int(entry) for entry in moved], dtype=object)
        if chosen.damping == "contact":
            _add(driven, moved, damper, TermKey(still, signal=mesh.damper))
        else:
            places = np.flatnonzero(moved)
            damped += [
                (int(a), int(b), damper * moved[a] * moved[b]) for a in places for b in places
            ]
        if chosen.mesh_work == "conservative":
            theta = int(layout.theta[mesh.joint])
            driven[theta, TermKey(still, signal=mesh.work)] = 1
    for number, (joint, place) in enumerate(zip(arm.joints, layout.theta, strict=True), start=1):
        if joint.friction_N_m_s_per_rad:
            damped.append((int(place), int(place), -1 * poly.symbol(f"c{number}")))
    return ForceCoefficients(driven, damped)


def build_weight_coefficients(
    chain: Chain, bodies: Sequence[Body], arm: Arm
) -> dict[tuple[int, TermKey], Any]:
    """Forces of the weights, by row and key."""
    coefficients: dict[tuple[int, TermKey], Any] = {}
    pull = [
        poly.symbol(f"g_{axis}") if g else 0
        for axis, g in zip("xy", arm.gravity_m_per_s2, strict=True)
    ]
    weight = build_weight_terms(bodies, chain.angles[1:], (pull[0], pull[1])) if any(pull) else {}
    for (place, wave), pair in weight.items():
        turned = tuple(wave[angle] for angle in chain.layout.theta)
        for function, coefficient in zip(("cos", "sin"), pair, strict=True):
            key = place, TermKey(turned, function)
            if coefficient:
                coefficients[key] = coefficients.get(key, 0) + coefficient
    return coefficients


def _add(
    driven: dict[tuple[int, TermKey], Any], row: np.ndarray, factor: Any, key: TermKey
) -> None:
    for place in np.flatnonzero(row):
        driven[int(place), key] = factor * row[place]


class ForceStates(NamedTuple):
    """States at which forces are asked: t (K,), layout's q and v (K, n), torque (K, joints)."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    torque: np.ndarray


class MeshConvention(NamedTuple):
    """Another law of all meshes than any switch has.

    absolute: phases by absolute link angles; rate_factor: phases faster by factors (meshes,) or
    one; contact_by_x: whether teeth touch is asked of x in place of x - e. damper: of teeth in
    contact, ``pushing`` never pulls them together, ``capped`` is at most the spring's force.
    """

    absolute: bool = False
    rate_factor: np.ndarray | float = 1.0
    contact_by_x: bool = False
    damper: Literal["", "pushing", "capped"] = ""

    @property
    def changes_phases(self) -> bool:
        """Whether it is the phases that are counted in another way."""
        return self.absolute or bool(np.any(self.rate_factor != 1.0))


USUAL = MeshConvention()


def compute_signal_columns(
    arm: Arm,
    layout: Layout,
    chosen: Switches,
    states: ForceStates,
    convention: MeshConvention = USUAL,
) -> Columns:
    """Output torques [N m], forces of a planet's meshes [N], and the dampers' rates [m/s].

    Each is (K,), by the signal's name. The user's rates, ``rate_name`` of each coordinate, are
    added by the caller.
    """
    columns = {f"T_{j + 1}": states.torque[:, j] for j in range(states.torque.shape[1])}
    data, meshes = build_gears(arm, layout, chosen), list_meshes(arm, layout)
    clock, q, v = states.t[:, None], states.q, states.v
    of_two = data.subtract_index >= 0
    x, rate = (each[:, data.x_index] - of_two * each[:, data.subtract_index] for each in (q, v))
    turned = np.array((q, v))
    if convention.absolute:
        turned[:, :, layout.theta] = turned[:, :, layout.theta].cumsum(axis=2)
    phase = mesh_phase(
        data.phase,
        data.rate * convention.rate_factor,
        data.offset,
        clock,
        *turned[:, :, data.theta],
    )
    gap = x - total_error(phase, data.E, data.error_phase, data.static_error)
    opening = x if convention.contact_by_x else gap
    in_contact = is_in_contact(opening, data.b)
    touching = in_contact | data.damps_without_contact
    for i, mesh in enumerate(meshes):
        k = stiffness(data.law, i, phase[:, i], data.k_m[i], data.k_a[i])
        force = mesh_force(data.dead_zone, gap[:, i], k, data.b[i], data.sigma[i])
        if convention.contact_by_x:
            flank = np.sign(x[:, i]) * data.b[i]
            force = np.where(in_contact[:, i], k * (gap[:, i] - flank), 0.0)
        columns[mesh.force] = force
        if chosen.damping == "contact":
            damped = np.where(touching[:, i], rate[:, i], 0.0)
            columns[mesh.damper] = _limit_rate(
                convention, damped, data.d[i] / data.planets[i], force
            )
        if chosen.mesh_work == "conservative":
            slopes = (
                stiffness_slope(data.law, i, phase[:, i], data.k_a[i]),
                data.E[i] * np.cos(phase[:, i] + data.error_phase[i]),
            )
            on_phase = phase_force(gap[:, i], k, *slopes, data.b[i])
            columns[mesh.work] = data.planets[i] * data.rate[i] * on_phase
    return columns


def _limit_rate(
    convention: MeshConvention, rate: np.ndarray, damping: float, spring: np.ndarray
) -> np.ndarray:
    """The rates [m/s] that a damper's force would have by a convention; spring: its force (K,)."""
    if not (convention.damper and damping):
        return rate
    most = np.abs(spring) / damping
    capped = np.clip(rate, -most, most)
    if convention.damper == "capped":
        return capped
    return np.where(rate * spring < 0, capped, rate)
