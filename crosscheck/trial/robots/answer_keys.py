"""Right answers of a robot's equations at a few states, on it and on one of its structure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any, Literal, get_args

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.robot.robot import Joint, Level, Robot, RobotBody, remove_friction
from crosscheck.models.robot.urdf import roll_pitch_yaw
from crosscheck.trial.coordinates.functions import map_calls
from crosscheck.trial.coordinates.robots import build_robot_frame
from crosscheck.trial.input.calls import TAKES, call_part
from crosscheck.trial.input.loading import build_robot_equations
from crosscheck.trial.result import Trial
from crosscheck.trial.robots.answers import ARGUMENTS, NONLINEAR, bind_functions
from crosscheck.trial.robots.judge import RobotProblem, compute_sizes_by_level
from crosscheck.trial.source.answer_key import (
    AT_REST,
    FACTORS,
    MOTIONS,
    WITHOUT_RATES,
    Answer,
    AnswerKey,
    LevelAnswers,
    NumberExchange,
)
from crosscheck.trial.source.sandbox import freeze

FEW_STATES = 3
SEED = 7
NumberKind = Literal["mass", "com", "inertia", "position"]
NUMBER_KINDS: tuple[NumberKind, ...] = get_args(NumberKind)


def make_robot_answer_keys(trial: Trial) -> Iterator[AnswerKey]:
    """The answer keys of a trial's robot, and of others of its structure, one for a kind of number.

    Code may take some kinds from the robot and have others of its own. It is made of the robot with
    its friction and without the motors of elastic joints.
    """
    problem, level, robot = trial.problem, trial.diagnosis.level, trial.request.mechanism
    follows = "bias" in problem.self_differences and not problem.find_self_places("bias", level)
    yield _make_answer_key(problem, level, robot, {"bias": "mass_matrix"} if follows else {})
    if problem.stiffness.any():  # springs of another robot would be others
        return
    states = problem.states.first(FEW_STATES)
    exchange = NumberExchange(_list_angles(robot))
    others = [draw_probe_robot(robot, kind) for kind in NUMBER_KINDS]
    exchanged = _exchange_numbers(robot, exchange)
    for other in (*others, exchanged):
        with suppress(InputError):  # where another robot's mass matrix loses its digits
            sizes = compute_sizes_by_level(remove_friction(other), problem.stated, states)
            there = replace(problem, robot=remove_friction(other), states=states, sizes=sizes)
            key = _make_answer_key(there, level, other, {})
            is_exchanged = other is exchanged
            yield exchange.exchange_code(key, _list_numbers(robot)) if is_exchanged else key


def _exchange_numbers(robot: Robot, exchange: NumberExchange) -> Robot:
    """A robot of the same structure of which each number is another, equal ones the same."""
    bodies = (
        replace(
            body,
            mass=exchange(body.mass),
            com=exchange.exchange_array(body.com),
            inertia=exchange.exchange_array(body.inertia),
        )
        for body in robot.bodies
    )
    positions = (exchange.exchange_array(each.placement.position) for each in robot.joints)
    joints = (
        replace(joint, placement=replace(joint.placement, position=position))
        for joint, position in zip(robot.joints, positions, strict=True)
    )
    rotors = (
        replace(rotor, inertia=exchange(rotor.inertia), ratio=exchange(rotor.ratio))
        for rotor in robot.rotors
    )
    return replace(robot, bodies=tuple(bodies), joints=tuple(joints), rotors=tuple(rotors))


def _list_angles(robot: Robot) -> Iterator[float]:
    """Roll, pitch and yaw [rad] of each joint's frame."""
    for joint in robot.joints:
        yield from roll_pitch_yaw(joint.placement.rotation)


def draw_probe_robot(robot: Robot, kind: NumberKind) -> Robot:
    """A robot of the same structure of which all numbers of a kind are others.

    Seeded, so the same every time. What is 0 stays so.
    """
    generator = np.random.default_rng(SEED)

    def draw(*shape: int) -> np.ndarray:
        return generator.uniform(*FACTORS, shape)

    def change_body(body: RobotBody) -> RobotBody:
        if kind == "mass":
            return replace(body, mass=body.mass * float(draw()))
        if kind == "com":
            return replace(body, com=body.com * draw(3))
        stretch = np.diag(draw(3))  # so that an inertia stays positive
        return replace(body, inertia=stretch @ body.inertia @ stretch)

    def change_joint(joint: Joint) -> Joint:
        position = joint.placement.position * draw(3)
        return replace(joint, placement=replace(joint.placement, position=position))

    if kind == "position":
        return replace(robot, joints=tuple(map(change_joint, robot.joints)))
    return replace(robot, bodies=tuple(map(change_body, robot.bodies)))


def _make_answer_key(
    problem: RobotProblem, level: Level, robot: Robot, holds: Mapping[str, str]
) -> AnswerKey:
    """The answers of the nearest level, and of others of which wrong equations may be.

    holds: by part, one from which it follows.
    """
    freeze(robot)
    states = problem.states.first(FEW_STATES)
    pushed = states._replace(torques=states.torques + problem.friction[:FEW_STATES])
    by_name = dict(zip(ARGUMENTS, pushed, strict=True)) | {"t": np.zeros(FEW_STATES)}

    def bind(source: Any) -> Answer:
        made = build_robot_equations(source, robot, None, problem.name)
        given = problem.equations
        coordinates = given.coordinates if made.has_open_angles else made.coordinates
        made = replace(made, drive=given.drive, coordinates=coordinates)
        calls: dict[str, Any] = bind_functions(made, problem.robot)[1]
        frame = build_robot_frame(made.coordinates, problem.robot, problem.name)
        calls = map_calls(calls, frame, problem.name)

        def answer(part: str, state: int) -> np.ndarray:
            quantity, _ = MOTIONS.get(part, (part, ""))
            name = quantity if quantity in calls else "bias"  # of which a mapped coriolis is one
            arguments = {
                each: values[state] for each, values in by_name.items() if each in TAKES[name]
            }
            if part in MOTIONS:
                arguments["v"] = 0 * arguments["v"]
            if part == AT_REST:
                arguments["a"] = 0 * arguments["a"]
            answered = call_part(calls[name], name, len(problem.names), arguments)
            return answered @ states.v[state] if name == "coriolis" else answered

        return answer

    levels = dict.fromkeys((level, *([] if problem.stated else problem.sizes)))
    right = {
        str(each): _select_answers(problem, each, holds) for each in levels if each in problem.sizes
    }
    numbers = frozenset((*_list_numbers(robot), *robot.gravity.tolist()))
    return AnswerKey(bind, right, problem.names, numbers)


def _list_numbers(robot: Robot) -> Iterator[float]:
    """The numbers of a robot's bodies, places and rotors; a body's equal inertias are one."""
    bodies = [np.append(np.unique(each.inertia), [each.mass, *each.com]) for each in robot.bodies]
    places = [joint.placement.position for joint in robot.joints]
    rotors = [np.append(rotor.inertia, rotor.ratio) for rotor in robot.rotors]
    yield from (float(number) for array in (*bodies, *places, *rotors) for number in array.flat)


def _select_answers(problem: RobotProblem, level: Level, holds: Mapping[str, str]) -> LevelAnswers:
    """Answers that a level expects of the functions, before the trial splits them into parts."""
    answers, sizes, equations = problem.answers, problem.sizes[level], problem.equations
    friction = problem.friction[:FEW_STATES]
    right = {part: values[:FEW_STATES] for part, values in problem.reference_values[level].items()}
    allowed = {
        part: sizes.tolerance(part)
        * sizes.entry_sizes(part, answers.sources.get(part, ""))[:FEW_STATES]
        for part in right
    }
    if answers.sources.get("bias") == NONLINEAR:
        right["bias"] = right["bias"] + right["gravity"]
    if answers.friction_in_bias and "bias" in right:
        right["bias"] = right["bias"] + friction
    if "inverse_dynamics" in right:
        right["inverse_dynamics"] = right["inverse_dynamics"] + friction
    if equations.coriolis is not None and "bias" in right:  # C itself is not unique, C v is
        right["coriolis"], allowed["coriolis"] = right["bias"], allowed["bias"]
    parts = {part: right[part] for part in right if getattr(equations, part) is not None}
    held = {part: each for part, each in holds.items() if {part, each} <= set(parts)}
    if "inverse_dynamics" in parts:
        moving = np.einsum("sij,sj->si", right["mass_matrix"], problem.states.a[:FEW_STATES])
        parts[WITHOUT_RATES] = parts["inverse_dynamics"] - friction - right["bias"]
        parts[AT_REST] = parts[WITHOUT_RATES] - moving
        allowed |= dict.fromkeys((AT_REST, WITHOUT_RATES), allowed["inverse_dynamics"])
        held |= {"inverse_dynamics": WITHOUT_RATES, WITHOUT_RATES: AT_REST}
    return LevelAnswers(parts, allowed, held)
