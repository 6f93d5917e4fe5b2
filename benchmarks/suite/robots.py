"""Part 8: mass matrices of robots a second, and how many planted errors are named."""

from __future__ import annotations

import sysconfig
import tempfile
from collections.abc import Callable
from functools import partial
from itertools import count
from pathlib import Path

import numpy as np
import pinocchio as pin

from benchmarks.suite.rows import Row, absent
from benchmarks.suite.timing import in_turn, per_unit, processor, progress
from crosscheck.cost.agreement import drawn
from crosscheck.cost.engines import model_of
from crosscheck.models.robot.file import RobotFile, load_robot, robot_of
from crosscheck.models.robot.robot import Robot
from crosscheck.trial.robots.trial import try_equations
from tests.robots.test_trial import equations, is_named, planted

TABLE = "robots"
ROBOTS = ("six-joint", "puma560")
TOGETHER, CALLS, LONGER = 100, 100, 20  # states in a call, calls of one state, repeats of a call
ERRORS, UNNAMED = 200, 0.05  # that change equations, and the share that may stay without a name
UR5 = Path(sysconfig.get_path("purelib")) / (
    "cmeel.prefix/share/example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"
)
OWN, ADAM, PIN = "analytic", "adam with NumPy", "pin.crba, one by one"


def measure(repeats: int) -> list[Row]:
    """Per state, at the level links; then errors planted in two robots of six joints."""
    rows = []
    for name in ROBOTS:
        progress(name)
        rows += _speeds(load_robot(name), repeats)
    progress(f"{ERRORS} planted errors")
    rows += _planted(load_robot("six-joint"))
    if not UR5.exists():
        return [*rows, absent(TABLE, "UR5", "example-robot-data is not installed")]
    file = RobotFile(schema_version=1, name="UR5", urdf=UR5.name)
    return [*rows, *_planted(robot_of(file, UR5.read_text("utf-8"), "UR5", str(UR5)))]


def _speeds(robot: Robot, repeats: int) -> list[Row]:
    states = drawn(robot, TOGETHER, 0).q
    own, tree = model_of("analytic", robot, "links"), pin.buildModelFromXML(robot.urdf)
    data, home = tree.createData(), pin.neutral(tree)
    places = [pin.integrate(tree, home, at) for at in states]
    runs: dict[str, Callable[[], object]] = {
        f"{OWN}, {TOGETHER} at once": lambda: [own.mass_matrix(states) for _ in range(LONGER)],
        f"{OWN}, one by one": lambda: [own.mass_matrix(at[None]) for at in states[:CALLS]],
        PIN: lambda: [pin.crba(tree, data, at) for _ in range(LONGER) for at in places],
    }
    units = dict(zip(runs, (TOGETHER * LONGER, CALLS, TOGETHER * LONGER), strict=True))
    rows = []
    try:
        adams = _adam(robot, states)
    except ImportError:
        rows.append(absent(TABLE, robot.name, "adam-robotics is not installed"))
    else:
        runs |= {f"{ADAM}, {TOGETHER} at once": adams[0], f"{ADAM}, one by one": adams[1]}
        units |= {f"{ADAM}, {TOGETHER} at once": TOGETHER, f"{ADAM}, one by one": CALLS}
    times = per_unit(in_turn(runs, repeats, processor), units)
    for name, found in times.items():
        rival = name.replace(OWN, ADAM) if name.startswith(OWN) else PIN
        against = rival if rival in times else PIN
        target = 1.0 if against.startswith(ADAM) else None
        rows.append(
            Row(
                TABLE,
                robot.name,
                f"mass matrix: {name}",
                found.median * 1e6,
                "us",
                against,
                found.over(times[against]),
                target,
                found.spread,
            )
        )
    return rows


def _adam(robot: Robot, states: np.ndarray) -> tuple[Callable[[], object], Callable[[], object]]:
    """All states at once, and one by one. Raises ImportError where there is no adam."""
    from adam.numpy import KinDynComputations

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.urdf"
        path.write_text(robot.urdf, encoding="utf-8")
        model = KinDynComputations(str(path), [joint.name for joint in robot.joints])
    base = np.eye(4)
    free = len(robot.coordinates)
    found = model.mass_matrix(base, states[0])[-free:, -free:]
    expected = model_of("analytic", robot, "links").mass_matrix(states[:1])[0]
    if not np.allclose(found, expected, rtol=1e-9, atol=1e-12):
        raise ValueError("adam's mass matrix is another")
    bases = np.tile(base, (len(states), 1, 1))
    return (
        partial(model.mass_matrix, bases, states),
        lambda: [model.mass_matrix(base, at) for at in states[:CALLS]],
    )


def _planted(own: Robot) -> list[Row]:
    """How many of the errors that change equations are named, and whether right ones are blamed."""
    named, asked = 0, 0
    for seed in count():
        if asked == ERRORS:
            break
        error = planted(own, seed)
        trial = try_equations(equations(error.robot), own, seed=seed)
        if not trial.agrees:
            asked += 1
            named += is_named(error, trial)
    unnamed = 1 - named / asked
    blamed = sum(not try_equations(equations(own), own, seed=seed).agrees for seed in range(20))
    return [
        Row(
            TABLE,
            own.name,
            f"not named, of {ERRORS} planted errors that change its equations",
            100 * unnamed,
            "%",
            f"{100 * UNNAMED:g} %",
            unnamed / UNNAMED,
            1.0,
        ),
        Row(TABLE, own.name, "right equations blamed, of 20", float(blamed), ""),
    ]
