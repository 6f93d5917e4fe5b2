"""All checks of answers at states: what equations owe to themselves, and each engine.

Equations of arms and of robots are judged by the same arrays: whoever asks fills in ``AnswerSet``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.states import is_usable, scale_mass_matrix
from crosscheck.findings import (
    ComparisonKey,
    Finding,
    Subject,
    make_check,
    make_failed_check,
    make_measurement,
    make_unfinished_check,
)
from crosscheck.runner.outcomes import Failure, failure_from_error
from crosscheck.trial.judge.entries import SLOPES, entry_place, list_entries

OWN, AGAINST = "trial-own", "trial-states"
COMPARED = ("mass_matrix", "bias", "gravity", "force", "acceleration")
WHOLE = ("mass_matrix", "bias", "force", "acceleration")  # complete equations of an arm
JUDGED = (*COMPARED[:3], "inverse_dynamics", *COMPARED[3:])
MEANINGFUL = 1e-4  # engines further apart, at the end of what numbers can do, judge nobody
# Checks and their parts.
CHRISTOFFEL = "bias-from-inertia", "bias"
GRADIENT = "gravity-is-a-gradient", "gravity"
INVERSE = "inverse-dynamics", "inverse_dynamics"
SECOND_LAW = "second-law"
CHANGES = "{} changes from one call to the next with the same arguments"
MOTIONLESS = "some motion would have zero or negative kinetic energy"


class PartSize(NamedTuple):
    """Natural sizes of entries (states, ...) or (...), the share that may differ, and its basis."""

    entries: np.ndarray
    tolerance: float
    basis: str

    def scale_to_slopes(self) -> PartSize:
        """The size of slopes of a quantity with these sizes, by differences of its answers."""
        basis = f"{self.basis}, {SLOPES:.3g} times for differences of answers"
        return PartSize(self.entries, SLOPES * self.tolerance, basis)


class Identity(NamedTuple):
    """Two sides that are equal at every state if the equations are consistent.

    check: its name in findings; part: the part that is wrong if they are not; size: of the sides'
    entries; left, right (..., entry), an entry with so many axes; doubt: how far they may be apart
    anyway; fault: what is wrong then, in words, unless wrong entries say it.
    """

    check: str
    part: str
    size: PartSize
    left: np.ndarray
    right: np.ndarray
    doubt: np.ndarray | float = 0.0
    axes: int = 1
    fault: str = ""

    @property
    def errors(self) -> np.ndarray:
        """Largest deviation of each entry over the states, relative to its size."""
        beyond = np.maximum(np.abs(self.left - self.right) - self.doubt, 0.0) / self.size.entries
        return beyond.max(axis=tuple(range(beyond.ndim - self.axes)))

    @property
    def places(self) -> list[tuple[int, ...]]:
        """The entries that deviate by more than the tolerance."""
        beyond = ~(self.errors <= self.size.tolerance)
        return [tuple(place) for place in np.argwhere(beyond).tolist()]


@dataclass(frozen=True)
class AnswerSet:
    """Answers of equations at states, and what they are judged by.

    Args:
        name: The equations.
        mechanism: The arm or robot.
        names: Of its coordinates.
        states: The states in words.
        values: By part, M (states, n, n), others (states, n).
        sizes: By part, in the unit of the equations' own numbers.
        symmetry: Size of the difference of M from its transpose.
        repeated: The answers to the same questions, asked a second time.
        failures: Parts that did not answer, with the reason.
        other_speeds: The bias h(x, s u) / s^2 at s = -1 and 2, then at rest (states, 3, n).
        by_torques: A part at no torque, each alone, twice each alone, all (states, 2 m + 2, n).
        identities: What else the answers owe to each other.
    """

    name: str
    mechanism: str
    names: Sequence[str]
    states: str
    values: Mapping[str, np.ndarray]
    sizes: Mapping[str, PartSize]
    symmetry: PartSize | None
    repeated: Mapping[str, np.ndarray]
    failures: Mapping[str, Failure]
    other_speeds: np.ndarray | None = None
    by_torques: Mapping[str, np.ndarray] = field(default_factory=dict)
    identities: Sequence[Identity] = ()

    def make_subject(self, family: str, quantity: str, engine: str = "") -> Subject:
        """The subject of a finding on the equations, of an engine or of themselves alone."""
        key = ComparisonKey(family, self.mechanism, quantity, self.name, engine)
        metric = f"largest difference of an entry over {self.states}, over its natural size"
        return Subject(key, "1", metric, "" if engine else "first principles")


class SelfCheck(NamedTuple):
    """What equations owe to themselves, judged: of which part, and what is wrong if it differs."""

    part: str
    fault: str
    finding: Finding


def make_part_size(sizes: Any, quantity: str, *source: str) -> PartSize:
    """Size of a quantity by the natural sizes of an arm or a robot."""
    entries = sizes.entry_sizes(quantity, *source)
    return PartSize(entries, sizes.tolerance(quantity), sizes.basis(quantity))


def make_second_law(
    size: PartSize, values: Mapping[str, np.ndarray], gravity: Any, force: np.ndarray
) -> Identity:
    """M a + bias + gravity = force, with the acceleration that stands beside them."""
    left = np.einsum("sij,sj->si", values["mass_matrix"], values["acceleration"])
    return Identity(SECOND_LAW, "force", size, left + values["bias"] + gravity, force)


def judge_answers(answers: AnswerSet) -> Iterator[SelfCheck]:
    """Judge what equations owe to themselves; a part that did not answer is a failed check."""
    for part, why in answers.failures.items():
        about = answers.make_subject(OWN, f"answers-{part}")
        yield SelfCheck(part, "", _make_lost_check(about, answers.name, why))
    for identity in _list_identities(answers):
        about = answers.make_subject(OWN, identity.check)
        finding = _judge_safely(about, partial(_judge_identity, answers, identity))
        yield SelfCheck(identity.part, identity.fault, finding)
    if "mass_matrix" in answers.values:
        about, mass = answers.make_subject(OWN, "positive-definite"), answers.values["mass_matrix"]
        finding = _judge_safely(about, partial(_judge_positive, mass))
        yield SelfCheck("mass_matrix", "M is not positive definite", finding)


def judge_engine(
    answers: AnswerSet,
    engine: str,
    engine_values: Mapping[str, np.ndarray | Failure],
    sizes: Mapping[str, PartSize],
    reference_values: Mapping[str, np.ndarray | Failure] | None = None,
    *,
    is_binding: bool = True,
) -> Iterator[Finding]:
    """Compare each part with an engine's.

    reference_values: of the engine from which entries are counted, whose distance from this one is
    allowed on top; is_binding: whether they must agree, or are measured, as at another level.
    """
    for part in (each for each in JUDGED if each in answers.values):
        about: Subject = answers.make_subject(AGAINST, part, engine)
        values: Any = engine_values[part]
        reference: Any = values if reference_values is None else reference_values[part]
        lost = [each for each in (values, reference) if isinstance(each, Failure)]
        if lost:
            yield _make_lost_check(about, engine, lost[0])
            continue
        size, axes = sizes[part], 2 if part == "mass_matrix" else 1
        difference = Identity(part, part, size, answers.values[part], values, axes=axes)
        measured = float(difference.errors.max())
        if not is_binding:
            yield make_measurement(about, measured=measured)
            continue
        among, basis = 0.0, size.basis
        if reference_values is not None:
            between = difference._replace(left=reference)
            among = float(between.errors.max())
            basis = f"{basis}; engines among themselves {among:.2g}"
        yield make_check(
            about,
            measured=measured,
            tolerance=size.tolerance + among,
            basis=basis,
            resolved=among <= MEANINGFUL,
            relative=measured,
            note=_format_places(answers, difference),
        )


def has_engine_conflict(findings: Sequence[Finding]) -> bool:
    """Whether engines judge a part in different ways, so that one of them must be wrong."""
    verdicts: dict[str, set[str]] = {}
    for finding in findings:
        if finding.about.key.family == AGAINST and finding.kind == "check":
            verdicts.setdefault(finding.quantity, set()).add(finding.verdict)
    return any(len(each) > 1 for each in verdicts.values())


def find_idle_motors(answers: AnswerSet, motors: Sequence[int]) -> tuple[int, ...]:
    """The motors, by their coordinate from 0, whose torque changes no answer."""
    if not answers.by_torques:
        return ()
    return tuple(
        motor
        for place, motor in enumerate(motors, 1)
        if all((each[:, place] == each[:, 0]).all() for each in answers.by_torques.values())
    )


def _list_identities(answers: AnswerSet) -> Iterator[Identity]:
    values, sizes = answers.values, answers.sizes
    for part, repeated in answers.repeated.items():
        fault, axes = CHANGES.format(part), values[part].ndim - 1
        sides = sizes[part], values[part], repeated
        yield Identity(f"repeatable-{part}", part, *sides, axes=axes, fault=fault)
    if answers.symmetry is not None:
        sides = answers.symmetry, values["mass_matrix"], values["mass_matrix"].swapaxes(1, 2)
        yield Identity("symmetric", "mass_matrix", *sides, axes=2, fault="M is not symmetric")
    if "bias" in values and answers.other_speeds is not None:
        at_speeds = answers.other_speeds.swapaxes(0, 1)  # at the first states
        bias = values["bias"][: at_speeds.shape[1]]
        expected = np.repeat(bias[None], len(at_speeds), axis=0)
        expected[-1] = 0.0  # at rest
        fault = "the bias is not quadratic in the rates"
        yield Identity("bias-quadratic", "bias", sizes["bias"], at_speeds, expected, fault=fault)
    for part, by_torques in answers.by_torques.items():
        errors, fault = _compute_nonlinearity(by_torques), f"{part} is not linear in the torques"
        name = "linear-in-torques" if part == "force" else f"{part}-linear-in-torques"
        size = sizes[part]
        if size.entries.ndim > 1:  # it was asked at the first states
            size = size._replace(entries=size.entries[: errors.shape[1]])
        yield Identity(name, part, size, errors, np.zeros(1), fault=fault)
    yield from answers.identities


def _compute_nonlinearity(answers: np.ndarray) -> np.ndarray:
    """Deviation from sums of each torque's effect, proportional to it (torques + 1, states, n).

    answers (states, 2 m + 2, n): as ``AnswerSet.by_torques``.
    """
    none, *single, together = answers.swapaxes(0, 1)
    half = len(single) // 2
    each, twice = np.array(single[:half]), np.array(single[half:])
    doubled = twice - none - 2 * (each - none)
    summed = together - none - (each - none).sum(axis=0)
    return np.concatenate([doubled, summed[None]])


def _make_lost_check(about: Subject, what: str, why: Failure) -> Finding:
    make = make_unfinished_check if why.unfinished else make_failed_check
    return make(about, f"{what}: {why}")


def _judge_safely(about: Subject, judge: Callable[[Subject], Finding]) -> Finding:
    """The finding; a failed check of answers for which no comparison can be made."""
    try:
        return judge(about)
    except Exception as error:  # numbers that nobody foresaw stay this check's affair
        return make_failed_check(about, str(failure_from_error(error)))


def _judge_identity(answers: AnswerSet, identity: Identity, about: Subject) -> Finding:
    return make_check(
        about,
        measured=float(identity.errors.max()),
        tolerance=identity.size.tolerance,
        basis=identity.size.basis,
        note=_format_places(answers, identity),
    )


def _format_places(answers: AnswerSet, identity: Identity) -> str:
    """The entries that deviate, in words, the largest deviation first."""
    errors = identity.errors
    indices = sorted(identity.places, key=lambda index: -errors[index])
    places = dict.fromkeys(entry_place(identity.part, index) for index in indices)
    return f"wrong: {list_entries(list(places), answers.names)}" if places else ""


def _judge_positive(mass: np.ndarray, about: Subject) -> Finding:
    """Check that M (states, n, n) has positive eigenvalues at every state."""
    count = sum(not _is_positive(each) for each in mass)
    if count:
        return make_failed_check(about, f"at {count} of {len(mass)} states: {MOTIONLESS}")
    return make_check(about, measured=0.0, tolerance=0.0, basis="every eigenvalue is positive")


def _is_positive(mass: np.ndarray) -> bool:
    """Whether the symmetric part of M (n, n) has positive eigenvalues alone."""
    if not is_usable(mass):
        return False
    return bool(np.linalg.eigvalsh(scale_mass_matrix((mass + mass.T) / 2))[0] > 0)
