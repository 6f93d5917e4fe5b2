"""Starts that differ by next to nothing: with backlash an arm may end elsewhere from each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crosscheck.models.experiment.scenario import Scenario, expand_to_joints, planet_offsets
from crosscheck.models.loading import Case

PERTURBATION_M = 1e-12  # perturbation of every mesh displacement in a seeded start [m]


def perturb_start(case: Case, seed: int, size_m: float = PERTURBATION_M) -> Case:
    """The case with every mesh displacement of its start changed by up to ``size_m``, by a seed.

    If planets are free, every planet's own displacement is changed too. All is added to what the
    scenario says of the start.
    """
    free = case.switches.planets == "free"
    counts = [count if free else 0 for count in case.arm.planet_counts]
    return case._replace(scenario=perturb_scenario(case.scenario, counts, seed, size_m))


def perturb_scenario(
    scenario: Scenario, planets: Sequence[int], seed: int, size_m: float
) -> Scenario:
    """The scenario whose start's offsets of both meshes, and planets, differ by up to ``size_m``.

    planets: of each joint that move by themselves.
    """
    joints, start, generator = len(planets), scenario.start, np.random.default_rng(seed)
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
    return scenario.model_copy(update={"start": start.model_copy(update=changed)})


def _sum(given: Sequence[float], more: np.ndarray) -> tuple[float, ...]:
    return tuple(float(a + b) for a, b in zip(given, more, strict=True))
