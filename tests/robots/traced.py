"""The text of a robot's kernel run by Python."""

import ast
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from crosscheck.analytic.robot.equations import RobotEquations, build_equations
from crosscheck.models.robot.robot import Level, Robot

# Rational points of the unit circle, so that rotations are exact.
CIRCLE = [(Fraction(3, 5), Fraction(4, 5)), (Fraction(5, 13), Fraction(-12, 13))]
CIRCLE += [(Fraction(-8, 17), Fraction(15, 17)), (Fraction(20, 29), Fraction(21, 29))]


def equations(robot: Robot, level: Level) -> RobotEquations:
    """Equations under torques that a test gives."""
    return build_equations(robot, level)


def random_state(
    robot: Robot, level: Level, seed: int, states: int = 1
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates, rates (states, n) and torques; displacements on both sides of their gaps."""
    rng, free = np.random.default_rng(seed), len(robot.coordinates)
    size = free + robot.mesh_coordinates * (level == "geared")
    q, v = rng.normal(size=(2, states, size))
    q[:, free:] *= 1e-4
    v[:, free:] *= 1e-2
    return q, v, 10 * rng.normal(size=(states, free))


def run_text(
    lines: Iterable[str], values: Mapping[str, Any], number: Callable[[float], Any] = float
) -> dict[str, Any]:
    """Every name that lines set, from values by name; number: of a literal."""
    tree = _Literals().visit(ast.parse("\n".join(lines)))
    names = {"rint": lambda x: float(round(x)), "number_of": number, **values}
    exec(compile(tree, "<kernel>", "exec"), names)
    return names


class _Literals(ast.NodeTransformer):
    def visit_Constant(self, node: ast.Constant) -> ast.Call:
        name = ast.copy_location(ast.Name("number_of", ast.Load()), node)
        return ast.copy_location(ast.Call(name, [node], []), node)


def interpreted_accelerations(
    own: RobotEquations, q: np.ndarray, v: np.ndarray, torques: np.ndarray
) -> np.ndarray:
    """Accelerations (n,) of one state by the kernel's text, in Python's floats."""
    s = own.structure
    values = {**own.numbers, **{f"T{j}": t for j, t in enumerate(torques, 1)}}
    for kind, state in (("q", q), ("v", v)):
        values |= {f"{kind}_{name}": x for name, x in zip(s.coordinates, state, strict=True)}
    names = run_text(s.dynamics(), {k: float(x) for k, x in values.items() if np.ndim(x) == 0})
    return np.array([names[f"a_{name}"] for name in s.coordinates])
