"""An arm or a robot written as a robot: its URDF, and the robot's file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from math import inf, isfinite
from pathlib import Path

from crosscheck.file_types import ROBOT_FILE, URDF_FILE
from crosscheck.mechanisms import supply
from crosscheck.models.errors import InputError, make_printable
from crosscheck.models.files import format_toml_fields, parse_toml
from crosscheck.models.loading import validate_record
from crosscheck.models.mechanism import select_mechanism
from crosscheck.models.robot.file import RobotFile, build_robot, load_urdf, read_text
from crosscheck.models.robot.planar import RobotText
from crosscheck.models.robot.robot import Robot, remove_friction
from crosscheck.models.robot.urdf_gears import StatedGear, StatedNumber, read_gears
from crosscheck.output import require_file, write_files

STATE_ROTORS = "; {}; for a first answer add"
STATED_IN = {
    "robot": "`crosscheck init` writes a robot file for them",
    "arm": "they belong in the arm's file",
}
EXAMPLES = {"--ratio": "101", "--rotor-inertia": "1e-4"}
FRICTIONLESS = "friction of joints left out, which is the same at each level"


def export_as_robot(name: str, settings: list[str], out: Path) -> None:
    """Write an arm or robot as a URDF, and the robot's file beside it. Raises InputError."""
    chosen, file = select_mechanism(name, (), settings).mechanism, out.with_suffix(".toml")
    require_file(out, URDF_FILE, "--out")
    require_file(file, ROBOT_FILE, "--out")
    text = supply("write_as_robot", chosen.section)(chosen, out.name)
    write_files({out: text.urdf, file: text.file})
    print(make_printable(f"wrote {out} and {file}: {len(chosen.joints)} joints"))


def load_as_robot(
    name: str, ratio: float | None = None, rotor_inertia: float | None = None
) -> Robot:
    """The robot of a name or file, or an arm as one, without friction, with a rotor at least.

    Friction is the same at each level of the gears, and is left out with a note.

    Args:
        name: Built-in name or file.
        ratio: Of each joint without a rotor whose URDF states no ratio.
        rotor_inertia: Of each joint without a rotor whose URDF states none [kg m^2].

    Raises:
        InputError: The file does not fit, or no joint has a rotor or an armature, or each has one
            and another is given.
    """
    if ratio is not None and not (ratio and isfinite(ratio)):
        raise InputError("--ratio", "", ratio, "must be a finite number other than 0")
    if rotor_inertia is not None and not 0 < rotor_inertia < inf:
        raise InputError("--rotor-inertia", "", rotor_inertia, "must be finite and above 0")
    mechanism = select_mechanism(name).mechanism
    text = supply("write_as_robot", mechanism.section)(mechanism, "mechanism.urdf")
    content = parse_toml(text.file)
    robot = build_robot(validate_record(RobotFile, content, name), text.urdf, name, name)
    has_rotors = bool(robot.rotors or robot.stages or robot.armature.any())
    numbers = [None if v is None else StatedNumber(v, "option") for v in (ratio, rotor_inertia)]
    is_robot = mechanism.section == "robot"  # whose URDF is read again, with its transmissions
    urdf = read_text(Path(load_urdf(name)[1])) if is_robot else text.urdf
    rotors, lacks = _complete_rotors(robot, read_gears(urdf, name)[0], StatedGear(*numbers))
    if any(numbers) and rotors:
        tables = content.setdefault("joints", {})
        tables |= {joint: {**tables.get(joint, {}), **rotor} for joint, rotor in rotors.items()}
        robot = build_robot(validate_record(RobotFile, content, name), text.urdf, name, name)
    elif any(numbers) or not has_rotors:
        enough = "each has a rotor" if robot.motors else "no motor drives any"
        options = zip(EXAMPLES.items(), numbers, strict=True)
        missing = [f"{option} {value}" for (option, value), given in options if given is None]
        state = STATE_ROTORS.format(STATED_IN[mechanism.section])
        allowed = f"{'; '.join(lacks)}{state} {' '.join(missing)}" if lacks else enough
        raise InputError(name, "", None, allowed)
    if not robot.friction.any():
        return robot
    return replace(remove_friction(robot), notes=(*robot.notes, FRICTIONLESS))


def _complete_rotors(
    robot: Robot, stated: Mapping[str, StatedGear], given: StatedGear
) -> tuple[dict[str, dict[str, object]], list[str]]:
    """Tables of rotors for joints without one, and lines on the numbers that are missing.

    Numbers that the URDF states, by joint, come before given ones.
    """
    geared = {r.joint for r in robot.rotors} | {s.joint for s in robot.stages}
    tables, lacks = dict[str, dict[str, object]](), dict[str, list[str]]()
    motors = [robot.coordinates[place] for place in robot.motors]
    for joint in (robot.joints[n] for n in motors if n not in geared):
        gear = stated.get(joint.name, StatedGear())
        inertia = gear.inertia or (None if gear.armature else given.inertia)
        gear = replace(gear, ratio=gear.ratio or given.ratio, inertia=inertia)
        tables |= {joint.name: gear.table} if gear.table else {}
        missing = ["a ratio"] * (gear.ratio is None)
        missing += ["a rotor inertia"] * (gear.inertia is None and gear.armature is None)
        lacks.setdefault(" and ".join(missing) or "a table of its rotor", []).append(joint.name)
    return tables, [f"{', '.join(names)}: without {lack}" for lack, names in lacks.items()]


def write_robot_as_robot(robot: Robot, urdf: str) -> RobotText:
    """The texts of a robot, its settings in its file; urdf: name of the URDF."""
    content = {**json.loads(robot.file_json), "urdf": urdf}
    return RobotText(robot.urdf, "\n".join([*format_toml_fields(content), ""]))
