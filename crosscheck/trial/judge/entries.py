"""Entries of equations of motion: their natural sizes, what is wrong there, and by how much."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import Any, Literal

import numpy as np

from crosscheck.checks.scales import EPS, LOOSEST
from crosscheck.models.errors import InputError
from crosscheck.report.formatting import list_first
from crosscheck.trial.coordinates.differences import TURN_RAD, difference_steps, turns
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.coordinates.states import UserState, stack_states

PART_TITLES = {"mass_matrix": "M", "rate_terms": "bias"}

NUDGE = 1e-7  # step of coordinates by which a map is differentiated
WRITTEN = 10  # tolerance in roundings, for states and answers written with fewer digits
LARGEST_POWER = 200  # largest power of ten between the numbers of two units
SLOPES = 2 / TURN_RAD  # largest error of slopes of M, over the error of M itself
ROUNDINGS = 1000  # roundings of a few hundred operations, times how badly conditioned they are
SOLVED = 10  # roundings of a solution by elimination, times the condition number of the matrix
Part = Literal["mass_matrix", "bias", "gravity", "inverse_dynamics", "force", "acceleration"]
ErrorKind = Literal["sign", "factor", "dropped", "swapped", "angle", "extra"]
ALONE = "alone: errors that its equal numbers and zeros hide are not seen"  # on a mechanism
LONE = "not what your other parts make"
SHOWN = 8  # places of a list that are shown; the report has them all


@dataclass(frozen=True)
class NaturalSizes:
    """Natural sizes in a user's coordinates: mass (n, n); rate_terms (n, n, n); rows of each part.

    gravity_slopes (n, n): of derivatives by x, over SLOPES.

    roundings: of the map, how many a difference may hold; solving: what solving by M makes of one;
    precision: relative rounding of answers from a file, 0 for that of double precision.
    """

    mass: np.ndarray
    rate_terms: np.ndarray
    bias: np.ndarray
    force: np.ndarray
    acceleration: np.ndarray
    gravity: np.ndarray
    gravity_slopes: np.ndarray
    roundings: float
    solving: float
    precision: float = 0.0

    def tolerance(self, quantity: str) -> float:
        """Tolerance of the entries of a part, relative to their sizes."""
        solved = SOLVED * EPS * self.solving if quantity == "acceleration" else 0.0
        return LOOSEST + ROUNDINGS * EPS * self.roundings + solved + self.file_rounding(quantity)

    def file_rounding(self, quantity: str) -> float:
        """Error of an entry that is due to rounding of written answers and states."""
        larger = {"rate_terms": SLOPES, "acceleration": self.solving}.get(quantity, 1.0)
        return WRITTEN * self.precision * self.roundings * larger

    def basis(self, quantity: str) -> str:
        """The tolerance of a part in words."""
        solved = f" + {SOLVED} eps x {self.solving:.3g}, that of M" * (quantity == "acceleration")
        rounding = self.file_rounding(quantity)
        written = f" + {rounding:.3g}, by the digits of the answers' file" if rounding else ""
        return (
            f"{LOOSEST:g} + {ROUNDINGS} eps x {self.roundings:.3g}, the conditioning of the"
            f" coordinates' map{solved}{written}, of each entry's natural size"
        )

    def scale_by(self, factor: float) -> NaturalSizes:
        """The sizes of equations whose numbers are this many times as large."""
        sizes = ("mass", "rate_terms", "bias", "force", "acceleration", "gravity", "gravity_slopes")
        return replace(self, **{name: factor * getattr(self, name) for name in sizes})

    def entry_sizes(self, quantity: str) -> np.ndarray:
        """The natural sizes of a part's entries."""
        return self.mass if quantity == "mass_matrix" else getattr(self, quantity)


def compute_sizes(
    frame: Frame,
    states: Sequence[UserState],
    mass: np.ndarray,
    force: np.ndarray | None,
    acceleration: np.ndarray | None,
    gravity: np.ndarray | None = None,
    precision: float = 0.0,
) -> NaturalSizes:
    """Natural sizes by a trusted M (count, n, n), and vectors (count, n), at states.

    M_ij is of size sqrt(M_ii M_jj); a bias of sqrt(M_ii) times the root of u M u and the joints'
    rate; a term of it in u_j u_k of that over the rates' own sizes. Where x hides how large M is
    (its rows nearly depend on each other), a term is of the size of what it is the small sum of:
    sqrt(M_ii M_jj) by how far x_k turns the joints, i, j and k in any order. A force or
    acceleration that vanishes has what its inertia makes of the others.
    """
    at = stack_states(states)
    rates, turning = at.u, at.v[:, frame.layout.angular]
    diagonal = np.sqrt(np.einsum("kii->ki", mass).max(axis=0))
    lively = np.sqrt(np.einsum("ki,kij,kj->k", rates, mass, rates).mean() * (turning**2).mean())
    of_rates = np.sqrt((rates**2).mean(axis=0))
    jacobians = np.array([frame.jacobian(state.x) for state in states])
    inverses = np.linalg.inv(jacobians)
    moved = inverses.swapaxes(1, 2) @ mass @ inverses  # M of q
    summed = _summands(
        diagonal, np.max([turns(J, frame.layout.angular) for J in jacobians], axis=0)
    )
    moving = np.einsum("ijk,j,k->i", summed, of_rates, of_rates)
    weights = _rows(gravity, diagonal)
    steps = np.min([difference_steps(J, frame.layout.angular) for J in jacobians], axis=0)
    sloped = np.outer(weights, TURN_RAD / steps)
    return NaturalSizes(
        mass=np.outer(diagonal, diagonal),
        rate_terms=np.maximum(
            (diagonal * lively)[:, None, None] / np.outer(of_rates, of_rates), summed
        ),
        bias=np.maximum(diagonal * lively, moving),
        force=_rows(force, diagonal),
        acceleration=_rows(acceleration, 1 / diagonal),
        gravity=weights,
        gravity_slopes=np.maximum(sloped, sloped.T),
        roundings=max(
            _skeel_condition(mass, moved, jacobians, inverses),
            _cancellation_factor(moved, jacobians, diagonal),
            *(_map_curvature(frame, state.x) for state in states if frame.matrix is None),
        ),
        solving=float(np.linalg.cond(mass / np.sqrt(np.einsum("kii,kjj->kij", mass, mass))).max()),
        precision=precision,
    )


def unit_ratio(user_values: np.ndarray, reference_values: np.ndarray) -> float:
    """How many times as large a part's numbers are as the right ones, by their medians.

    Of the rows' ratios it is the median, the lower one of two: a single entry that is wrong,
    however large, changes nothing. 1 where no row is there on both sides.

    Args:
        user_values: A mass matrix (count, n, n), or a vector (count, n), state by state.
        reference_values: The same part of a model that is trusted.
    """
    user_medians, reference_medians = map(_row_medians, (user_values, reference_values))
    there = (user_medians > 0) & (reference_medians > 0) & np.isfinite(user_medians)
    if not there.any():
        return 1.0
    ratios = np.sort(user_medians[there] / reference_medians[there])
    return float(ratios[(len(ratios) - 1) // 2])


def power_of_ten(ratio: float) -> float:
    """The power of ten next to a ratio: 1 unless the numbers are in another unit."""
    return 10.0 ** float(np.clip(np.round(np.log10(ratio)), -LARGEST_POWER, LARGEST_POWER))


def _row_medians(values: np.ndarray) -> np.ndarray:
    """The median size of each row over the states, of a matrix that of its diagonal, (n,)."""
    rows = np.einsum("kii->ki", values) if values.ndim == 3 else values
    return np.median(np.abs(rows), axis=0)


def _summands(diagonal: np.ndarray, turned: np.ndarray) -> np.ndarray:
    """Largest of what Christoffel's symbols add up, (n, n, n), by x_k's turning of the joints."""
    terms = np.einsum("i,j,k->ijk", diagonal, diagonal, turned)
    return np.max([terms, terms.transpose(0, 2, 1), terms.transpose(2, 1, 0)], axis=0)


def _rows(values: np.ndarray | None, weight: np.ndarray) -> np.ndarray:
    if values is None:
        return weight
    rms, shared = np.sqrt((values**2).mean(axis=0)), np.sqrt(((values / weight) ** 2).mean())
    natural = weight * (float(shared) or 1.0)
    return np.where(rms > ROUNDINGS * EPS * natural, rms, natural)


def _cancellation_factor(moved: np.ndarray, jacobians: np.ndarray, diagonal: np.ndarray) -> float:
    """How much larger than M_x the terms are whose sum J^T M J is; M (count, n, n)."""
    sizes = np.abs(jacobians)
    terms = sizes.swapaxes(1, 2) @ np.abs(moved) @ sizes
    return float((terms / np.outer(diagonal, diagonal)).max())


def _map_curvature(frame: Frame, x: np.ndarray) -> float:
    """Relative change of J over that of x, at least 1; 1 where the map ends too near for that."""
    here, curvature = frame.jacobian(x), 1.0
    for sign in (-1, 1):
        with suppress(InputError):
            difference = np.abs(frame.jacobian(x * (1 + sign * NUDGE)) - here).max(axis=0)
            curvature = max(curvature, float((difference / np.abs(here).max(axis=0)).max()) / NUDGE)
    return curvature


def _skeel_condition(
    mass: np.ndarray, moved: np.ndarray, jacobians: np.ndarray, inverses: np.ndarray
) -> float:
    """Skeel's condition number of J, its rows and columns in units of the inertia at either side.

    So it is the map's, whatever the units of x are. All (count, n, n); mass: M of x and
    of q.
    """
    x_roots, others = (np.sqrt(np.abs(np.einsum("kii->ki", each))) for each in (mass, moved))
    scaled_by = others[:, :, None] / x_roots[:, None, :]
    terms = np.abs(inverses / scaled_by.swapaxes(1, 2)) @ np.abs(jacobians * scaled_by)
    return float(terms.sum(axis=2).max())


@dataclass(frozen=True)
class EntryPlace:
    """An entry, counted from 0: M[row, column]; bias[row] in v_j v_k, j <= k; force[row]."""

    part: Part
    row: int
    column: int | None = None
    rates: tuple[int, int] | None = None

    @property
    def quantity(self) -> str:
        """The array that it stands in: of its part, or of the bias' terms."""
        return self.part if self.rates is None else "rate_terms"

    @property
    def index(self) -> tuple[int, ...]:
        """Where it stands there."""
        beside = self.rates or () if self.column is None else (self.column,)
        return (self.row, *beside)


@dataclass(frozen=True)
class Term:
    """coefficient * cosine or sine of an angle sum: what stands in an entry for too much or little.

    coefficient, angle, signal: text as one writes it (``m_payload L2 L1``, ``theta_1 - theta_2``,
    ``F_sp1``), empty for 1, no angle, none.
    """

    coefficient: str
    wave: Literal["", "cos", "sin"] = ""
    angle: str = ""
    signal: str = ""


@dataclass(frozen=True)
class TermError:
    """A term of an entry as it must be, and what stands there instead.

    kind: ``sign``, ``factor`` (``by``: yours over right), ``dropped``, ``swapped`` (``yours`` where
    ``right`` belongs), ``angle`` (the same of an angle sum), ``extra`` (which belongs to ``right``,
    if anywhere). term: the right one, of ``extra`` the one too many.
    """

    kind: ErrorKind
    term: Term
    yours: str = ""
    right: str = ""
    by: float | None = None


@dataclass(frozen=True)
class Explanation:
    """Errors that together make a difference, and what they leave of it, relative to that.

    others: explanations that fit as well with the arm's numbers (equal lengths, say), likeliest
    first.
    """

    errors: tuple[TermError, ...]
    left_over: float
    others: tuple[tuple[TermError, ...], ...] = ()


@dataclass(frozen=True)
class EntryMismatch:
    """An entry that is wrong: by how much (relative to the entry's natural size), and perhaps why.

    difference: yours minus right in numbers, of an entry that nothing explains. shown_on: name of
    the arm that shows it, where the user's cannot. notes: sentences on what the entry is beside the
    right one. name: of the entry in its coordinates; guess: at the error, in words;
    is_consequence: whether other parts that are wrong make it.
    """

    place: EntryPlace
    share: float
    explanation: Explanation | None = None
    difference: tuple[Term, ...] = ()
    shown_on: str = ""
    notes: tuple[str, ...] = ()
    name: str = ""
    guess: str = ""
    is_consequence: bool = False

    @property
    def part(self) -> str:
        """The part that it belongs to."""
        return self.place.part

    @property
    def remark(self) -> str:
        """The notes together."""
        return ", ".join(self.notes)

    @property
    def cause(self) -> str:
        """What is wrong with the entry, in words; '' where nobody knows."""
        return self.remark or self.guess


def select_counted(wrong: Sequence[EntryMismatch]) -> Sequence[EntryMismatch]:
    """Those of wrong entries that are counted: not what others make together, beside these.

    Two of M that mirror each other, and are wrong alike, are one.
    """
    counted = dict[object, EntryMismatch]()
    for each in (each for each in wrong if not each.is_consequence):
        at = each.place
        pair = frozenset((at.row, at.column))
        counted.setdefault((at.part, at.rates, pair, f"{each.share:.6g}"), each)
    return list(counted.values())


@dataclass(frozen=True)
class LevelDistance:
    """A level beside the equations: how many entries differ, their largest and mean deviation.

    Deviations are relative to the sizes of entries.
    """

    level: Any
    entries: int
    largest: float
    mean: float


def measure_distance(level: str, count: int, errors: Iterable[np.ndarray]) -> LevelDistance:
    """The distance of a level from which so many entries differ; errors: of all entries."""
    shares = np.concatenate([each.ravel() for each in errors] or [np.zeros(1)])
    return LevelDistance(level, count, float(shares.max()), float(shares.mean()))


def sort_distances(
    distances: Mapping[LevelDistance, set[str]], stated: str = ""
) -> list[LevelDistance]:
    """The levels, of which richer ones come later: the stated first, then that of fewest entries.

    Of as many the one with the least mean; of several that agree the first. One large error must
    not choose a level from which right entries differ. But a mass that some part has, and another
    one lacks, was left out of the latter: nobody adds one by mistake.

    distances: with the parts in which any entry differs.
    """
    listed = list(distances)
    nearest, *others = sorted(
        listed, key=lambda d: (d.level != stated, d.entries, d.mean if d.entries else 0.0)
    )
    for each in others if nearest.level != stated else ():
        is_richer = listed.index(each) > listed.index(nearest)
        is_as_near = each.entries == nearest.entries
        if is_richer and is_as_near and distances[nearest] - distances[each]:
            return [each, nearest, *(other for other in others if other is not each)]
    return [nearest, *others]


def format_entry(place: EntryPlace, names: Sequence[str]) -> str:
    """An entry in words, such as M[phi_1, phi_2], bias[phi_1] of phi_1' phi_2', force[phi_1]."""
    row = names[place.row]
    if place.part == "mass_matrix":
        assert place.column is not None  # of a matrix
        return f"M[{row}, {names[place.column]}]"
    if place.rates is not None:
        return f"bias[{row}] of {format_rates(place.rates, names)}"
    return f"{place.part}[{row}]"


def format_rates(rates: tuple[int, int], names: Sequence[str]) -> str:
    """The product of the rates of two coordinates, such as phi_1' phi_2' or phi_1'^2."""
    j, k = rates
    return f"{names[j]}'^2" if j == k else f"{names[j]}' {names[k]}'"


def list_entries(places: Sequence[EntryPlace], names: Sequence[str]) -> str:
    """The entries in words, the first few by name; '' for none."""
    return list_first([format_entry(place, names) for place in places], SHOWN)


def describe_entry_notes(wrong: Sequence[EntryMismatch]) -> Iterator[str]:
    """A line for each note on wrong entries, and all entries that it is on."""
    for note in dict.fromkeys(note for each in wrong for note in each.notes):
        yield f"{', '.join(each.name for each in wrong if note in each.notes)}: {note}"


def interleave(groups: Iterable[Sequence[str]]) -> list[str]:
    """The first sentence of each group, then the second, and so on."""
    return [words for each in zip_longest(*groups) for words in each if words]


def deviations(values: np.ndarray, expected: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Largest difference of every entry over the states, relative to its size: shape of size.

    values, expected (count, ...): the states along the first axis.
    """
    return np.abs(values - expected).max(axis=0) / size


def find_wrong_entries(
    quantity: str, user_values: np.ndarray, reference_values: np.ndarray, sizes: NaturalSizes
) -> Iterator[EntryMismatch]:
    """The entries of a part that differ by more than rounding, the largest difference first."""
    relative_errors = deviations(user_values, reference_values, sizes.entry_sizes(quantity))
    beyond = np.argwhere(~(relative_errors <= sizes.tolerance(quantity)))
    for index in sorted(map(tuple, beyond.tolist()), key=lambda at: -relative_errors[at]):
        yield EntryMismatch(entry_place(quantity, index), float(relative_errors[index]))


def find_part(quantity: str) -> Part:
    """The part that an array is of: the bias of its terms by rates."""
    part: Any = "bias" if quantity == "rate_terms" else quantity
    return part


def entry_place(quantity: str, index: tuple[int, ...]) -> EntryPlace:
    """The place of an entry of an array of a part, or of its terms."""
    part = find_part(quantity)
    if part == "mass_matrix":
        return EntryPlace(part, index[0], column=index[1])
    if len(index) == 3:
        return EntryPlace(part, index[0], rates=(index[1], index[2]))
    return EntryPlace(part, index[0])
