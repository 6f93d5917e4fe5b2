"""State by state: do two models give the same M, bias, force and acceleration?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from crosscheck.findings import Finding, checked, failed, measured_only
from models.arm import Arm
from models.interface import Model

EPS = np.finfo(float).eps
# Rounding of a few hundred operations, times how badly conditioned they are; but never looser
# than a tenth of a billionth.
ROUNDINGS = 1000
LOOSEST = 1e-10


class States(NamedTuple):
    """t (count,) [s]; q, v (count, n) in a model's coordinates."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray


class Scale(NamedTuple):
    """What a difference is measured against: natural sizes (n,), tolerance and its basis."""

    natural: np.ndarray
    tolerance: float
    basis: str


def random_states(coordinates: Sequence[str], arm: Arm, count: int, seed: int) -> States:
    """States on both flanks, in free play, at any pose, as brisk as the paper's runs."""
    generator = np.random.default_rng(seed)
    play = 3 * max(*(joint.backlash_m for joint in arm.joints), 2e-5)
    angular = np.array([name.startswith("theta") for name in coordinates])
    q_size, v_size = np.where(angular, np.pi, play), np.where(angular, 3.0, 0.1)
    shape = (count, len(coordinates))
    return States(
        generator.uniform(0, 2, count),
        generator.uniform(-1, 1, shape) * q_size,
        generator.uniform(-1, 1, shape) * v_size,
    )


def compare_states(
    case: str, models: Sequence[Model], quantities: Sequence[str], count: int, seed: int
) -> Iterator[Finding]:
    """A Finding per pair of models and quantity that both can give.

    The models must share their coordinates. Each component is measured against its own root mean
    square over the states, so that small components count as much as large ones.
    """
    states = random_states(models[0].coordinates, models[0].arm, count, seed)
    for quantity in quantities:
        able = [model for model in models if quantity in model.abilities]
        values = {model.name: _evaluated(model, quantity, states) for model in able}
        scale = _scale_or_reason(able[0], quantity, states)
        for left, right in combinations(able, 2):
            yield _compared(case, quantity, left.name, right.name, values, scale, count)


def measure_states(
    case: str, left: Model, right: Model, quantities: Sequence[str], count: int, seed: int
) -> Iterator[Finding]:
    """Like compare_states, for models that are known to differ."""
    states = random_states(left.coordinates, left.arm, count, seed)
    for quantity in quantities:
        one, other = (_evaluated(model, quantity, states) for model in (left, right))
        fields = _fields(case, quantity, left.name, right.name, count)
        if isinstance(one, Exception) or isinstance(other, Exception):
            yield failed(note="a model raised an exception", **fields)
            continue
        scale = _scale(left, quantity, states)
        measured = relative_difference(one, other, quantity, scale)
        yield measured_only(measured=measured, basis="", relative=measured, **fields)


def _evaluated(model: Model, quantity: str, states: States) -> np.ndarray | Exception:
    try:
        return np.array([evaluate(model, quantity, *state) for state in zip(*states, strict=True)])
    except Exception as error:  # a model that raises is a failed check, not a crash
        return error


def evaluate(model: Model, quantity: str, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """One of a model's four state functions at one state."""
    if quantity == "mass_matrix":
        return model.mass_matrix(q)
    if quantity == "bias":
        return model.bias(q, v)
    if quantity == "generalized_force":
        return model.generalized_force(t, q, v)
    return model.acceleration(t, q, v)


def _compared(
    case: str,
    quantity: str,
    left: str,
    right: str,
    values: dict[str, np.ndarray | Exception],
    scale: Scale | Exception,
    count: int,
) -> Finding:
    fields = _fields(case, quantity, left, right, count)
    one, other = values[left], values[right]
    if isinstance(one, Exception) or isinstance(other, Exception) or isinstance(scale, Exception):
        raised = next(side for side in (one, other, scale) if isinstance(side, Exception))
        return failed(note=f"{type(raised).__name__}: {raised}", **fields)
    if one.shape != other.shape:
        return failed(note=f"shapes differ: {one.shape}, {other.shape}", **fields)
    measured = relative_difference(one, other, quantity, scale)
    return checked(
        measured=measured,
        tolerance=scale.tolerance,
        basis=scale.basis,
        relative=measured,
        **fields,
    )


def _fields(case: str, quantity: str, left: str, right: str, count: int) -> dict[str, Any]:
    return {
        "id": f"states/{case}/{quantity}/{left}~{right}",
        "quantity": quantity,
        "unit": "1",
        "left": left,
        "right": right,
        "metric": f"largest relative difference over {count} random states",
    }


def relative_difference(one: np.ndarray, other: np.ndarray, quantity: str, scale: Scale) -> float:
    """Largest difference, component by component, over that component's size; nan if any is nan.

    Arrays (count, n) or, for mass matrices, (count, n, n), where M_ij's size is sqrt(M_ii M_jj).
    """
    if not (np.isfinite(one).all() and np.isfinite(other).all()):
        return np.nan
    if quantity == "mass_matrix":
        diagonal = np.sqrt(np.abs(np.einsum("kii->ki", one)))
        size = diagonal[:, :, None] * diagonal[:, None, :]
    else:
        size = component_sizes(one, scale.natural)
    return float((np.abs(one - other) / size).max())


def component_sizes(values: np.ndarray, natural: np.ndarray) -> np.ndarray:
    """Root mean square of each component, (n,), of values (count, n).

    A component that vanishes at all states (no centrifugal force on a mesh, none at all on an arm
    of one joint) has no size of its own: it gets its natural one.
    """
    own = np.sqrt((values**2).mean(axis=0))
    return np.where(own > ROUNDINGS * EPS * natural, own, natural)


def _natural_sizes(model: Model, quantity: str, states: States) -> np.ndarray:
    """What the arm's inertia and motion make of each component, (n,), or for M of its diagonal.

    With m the diagonal of M and w the joint rates: a centrifugal force is of size sqrt(m_i m) w^2,
    m the largest of the joints'; a force of size sqrt(m_i) and an acceleration of 1 / sqrt(m_i)
    times what the model's other components share.
    """
    inertia = np.diag(model.mass_matrix(states.q[0]))
    if not (inertia > 0).all():
        raise ValueError(f"{model.name}: mass matrix with a diagonal that is not positive")
    angular = np.array([name.startswith("theta") for name in model.coordinates])
    if quantity in ("mass_matrix", "bias"):
        rates = states.v[:, angular]
        return np.sqrt(inertia * inertia[angular].max()) * float((rates**2).mean())
    weight = np.sqrt(inertia) if quantity == "generalized_force" else 1 / np.sqrt(inertia)
    values = np.array([evaluate(model, quantity, *s) for s in zip(*states, strict=True)])
    shared = float(np.sqrt(((values / weight) ** 2).mean()))
    return weight * (shared or 1.0)


def _scale_or_reason(model: Model, quantity: str, states: States) -> Scale | Exception:
    try:
        return _scale(model, quantity, states)
    except Exception as error:  # a model that raises is a failed check
        return error


def _scale(model: Model, quantity: str, states: States) -> Scale:
    conditioning, reason = 1.0, "1"
    if quantity in ("generalized_force", "acceleration"):
        conditioning = _play_conditioning(model.arm, model.coordinates, states)
        reason = f"{conditioning:.0f} (arcs of the gears against the play between their teeth)"
    if quantity == "acceleration":
        inverse = _inverse_conditioning(model, states)
        conditioning *= inverse
        reason += f" x {inverse:.0f} (scaled mass matrix)"
    tolerance = min(LOOSEST, ROUNDINGS * EPS * conditioning)
    basis = f"{ROUNDINGS} eps x conditioning {reason}, at most {LOOSEST:g}"
    return Scale(_natural_sizes(model, quantity, states), tolerance, basis)


def _play_conditioning(arm: Arm, coordinates: Sequence[str], states: States) -> float:
    """A mesh displacement is a small difference of large arcs, in a model that turns its gears."""
    mesh = [name.startswith("x_") for name in coordinates]
    if not any(mesh):
        return 1.0
    pitch = max(joint.module_m * joint.ring_teeth / 2 for joint in arm.joints)
    arcs = pitch * np.abs(states.q[:, ~np.array(mesh)]).max()
    return float(arcs / np.sqrt((states.q[:, mesh] ** 2).mean()))


def _inverse_conditioning(model: Model, states: States) -> float:
    mass = model.mass_matrix(states.q[0])
    scale = 1 / np.sqrt(np.abs(np.diag(mass)))
    return float(np.linalg.cond(mass * scale[:, None] * scale))
