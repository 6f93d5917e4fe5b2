"""Slips in numbers as the file has them: of links that are merged, and of a rotor's usual place."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from crosscheck.models.robot.file import load_robot
from crosscheck.models.robot.robot import Robot
from tests.robots.test_robot_slips_everywhere import diagnosis_of

FILES = Path("models/robots")


def six_joint(folder: Path, urdf: Callable[[str], str], toml: Callable[[str], str]) -> Robot:
    """The robot of six joints, whose tool is fixed to its wrist, out of changed files."""
    for name, change in (("six-joint.urdf", urdf), ("six-joint.toml", toml)):
        (folder / name).write_text(change((FILES / name).read_text()))
    return load_robot(str(folder / "six-joint.toml"))


def turn_products(text: str) -> str:
    return re.sub(
        r'(ix[yz]|iyz)="(-?)([^"]*)"', lambda m: f'{m[1]}="{"" if m[2] else "-"}{m[3]}"', text
    )


def leave_out_places(text: str) -> str:
    return re.sub(r",? *(stator|rotor_axis) = (\"[^\"]*\"|\[[^\]]*\])", "", text)


SLIPS: dict[str, tuple[Callable[[str], str], Callable[[str], str], str]] = {
    "products of inertia in the axes of the file": (
        turn_products,
        str,
        "every link: all products of inertia with the opposite sign",
    ),
    "the rotor's place and axis": (
        str,
        leave_out_places,
        "on the link before its joint, along the joint's axis",
    ),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_in_the_file_s_own_numbers_is_named(slip, tmp_path):
    urdf, toml, words = SLIPS[slip]
    diagnosis = diagnosis_of(load_robot("six-joint"), six_joint(tmp_path, urdf, toml))
    assert any(words in each for each in diagnosis.explanations)
    assert diagnosis.level == "coupled"
