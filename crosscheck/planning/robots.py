"""The cross-check of a robot: its cases by level, and every comparison of its models."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np

from crosscheck.analytic.robot.springs import (
    drive_matrix,
    friction_rate,
    largest_stable_step,
    mesh_rates,
    replace_stages_by_rotors,
    tooth_springs,
)
from crosscheck.checks import engines
from crosscheck.checks.answers import mass_matrix
from crosscheck.checks.robot_states import RandomStates, compute_sizes, sample_states
from crosscheck.checks.sampled import LEAST_RUN_S, RobotLevel, SampledRobot, Subjects
from crosscheck.checks.simulations import DEPTH, simulation_start
from crosscheck.findings import EntryDifferences, Finding
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.robot.integration import integrate
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import WITH_ROTORS, Level, Robot
from crosscheck.planning.checks import plan_checks
from crosscheck.planning.comparison import (
    Plan,
    Results,
    collect_tasks,
    compare_entries,
    judge_comparisons,
)
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.registry import build_robot_model, find_level_engines, reference_engine
from crosscheck.runner.tasks import Evaluation
from crosscheck.runner.workers import Workers, perform_all

COUNT, QUICK_COUNT = 100, 20
RUN_S = 0.1  # longest run [s], if few steps of it resolve mesh swings, their decay and friction
# Load of a drawn mesh [N m or N]; its deflection at most, over its pinion's radius.
FORCE, DEEPEST = 10.0, 0.01
# Of free motions on all levels: a step of the fastest mesh [rad], and steps at most.
RESOLVED, MOST_STEPS, QUICK_STEPS, LEAST_STEPS = 0.4, 1000, 100, 50
UNRESOLVED = 0.01  # part of a motion by which halving its steps may change it


def plan_robot(request: CrossCheckRequest, workers: Workers | None = None) -> Plan:
    """The whole cross-check of a robot. Raises InputError for one whose M cannot be inverted.

    workers: are not needed, for a robot's runs are made by its own numbers.
    """
    robot = cast(Robot, request.mechanism)
    count = QUICK_COUNT if request.quick else COUNT
    most_steps = QUICK_STEPS if request.quick else MOST_STEPS
    cases = make_cases(robot, sample_states(robot, count, request.seed), most_steps)
    models = sample_models([add_scenarios(case, request.scenarios) for case in cases])
    comparisons, remarks = plan_checks(Subjects(robots=models))
    remarks += [
        f"without {engine} at {case.level}: it does not have this level"
        for case in cases
        for engine in find_level_engines("links")
        if engine not in find_level_engines(case.level)
    ]
    entries = partial(compute_robot_entries, models)
    return Plan(comparisons, (*remarks, *robot.notes), entries)


def describe_quick_limits(request: CrossCheckRequest) -> str:
    """A sentence on what a quick cross-check of a robot leaves out."""
    return (
        f"With --quick models are compared at {QUICK_COUNT} random states, where a full"
        f" cross-check takes {COUNT}, and free motions take at most {QUICK_STEPS} steps of"
        f" {MOST_STEPS}."
    )


def compare_engines(robot: Robot, states: RandomStates) -> list[Finding]:
    """Every two engines compared at each level. Raises InputError as ``plan_robot``."""
    models = sample_models(make_cases(robot, states, QUICK_STEPS))
    comparisons = list(engines.plan(Subjects(robots=models)))
    outcomes = perform_all(collect_tasks(comparisons), os.cpu_count() or 1)
    return list(judge_comparisons(comparisons, Results(outcomes)))


def sample_models(cases: list[RobotLevel]) -> list[SampledRobot]:
    """The model of each engine that has a case's level."""
    return [
        SampledRobot(where, name, case, partial(Evaluation, name))
        for case in cases
        for where in [f"{case.robot.name}/{case.level}"]
        for name in (f"{engine}:{case.level}" for engine in find_level_engines(case.level))
    ]


def make_cases(robot: Robot, states: RandomStates, most_steps: int) -> list[RobotLevel]:
    """The case of each level. Raises InputError for a robot whose M cannot be inverted."""
    states_by_level = {
        level: add_mesh_states(robot, states) if level == "geared" else states
        for level in robot.levels
    }
    models = {level: build_robot_model(reference_engine(), robot, level) for level in robot.levels}
    masses = {level: models[level].mass_matrix(at.q) for level, at in states_by_level.items()}
    slowing = {level: friction_rate(robot, mass) for level, mass in masses.items()}
    swings = mesh_rates(robot, masses["geared"]).fastest if "geared" in masses else 0.0
    fastest = max(swings, *slowing.values())
    motion_s = min(RUN_S, most_steps * RESOLVED / fastest) if fastest else RUN_S
    steps = max(LEAST_STEPS, int(np.ceil(motion_s * fastest / RESOLVED)))
    inertia = sum(rotor.inertia for rotor in replace_stages_by_rotors(robot).rotors)

    def make_case(level: Level) -> RobotLevel:
        at, is_geared = states_by_level[level], level == "geared"
        pushes = _push_bounds(robot, at) if is_geared else None
        sizes = compute_sizes(robot, masses[level], at, pushes=pushes, spinning=inertia)
        drive = drive_matrix(robot, level)
        rate = max(slowing[level], swings if is_geared else 0.0)
        run_s = min(RUN_S, engines.STEPS / 2 / rate) if rate else RUN_S
        return RobotLevel(robot, level, at, sizes, drive, run_s, motion_s, steps)

    cases = [make_case(level) for level in robot.levels]
    shortened = [shorten_runs(models[case.level], case) for case in cases]
    factor = min(short.run_s / case.run_s for short, case in zip(shortened, cases, strict=True))
    return [replace(case, motion_s=factor * case.motion_s) for case in shortened]


def shorten_runs(model: RobotModel, case: RobotLevel) -> RobotLevel:
    """The case with runs so short that their steps resolve them.

    Links of very unequal masses fling each other about within one step of a run of usual length,
    and then its numbers overflow and say nothing of the equations. So runs are halved until twice
    as many steps change them by next to nothing. All but such robots keep the usual length.
    """
    while case.has_runs and not is_resolved(model, case):
        case = replace(case, run_s=case.run_s / 2)
    return case


def add_scenarios(case: RobotLevel, scenarios: Sequence[Scenario]) -> RobotLevel:
    """The case with the beginnings of scenarios, in as few steps as its runs.

    More steps would let rounding grow beyond what tells two engines' equations from each other.
    """
    model = build_robot_model(reference_engine(), case.robot, case.level)
    beginnings = [begin_scenario(model, case, scenario) for scenario in scenarios]
    return replace(case, scenarios=tuple(beginnings))


def begin_scenario(model: RobotModel, case: RobotLevel, scenario: Scenario) -> Scenario:
    """As much of a scenario's beginning as few steps resolve, whatever its own rule of steps is.

    Half as long steps change it by a small part of its motion. No teeth are on the edge of contact
    at the start, where rounding decides whether they touch.
    """
    start, steps = scenario.start, engines.STEPS
    offsets = ("sun_planet_offset_m", "planet_ring_offset_m")
    deep = start.model_copy(update={each: getattr(start, each) or DEPTH for each in offsets})
    stable_s = steps * largest_stable_step(model, scenario)
    duration = min(case.run_s, stable_s, scenario.duration_s)
    while True:
        update = {"start": deep, "duration_s": duration, "record_every": 1}
        coarse = scenario.model_copy(update={**update, "step_s": duration / steps})
        fine = coarse.model_copy(update={"step_s": duration / (2 * steps)})
        with suppress(Diverged):
            (q, _), (fine_q, _) = model.integrate(coarse), model.integrate(fine)
            motion = np.abs(q[-1] - q[0]).max()
            if np.abs(fine_q[-1] - q[-1]).max() <= UNRESOLVED * motion:
                return coarse
        if duration <= LEAST_RUN_S:
            return coarse
        duration /= 2


def is_resolved(model: RobotModel, case: RobotLevel) -> bool:
    """Whether twice as many steps change the runs of a case by a small part of their motion.

    These are free motions, and the simulation's.
    """
    free, start = case.states.first(engines.RUNS), simulation_start(case)
    q, v, torques = (np.vstack([each, each[:1]]) for each in (*free[:2], 0 * free.torques))
    for values, first in zip((q, v, torques), start, strict=True):
        values[-1, : case.free] = first
    run = partial(integrate, model, q, v, lambda time: torques, case.run_s)
    (coarse, _), (fine, _) = run(engines.STEPS), run(2 * engines.STEPS)
    if not (np.isfinite(coarse).all() and np.isfinite(fine).all()):
        return False
    differences, motions = (np.abs(fine - other).max(axis=1) for other in (coarse, q))
    return bool((differences <= UNRESOLVED * motions).all())


def add_mesh_states(robot: Robot, states: RandomStates) -> RandomStates:
    """The states with those of the meshes: on either flank, or between where there is backlash."""
    rng, springs, free = np.random.default_rng(0), tooth_springs(robot), len(robot.coordinates)
    backlash, sizes = 0.0, np.zeros((3, 1))
    for spring in springs:
        deep = min(FORCE / abs(spring.lever) / spring.stiffness, DEEPEST * spring.radius)
        rate = np.sqrt(spring.stiffness / spring.mass)  # of swings while the joint stands
        has_spring = spring.row[free:] != 0
        sizes = np.maximum(sizes, np.outer(deep * rate ** np.arange(3), has_spring))
        backlash = np.maximum(backlash, spring.backlash * has_spring)
    shape = len(states.q), sizes.shape[1]
    drawn = sizes[:, None] * rng.uniform(-1, 1, (3, *shape))
    drawn[0] = rng.choice((-1, 1), shape) * (backlash + drawn[0])
    q, v, a = (np.hstack(each) for each in zip(states[:3], drawn, strict=True))
    return RandomStates(q, v, a, states.torques)


def _push_bounds(robot: Robot, states: RandomStates) -> np.ndarray:
    """Bounds of what springs, dampers and motors do to each x (states, coordinates) [N]."""
    bounds = np.abs(states.torques) @ np.abs(drive_matrix(robot, "geared"))
    for spring in tooth_springs(robot):
        force = spring.stiffest * (np.abs(states.q @ spring.row) + spring.error)
        force += spring.damping * np.abs(states.v @ spring.row)
        bounds += force[:, None] * np.abs(spring.row)
    return bounds[:, len(robot.coordinates) :]


def compute_robot_entries(
    models: Sequence[SampledRobot], results: Results
) -> Iterator[EntryDifferences]:
    """Compare the first engine's M with the others', entry by entry, with rotors as bodies."""
    levels = [each.setting.level for each in models]
    level = next((each for each in levels if each in WITH_ROTORS), levels[0])
    reference, *others = (each for each in models if each.setting.level == level)
    return compare_entries(mass_matrix, reference, others, results)
