"""Part 9: the kernel of robots beside Pinocchio in C++, and beside real time.

Pinocchio is compiled from its wheel's own headers for this machine, with Boost's of a wheel and
Eigen's of the system, of a wheel (cmeel-eigen) or of $EIGEN; else it is called from Python.
"""

from __future__ import annotations

import os
import subprocess
import sysconfig
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pinocchio as pin

from benchmarks.suite.c_reference import SOURCES, find_compiler
from benchmarks.suite.robot_states import RobotStates
from benchmarks.suite.rows import Row
from benchmarks.suite.timing import (
    Times,
    divide_times,
    measure_seconds,
    print_progress,
    processor_s,
    run_in_turn,
)
from crosscheck.analytic.kernel.batch import Batch
from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.robot.runs import RobotMember
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.files import HERE
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import MESH_LAWS, Level, Robot, RotorMesh
from crosscheck.provenance import ROOT
from crosscheck.registry import build_robot_model

TABLE = "robots' kernel"
NAME, LEVELS = "puma560", ("links", "coupled")
STATES = 1024  # of a call: as many as stay in a processor's second cache
CALLS = 20 * STATES
PREFIX = Path(sysconfig.get_path("purelib"), "cmeel.prefix")
EIGEN = (os.environ.get("EIGEN", ""), "/usr/include/eigen3", str(PREFIX / "include" / "eigen3"))
FLAGS = (
    *("-O3", "-march=native", "-std=c++17", "-DNDEBUG", "-w"),
    *("-DBOOST_FUSION_INVOKE_MAX_ARITY=10", "-DBOOST_MPL_LIMIT_LIST_SIZE=40"),
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
)
MESH = RotorMesh(
    pinion_base_radius_m=0.01, stiffness_N_per_m=1e6, damping_N_s_per_m=40.0, backlash_m=5e-5
)
REAL_TIME = "real time"
RUN_S, STEPS = 1.0, 5000  # of a run, simulated; of a batch
LEAST = {"aba": (8, 60), "crba": (5, None)}  # times as fast, one state at a time and in lanes


def measure(repeats: int) -> list[Row]:
    """Forward dynamics and M of a state; seconds for a simulated second."""
    robot = load_robot(NAME)
    rival, reference = _build_reference()
    runs = {}
    for level in LEVELS:
        for lanes in (1, 8):
            runs |= _kernel_runs(robot, level, lanes)
    for run in (*runs.values(), reference):
        run()
    rounds: list[dict[str, float]] = []
    for _ in range(repeats):
        own = {name: measure_seconds(run, processor_s) / CALLS for name, run in runs.items()}
        rounds.append({**own, **reference()})
    times = {name: Times(tuple(each[name] for each in rounds)) for name in rounds[0]}
    rows = [_speed_row(name, own, rival, times) for name, own in times.items()]
    return [*rows, *_run_rows(repeats), *_planar_rows(repeats)]


def _kernel_runs(robot: Robot, level: Level, lanes: int) -> dict[str, Callable[[], object]]:
    """CALLS evaluations of states, at so many lanes."""
    states, rng = RobotStates(robot, level, lanes), np.random.default_rng(0)
    q, v, torques = rng.normal(size=(3, STATES, len(robot.coordinates)))
    blocks = {"aba": states.dynamics_blocks(q, v, torques), "crba": states.mass_blocks(q)}

    def evaluate(name: str) -> None:
        for _ in range(CALLS // STATES):
            blocks[name].evaluate()

    return {f"{name}, {level}, {lanes} lanes": partial(evaluate, name) for name in blocks}


def _speed_row(name: str, own: Times, rival: str, times: dict[str, Times]) -> Row:
    what, _, rest = name.partition(", ")
    quantity = {"aba": "forward dynamics", "crba": "M"}[what]
    if not rest:
        return Row(TABLE, NAME, f"{what}, {rival}", own.median * 1e9, "ns", spread=own.spread)
    singly, abreast = LEAST[what]
    least = singly if rest.endswith("1 lanes") else abreast
    target = 1 / least if least else None
    ratio = own.median_ratio(times[what])
    against = f"{what}, {rival}"
    text = f"{quantity} of a state, {rest}"
    return Row(TABLE, NAME, text, own.median * 1e9, "ns", against, ratio, target, own.spread)


def _build_reference() -> tuple[str, Callable[[], dict[str, float]]]:
    """What Pinocchio is here, and its seconds for a call of aba and of crba."""
    print_progress("compiling Pinocchio's headers, some minutes")
    eigen = next((path for path in EIGEN if path and Path(path, "Eigen").is_dir()), None)
    urdf = HERE / "robots" / f"{NAME}.urdf"
    if eigen is not None:
        made = Path(tempfile.mkdtemp(), "pinocchio_robot")
        folders = (f"-I{PREFIX / 'include'}", f"-I{eigen}", f"-L{PREFIX / 'lib'}")
        libraries = ("-lpinocchio_default", f"-Wl,-rpath,{PREFIX / 'lib'}")
        source = str(SOURCES / "pinocchio_robot.cpp")
        command = [_cpp_compiler(), *FLAGS, source, "-o", str(made), *folders, *libraries]
        if subprocess.run(command, capture_output=True).returncode == 0:
            return "Pinocchio in C++", partial(_reference_seconds, made, load_robot(NAME))
    return "Pinocchio from Python", partial(_python_seconds, urdf)


def _cpp_compiler() -> str:
    return os.environ.get("CXX") or find_compiler().replace("cc", "c++")


def _reference_seconds(program: Path, robot: Robot) -> dict[str, float]:
    command = [str(program), str(CALLS)]
    done = subprocess.run(
        command, input=_numbers(robot), capture_output=True, text=True, check=True
    )
    lines = done.stdout.splitlines()
    return {name: float(took) / CALLS for name, took in map(str.split, lines)}


def _numbers(robot: Robot) -> str:
    """A robot whose joints turn about axes of their frames, as the reference reads it."""
    lines = []
    for joint, body in zip(robot.joints, robot.bodies, strict=True):
        axis = int(np.argmax(joint.axis))
        assert joint.kind == "revolute"
        assert joint.axis[axis] == 1.0
        placement = joint.placement
        parts = placement.rotation, placement.position, body.mass, body.com, body.inertia
        numbers = np.concatenate([np.ravel(part) for part in parts])
        words = (joint.parent + 1, axis, *(repr(float(number)) for number in numbers))
        lines.append(" ".join(map(str, words)))
    return "\n".join(lines)


def _python_seconds(urdf: Path) -> dict[str, float]:
    tree = pin.buildModelFromUrdf(str(urdf))
    data, q = tree.createData(), pin.neutral(tree)
    calls = {
        "aba": lambda: [pin.aba(tree, data, q, q, q) for _ in range(CALLS)],
        "crba": lambda: [pin.crba(tree, data, q) for _ in range(CALLS)],
    }
    return {name: measure_seconds(call, processor_s) / CALLS for name, call in calls.items()}


def _scenario(joints: int, step_s: float) -> Scenario:
    """A run under small torques from a bent pose, hardly recorded."""
    steps = round(RUN_S / step_s)
    return Scenario.model_validate(
        {
            "schema_version": 1,
            "name": "run",
            "duration_s": steps * step_s,
            "step_s": step_s,
            "record_every": steps,
            "start": {"theta_rad": [0.3] * joints},
            "drive": {"kind": "constant", "torque_N_m": [2.0] * joints},
        }
    )


def _run_rows(repeats: int) -> list[Row]:
    """Seconds for a simulated second, of robots whose every joint has teeth that give way."""
    six = load_robot("six-joint")
    sprung = replace(six, rotors=tuple(replace(rotor, mesh=MESH) for rotor in six.rotors))
    paper = load_robot(str(ROOT / "examples" / "robots" / "planetary-arm.toml"))
    rows = []
    for robot, rate, least in ((paper, 76_868, 5), (sprung, 100_000, 10)):
        model, scenario = (
            build_robot_model("analytic", robot, "geared"),
            _scenario(len(robot.coordinates), 1 / rate),
        )
        model.integrate(scenario)
        took = Times(
            tuple(
                measure_seconds(lambda m=model, s=scenario: m.integrate(s), processor_s) / RUN_S
                for _ in range(repeats)
            )
        )
        what = f"a simulated second at {rate:,} steps a second"
        figures = took.median, "s", REAL_TIME, took.median, 1 / least, took.spread
        rows.append(Row(TABLE, f"{robot.name}, geared", what, *figures))
    return rows


def _planar_rows(repeats: int) -> list[Row]:
    """A step of the paper's arm as a robot, beside the text by hand over its absolute angles."""
    scenario = _scenario(2, 1 / 76_868)
    robot = load_robot(str(ROOT / "examples" / "robots" / "planetary-arm.toml"))
    members = {
        "traced": RobotMember(robot, "geared", scenario),
        "by hand": PhysicalModel(load_arm("paper-labelled"), scenario, MESH_LAWS),
    }
    rows = []
    for lanes in (1, 8):
        batches = {name: Batch([member] * lanes, lanes) for name, member in members.items()}
        runs = {name: partial(batch.advance, 1, STEPS) for name, batch in batches.items()}
        times = divide_times(
            run_in_turn(runs, repeats, processor_s), dict.fromkeys(runs, STEPS * lanes)
        )
        for name, own in times.items():
            ratio = own.median_ratio(times["by hand"])
            text = f"a step, {lanes} lanes, {name}"
            figures = own.median * 1e9, "ns", "by hand", ratio, None, own.spread
            rows.append(Row(TABLE, "planetary-arm, geared", text, *figures))
    return rows
