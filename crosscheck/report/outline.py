"""Subject of a report on an arm or a robot: its models, quantities and questions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.robot.robot import LEVELS as ROBOT_LEVELS
from crosscheck.models.robot.robot import Robot
from crosscheck.planning.plan import is_the_papers
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
    each; questions: that it answers; topics: what each is about, the title of its card; levels:
    titles; finest: the model that levels are beside;
    truths: what single models are compared with; described: the mechanism in lines; tolerances:
    what is compared, and within which tolerance. Of the page: caption and pose of its scheme;
    scope: of the largest differences; lead, rest: before and behind the levels; unresolved: a
    verdict that only some runs have; has_levels: whether its levels differ.
    """

    name: str
    title: str
    models: Mapping[str, str]
    forms: tuple[str, ...]
    quantities: Mapping[str, str]
    questions: tuple[str, str, str]
    topics: tuple[str, str, str]
    levels: Mapping[str, str]
    finest: str
    truths: str
    described: tuple[str, ...]
    caption: str
    scope: str
    tolerances: Mapping[str, str]
    lead: str = ""
    rest: str = ""
    pose: str = ""
    unresolved: str = ""
    has_levels: bool = True
    is_the_papers: bool = False


def outline_arm(arm: Arm) -> ReportOutline:
    """The outline of the report on an arm."""
    home = engine_of(reference_model())  # the derivation, with rigid models of its own
    derived = [
        name
        for name in model_names("rigid")
        if engine_of(name) == home and MODELS[name].level  # which other engines have too
    ]
    names = (*model_names("form"), reference_model(), *derived)
    has_gears = any(isinstance(joint, Planetary) for joint in arm.joints)
    return ReportOutline(
        name=arm.name,
        title=arm.title,
        models={name: MODELS[name].title for name in names},
        forms=model_names("form"),
        quantities={
            "mass_matrix": "mass matrix",
            "acceleration": "acceleration",
            "theta": "joint angle",
        }
        | ({"F_sp": "mesh force"} if has_gears else {}),
        questions=(
            "Do the equations agree with the engines?",
            "How far is the rigid arm from the geared one?"
            if has_gears
            else "How far is the arm without its motors' inertia from the whole one?",
            TRUST,
        ),
        topics=("Equations", "Rigid arm", "Checks"),
        levels=LEVELS,
        finest=reference_model(),
        truths="first principles, its own records or the arm's file",
        described=arm.described,
        caption="Bent arm.",
        scope="random states of this arm (mass matrix, acceleration: relative) and over its runs.",
        tolerances={
            "values at random states": "1000 ε c of the quantity's size, ε = 2.2e-16,"
            " c its conditioning; at most 1e-10",
            "runs with the same integrator and step": "10 √N (g + ε s): N steps, g the measured"
            " growth of one rounding in the start, s the quantity's size",
            "runs with other integrators": "√(u₁² + u₂²) + ε s √N: u three times the distance from"
            " a run with a coarser step, of each side",
        },
        lead="Largest difference of each rigid level in Pinocchio from the geared arm"
        f" ({reference_model()}) over a run.",
        rest="The remaining difference of coupled comes from the teeth: compliance, backlash,"
        " varying stiffness and profile errors.",
        unresolved="A run whose uncertainty exceeds the size that matters, a hundredth of a mesh's"
        " travel, is unresolved and does not pass.",
        has_levels=not is_rigid_arm(arm),
        is_the_papers=is_the_papers(arm),
    )


def outline_robot(robot: Robot) -> ReportOutline:
    """The outline of the report on a robot."""
    levels = {str(level): ROBOT_LEVELS[level] for level in robot.levels}
    return ReportOutline(
        name=robot.name,
        title=robot.title,
        models={f"{reference_engine()}:{level}": title for level, title in levels.items()},
        forms=(),
        quantities={
            "mass_matrix": "mass matrix",
            "forward_dynamics": "acceleration",
            "tip": "tip",
            "run": "coordinates in runs",
        },
        questions=(
            "Do the engines agree?",
            "How far is each level from the most detailed one?",
            TRUST,
        ),
        topics=("Engines", "Without rotors", "Checks"),
        levels=levels,
        finest=f"{reference_engine()}:{robot.levels[-1]}",
        truths="first principles",
        described=robot.described,
        caption="All coordinates zero.",
        pose="In the picture all coordinates are zero, and joints are counted from 1.",
        scope="random states, and over short runs, each as a part of its quantity's natural size.",
        tolerances={
            "values at random states, runs in equal steps": "1e-10 of the quantity's natural size,"
            " by Cauchy and Schwarz; where M is solved with, 1000 ε κ if that is more,"
            " ε = 2.2e-16, κ its condition number",
            "a model with its own slopes": "1e-10 of the terms that are summed; differences of"
            " order 8 leave 3e-12",
            "energy over a free motion": "1e-10 of its size, and what the last halving of the step"
            " changed",
        },
        lead="Of motors' torques rigid gears, coupled, are the most detailed level.",
    )
