"""The rigid arm in the experiments of geared ones, for comparison."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from crosscheck.mechanisms import supply
from crosscheck.models.experiment.scenario import Scenario, Start
from crosscheck.studies.members.cases import MemberCase, group_cases

STEP_RATIO = 10  # steps of the geared arm in one of the rigid arm, which is smooth


def simulate_rigid_angles(level: str, cases: Sequence[MemberCase]) -> tuple[np.ndarray, np.ndarray]:
    """Angles [rad] of distinct rigid models, (models, records, joints), and the model of each case.

    They are on the geared runs' own recording grid; nan where a run diverged. Members that differ
    in their meshes alone share a model.
    """
    places: dict[object, int] = {}
    models, whose = list[Any](), list[int]()
    find_rigid_model = supply("find_rigid_model", cases[0].mechanism.section)
    for case in cases:
        key, build_model = find_rigid_model(case, level, _smooth_scenario(case.scenario))
        if key not in places:
            places[key] = len(models)
            models.append(build_model())
        whose.append(places[key])
    scenario, joints = models[0].scenario, len(cases[0].planet_counts)
    angles = np.full((len(models), scenario.steps // scenario.stride + 1, joints), np.nan)
    for group in group_cases(cases, models):
        theta = np.concatenate([chunk.theta for chunk in group.chunks()])
        alive = np.isnan(group.diverged_s)
        angles[np.array(group.members)[alive]] = np.moveaxis(theta, -1, 0)[alive]
    return angles, np.array(whose)


def _smooth_scenario(scenario: Scenario) -> Scenario:
    """The experiment with nothing of meshes, in steps for a smooth motion."""
    longer = next(n for n in range(STEP_RATIO, 0, -1) if scenario.stride % n == 0)
    given = {name: getattr(scenario.start, name) for name in ("theta_rad", "theta_dot_rad_per_s")}
    changed = {
        "step_s": scenario.step_s * longer,
        "record_every": scenario.stride // longer,
        "start": Start(**given),
    }
    return scenario.model_copy(update=changed)
