"""The one place that knows what each sort of mechanism supplies to commands: an arm, and a robot.

A command asks for a function by name, and never which sort it has. Functions of one name take the
same arguments, and are imported on first use.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

SECTIONS = ("arm", "robot")  # sorts by the names of their files' sections
# Functions by what they are asked for: one with {} for the sort, or that of arms | that of robots.
SUPPLIED = {
    "plan": "planning.{}s:plan_{}",
    "describe_quick_limits": "planning.{}s:describe_quick_limits",
    "outline": "report.outline:outline_{}",
    "answer_on_levels": "report.answers:answer_on_rigid_arm|report.answers:answer_on_levels",
    "draw": "report.plots.scheme:draw_{}",
    "describe_scene": "view.scene:describe_{}_scene",
    "show": "cli.show:show_{}",
    "find_entry": "registry:get_entry|registry:find_robot_entry",
    "build": "registry:build_arm_model|registry:build_robot_experiment",
    "export": "cli.files.export:export_{}",
    "write_as_robot": "models.robot.planar:write_arm_as_robot"
    "|cli.files.robot_files:write_robot_as_robot",
    "compare": "identification.mechanism:PlanarArm|identification.mechanism:SpatialRobot",
    "read_member": "studies.members.cases:read_{}",
    "make_member_model": "studies.members.cases:make_{}_model",
    "make_member_run": "studies.members.cases:make_{}_run",
    "find_rigid_model": "studies.members.cases:find_rigid_{}",
    "group_members": "analytic.ensemble:group_models|analytic.robot.ensemble:group_robots",
    "try_equations": "testing:try_{}",
}


def supply(what: str, section: str) -> Callable[..., Any]:
    """The function that a sort of mechanism supplies; section: of its file, arm or robot."""
    name = (SUPPLIED[what].split("|") * 2)[SECTIONS.index(section)]
    module, _, attribute = name.replace("{}", section).partition(":")
    function: Callable[..., Any] = getattr(import_module(f"crosscheck.{module}"), attribute)
    return function
