"""The one place that knows what each sort of mechanism supplies to commands: an arm, and a robot.

A command asks for a function by name, and never which sort it has. Both functions of a row take the
same arguments, and are imported on first use.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple


class Supply(NamedTuple):
    """Functions of one purpose, ``module:function``, by the sort of mechanism that they are for."""

    arm: str
    robot: str


SUPPLIED = {
    "plan": Supply("planning.arms:plan_arm", "planning.robots:plan_robot"),
    "describe_quick_limits": Supply(
        "planning.arms:describe_quick_limits", "planning.robots:describe_quick_limits"
    ),
    "outline": Supply("report.outline:outline_arm", "report.outline:outline_robot"),
    "answer_on_levels": Supply(
        "report.answers:answer_on_rigid_arm", "report.answers:answer_on_levels"
    ),
    "draw": Supply("report.plots.scheme:draw_arm", "report.plots.scheme:draw_robot"),
    "describe_scene": Supply("view.scene:describe_arm_scene", "view.scene:describe_robot_scene"),
    "show": Supply("cli.show:show_arm", "cli.show:show_robot"),
    "find_entry": Supply("registry:get_entry", "registry:find_robot_entry"),
    "build": Supply("registry:build_arm_model", "registry:build_robot_experiment"),
    "export": Supply("cli.files.export:export_arm", "cli.files.export:export_robot"),
    "write_as_robot": Supply(
        "models.robot.planar:write_arm_as_robot", "cli.files.robot_files:write_robot_as_robot"
    ),
    "compare": Supply(
        "identification.mechanism:PlanarArm", "identification.mechanism:SpatialRobot"
    ),
    "read_member": Supply("studies.members.cases:read_arm", "studies.members.cases:read_robot"),
    "make_member_model": Supply(
        "studies.members.cases:make_arm_model", "studies.members.cases:make_robot_model"
    ),
    "make_member_run": Supply(
        "studies.members.cases:make_arm_run", "studies.members.cases:make_robot_run"
    ),
    "find_rigid_model": Supply(
        "studies.members.cases:find_rigid_arm", "studies.members.cases:find_rigid_robot"
    ),
    "group_members": Supply(
        "analytic.ensemble:group_models", "analytic.robot.ensemble:group_robots"
    ),
    "load_equations": Supply(
        "trial.input.loading:load_equations", "trial.input.loading:load_robot_equations"
    ),
    "build_equations": Supply(
        "trial.input.loading:build_equations", "trial.input.loading:build_robot_equations"
    ),
    "build_frame": Supply(
        "trial.coordinates.build:build_frame", "trial.coordinates.robots:build_robot_frame"
    ),
    "trial_subject": Supply("trial.arms.subject:ArmSubject", "trial.robots.subject:RobotSubject"),
    "make_table": Supply(
        "trial.tables.state_requests:TableTrial", "trial.tables.robot_requests:RobotTableTrial"
    ),
}


def supply(what: str, section: str) -> Callable[..., Any]:
    """The function of a purpose that a sort of mechanism supplies; section: arm or robot."""
    module, _, name = getattr(SUPPLIED[what], section).partition(":")
    return getattr(import_module(f"crosscheck.{module}"), name)
