"""The one place that knows which models exist and where."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager

from models.arm import Arm
from models.errors import InputError
from models.interface import Model
from models.scenario import Scenario
from models.switches import Switches

MODELS = {
    "analytic:physical": ("analytic.model", "PhysicalModel"),
    "analytic:energies": ("analytic.model", "EnergiesModel"),
    "analytic:printed": ("analytic.model", "PrintedModel"),
    "analytic:links": ("analytic.model", "RigidLinks"),
    "analytic:carriers": ("analytic.model", "RigidCarriers"),
    "analytic:armature": ("analytic.model", "RigidArmature"),
    "analytic:coupled": ("analytic.model", "RigidCoupled"),
    "pinocchio:links": ("models.pinocchio_rigid", "PinocchioLinks"),
    "pinocchio:carriers": ("models.pinocchio_rigid", "PinocchioCarriers"),
    "pinocchio:armature": ("models.pinocchio_rigid", "PinocchioArmature"),
    "pinocchio:coupled": ("models.pinocchio_rigid", "PinocchioCoupled"),
    "pinocchio:gears": ("models.pinocchio_gears", "PinocchioGears"),
    "exudyn:tree": ("models.exudyn_tree", "ExudynTree"),
    "exudyn:bodies": ("models.exudyn_bodies", "ExudynBodies"),
}
RIGID_LEVELS = ("links", "carriers", "armature", "coupled")
PAPER_FORMS = ("analytic:energies", "analytic:printed")
GEARED = ("analytic:physical", "pinocchio:gears", "exudyn:tree", "exudyn:bodies")


def model_class(name: str) -> type[Model]:
    """The class of a model name, its engine imported on first use.

    Raises InputError for an unknown name or an engine that cannot be imported.
    """
    if name not in MODELS:
        raise InputError("model", "", name, f"unknown; allowed: {', '.join(MODELS)}")
    module, attribute = MODELS[name]
    try:
        return getattr(importlib.import_module(module), attribute)
    except ImportError as error:
        reason = " ".join(str(error).split())
        raise InputError("model", "", name, f"its engine cannot be imported: {reason}") from None


@contextmanager
def usable_numbers(what: str, arm: Arm) -> Iterator[None]:
    """Raise InputError naming what is made of which arm, where its numbers break the arithmetic."""
    from numpy.linalg import LinAlgError

    try:
        yield
    except (ArithmeticError, LinAlgError) as error:
        reason = f"{type(error).__name__}: {error}"
        raise InputError(arm.name, "", None, f"{what} cannot use its numbers: {reason}") from None


def build(name: str, arm: Arm, scenario: Scenario, switches: Switches | None = None) -> Model:
    """The named model of this arm in this experiment. Raises InputError."""
    model = model_class(name)
    with usable_numbers(name, arm):
        return model(arm, scenario, switches)
