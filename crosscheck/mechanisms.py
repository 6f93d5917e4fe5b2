"""The one place that knows what each sort of mechanism supplies to commands: an arm, and a robot.

A command asks for a function by name, and never which sort it has. Both functions of a row take the
same arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

# Functions by what they are asked for: of arms, then of robots; imported on first use.
SUPPLIED = {
    "plan": ("planning.arms:plan_arm", "planning.robots:plan_robot"),
    "describe_quick_limits": (
        "planning.arms:describe_quick_limits",
        "planning.robots:describe_quick_limits",
    ),
    "outline": ("report.outline:outline_arm", "report.outline:outline_robot"),
    "answer_on_levels": ("report.answers:answer_on_rigid_arm", "report.answers:answer_on_levels"),
    "draw": ("report.plots.scheme:draw_arm", "report.plots.scheme:draw_robot"),
    "show": ("cli.show:show_arm", "cli.show:show_robot"),
    "describe_scene": ("view.scene:describe_arm_scene", "view.robot_scene:describe_robot_scene"),
    "find_entry": ("registry:get_entry", "registry:find_robot_entry"),
    "build": ("registry:build_arm_model", "registry:build_robot_experiment"),
    "export": ("cli.files.export:export_arm", "cli.files.export:export_robot"),
    "as_robot": ("cli.files.robot_files:read_arm_as_robot", "models.robot.file:load_robot"),
    "write_as_robot": (
        "cli.files.robot_files:write_arm_as_robot",
        "cli.files.robot_files:write_robot",
    ),
    "read_member": ("studies.members.arms:read_member", "studies.members.robots:read_member"),
    "require_fitting": ("studies.members.arms:require_fit", "studies.members.robots:require_fit"),
    "make_member_model": ("studies.members.arms:make_model", "studies.members.robots:make_model"),
    "make_member_run": ("studies.members.arms:make_run", "studies.members.robots:make_run"),
    "find_rigid_model": (
        "studies.members.arms:find_rigid_model",
        "studies.members.robots:find_rigid_model",
    ),
    "group_members": ("analytic.ensemble:group_models", "analytic.robot.ensemble:group_robots"),
    "try_equations": ("testing:try_arm", "testing:try_robot"),
}
SECTIONS = ("arm", "robot")  # sorts by the names of their files' sections


def supply(what: str, section: str) -> Callable[..., Any]:
    """The function that a sort of mechanism supplies; section: of its file, arm or robot."""
    module, _, name = SUPPLIED[what][SECTIONS.index(section)].partition(":")
    function: Callable[..., Any] = getattr(import_module(f"crosscheck.{module}"), name)
    return function
