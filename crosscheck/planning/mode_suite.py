"""Modes and poles of the geared models with the teeth in contact, before they are compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import combinations

import numpy as np

from crosscheck.checks import modes, scales
from crosscheck.checks.answers import FORCE_SLOPES, START_MASS
from crosscheck.findings import About, Finding, Key
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Switches
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import Comparison, Unavailable, answered
from crosscheck.planning.sizing import at_rest, bent_start, unequal_gains
from crosscheck.registry import MODELS, about, covering, promising, same_integrator
from crosscheck.runner.tasks import Evaluation

POLE_METRIC = "largest relative distance of a pole to the nearest of the other model's forces"
MODE_METRIC = "largest relative distance of a mode to the nearest of the other model"


def linearised(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Comparisons of modes and poles with the teeth in contact."""
    case = Case(arm, at_rest(), chosen)
    able = promising("mesh_modes", geared_models(case)) if scales.geared(arm) else ()
    for left, right in combinations(able, 2):
        tasks = [Evaluation(name, case, "mesh_modes") for name in (left, right)]
        key = Key("modes", where, "mesh-mode", left, right)
        yield answered(About(key, "1", MODE_METRIC), tasks, partial(_same_modes, tasks, []))
    yield from pole_comparisons(where, arm, chosen)
    yield from _locked_stages(where, arm, chosen)
    yield from _stable_steps(where, arm, chosen)


def _stable_steps(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Comparisons of a model's largest stable step with its own poles, teeth at their stiffest."""
    case = Case(arm, unequal_gains(arm), chosen)
    stiff = case._replace(arm=modes.linear_teeth(arm, scales.largest_of))
    able = *about(same_integrator(), arm, chosen), *covering("form", arm, chosen)
    for name in able if scales.geared(arm) else ():
        limit = Evaluation(name, case, "largest_stable_step")
        key = Key("modes", where, "stable-step", name)
        metric = "largest stable step over that of its poles, or the other way round"
        told = About(key, "1", metric, "its poles")
        yield answered(told, (limit, *_system(name, stiff)), modes.step_follows)


def _system(name: str, case: Case) -> tuple[Evaluation, Evaluation]:
    """Tasks for a model's inertia and slopes of its force at the start, of which poles are made."""
    return Evaluation(name, case, START_MASS), Evaluation(name, case, FORCE_SLOPES)


def pole_comparisons(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Comparisons of the loop's poles with teeth in contact, by which it is called unstable."""
    start = bent_start(len(arm.joints))
    scenario = unequal_gains(arm).model_copy(update={"start": start})
    case = Case(arm, scenario, chosen)
    linear = case._replace(arm=modes.linear_teeth(arm))
    for left in promising("contact_poles", geared_models(linear)):
        for right in (name for name in geared_models(linear) if name != left):
            tasks = Evaluation(left, case, "contact_poles"), *_system(right, linear)
            key = Key("modes", where, "contact-poles", left, right)
            yield answered(About(key, "1", POLE_METRIC), tasks, modes.poles_follow)


def _same_modes(
    tasks: Sequence[Evaluation], closed: Sequence[np.ndarray], about: About, *found: np.ndarray
) -> Finding:
    """The check of two models' modes, or of one's and those of first principles.

    Raises Unavailable if a model has lost some.
    """
    for task, own in zip(tasks, found, strict=True):
        single = MODELS[task.model].free_planets or task.case.switches.planets == "free"
        planets = [joint.planet_count for joint in task.case.arm.joints if joint.planet_count]
        expected = sum(1 + (count if single else 1) for count in planets)
        if len(own) != expected:
            raise Unavailable(f"{task.model}: {len(own)} mesh modes, there must be {expected}")
    few, many = sorted((*closed, *found), key=len)
    return modes.modes_among(about, few, many)


def _locked_stages(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Comparisons of the modes of each geared stage, carrier locked, with first principles."""
    for number, joint in scales.geared(arm):
        case = Case(locked_stage(arm, number), at_rest(), chosen)
        lumped = chosen.planets == "lumped"
        for name in promising("mesh_modes", geared_models(case)):
            tasks = [Evaluation(name, case, "mesh_modes")]
            key = Key("modes", where, "locked-stage", name, joint=number + 1)
            closed = modes.closed_form_modes(joint) if lumped else modes.free_modes(joint)
            told = About(key, "1", MODE_METRIC, "closed form")
            yield answered(told, tasks, partial(_same_modes, tasks, [closed]))


def locked_stage(arm: Arm, number: int) -> Arm:
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
    return covering("geared", case.arm, case.switches)
