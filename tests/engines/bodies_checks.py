"""Checks that only separate bodies allow: forces on each of them, and joints that stay closed."""

import numpy as np

from crosscheck.checks.answers import sample_states
from crosscheck.findings import ComparisonKey, Finding, Subject, make_check
from crosscheck.models.exudyn.bodies.bodies import ExudynBodies
from crosscheck.models.pinocchio.arm import PinocchioGears

STATES, SEED = 5, 2


def wrenches(model: ExudynBodies, other: PinocchioGears) -> Finding:
    """What the teeth do to every body, with the radial part that no coordinate feels.

    The motors of ``model`` must be at rest.
    """
    rows = [other.model.bodies.index(name) for name in _names(model)]
    states, pairs = sample_states(model.layout, model.arm, STATES, SEED), []
    for t, q, v in zip(*states, strict=True):
        forces = model.body_forces(t, q, v).reshape(-1, 3)
        x, y, _ = model.poses.pose(q).reshape(-1, 3).T
        forces[:, 2] += x * forces[:, 1] - y * forces[:, 0]
        pairs.append((forces, contact_wrenches(other, t, q, v)[rows]))
    off = max(float(abs(one - two).max() / abs(two).max()) for one, two in pairs)
    return _checked("wrenches", off, 1e-10, "that of the states' generalized forces")


def contact_wrenches(model: PinocchioGears, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Force along x and y, and moment about the shoulder, on each of the bodies (bodies, 3)."""
    forces = model.model.contact_wrenches(t, q[model.order], v[model.order])
    # In the plane there is nothing else.
    assert not forces[:, 2:5].any()
    return forces[:, [0, 1, 5]]


def _names(model: ExudynBodies) -> list[str]:
    """The bodies as Pinocchio's model calls them."""
    return [
        name
        for joint, stage in enumerate(model.stages, 1)
        for name in (
            f"joint_{joint}",
            f"sun_{joint}",
            *(f"planet_{joint}_{planet}" for planet in range(1, 1 + len(stage.planets))),
        )
    ]


def joint_gaps(model: ExudynBodies) -> Finding:
    """Do the model's poses, rates and accelerations keep the engine's joints closed?"""
    states = sample_states(model.layout, model.arm, STATES, SEED)
    a = np.random.default_rng(SEED).normal(size=states.q.shape)
    gaps = [model.constraint_residual(*state) for state in zip(states.q, states.v, a, strict=True)]
    widest = float(abs(np.array(gaps)).max())
    return _checked("joints", widest, 1e-12, "roundings of places, rates, accelerations up to 1e2")


def _checked(quantity: str, measured: float, tolerance: float, basis: str) -> Finding:
    key = ComparisonKey("bodies", "planted", quantity, "exudyn:bodies")
    about = Subject(key, "1", f"largest difference over {STATES} random states")
    return make_check(about, measured=measured, tolerance=tolerance, basis=basis)
