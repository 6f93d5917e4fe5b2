"""Checks that only separate bodies allow: forces on each of them, and joints that stay closed."""

import numpy as np

from crosscheck.checks.answers import sample_states
from crosscheck.findings import ComparisonKey, Finding, Subject, make_check
from crosscheck.models.exudyn.bodies.bodies import ExudynBodies
from crosscheck.models.pinocchio.gears import PinocchioGears

STATES, SEED = 5, 2


def wrenches(model: ExudynBodies, other: PinocchioGears) -> Finding:
    """What the teeth do to every body, with the radial part that no coordinate feels.

    The motors of ``model`` must be at rest.
    """
    rows = [other.bodies.index(name) for name in _names(model)]
    states = zip(*sample_states(model.layout, model.arm, STATES, SEED), strict=True)
    pairs = [
        (model.body_forces(*state).reshape(-1, 3), other.contact_wrenches(*state)[rows])
        for state in states
    ]
    off = max(float(abs(one - two).max() / abs(two).max()) for one, two in pairs)
    return _checked("wrenches", off, 1e-10, "that of the states' generalized forces")


def _names(model: ExudynBodies) -> list[str]:
    """The bodies as Pinocchio's model calls them."""
    return [
        name
        for joint, stage in enumerate(model.stages, 1)
        for name in (
            f"link_{joint}",
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
