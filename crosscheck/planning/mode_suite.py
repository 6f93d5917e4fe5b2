"""Modes and poles of the geared models with the teeth in contact, before they are compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import combinations

import numpy as np

from crosscheck.checks import modes, poles, scales
from crosscheck.checks.answers import FORCE_SLOPES, START_MASS
from crosscheck.findings import About, Finding, Key
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Start, Switches
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import Comparison, Results, Unavailable
from crosscheck.planning.sizing import at_rest, unequal_gains
from crosscheck.registry import MODELS, about, covering, promising, same_integrator
from crosscheck.runner.tasks import Evaluation

POLE_METRIC = "largest relative distance of a pole to the nearest of the other model's forces"
MODE_METRIC = "largest relative distance of a mode to the nearest of the other model"


def linearised(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Modes and poles with the teeth in contact."""
    yield from mode_comparisons(where, arm, chosen)
    yield from pole_comparisons(where, arm, chosen)
    yield from _locked_stages(where, arm, chosen)
    yield from _stable_steps(where, arm, chosen)


def _stable_steps(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """The limit that a model gives its own steps, against its own poles with the stiffest teeth."""
    case = Case(arm, unequal_gains(arm), chosen)
    stiff = case._replace(arm=poles.linear_teeth(arm, scales.largest_of))
    able = *about(same_integrator(), arm, chosen), *covering("form", arm, chosen)
    for name in able if scales.geared(arm) else ():
        limit = Evaluation(name, case, "largest_stable_step")
        system = Evaluation(name, stiff, START_MASS), Evaluation(name, stiff, FORCE_SLOPES)
        key = Key("modes", where, "stable-step", name)
        tasks = (limit, *system)
        metric = "largest stable step over that of its poles, or the other way round"
        yield Comparison(About(key, "1", metric, "its poles"), tasks, partial(_same_step, tasks))


def _same_step(tasks: Sequence[Evaluation], about: About, results: Results) -> Finding:
    limit, mass, slopes = (results.need(task) for task in tasks)
    return poles.step_follows(about, float(limit), mass, slopes)


def mode_comparisons(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Mesh modes of every pair of models that have them."""
    case = Case(arm, at_rest(), chosen)
    able = promising("mesh_modes", _geared(case)) if scales.geared(arm) else ()
    for left, right in combinations(able, 2):
        tasks = tuple(Evaluation(name, case, "mesh_modes") for name in (left, right))
        key = Key("modes", where, "mesh-mode", left, right)
        yield Comparison(About(key, "1", MODE_METRIC), tasks, partial(_same_modes, tasks))


def pole_comparisons(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """Poles of the loop with the teeth in contact, by which experiments are called unstable."""
    bent = Start(theta_rad=tuple(0.4 - 0.7 * number for number in range(len(arm.joints))))
    scenario = unequal_gains(arm).model_copy(update={"start": bent})
    case = Case(arm, scenario, chosen)
    linear = case._replace(arm=poles.linear_teeth(arm))
    for left in promising("contact_poles", _geared(linear)):
        for right in (name for name in _geared(linear) if name != left):
            own = Evaluation(left, case, "contact_poles")
            system = Evaluation(right, linear, START_MASS), Evaluation(right, linear, FORCE_SLOPES)
            key = Key("modes", where, "contact-poles", left, right)
            yield Comparison(
                About(key, "1", POLE_METRIC), (own, *system), partial(_same_poles, (own, *system))
            )


def _same_poles(tasks: Sequence[Evaluation], about: About, results: Results) -> Finding:
    return poles.poles_follow(about, *(results.need(task) for task in tasks))


def _same_modes(tasks: Sequence[Evaluation], about: About, results: Results) -> Finding:
    given = [_all_modes(task, results) for task in tasks]
    few, many = sorted(given, key=len)
    return modes.modes_among(about, few, many)


def _all_modes(task: Evaluation, results: Results) -> np.ndarray:
    """A model's modes. Raises Unavailable if it has lost some."""
    found, joints = results.need(task), task.case.arm.joints
    single = MODELS[task.model].free_planets or task.case.switches.planets == "free"
    planets = [joint.planet_count for joint in joints if joint.planet_count]
    expected = sum(1 + (count if single else 1) for count in planets)
    if len(found) != expected:
        raise Unavailable(f"{task.model}: {len(found)} mesh modes, there must be {expected}")
    return found


def _locked_stages(where: str, arm: Arm, chosen: Switches) -> Iterator[Comparison]:
    """The modes of each geared stage, carrier locked, against first principles."""
    for number, joint in scales.geared(arm):
        case = Case(locked_stage(arm, number), at_rest(), chosen)
        for name in promising("mesh_modes", _geared(case)):
            task = Evaluation(name, case, "mesh_modes")
            key = Key("modes", where, "locked-stage", name, joint=number + 1)
            lumped = chosen.planets == "lumped"
            closed = modes.closed_form_modes(joint) if lumped else modes.free_modes(joint)
            yield Comparison(
                About(key, "1", MODE_METRIC, "closed form"),
                (task,),
                partial(_as_closed_form, task, closed),
            )


def locked_stage(arm: Arm, number: int) -> Arm:
    """One geared joint alone, its link too heavy to move, without weight and friction."""
    free = arm.joints[number].model_copy(update={"friction_N_m_s_per_rad": 0.0})
    link = arm.links[number]
    heavier = {
        name: modes.LOCK * value
        for name, value in link
        if name in ("density_kg_per_m3", "mass_kg", "inertia_kg_m2") and value is not None
    }
    locked = {"joints": (free,), "links": (link.model_copy(update=heavier),)}
    return arm.model_copy(update={**locked, "gravity_m_per_s2": (0.0, 0.0)})


def _as_closed_form(
    task: Evaluation, closed: np.ndarray, about: About, results: Results
) -> Finding:
    return modes.modes_among(about, closed, _all_modes(task, results))


def _geared(case: Case) -> tuple[str, ...]:
    """The geared models that are about a case."""
    return covering("geared", case.arm, case.switches)
