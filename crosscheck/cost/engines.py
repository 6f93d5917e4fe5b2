"""Which models of a robot there are: the program's own, and those of installed packages."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import TYPE_CHECKING

from crosscheck.entry import entry_point_error, load_record

if TYPE_CHECKING:  # the names of engines are asked for without any schema
    from crosscheck.models.robot.interface import RobotModel
    from crosscheck.models.robot.robot import Level, Robot

ENTRY_POINTS = "geararm_crosscheck.robots"  # the group by which packages offer engines
REFERENCE_ENGINE = "analytic"  # the one that costs are worked out with


@dataclass(frozen=True)
class RobotEngine:
    """An engine for robots: where its class is, a RobotModel, and what to know of it.

    levels: those that it promises; empty for all.
    """

    module: str
    attribute: str
    levels: tuple[Level, ...] = ()
    title: str = ""

    def has_level(self, level: Level) -> bool:
        """Whether the engine has this level."""
        return not self.levels or level in self.levels


BUILT_IN_ENGINES = {
    REFERENCE_ENGINE: RobotEngine(
        "crosscheck.analytic.robot.model",
        "AnalyticRobot",
        title="the project's derivation by Kane's method",
    ),
    "pinocchio": RobotEngine(
        "crosscheck.models.pinocchio.robot",
        "PinocchioRobot",
        title="its own reader of URDFs, rotors as bodies of the tree",
    ),
    "exudyn": RobotEngine(
        "crosscheck.models.exudyn.robot",
        "ExudynRobot",
        title="kinematic tree in minimal coordinates, rotors as bodies of it",
    ),
}


FIELDS = {"module": str, "attribute": str, "levels": tuple, "title": str}


@cache
def load_engines() -> dict[str, RobotEngine]:
    """All engines by name, the program's own first.

    Raises InputError for an offer that cannot be imported, is no RobotEngine or has a taken name.
    """
    available_engines = dict(BUILT_IN_ENGINES)
    for offer in sorted(entry_points(group=ENTRY_POINTS), key=lambda each: each.name):
        if offer.name in available_engines:
            raise entry_point_error(offer, "an engine of this name exists already")
        available_engines[offer.name] = load_record(offer, RobotEngine, FIELDS)
    return available_engines


def build_model(engine: str, robot: Robot, level: Level) -> RobotModel:
    """A new model of the robot at the level; engine: a name of engines()."""
    entry = load_engines()[engine]
    return getattr(import_module(entry.module), entry.attribute)(robot, level)
