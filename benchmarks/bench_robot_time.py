"""Processor seconds of a robot's trial: of 6 and of 20 joints, right and wrong in each part.

Run as ``python -m benchmarks.bench_robot_time [WORD]`` from the project's folder: all cases, or
those whose name has the word. What is wrong is nothing that a trial knows, so that it looks for
every cause; a right trial of each robot is run before, for what is made once in a process.
"""

from __future__ import annotations

import random
import resource
import sys
from collections.abc import Sequence

import numpy as np

from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import build_robot_model
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.result import Trial
from tests.robots import chains
from tests.robots.trials import run_robot_trial

JOINTS = 20
ROWS = [1, 2]  # that are wrong
WRONG: dict[str, tuple[str, ...]] = {
    "right": (),
    "gravity wrong": ("gravity",),
    "bias wrong": ("bias",),
    "M wrong": ("mass_matrix",),
    "all parts wrong": ("mass_matrix", "bias", "gravity"),
}


def make_long_chain() -> Robot:
    """A chain of turning joints along any axes, with a rotor at each."""
    draw = random.Random(0)

    def draw_three(size: float) -> list[float]:
        return [draw.uniform(-size, size) for _ in range(3)]

    parts = [chains.link("l0")]
    for number in range(1, JOINTS + 1):
        solid = chains.Solid(draw.uniform(0.5, 3.0), draw_three(0.2), (0.03, 0, 0, 0.04, 0, 0.05))
        names = f"j{number}", f"l{number - 1}", f"l{number}"
        axis, at, rpy = draw_three(1.0), draw_three(0.4), draw_three(3.0)
        parts += [chains.joint(*names, axis=axis, at=at, rpy=rpy), chains.link(names[2], solid)]
    rotors = {f"j{number}": chains.geared(50.0, 1e-4) for number in range(1, JOINTS + 1)}
    return chains.robot(chains.urdf(*parts), rotors)


def try_wrong(robot: Robot, parts: Sequence[str]) -> Trial:
    """The trial of Pinocchio's equations with a wave that is nobody's mistake in some parts."""
    model = build_robot_model("pinocchio", robot, "coupled")

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        mass = model.mass_matrix(q[None])[0]
        mass[np.ix_(ROWS, ROWS)] += _wave(q) * ("mass_matrix" in parts)
        return mass

    def bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        torques = model.bias(q[None], v[None])[0]
        torques[ROWS] += _wave(q) * v[0] * v[2] * ("bias" in parts)
        return torques

    def gravity(q: np.ndarray) -> np.ndarray:
        torques = model.gravity(q[None])[0]
        torques[ROWS] += _wave(q) * ("gravity" in parts)
        return torques

    return run_robot_trial(Equations(mass_matrix, bias, gravity=gravity), robot)


def _wave(q: np.ndarray) -> float:
    return float(0.1 * np.sin(1.3 * q[0] * q[1]))


def measure_seconds(robot: Robot, parts: Sequence[str]) -> tuple[float, Trial]:
    """Processor seconds of a trial, of this process and of its workers; and the trial."""
    before = _read_seconds()
    trial = try_wrong(robot, parts)
    return _read_seconds() - before, trial


def _read_seconds() -> float:
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def main(word: str = "") -> None:
    """Print the seconds of each case, and how many entries differ."""
    robots = {"puma560": load_robot("puma560"), f"{JOINTS} joints": make_long_chain()}
    for name, robot in robots.items():
        cases = {f"{name}, {what}": parts for what, parts in WRONG.items()}
        chosen = [each for each in cases if word in each]
        if chosen:
            try_wrong(robot, ())
        for each in chosen:
            seconds, trial = measure_seconds(robot, cases[each])
            print(f"{seconds:6.1f} s  {each}: {len(trial.diagnosis.entries)} entries", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
