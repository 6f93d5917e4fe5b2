"""Part 9: `compare` of a million rows of seven joints, from the CSV file to the answer."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.suite.machine import ROOT
from benchmarks.suite.rows import Row
from benchmarks.suite.timing import print_progress
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import build_robot_model
from tests.measured.robots import motion
from tests.robots import chains

TABLE = "recordings"
ROWS, JOINTS, STEP_S, TOGETHER = 1_000_000, 7, 1e-3, 10_000
LIMIT_S = 60.0
ARMATURE, COULOMB, NOISE = 0.2, 1.0, 0.1  # kg m^2, N m, N m
ANSWERS = (0, 1)  # exit codes of a comparison


def measure(repeats: int) -> list[Row]:
    """Processor time and largest memory of the command, once; a tenth of the rows where quick."""
    rows = ROWS // 10 if repeats == 1 else ROWS
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        print_progress("writing")
        write_recording(folder, build_chain(), rows)
        print_progress("comparing")
        command = [sys.executable, "-m", "crosscheck", "compare"]
        files = [str(folder / "record.toml"), str(folder / "robot.urdf")]
        process = subprocess.Popen(command + files, cwd=ROOT, stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        if os.waitstatus_to_exitcode(status) not in ANSWERS:
            raise RuntimeError(f"compare ended with {os.waitstatus_to_exitcode(status)}")
    case, seconds = f"{rows:,} rows, {JOINTS} joints", used.ru_utime + used.ru_stime
    limit, share = f"{LIMIT_S:g} s", seconds / LIMIT_S
    return [
        Row(TABLE, case, "compare, processor time", seconds, "s", limit, share, 1.0),
        Row(TABLE, case, "compare, largest memory", used.ru_maxrss / 1000, "MB"),
    ]


def build_chain() -> Robot:
    """Seven joints whose axes take turns."""
    parts = [chains.link("l0")]
    for number in range(1, JOINTS + 1):
        axis = ((0, 0, 1), (0, 1, 0), (1, 0, 0))[number % 3]
        at = (0.1, 0.0, 0.2)
        parts.append(chains.joint(f"j{number}", f"l{number - 1}", f"l{number}", axis=axis, at=at))
        solid = chains.Solid(8.0 / number, (0.1, 0.02, 0.1), (0.1, 0, 0, 0.2, 0, 0.15))
        parts.append(chains.link(f"l{number}", solid))
    return chains.robot(chains.urdf(*parts))


def write_recording(folder: Path, robot: Robot, rows: int) -> None:
    """Write the robot, its recording and what its columns are."""
    model, rng = build_robot_model("analytic", robot, "links"), np.random.default_rng(0)
    columns = {kind: [f"{kind}{joint}" for joint in range(JOINTS)] for kind in ("q", "torque")}
    with (folder / "record.csv").open("w", encoding="utf-8") as file:
        file.write(",".join(["t", *columns["q"], *columns["torque"]]) + "\n")
        for first in range(0, rows, TOGETHER):
            time = STEP_S * np.arange(first, min(first + TOGETHER, rows))
            q, v, a = motion(time, JOINTS, 0)
            torque = model.inverse_dynamics(q, v, a) + ARMATURE * a + COULOMB * np.sign(v)
            torque += NOISE * rng.normal(size=q.shape)
            np.savetxt(file, np.column_stack([time, q, torque]), fmt="%.8g", delimiter=",")
    (folder / "robot.urdf").write_text(robot.urdf, encoding="utf-8")
    (folder / "record.toml").write_text(
        'schema_version = 1\ntime = "t"\nrecordings = [{ position = "record.csv" }]\n'
        f"[position]\ncolumns = {columns['q']}\n[motor_torque]\ncolumns = {columns['torque']}\n",
        encoding="utf-8",
    )
