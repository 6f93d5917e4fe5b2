"""Modes and poles of the geared models with the teeth in contact, before they are compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import combinations

import numpy as np

from crosscheck.checks import modes, scales
from crosscheck.checks.answers import FORCE_SLOPES, START_MASS
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import Comparison, MissingResult, make_comparison
from crosscheck.planning.sizing import (
    make_bent_start,
    make_rest_scenario,
    make_unequal_gains_scenario,
)
from crosscheck.registry import (
    MODELS,
    find_covering_models,
    find_same_integrator_models,
    select_covering,
    select_with_method,
)
from crosscheck.runner.tasks import Evaluation

POLE_METRIC = "largest relative distance of a pole to the nearest of the other model's forces"
MODE_METRIC = "largest relative distance of a mode to the nearest of the other model"


def plan_linear_comparisons(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Comparisons of modes and poles with the teeth in contact."""
    case = Case(arm, make_rest_scenario(), chosen)
    able = (
        select_with_method("mesh_modes", geared_models(case)) if scales.geared_joints(arm) else ()
    )
    for left, right in combinations(able, 2):
        tasks = [Evaluation(name, case, "mesh_modes") for name in (left, right)]
        key = ComparisonKey("modes", where, "mesh-mode", left, right)
        yield make_comparison(
            Subject(key, "1", MODE_METRIC), tasks, partial(_compare_modes, tasks, [])
        )
    yield from plan_pole_comparisons(where, arm, chosen)
    yield from _plan_locked_stages(where, arm, chosen)
    yield from _plan_stable_steps(where, arm, chosen)


def _plan_stable_steps(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Comparisons of a model's largest stable step with its own poles, teeth at their stiffest."""
    case = Case(arm, make_unequal_gains_scenario(arm), chosen)
    stiff = case._replace(arm=modes.linearize_teeth(arm, scales.stiffness_bound))
    able = (
        *select_covering(find_same_integrator_models(), arm, chosen),
        *find_covering_models("form", arm, chosen),
    )
    for name in able if scales.geared_joints(arm) else ():
        limit = Evaluation(name, case, "largest_stable_step")
        key = ComparisonKey("modes", where, "stable-step", name)
        metric = "largest stable step over that of its poles, or the other way round"
        subject = Subject(key, "1", metric, "its poles")
        yield make_comparison(subject, (limit, *_pole_tasks(name, stiff)), modes.check_step_limit)


def _pole_tasks(name: str, case: Case) -> tuple[Evaluation, Evaluation]:
    """Tasks for a model's inertia and slopes of its force at the start, of which poles are made."""
    return Evaluation(name, case, START_MASS), Evaluation(name, case, FORCE_SLOPES)


def plan_pole_comparisons(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Comparisons of the loop's poles with teeth in contact, by which it is called unstable."""
    start = make_bent_start(len(arm.joints))
    scenario = make_unequal_gains_scenario(arm).model_copy(update={"start": start})
    case = Case(arm, scenario, chosen)
    linear = case._replace(arm=modes.linearize_teeth(arm))
    for left in select_with_method("contact_poles", geared_models(linear)):
        for right in (name for name in geared_models(linear) if name != left):
            tasks = Evaluation(left, case, "contact_poles"), *_pole_tasks(right, linear)
            key = ComparisonKey("modes", where, "contact-poles", left, right)
            yield make_comparison(Subject(key, "1", POLE_METRIC), tasks, modes.check_poles)


def _compare_modes(
    tasks: Sequence[Evaluation],
    closed: Sequence[np.ndarray],
    about: Subject,
    *model_modes: np.ndarray,
) -> Finding:
    """The check of two models' modes, or of one's and those of first principles.

    Raises MissingResult if a model has lost some.
    """
    for task, frequencies in zip(tasks, model_modes, strict=True):
        single = MODELS[task.model].free_planets or task.case.switches.planets == "free"
        planets = [joint.planet_count for joint in task.case.arm.joints if joint.planet_count]
        expected = sum(1 + (count if single else 1) for count in planets)
        if len(frequencies) != expected:
            raise MissingResult(
                f"{task.model}: {len(frequencies)} mesh modes, there must be {expected}"
            )
    few, many = sorted((*closed, *model_modes), key=len)
    return modes.check_modes(about, few, many)


def _plan_locked_stages(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Comparisons of the modes of each geared stage, carrier locked, with first principles."""
    for number, joint in scales.geared_joints(arm):
        case = Case(make_locked_stage(arm, number), make_rest_scenario(), chosen)
        lumped = chosen.planets == "lumped"
        for name in select_with_method("mesh_modes", geared_models(case)):
            tasks = [Evaluation(name, case, "mesh_modes")]
            key = ComparisonKey("modes", where, "locked-stage", name, joint=number + 1)
            closed = modes.closed_form_modes(joint) if lumped else modes.free_modes(joint)
            subject = Subject(key, "1", MODE_METRIC, "closed form")
            yield make_comparison(subject, tasks, partial(_compare_modes, tasks, [closed]))


def make_locked_stage(arm: Arm, number: int) -> Arm:
    """An arm of one geared joint, its link too heavy to move, without weight and friction."""
    free = arm.joints[number].model_copy(update={"friction_N_m_s_per_rad": 0.0})
    link = arm.links[number]
    heavier = {
        name: modes.LOCK * value
        for name, value in link
        if name in ("density_kg_per_m3", "mass_kg", "inertia_kg_m2") and value is not None
    }
    locked = {"joints": (free,), "links": (link.model_copy(update=heavier),)}
    return arm.model_copy(update={**locked, "gravity_m_per_s2": (0.0, 0.0)})


def geared_models(case: Case) -> tuple[str, ...]:
    """Names of the geared models that are about a case."""
    return find_covering_models("geared", case.arm, case.switches)
