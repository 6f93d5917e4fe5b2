"""Starts that differ by next to nothing: with backlash an arm may end elsewhere from each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crosscheck.models.experiment.scenario import Start, expand_to_joints, planet_offsets
from crosscheck.models.loading import Case

PERTURBATION_M = 1e-12  # perturbation of every mesh displacement in a seeded start [m]


def perturb_start(case: Case, seed: int, size_m: float = PERTURBATION_M) -> Case:
    """The case with every mesh displacement of its start changed by up to ``size_m``, by a seed.

    If planets are free, every planet's own displacement is changed too. All is added to what the
    scenario says of the start.
    """
    generator = np.random.default_rng(seed)
    start = case.scenario.start
    free = case.switches.planets == "free"
    counts = [joint.planet_count if free else 0 for joint in case.arm.joints]
    update = perturb_offsets(start, counts, generator, size_m)
    moved = start.model_copy(update=update)
    return case._replace(scenario=case.scenario.model_copy(update={"start": moved}))


def perturb_offsets(
    start: Start, planets: Sequence[int], generator: np.random.Generator, size_m: float
) -> dict[str, object]:
    """Fields of a start whose offsets of both meshes, and planets, differ by up to ``size_m``.

    planets: of each joint that move by themselves.
    """
    joints = len(planets)
    sun, ring = size_m * generator.uniform(-1, 1, (2, joints))
    changed: dict[str, object] = {
        "sun_planet_offset_m": _sum(expand_to_joints(start.sun_planet_offset_m, joints), sun),
        "planet_ring_offset_m": _sum(expand_to_joints(start.planet_ring_offset_m, joints), ring),
    }
    if any(planets):
        displacements = [size_m * generator.uniform(-1, 1, count) for count in planets]
        changed["planet_offset_m"] = tuple(
            _sum(planet_offsets(start, joint, planets[joint]), displacements[joint])
            for joint in range(joints)
        )
    return changed


def _sum(given: Sequence[float], more: np.ndarray) -> tuple[float, ...]:
    return tuple(float(a + b) for a, b in zip(given, more, strict=True))
