"""What equations of motion owe to themselves: blame that needs no reference."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.invariants import SYMMETRY
from crosscheck.checks.states import scaled, usable
from crosscheck.findings import About, Finding, checked, failed
from crosscheck.trial.judge.places import EntryPlace, deviations, place_of
from crosscheck.trial.judge.sizes import NaturalSizes


def symmetric(
    about: About, mass: np.ndarray, sizes: NaturalSizes
) -> tuple[Finding, list[EntryPlace]]:
    """M (count, n, n) equals its transpose at every state."""
    if not all(usable(matrix) for matrix in mass):
        return failed(about, "the diagonal is not positive at every state"), _bad_diagonal(mass)
    size = np.sqrt(np.einsum("kii,kjj->kij", mass, mass)).max(axis=0)
    apart = deviations(mass, mass.swapaxes(1, 2), size)
    tolerance = SYMMETRY + sizes.written("mass_matrix")
    wrong = [EntryPlace("mass_matrix", i, j) for i, j in np.argwhere(apart > tolerance) if i < j]
    basis = "rounding of the entries' natural sizes"
    measured = float(apart.max())
    return checked(about, measured=measured, tolerance=tolerance, basis=basis), wrong


def _bad_diagonal(mass: np.ndarray) -> list[EntryPlace]:
    lowest = np.einsum("kii->ki", mass).min(axis=0)
    return [EntryPlace("mass_matrix", int(i), int(i)) for i in np.flatnonzero(~(lowest > 0))]


def positive(about: About, mass: np.ndarray) -> Finding:
    """The least eigenvalue of M (count, n, n), ones on its diagonal, is positive at every state."""
    if not all(usable(matrix) for matrix in mass):
        return failed(about, "the diagonal is not positive at every state")
    symmetric_part = (mass + mass.swapaxes(1, 2)) / 2
    lowest = [float(np.linalg.eigvalsh(scaled(matrix)).min()) for matrix in symmetric_part]
    state = int(np.argmin(lowest))
    if lowest[state] <= 0:
        note = f"not positive definite at state {state + 1} of {len(mass)}: {lowest[state]:.3g}"
        return failed(about, note)
    return checked(about, measured=0.0, tolerance=0.0, basis="every eigenvalue is positive")


def repeatable(
    about: About, quantity: str, answers: np.ndarray, again: np.ndarray, sizes: NaturalSizes
) -> tuple[Finding, list[EntryPlace]]:
    """The same question at the same states (count, ...) has the same answer."""
    return _judged(about, quantity, deviations(answers, again, sizes.of(quantity)), sizes)


def quadratic(
    about: About, bias: np.ndarray, at_speeds: np.ndarray, sizes: NaturalSizes
) -> tuple[Finding, list[EntryPlace]]:
    """h(x, s u) = s^2 h(x, u) for s = -1 and 2, and h(x, 0) = 0.

    bias (count, n); at_speeds (count, speeds + 1, n): h(x, s u) / s^2, then h(x, 0).
    """
    expected = np.repeat(bias[:, None], at_speeds.shape[1], axis=1)
    expected[:, -1] = 0.0
    apart = (np.abs(at_speeds - expected) / sizes.bias).max(axis=(0, 1))
    return _judged(about, "bias", apart, sizes)


def from_inertia(
    about: About, terms: np.ndarray, christoffel: np.ndarray, sizes: NaturalSizes
) -> tuple[Finding, list[EntryPlace]]:
    """A bias's terms (count, n, n, n) against those that its own M demands."""
    return _judged(about, "rate_terms", deviations(terms, christoffel, sizes.rate_terms), sizes)


def linear_in_torques(
    about: About, answers: np.ndarray, sizes: NaturalSizes
) -> tuple[Finding, list[EntryPlace]]:
    """What torques do to the force is proportional to each, and adds up.

    answers (count, 2 m + 2, n): at no torque, each alone, twice each alone, all together.
    """
    joints = (answers.shape[1] - 2) // 2
    none, each = answers[:, :1], answers[:, 1 : 1 + joints]
    twice, together = answers[:, 1 + joints : -1], answers[:, -1:]
    doubled = twice - none - 2 * (each - none)
    summed = together - none - (each - none).sum(axis=1, keepdims=True)
    apart = np.abs(np.concatenate([doubled, summed], axis=1)).max(axis=(0, 1)) / sizes.force
    return _judged(about, "force", apart, sizes)


def second_law(
    about: About,
    parts: tuple[np.ndarray, np.ndarray, np.ndarray],
    acceleration: np.ndarray,
    sizes: NaturalSizes,
) -> tuple[Finding, list[EntryPlace]]:
    """M a + h = f of the acceleration that was handed over beside them.

    parts: M (count, n, n), bias and force (count, n).
    """
    mass, bias, force = parts
    left = np.einsum("kij,kj->ki", mass, acceleration) + bias
    return _judged(about, "force", deviations(left, force, sizes.force), sizes)


def inverse_dynamics(
    about: About, answers: np.ndarray, sizes: NaturalSizes
) -> tuple[Finding, list[EntryPlace]]:
    """Inverse dynamics is M a + h, for any a and u together.

    answers (count, 3, n): as handed over; M a + h; a.
    """
    one, other, a = answers.swapaxes(0, 1)
    size = sizes.bias + sizes.mass @ np.abs(a).max(axis=0)
    return _judged(about, "bias", deviations(one, other, size), sizes)


def _judged(
    about: About, quantity: str, apart: np.ndarray, sizes: NaturalSizes
) -> tuple[Finding, list[EntryPlace]]:
    tolerance = sizes.tolerance(quantity)
    beyond = np.argwhere(~(apart <= tolerance))
    wrong = [place_of(quantity, tuple(index)) for index in beyond.tolist()]
    measured = float(apart.max())
    found = checked(about, measured=measured, tolerance=tolerance, basis=sizes.basis(quantity))
    return found, wrong
