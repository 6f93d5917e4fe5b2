"""`crosscheck init --urdf`: a robot's file to begin with, with the names of its joints."""

from __future__ import annotations

import json
import os
import re
import shlex
from pathlib import Path

from crosscheck.cli.template import require_new
from crosscheck.models.arm.quantities import Printable
from crosscheck.models.errors import InputError
from crosscheck.models.robot.file import RobotFile, read_text, robot_of
from crosscheck.models.robot.robot import Robot
from crosscheck.output import write_text
from crosscheck.report.words import printable

HEAD = """\
# Which rotor turns each joint of {urdf}, whose joints these are. A joint without gears stays
# direct. Of one with gears the ratio, with its sign, and the rotor's inertia are needed:
#     {{ kind = "geared", ratio = 100.0, rotor_inertia_kg_m2 = 1e-4 }}
# The motor stands on the link before its joint, along the joint's axis, unless the file says
# stator = "a link", rotor_axis = [1.0, 0.0, 0.0]. docs/reference/robot-file.md lists all fields.
"""


def init_robot_command(path: Path, urdf: Path) -> None:
    """Write a file for the robot of a URDF. Raises InputError, also if the file exists."""
    require_new(path)
    own = os.path.relpath(urdf, path.parent)
    if not Printable(400).allows(own):
        allowed = f"must have {Printable(400)} from the folder of {path}"
        raise InputError("--urdf", "", own, allowed)
    name = path.stem if Printable(80).allows(path.stem) else "my-robot"
    file = RobotFile(schema_version=1, name=name, urdf=own)
    robot = robot_of(file, read_text(urdf), str(path), str(urdf))
    write_text(path, robot_template(robot, own))
    moved = [robot.joints[number].name for number in robot.coordinates]
    print(
        f"wrote {printable(str(path))}: {len(moved)} joints, all direct; state their rotors, then"
    )
    print(f"  crosscheck cost {printable(shlex.quote(str(path)))}")


def robot_template(robot: Robot, urdf: str) -> str:
    """The file's text: TOML with every joint that mimics none."""
    lines = [HEAD.format(urdf=urdf), "schema_version = 1", f"name = {_quoted(robot.name)}"]
    gravity = ", ".join(map(repr, robot.gravity.tolist()))
    lines += [f"urdf = {_quoted(urdf)}", f"gravity_m_per_s2 = [{gravity}]"]
    lines += [f"tip = {_quoted(robot.tip)}", "", "[joints]"]
    for number in robot.coordinates:
        name = robot.joints[number].name
        key = name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _quoted(name)
        lines.append(f'{key} = {{ kind = "direct" }}')
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
