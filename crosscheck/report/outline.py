"""Subject of a report on an arm or a robot: its models, quantities and questions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.loading import is_the_papers
from crosscheck.models.robot.robot import LEVELS as ROBOT_LEVELS
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import (
    LEVELS,
    MODELS,
    engine_of,
    is_rigid_arm,
    model_names,
    reference_engine,
    reference_model,
)

TRUST = "Can I trust this?"


@dataclass(frozen=True)
class ReportOutline:
    """Models, quantities and questions of a report.

    models: titles by name of the models that are compared with other engines', one a row; forms:
    those of them that are only measured; quantities: their names by that of a Finding, a column
    each; questions: that it answers; topic: of the second one, the title of its card; levels:
    titles; finest: the model that levels are beside; truths: what single models are compared with;
    has_levels: whether its levels differ.
    """

    name: str
    models: Mapping[str, str]
    forms: tuple[str, ...]
    quantities: Mapping[str, str]
    questions: tuple[str, str, str]
    topic: str
    levels: Mapping[str, str]
    finest: str
    truths: str
    has_levels: bool = True
    is_the_papers: bool = False


def outline_arm(arm: Arm) -> ReportOutline:
    """The outline of the report on an arm."""
    home = engine_of(reference_model())  # the derivation, with rigid models of its own
    derived = [n for n in model_names("rigid") if engine_of(n) == home]
    names = (*model_names("form"), reference_model(), *derived)
    quantities = {"mass_matrix": "mass matrix", "acceleration": "acceleration"}
    quantities["theta"] = "joint angle"
    rigid = "How far is the arm without its motors' inertia from the whole one?"
    if any(isinstance(joint, Planetary) for joint in arm.joints):
        quantities["F_sp"] = "mesh force"
        rigid = "How far is the rigid arm from the geared one?"
    return ReportOutline(
        name=arm.name,
        models={name: MODELS[name].title for name in names},
        forms=model_names("form"),
        quantities=quantities,
        questions=("Do the equations agree with the engines?", rigid, TRUST),
        topic="Rigid arm",
        levels=LEVELS,
        finest=reference_model(),
        truths="first principles, its own records or the arm's file",
        has_levels=not is_rigid_arm(arm),
        is_the_papers=is_the_papers(arm),
    )


def outline_robot(robot: Robot) -> ReportOutline:
    """The outline of the report on a robot."""
    levels = {str(level): ROBOT_LEVELS[level] for level in robot.levels}
    quantities = {"mass_matrix": "mass matrix", "forward_dynamics": "acceleration", "tip": "tip"}
    finest = "How far is each level from the most detailed one?"
    return ReportOutline(
        name=robot.name,
        models={f"{reference_engine()}:{level}": title for level, title in levels.items()},
        forms=(),
        quantities={**quantities, "run": "coordinates in runs"},
        questions=("Do the engines agree?", finest, TRUST),
        topic="Without rotors",
        levels=levels,
        finest=f"{reference_engine()}:{robot.levels[-1]}",
        truths="first principles",
        has_levels=len(levels) > 1,
    )
