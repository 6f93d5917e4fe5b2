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

from benchmarks.suite.rows import Row, absent_row
from benchmarks.suite.timing import divide_times, print_progress, processor_s, run_in_turn
from crosscheck.checks.robot_states import sample_states
from crosscheck.models.robot.file import RobotFile, build_robot, load_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import build_robot_model
from tests.robots.test_trial import is_named, planted
from tests.robots.trials import robot_equations, run_robot_trial

TABLE = "robots"
ROBOTS = ("six-joint", "puma560")
TOGETHER, CALLS, LONGER = 100, 100, 20  # states in a call, calls of one state, repeats of a call
ERRORS, UNNAMED = 200, 0.05  # that change equations, and the share that may stay without a name
UR5 = Path(sysconfig.get_path("purelib")) / (
    "cmeel.prefix/share/example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"
)
ANALYTIC, ADAM, PIN = "analytic", "adam with NumPy", "pin.crba, one by one"


def measure(repeats: int) -> list[Row]:
    """Per state, at the level links; then errors planted in two robots of six joints."""
    rows = []
    for name in ROBOTS:
        print_progress(name)
        rows += _speeds(load_robot(name), repeats)
    print_progress(f"{ERRORS} planted errors")
    rows += _measure_planted_errors(load_robot("six-joint"))
    if not UR5.exists():
        return [*rows, absent_row(TABLE, "UR5", "example-robot-data is not installed")]
    file = RobotFile(schema_version=1, name="UR5", urdf=UR5.name)
    return [
        *rows,
        *_measure_planted_errors(build_robot(file, UR5.read_text("utf-8"), "UR5", str(UR5))),
    ]


def _speeds(robot: Robot, repeats: int) -> list[Row]:
    states = sample_states(robot, TOGETHER, 0).q
    analytic_model, tree = (
        build_robot_model("analytic", robot, "links"),
        pin.buildModelFromXML(robot.urdf),
    )
    data, home = tree.createData(), pin.neutral(tree)
    places = [pin.integrate(tree, home, at) for at in states]
    runs: dict[str, Callable[[], object]] = {
        f"{ANALYTIC}, {TOGETHER} at once": lambda: [
            analytic_model.mass_matrix(states) for _ in range(LONGER)
        ],
        f"{ANALYTIC}, one by one": lambda: [
            analytic_model.mass_matrix(at[None]) for at in states[:CALLS]
        ],
        PIN: lambda: [pin.crba(tree, data, at) for _ in range(LONGER) for at in places],
    }
    units = dict(zip(runs, (TOGETHER * LONGER, CALLS, TOGETHER * LONGER), strict=True))
    rows = []
    try:
        adams = _adam(robot, states)
    except ImportError:
        rows.append(absent_row(TABLE, robot.name, "adam-robotics is not installed"))
    else:
        runs |= {f"{ADAM}, {TOGETHER} at once": adams[0], f"{ADAM}, one by one": adams[1]}
        units |= {f"{ADAM}, {TOGETHER} at once": TOGETHER, f"{ADAM}, one by one": CALLS}
    times = divide_times(run_in_turn(runs, repeats, processor_s), units)
    for name, name_times in times.items():
        rival = name.replace(ANALYTIC, ADAM) if name.startswith(ANALYTIC) else PIN
        against = rival if rival in times else PIN
        target = 1.0 if against.startswith(ADAM) else None
        rows.append(
            Row(
                TABLE,
                robot.name,
                f"mass matrix: {name}",
                name_times.median * 1e6,
                "us",
                against,
                name_times.median_ratio(times[against]),
                target,
                name_times.spread,
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
    mass_matrix = model.mass_matrix(base, states[0])[-free:, -free:]
    expected = build_robot_model("analytic", robot, "links").mass_matrix(states[:1])[0]
    if not np.allclose(mass_matrix, expected, rtol=1e-9, atol=1e-12):
        raise ValueError("adam's mass matrix is another")
    bases = np.tile(base, (len(states), 1, 1))
    return (
        partial(model.mass_matrix, bases, states),
        lambda: [model.mass_matrix(base, at) for at in states[:CALLS]],
    )


def _measure_planted_errors(robot: Robot) -> list[Row]:
    """How many of the errors that change equations are named, and whether right ones are blamed."""
    named, total = 0, 0
    for seed in count():
        if total == ERRORS:
            break
        error = planted(robot, seed)
        trial = run_robot_trial(robot_equations(error.robot), robot, seed=seed)
        if not trial.agrees:
            total += 1
            named += is_named(error, trial)
    unnamed = 1 - named / total
    blamed = sum(
        not run_robot_trial(robot_equations(robot), robot, seed=seed).agrees for seed in range(20)
    )
    return [
        Row(
            TABLE,
            robot.name,
            f"not named, of {ERRORS} planted errors that change its equations",
            100 * unnamed,
            "%",
            f"{100 * UNNAMED:g} %",
            unnamed / UNNAMED,
            1.0,
        ),
        Row(TABLE, robot.name, "right equations blamed, of 20", float(blamed), ""),
    ]
