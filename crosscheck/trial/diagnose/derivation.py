"""M, bias and weight of bodies whose motion is derived, rightly or with a mistake.

Numbers at many states, and no sums of waves: a mistake of one step, such as a relative rate in a
body's velocity, changes every entry at once, and by waves that belong to none.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.derivation.bodies import Body
from crosscheck.trial.coordinates.differences import fold_rate_pairs
from crosscheck.trial.diagnose.terms.polynomial import Polynomial
from crosscheck.trial.diagnose.terms.values import Values


class MovingBody(NamedTuple):
    """A body at the end of a chain of levers, one along each link, as a derivation has it.

    Its centre goes along axis a by levers[l] cos(places[l] x + phases[a, l]) rates[l] x', added
    up over the links l; it weighs by its mass times the same with ``pulls`` for ``rates``.

    Args:
        mass: In kg.
        inertia: About its centre [kg m^2].
        turn: Row of its angular velocity over the rates x' (n,).
        levers: Of each link [m], (links,).
        phases: Of each lever's velocity along x and y [rad], (2, links).
        axes: How often the velocity along x and y counts in its kinetic energy, (2,).
        places: Rows of the levers' angles over x (links, n).
        rates: Rows of their angular velocities (links, n).
        pulls: Rows of what weight turns (links, n).
    """

    mass: float
    inertia: float
    turn: np.ndarray
    levers: np.ndarray
    phases: np.ndarray
    axes: np.ndarray
    places: np.ndarray
    rates: np.ndarray
    pulls: np.ndarray


RIGHT_PHASES = np.array([[np.pi / 2], [0.0]])  # -sin along x, cos along y


def move_body(body: Body, links: np.ndarray, columns: np.ndarray, values: Values) -> MovingBody:
    """The body as it moves; links (links, n): rows of their angles over x; columns: dq/dx (n, n).

    values: of the arm's symbols.
    """
    levers = np.zeros(len(links))
    levers[: len(body.centre)] = [evaluate_quantity(each, values) for each in body.centre]
    turn = np.array([evaluate_quantity(each, values) for each in body.angle]) @ columns
    phases = np.tile(RIGHT_PHASES, len(links))
    mass, inertia = (evaluate_quantity(each, values) for each in (body.mass, body.inertia))
    return MovingBody(mass, inertia, turn, levers, phases, np.ones(2), links, links, links)


def evaluate_quantity(quantity: Any, values: Values) -> float:
    """A number or polynomial of the arm's symbols."""
    if not isinstance(quantity, Polynomial):
        return float(quantity)
    return float(sum(each.value(values) for each in quantity.monomials))


class Effects(NamedTuple):
    """Contributions of bodies to M (.., K, n, n), dM/dx (.., K, n, n, n), weight (.., K, n)."""

    mass: np.ndarray
    slopes: np.ndarray
    weight: np.ndarray


def compute_effects(
    bodies: Sequence[MovingBody], x: np.ndarray, gravity: np.ndarray, *, with_slopes: bool
) -> Effects:
    """The effects of each body at states x (K, n); gravity (2,): of each body (bodies, 2).

    The slopes are empty where they are not asked for.
    """
    fields = (np.array(each) for each in zip(*bodies, strict=True))
    mass, inertia, turn, levers, phases, axes, places, rates, pulls = fields
    angles = np.einsum("bln,kn->bkl", places, x)[:, :, None] + phases[:, None]
    moving = levers[:, None, None] * np.cos(angles)
    weights = (mass[:, None] * axes)[:, None, :, None]
    jacobian = moving @ rates[:, None]
    total = np.swapaxes(jacobian, 2, 3) @ (weights * jacobian)
    total = total + (inertia[:, None, None] * turn[:, :, None] * turn[:, None, :])[:, None]
    slopes = np.zeros((len(bodies), 0))
    if with_slopes:
        bent = -levers[:, None, None] * np.sin(angles)
        turned = np.einsum("bli,blj->blij", rates, places)
        bent_jacobian = np.einsum("bkal,blij->bkaij", bent, turned, optimize=True)
        half = np.einsum("bkai,bkajm->bkijm", weights * jacobian, bent_jacobian, optimize=True)
        slopes = half + np.swapaxes(half, 2, 3)
    pulled = (moving * (mass[:, None] * gravity)[:, None, :, None]).sum(axis=2)
    return Effects(total, slopes, np.einsum("bkl,bln->bkn", pulled, pulls))


def compute_jacobians(body: MovingBody, x: np.ndarray) -> np.ndarray:
    """A body's velocity over x' at states x (K, n), (K, 2, n)."""
    angles = (x @ body.places.T)[:, None] + body.phases
    jacobians: np.ndarray = (body.levers * np.cos(angles)) @ body.rates
    return jacobians


def derive_rate_terms(slopes: np.ndarray) -> np.ndarray:
    """The bias's coefficients (..., n, n, n), j <= k, of dM/dx (..., n, n, n)."""
    return fold_rate_pairs(slopes - np.moveaxis(slopes, -1, -3) / 2)
