"""The rigid arm in the experiments of geared ones: what they are compared with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.meshes import change_meshes
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.models.experiment.scenario import Scenario, Start
from crosscheck.models.loading import Case
from crosscheck.models.robot.robot import RIGID
from crosscheck.registry import MODELS, build, find_level_models
from crosscheck.studies.members.cases import ArmCase, MemberCase, RobotMemberCase

STEP_RATIO = 10  # steps of the geared arm in one of the rigid arm, which is smooth

# In place of all meshes, which a rigid arm has none of.
ANY_MESH = Mesh(
    stiffness=SineStiffness(law="sine", mean_N_per_m=1.0, amplitude_N_per_m=0.0),
    backlash_m=0.0,
    tooth_error_m=0.0,
    damping_ratio=0.0,
)


def simulate_rigid_angles(level: str, cases: Sequence[MemberCase]) -> tuple[np.ndarray, np.ndarray]:
    """Angles [rad] of unlike rigid models, (models, records, joints), and each case's, (cases,).

    They are on the geared runs' own recording grid; nan where a run diverged. Members that differ
    in their meshes alone share a model.
    """
    from crosscheck.analytic.ensemble import group_models
    from crosscheck.analytic.robot.ensemble import group_robots

    places: dict[object, int] = {}
    models, whose = list[Any](), list[int]()
    for case in cases:
        key, build_model = _find_rigid_model(level, case)
        if key not in places:
            places[key] = len(models)
            models.append(build_model())
        whose.append(places[key])
    first = cases[0]
    groups = (group_models if isinstance(first, ArmCase) else group_robots)(models)
    scenario, joints = models[0].scenario, len(first.mechanism.joints)
    angles = np.full((len(models), scenario.steps // scenario.stride + 1, joints), np.nan)
    for group in groups:
        theta = np.concatenate([chunk.theta for chunk in group.chunks()])
        alive = np.isnan(group.diverged_s)
        angles[np.array(group.members)[alive]] = np.moveaxis(theta, -1, 0)[alive]
    return angles, np.array(whose)


def _find_rigid_model(level: str, case: MemberCase) -> tuple[object, Callable[[], Any]]:
    """Key of the rigid model of a member, and the function that builds it."""
    from crosscheck.analytic.robot.runs import RobotMember

    if isinstance(case, RobotMemberCase):  # alike where no number of their equations differs
        (chosen,) = (each for each in RIGID if each == level)
        model = RobotMember(case.robot, chosen, _smooth_scenario(case.scenario))
        numbers = frozenset(model.equations.numbers.items())
        return (numbers, model.equations.structure, model.scenario), lambda: model
    name = next(name for name in find_level_models(level) if MODELS[name].order is not None)
    smooth = remove_meshes(case)
    return smooth, partial(build, name, *smooth)


def remove_meshes(case: Case) -> tuple[Arm, Scenario]:
    """Arm and experiment with nothing left that is a mesh's own, in steps for a smooth motion."""
    return change_meshes(case.arm, lambda mesh: ANY_MESH), _smooth_scenario(case.scenario)


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
