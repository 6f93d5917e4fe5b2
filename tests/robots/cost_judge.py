"""How engines of robots are judged: answers just within a tolerance agree, just beyond they do not.

Sizes follow from the files by Pinocchio, each as the page says that it is.
"""

from collections.abc import Iterator
from functools import lru_cache, partialmethod
from typing import Any

import numpy as np
import pytest

from crosscheck.checks import engines, robot_states
from crosscheck.checks.robot_states import RandomStates, sample_states
from crosscheck.findings import Finding
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot
from crosscheck.planning import robots
from crosscheck.registry import build_robot_model
from crosscheck.runner import tasks
from tests.brief import perform_here
from tests.robots import chains
from tests.robots.cost_guard import FILES, robot
from tests.robots.recomputed import list_teeth

STATES, RUNS, SECONDS, STEPS = 5, 3, 0.1, 5
NAME, OTHER = "oblique", "other"
ROUNDING = 1e-10
SOLVED = "forward dynamics", "run"
EPSILONS = 1000 * 2.0**-52
AT = 1  # the state whose answers are wrong


class Sizes:
    """What differences are parts of, by quantity, of one entry at the state AT."""

    def __init__(self, level: Level, states: RandomStates) -> None:
        files, own = FILES[NAME], robot(NAME)
        model = build_robot_model("pinocchio", own, level)
        q, v, a, torques = states
        free = list(files.kinds)
        matrix = model.mass_matrix(q)
        roots = np.sqrt(np.diagonal(matrix, axis1=1, axis2=2))
        scaled = np.linalg.eigvalsh(matrix / roots[:, :, None] / roots[:, None, :])
        self.condition = float((scaled[:, -1] / scaled[:, 0]).max())
        speed, growth = (np.sqrt(np.einsum("si,sij,sj->s", x, matrix, x)) for x in (v, a))
        mass = sum(body.mass for body in own.bodies)
        weight = np.linalg.norm(files.gravity) * np.sqrt(mass)
        bias = speed * np.abs(v).sum(axis=1)
        held = bias + weight
        for number, tooth in enumerate(list_teeth(files) if level == "geared" else (), len(free)):
            force = tooth.stiffness * np.abs(q[:, number]) + tooth.damping * np.abs(v[:, number])
            if tooth.joint in free:
                motor = np.abs(torques[:, free.index(tooth.joint)])
                force = force + motor / abs(tooth.lever)
            held = held + force / roots[:, number]
        given = np.linalg.norm(torques / roots[:, : len(free)], axis=1)
        bodies = own.bodies  # merged, which the tests of the reader hold against sums
        reach = files.stretched() + float(np.abs(q[:, 2]).max())  # of the slide
        farthest = reach + max(float(np.linalg.norm(body.com)) for body in bodies)
        turning = sum(float(np.trace(body.inertia)) for body in bodies)
        turning += sum(spin.inertia for spin in files.list_spins())
        at, last = AT, matrix.shape[1] - 1
        self.entry: dict[str, tuple[tuple[int, ...], float]] = {
            "mass matrix": ((at, 0, last), roots[at, 0] * roots[at, last]),
            "bias": ((at, last), roots[at, last] * bias[at]),
            "gravity": ((at, 0), roots[at, 0] * weight),
            "inverse dynamics": ((at, last), roots[at, last] * (held + growth)[at]),
            "forward dynamics": ((at, last), (held + given)[at] / roots[at, last] / scaled[at, 0]),
            "energy": ((at,), speed[at] ** 2 / 2 + weight * np.sqrt(mass) * farthest),
            "momentum": ((at, 1), speed[at] * np.sqrt(mass)),
            "tip": ((at, 2), reach),
        }
        self.turning = (at, 4), speed[at] * np.sqrt(mass * farthest**2 + turning)
        if level != "geared":
            ends, _ = chains.stepped(
                lambda stage, q, v: model.forward_dynamics(q, v, 0 * q),
                *(q[:RUNS], v[:RUNS], STEPS, SECONDS),
            )
            self.entry["run"] = (at, 0), np.abs(ends - q[:RUNS])[at].max()


REFERENCE_ENGINE = "analytic"
ANSWERS: dict[tuple, np.ndarray] = {}


class Wrong(RobotModel):
    """The analytic model, whose answers are kept; one entry of each is wrong if it is so given.

    wrong: by quantity and level the entry, and by how much.
    """

    def __init__(self, own: Robot, level: Level, name: str, wrong: dict[tuple, Any]) -> None:
        super().__init__(own, level)
        self.name, self.wrong = name, wrong
        self.right = build_robot_model(REFERENCE_ENGINE, own, level)

    def answer(self, method: str, *given: np.ndarray) -> np.ndarray:
        """Of a method at states."""
        key = self.level, method, *(each.tobytes() for each in given)
        if key not in ANSWERS:
            ANSWERS[key] = getattr(self.right, method)(*given)
        whole = len(given[0]) == STATES  # a run is of fewer
        return self.changed(method.replace("_", " "), ANSWERS[key]) if whole else ANSWERS[key]

    def changed(self, quantity: str, answer: np.ndarray) -> np.ndarray:
        """The answer with its wrong entry."""
        changed = answer.copy()
        if (quantity, self.level) in self.wrong:
            place, by = self.wrong[quantity, self.level]
            changed[place] += by
        return changed

    mass_matrix = partialmethod(answer, "mass_matrix")
    bias = partialmethod(answer, "bias")
    gravity = partialmethod(answer, "gravity")
    inverse_dynamics = partialmethod(answer, "inverse_dynamics")
    forward_dynamics = partialmethod(answer, "forward_dynamics")
    energy = partialmethod(answer, "energy")
    momentum = partialmethod(answer, "momentum")
    tip = partialmethod(answer, "tip")


@lru_cache
def sizes_of(level: Level, seed: int) -> Sizes:
    """Sizes at states as the program draws them."""
    states = sample_states(robot(NAME), STATES, seed)
    is_geared = level == "geared"
    return Sizes(level, robots.add_mesh_states(robot(NAME), states) if is_geared else states)


def wrong_verdicts() -> Iterator[str]:
    """Verdicts, differences and tolerances that are not those of the answers that are wrong."""
    own = robot(NAME)
    states = sample_states(own, STATES, 0)
    sizes = {level: sizes_of(level, 0) for level in own.levels}
    for part, turning in ((0.98, False), (1.02, True)):
        wrong, wanted = {}, {}
        for level, size in sizes.items():
            solved = max(ROUNDING, EPSILONS * size.condition)
            entries = dict(size.entry) | ({"momentum": size.turning} if turning else {})
            for quantity, (place, whole) in entries.items():
                tolerance = solved if quantity in SOLVED else ROUNDING
                wrong[quantity, level] = place, part * tolerance * whole
                wanted[quantity, level] = part * tolerance, tolerance
        for each in _compared(own, states, wrong):
            asked = each.quantity.replace("_", " "), each.about.key.case.split("/")[1]
            if asked not in wanted:
                continue
            measured, tolerance = wanted.pop(asked)
            if each.verdict != ("agree" if part < 1 else "differ"):
                yield f"{each} at {part} of its tolerance"
            if each.measured != pytest.approx(measured, rel=1e-4, abs=0):
                yield f"{each}: {measured}"
            if each.tolerance != pytest.approx(tolerance, rel=1e-6, abs=0):
                yield f"{each}: tolerance {tolerance}"
        if wanted:
            yield f"not compared: {wanted}"


def wrong_condition() -> Iterator[str]:
    """Whether solving with an ill-conditioned M is given what rounding takes: 1000 epsilons of it.

    A ball of J and m turns at the end of an arm of length L, whose inertia about its own, parallel
    axis is I: M is [[I + m L^2 + J, J], [J, J]] at any pose.
    """
    arm, ball, inertia, mass, length = 0.5, 1e-4, 1e-5, 0.3, 0.7
    none = (0.0, 0.0, 0.0)
    text = chains.urdf(
        chains.link("ground"),
        chains.link("arm", chains.Solid(1.0, none, (arm, 0, 0, arm, 0, arm))),
        chains.link("ball", chains.Solid(mass, none, (ball, 0, 0, ball, 0, inertia))),
        chains.joint("turn", "ground", "arm"),
        chains.joint("roll", "arm", "ball", at=(length, 0, 0)),
    )
    whole = arm + mass * length**2 + inertia
    part = np.sqrt(inertia / whole)  # of the scaled M, beside 1 on its diagonal
    own = chains.robot(text)
    with pytest.MonkeyPatch.context() as patch:
        perform_here(patch)
        patch.setattr(robot_states, "TOLERANCE", 1e-13)
        two = REFERENCE_ENGINE, "pinocchio"
        patch.setattr(robots, "find_level_engines", lambda level: two)
        found = robots.compare_engines(own, sample_states(own, 2, 0))
    for each in found:
        right = (
            EPSILONS * (1 + part) / (1 - part)
            if each.quantity.replace("_", " ") in SOLVED
            else 1e-13
        )
        if each.tolerance != pytest.approx(right, rel=1e-6, abs=0):
            yield f"{each}: tolerance {right}"


def _compared(own: Robot, states: RandomStates, wrong: dict[tuple, Any]) -> list[Finding]:
    def made(engine: str, at: Robot, level: Level) -> RobotModel:
        return Wrong(at, level, engine, {} if engine == REFERENCE_ENGINE else wrong)

    right = engines.integrate

    def integrate(model: Wrong, *given: Any) -> tuple[np.ndarray, np.ndarray]:
        ends, rates = right(model, *given)
        return model.changed("run", ends), rates

    with pytest.MonkeyPatch.context() as patch:
        perform_here(patch)
        patch.setattr(robots, "find_level_engines", lambda level: (REFERENCE_ENGINE, OTHER))
        patch.setattr(tasks, "build_robot_model", made)
        patch.setattr(engines, "integrate", integrate)
        return robots.compare_engines(own, states)
