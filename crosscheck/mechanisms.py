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
    "find_entry": ("registry:find_arm_entry", "registry:find_robot_entry"),
    "build": ("registry:build_arm_model", "registry:build_robot_experiment"),
    "export": ("cli.files.export:export_arm", "cli.files.export:export_robot"),
    "as_robot": ("cli.files.robot_files:read_arm_as_robot", "models.robot.file:load_robot"),
    "write_as_robot": (
        "cli.files.robot_files:write_arm_as_robot",
        "cli.files.robot_files:write_robot",
    ),
    "try_equations": ("testing:try_arm", "testing:try_robot"),
}
SECTIONS = ("arm", "robot")  # sorts by the names of their files' sections


def supply(what: str, section: str) -> Callable[..., Any]:
    """The function that a sort of mechanism supplies; section: of its file, arm or robot."""
    module, _, name = SUPPLIED[what][SECTIONS.index(section)].partition(":")
    function: Callable[..., Any] = getattr(import_module(f"crosscheck.{module}"), name)
    return function
