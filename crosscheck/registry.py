"""The one place that knows which models exist, where, and what each promises."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

from models.arm import Arm
from models.errors import InputError
from models.interface import STATE_ABILITIES, Model, gear_coordinates, link_coordinates
from models.scenario import Scenario
from models.switches import Switches

Role = Literal["geared", "form", "rigid"]
STATES = frozenset(STATE_ABILITIES)
RUNS = STATES | {"simulate"}
BOTH_WAYS = RUNS | {"reference"}
RIGID_LEVELS = ("links", "carriers", "armature", "coupled")


@dataclass(frozen=True)
class Entry:
    """A model: where its class is, and what a cross-check may count on.

    role: ``geared`` must agree with every other geared model; a ``form`` is the paper's and is
    measured against them; ``rigid`` has no gears. promises: methods that a cross-check uses; it
    plans by these and never by what the class says of itself, so that nothing goes unnoticed.
    order: of its fixed-step integrator, None for one that chooses its steps. free_planets: whether
    every planet moves by itself inside. call_s: rough cost [s] of a step or state. any_stride:
    whether its states are the same, bit by bit, however often they are recorded.
    """

    module: str
    attribute: str
    role: Role
    promises: frozenset[str]
    order: int | None = None
    free_planets: bool = False
    call_s: float = 1e-5
    any_stride: bool = False

    def coordinates(self, joints: int) -> tuple[str, ...]:
        """What its coordinates must be for an arm of so many joints."""
        return link_coordinates(joints) if self.role == "rigid" else gear_coordinates(joints)


def _analytic(attribute: str, role: Role, promises: frozenset[str] = RUNS) -> Entry:
    return Entry("analytic.model", attribute, role, promises, order=4, any_stride=True)


def _pinocchio(attribute: str) -> Entry:
    return Entry("models.pinocchio_rigid", attribute, "rigid", BOTH_WAYS)


MODELS = {
    "analytic:physical": _analytic("PhysicalModel", "geared", BOTH_WAYS | {"mesh_modes"}),
    "analytic:energies": _analytic("EnergiesModel", "form"),
    "analytic:printed": _analytic("PrintedModel", "form"),
    "analytic:links": _analytic("RigidLinks", "rigid"),
    "analytic:carriers": _analytic("RigidCarriers", "rigid"),
    "analytic:armature": _analytic("RigidArmature", "rigid"),
    "analytic:coupled": _analytic("RigidCoupled", "rigid"),
    "pinocchio:links": _pinocchio("PinocchioLinks"),
    "pinocchio:carriers": _pinocchio("PinocchioCarriers"),
    "pinocchio:armature": _pinocchio("PinocchioArmature"),
    "pinocchio:coupled": _pinocchio("PinocchioCoupled"),
    "pinocchio:gears": Entry(
        "models.pinocchio_gears", "PinocchioGears", "geared", STATES, free_planets=True
    ),
    "exudyn:tree": Entry(
        "models.exudyn_tree",
        "ExudynTree",
        "geared",
        RUNS | {"mesh_modes"},
        order=4,
        free_planets=True,
        call_s=2e-4,
    ),
    "exudyn:bodies": Entry(
        "models.exudyn_bodies",
        "ExudynBodies",
        "geared",
        RUNS | {"constraint_residual"},
        order=2,
        free_planets=True,
        call_s=5e-4,
    ),
}


def names(role: Role) -> tuple[str, ...]:
    """Every model of this role, in the order of the registry."""
    return tuple(name for name, entry in MODELS.items() if entry.role == role)


def promising(ability: str, among: tuple[str, ...]) -> tuple[str, ...]:
    """Those models that promise a method."""
    return tuple(name for name in among if ability in MODELS[name].promises)


GEARED, PAPER_FORMS = names("geared"), names("form")


def entry_of(name: str) -> Entry:
    """What stands here of a model. Raises InputError for an unknown name."""
    if name not in MODELS:
        raise InputError("model", "", name, f"unknown; allowed: {', '.join(MODELS)}")
    return MODELS[name]


def home(name: str) -> tuple[str, str]:
    """Module and class of a model; nothing is imported."""
    entry = MODELS[name]
    return entry.module, entry.attribute


def model_class(name: str) -> type[Model]:
    """The class of a model name, its engine imported on first use.

    Raises InputError for an unknown name or an engine that cannot be imported.
    """
    entry = entry_of(name)
    try:
        return getattr(importlib.import_module(entry.module), entry.attribute)
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
