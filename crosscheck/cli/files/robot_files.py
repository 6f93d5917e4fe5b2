"""An arm or a robot written as a robot: its URDF, and the robot's file."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from crosscheck.file_types import ROBOT_FILE, URDF_FILE
from crosscheck.mechanisms import supply
from crosscheck.models.files import format_toml_fields, parse_toml
from crosscheck.models.loading import validate_record
from crosscheck.models.mechanism import select_mechanism
from crosscheck.models.robot.file import RobotFile, build_robot
from crosscheck.models.robot.planar import RobotText
from crosscheck.models.robot.robot import Robot, remove_friction
from crosscheck.output import require_file, write_files
from crosscheck.report.formatting import make_printable

FRICTIONLESS = "friction of joints left out, which is the same at each level"


def export_as_robot(name: str, settings: list[str], out: Path) -> None:
    """Write an arm or robot as a URDF, and the robot's file beside it. Raises InputError."""
    chosen, file = select_mechanism(name, (), settings).mechanism, out.with_suffix(".toml")
    require_file(out, URDF_FILE, "--out")
    require_file(file, ROBOT_FILE, "--out")
    text = supply("write_as_robot", chosen.section)(chosen, out.name)
    write_files({out: text.urdf, file: text.file})
    print(make_printable(f"wrote {out} and {file}: {len(chosen.joints)} joints"))


def load_as_robot(name: str) -> Robot:
    """The robot of a name or file, or an arm as one, without friction. Raises InputError.

    Friction is the same at each level of the gears, and is left out with a note.
    """
    mechanism = select_mechanism(name).mechanism
    text = supply("write_as_robot", mechanism.section)(mechanism, "mechanism.urdf")
    file = validate_record(RobotFile, parse_toml(text.file), name)
    robot = build_robot(file, text.urdf, name, name)
    if not robot.friction.any():
        return robot
    return replace(remove_friction(robot), notes=(*robot.notes, FRICTIONLESS))


def write_robot_as_robot(robot: Robot, urdf: str) -> RobotText:
    """The texts of a robot, its settings in its file; urdf: name of the URDF."""
    content = {**json.loads(robot.file_json), "urdf": urdf}
    return RobotText(robot.urdf, "\n".join([*format_toml_fields(content), ""]))
