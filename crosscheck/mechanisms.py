"""The one place that knows what each sort of mechanism supplies to commands: an arm, and a robot.

A command asks for a function by name, and never which sort it has. Both functions of a row take the
same arguments, and are imported on first use.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

SECTIONS = "arm", "robot"
CASES, LOADING = "studies.members.cases", "trial.input.loading"
# Functions by purpose, ``module:function``: for an arm, and for a robot.
SUPPLIED = {
    "plan": ("planning.arms:plan_arm", "planning.robots:plan_robot"),
    "describe_quick_limits": (
        "planning.arms:describe_quick_limits",
        "planning.robots:describe_quick_limits",
    ),
    "outline": ("report.outline:outline_arm", "report.outline:outline_robot"),
    "answer_on_levels": ("report.answers:answer_on_rigid_arm", "report.answers:answer_on_levels"),
    "draw": ("report.plots.scheme:draw_arm", "report.plots.scheme:draw_robot"),
    "describe_scene": ("view.scene:describe_arm_scene", "view.scene:describe_robot_scene"),
    "show": ("cli.show:show_arm", "cli.show:show_robot"),
    "find_entry": ("registry:get_entry", "registry:find_robot_entry"),
    "build": ("registry:build_arm_model", "registry:build_robot_experiment"),
    "export": ("cli.files.export:export_arm", "cli.files.export:export_robot"),
    "write_as_robot": (
        "models.robot.planar:write_arm_as_robot",
        "cli.files.robot_files:write_robot_as_robot",
    ),
    "compare": ("identification.mechanism:PlanarArm", "identification.mechanism:SpatialRobot"),
    "read_member": (f"{CASES}:read_arm", f"{CASES}:read_robot"),
    "make_member_model": (f"{CASES}:make_arm_model", f"{CASES}:make_robot_model"),
    "find_rigid_model": (f"{CASES}:find_rigid_arm", f"{CASES}:find_rigid_robot"),
    "build_equations": (f"{LOADING}:build_equations", f"{LOADING}:build_robot_equations"),
    "build_frame": (
        "trial.coordinates.build:build_frame",
        "trial.coordinates.robots:build_robot_frame",
    ),
    "trial_subject": ("trial.arms.subject:ArmSubject", "trial.robots.subject:RobotSubject"),
    "make_table": (
        "trial.tables.state_requests:TableTrial",
        "trial.tables.robot_requests:RobotTableTrial",
    ),
}


def supply(what: str, section: str) -> Callable[..., Any]:
    """The function of a purpose that a sort of mechanism supplies; section: arm or robot."""
    module, _, name = SUPPLIED[what][SECTIONS.index(section)].partition(":")
    return getattr(import_module(f"crosscheck.{module}"), name)
