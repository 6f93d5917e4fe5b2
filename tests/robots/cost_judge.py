"""How engines of robots are judged: answers just within a tolerance agree, just beyond they do not.

Sizes follow from the files by the second program, each as the page says that it is.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from crosscheck.cost import agreement
from crosscheck.cost.engines import LEAD, OWN
from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot
from tests.robots.cost_guard import FILES, robot
from tests.robots.recomputed import Lagrangian, stepped

STATES, RUNS, SECONDS, STEPS = 5, 3, 0.1, 5
NAME, OTHER = "oblique", "other"
ROUNDING = 1e-10
EPSILONS = 1000 * 2.0**-52
AT = 1  # the state whose answers are wrong


class Sizes:
    """What differences are parts of, by quantity, of one entry at the state AT."""

    def __init__(self, level: Level, states: agreement.DrawnStates) -> None:
        self.own = own = Lagrangian(FILES[NAME])
        q, v, a, torques = states
        free = len(own.free)
        matrix = own.energies(q[:, :free], level)[0]
        roots = np.sqrt(np.diagonal(matrix, axis1=1, axis2=2))
        scaled = np.linalg.eigvalsh(matrix / roots[:, :, None] / roots[:, None, :])
        self.condition = float((scaled[:, -1] / scaled[:, 0]).max())
        speed, growth = (np.sqrt(np.einsum("si,sij,sj->s", x, matrix, x)) for x in (v, a))
        moving = [mass for mass in own.masses if mass.link != own.root]
        mass = sum(each.mass for each in moving)
        weight = np.linalg.norm(own.gravity) * np.sqrt(mass)
        bias = speed * np.abs(v).sum(axis=1)
        held = bias + weight
        for number, tooth in enumerate(own.teeth if level == "geared" else (), free):
            force = tooth.stiffness * np.abs(q[:, number]) + tooth.damping * np.abs(v[:, number])
            if tooth.joint in own.free:
                motor = np.abs(torques[:, own.free.index(tooth.joint)])
                force = force + motor / abs(tooth.lever)
            held = held + force / roots[:, number]
        given = np.linalg.norm(torques / roots[:, :free], axis=1)
        bodies = robot(NAME).bodies  # merged, which the tests of the reader hold against sums
        reach = sum(float(np.linalg.norm(line.position)) for line in own.lines)
        reach -= float(np.linalg.norm(own.lines[-2].position))  # of a finger that bears nothing
        reach += float(np.abs(q).max())  # of the slide
        farthest = reach + max(float(np.linalg.norm(body.com)) for body in bodies)
        turning = sum(float(np.trace(body.inertia)) for body in bodies)
        turning += sum(spin.inertia for spin in own.spins)
        at, last = AT, matrix.shape[1] - 1
        self.entry: dict[str, tuple[tuple[int, ...], float]] = {
            "mass matrix": ((at, 0, last), roots[at, 0] * roots[at, last]),
            "bias": ((at, last), roots[at, last] * bias[at]),
            "gravity": ((at, 0), roots[at, 0] * weight),
            "inverse dynamics": ((at, last), roots[at, last] * (held + growth)[at]),
            "forward dynamics": (
                (at, last),
                (held + given)[at] / roots[at, last] / scaled[at, 0],
            ),
            "energy": ((at,), speed[at] ** 2 / 2 + weight * np.sqrt(mass) * farthest),
            "momentum": ((at, 1), speed[at] * np.sqrt(mass)),
            "tip": ((at, 2), reach),
        }
        self.turning = (at, 4), speed[at] * np.sqrt(mass * farthest**2 + turning)
        if level != "geared":
            ends = stepped(
                lambda stage, q, v: own.accelerations(q, v, 0 * q, level),
                *(q[:RUNS], v[:RUNS], STEPS, SECONDS),
            )
            self.entry["run"] = (at, 0), np.abs(ends - q[:RUNS])[at].max()


class Wrong(RobotModel):
    """The analytic model, but one entry of each answer is wrong by a part of its size."""

    def __init__(self, own: Robot, level: Level, wrong: dict[str, Any]) -> None:
        super().__init__(own, level)
        self.right, self.wrong = MODEL_OF(LEAD, own, level), wrong
        self.name = OTHER

    def changed(self, quantity: str, answer: np.ndarray) -> np.ndarray:
        if len(answer) == STATES or quantity == "run":
            place, by = self.wrong[level_key(quantity, self.level)]
            answer = answer.copy()
            answer[place] += by
        return answer

    def mass_matrix(self, q):
        return self.changed("mass matrix", self.right.mass_matrix(q))

    def bias(self, q, v):
        return self.changed("bias", self.right.bias(q, v))

    def gravity(self, q):
        return self.changed("gravity", self.right.gravity(q))

    def inverse_dynamics(self, q, v, a):
        return self.changed("inverse dynamics", self.right.inverse_dynamics(q, v, a))

    def forward_dynamics(self, q, v, torques):
        return self.changed("forward dynamics", self.right.forward_dynamics(q, v, torques))

    def energy(self, q, v):
        return self.changed("energy", self.right.energy(q, v))

    def momentum(self, q, v):
        return self.changed("momentum", self.right.momentum(q, v))

    def tip(self, q):
        return self.changed("tip", self.right.tip(q))


MODEL_OF = agreement.model_of


def level_key(quantity: str, level: str) -> tuple[str, str]:
    """Key of what is wrong."""
    return quantity, level


def wrong_verdicts() -> Iterator[str]:
    """Verdicts, differences and tolerances that are not those of the answers that are wrong."""
    own = robot(NAME)
    states = agreement.drawn(own, STATES, 0)
    given = {
        level: agreement.with_meshes(own, states) if level == "geared" else states
        for level in own.levels
    }
    sizes = {level: Sizes(level, each) for level, each in given.items()}
    for part, turning in ((0.98, False), (1.02, True)):
        wrong, wanted = {}, {}
        for level, size in sizes.items():
            solved = max(ROUNDING, EPSILONS * size.condition)
            entries = dict(size.entry) | ({"momentum": size.turning} if turning else {})
            for quantity, (place, whole) in entries.items():
                tolerance = solved if quantity in ("forward dynamics", "run") else ROUNDING
                wrong[quantity, level] = place, part * tolerance * whole
                wanted[quantity, level] = part * tolerance, tolerance
        for each in _compared(own, states, wrong):
            if (each.quantity, each.level) not in wanted:
                continue
            measured, tolerance = wanted.pop((each.quantity, each.level))
            if each.agrees != (part < 1) or each.failure:
                yield f"{each} at {part} of its tolerance"
            if each.measured != pytest.approx(measured, rel=5e-3):
                yield f"{each}: {measured}"
            if each.tolerance != pytest.approx(tolerance, rel=1e-6):
                yield f"{each}: tolerance {tolerance}"
        if wanted:
            yield f"not compared: {wanted}"


def _compared(own: Robot, states: agreement.DrawnStates, wrong: dict) -> list:
    def made(engine: str, at: Robot, level: Level) -> RobotModel:
        return MODEL_OF(engine, at, level) if engine == LEAD else Wrong(at, level, wrong)

    right = agreement.run

    def run(model: RobotModel, *given: Any) -> np.ndarray:
        if model.name != OTHER:
            return right(model, *given)
        ends = right(model.right, *given)
        return model.changed("run", ends) if model.level != "geared" else ends

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(agreement, "engines", lambda: {LEAD: OWN[LEAD], OTHER: OWN[LEAD]})
        patch.setattr(agreement, "model_of", made)
        patch.setattr(agreement, "run", run)
        return agreement.compared(own, states)
