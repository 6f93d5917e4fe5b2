"""A planar arm written as a robot: its URDF, and the robot's file with its planetary stages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from crosscheck.file_types import ROBOT_FILE, URDF_FILE
from crosscheck.models.files import is_robot
from crosscheck.models.loading import load_selection
from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.planar import build_planar_robot, write_as_robot
from crosscheck.models.robot.robot import Robot, remove_friction
from crosscheck.output import require_file, write_files
from crosscheck.report.formatting import make_printable

FRICTIONLESS = "friction of joints left out, which is the same at each level"


def export_arm_as_robot(name: str, settings: list[str], out: Path) -> None:
    """Write an arm as a URDF, and as the robot's file beside it. Raises InputError."""
    selection = load_selection(name, [], settings)
    file = out.with_suffix(".toml")
    require_file(out, URDF_FILE, "--out")
    require_file(file, ROBOT_FILE, "--out")
    text = write_as_robot(selection.arm, out.name)
    write_files({out: text.urdf, file: text.file})
    print(make_printable(f"wrote {out} and {file}: {len(selection.arm.joints)} joints"))


def load_as_robot(name: str) -> Robot:
    """The robot of a name or file, or an arm as one, without friction. Raises InputError.

    Friction is the same at each level of the gears, and is left out with a note.
    """
    robot = load_robot(name) if is_robot(name) else build_planar_robot(load_selection(name).arm)
    if not robot.friction.any():
        return robot
    return replace(remove_friction(robot), notes=(*robot.notes, FRICTIONLESS))
