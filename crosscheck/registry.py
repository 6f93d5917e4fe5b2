"""The one place that knows which models exist, where, and what each promises."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

from analytic.covered import papers_kind
from models.arm import Arm
from models.errors import Diverged, InputError
from models.interface import STATE_ABILITIES, Model
from models.layout import Layout, geared_layout, rigid_layout
from models.scenario import Scenario
from models.switches import Switches

Role = Literal["geared", "form", "rigid"]
Engine = Literal["analytic", "pinocchio", "exudyn"]
STATES = frozenset(STATE_ABILITIES)
RUNS = STATES | {"simulate"}
BOTH_WAYS = RUNS | {"reference"}
RIGID_LEVELS = ("links", "carriers", "armature", "coupled")


@dataclass(frozen=True)
class Entry:
    """A model: where its class is, and what a cross-check may count on.

    role: ``geared`` must agree with every other geared model; a ``form`` is the paper's and is
    measured against them; ``rigid`` has no gears, and a level that others of it share. promises:
    methods that a cross-check uses; it plans by these and never by what the class says of itself,
    so that nothing goes unnoticed. order: of its fixed-step integrator, None for one that chooses
    its steps. free_planets: whether every planet moves by itself inside. call_s: rough cost [s] of
    a step or state. any_stride: whether its states are the same, bit by bit, however often they are
    recorded.
    """

    engine: Engine
    module: str
    attribute: str
    role: Role
    promises: frozenset[str]
    order: int | None = None
    free_planets: bool = False
    call_s: float = 1e-5
    level: str = ""
    any_stride: bool = False

    def layout(self, arm: Arm, chosen: Switches) -> Layout:
        """What its coordinates must be for an arm and switches."""
        return rigid_layout(arm) if self.role == "rigid" else geared_layout(arm, chosen)

    def covers(self, arm: Arm, chosen: Switches) -> bool:
        """Whether it is about such an arm, under such switches."""
        return self.role != "form" or (papers_kind(arm) and chosen.planets == "lumped")

    @property
    def packages(self) -> tuple[str, ...]:
        """Distributions whose versions its results depend on."""
        return (*EVERY_MODELS_PACKAGES, *ENGINES_PACKAGES[self.engine])


EVERY_MODELS_PACKAGES = ("numpy", "scipy", "numba", "xarray")
ENGINES_PACKAGES: dict[Engine, tuple[str, ...]] = {
    "analytic": ("sympy",),
    "pinocchio": ("pin",),
    "exudyn": ("exudyn",),
}


def _analytic(attribute: str, level: str) -> Entry:
    module = "analytic.model"
    return Entry(
        "analytic", module, attribute, "rigid", RUNS, order=4, level=level, any_stride=True
    )


def _paper(attribute: str) -> Entry:
    module = "analytic.paper_model"
    return Entry("analytic", module, attribute, "form", RUNS, order=4, any_stride=True)


def _pinocchio(attribute: str, level: str) -> Entry:
    module = "models.pinocchio_rigid"
    return Entry("pinocchio", module, attribute, "rigid", BOTH_WAYS, level=level)


MODELS = {
    "analytic:physical": Entry(
        "analytic",
        "analytic.model",
        "PhysicalModel",
        "geared",
        BOTH_WAYS | {"mesh_modes", "contact_poles"},
        order=4,
        any_stride=True,
    ),
    "analytic:energies": _paper("EnergiesModel"),
    "analytic:printed": _paper("PrintedModel"),
    "analytic:links": _analytic("RigidLinks", "links"),
    "analytic:carriers": _analytic("RigidCarriers", "carriers"),
    "analytic:armature": _analytic("RigidArmature", "armature"),
    "analytic:coupled": _analytic("RigidCoupled", "coupled"),
    "pinocchio:links": _pinocchio("PinocchioLinks", "links"),
    "pinocchio:carriers": _pinocchio("PinocchioCarriers", "carriers"),
    "pinocchio:armature": _pinocchio("PinocchioArmature", "armature"),
    "pinocchio:coupled": _pinocchio("PinocchioCoupled", "coupled"),
    "pinocchio:gears": Entry(
        "pinocchio",
        "models.pinocchio_gears",
        "PinocchioGears",
        "geared",
        STATES,
        free_planets=True,
    ),
    "exudyn:tree": Entry(
        "exudyn",
        "models.exudyn_tree",
        "ExudynTree",
        "geared",
        RUNS | {"mesh_modes"},
        order=4,
        free_planets=True,
        call_s=2e-4,
    ),
    "exudyn:bodies": Entry(
        "exudyn",
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


def of_level(level: str) -> tuple[str, ...]:
    """The rigid models of a level."""
    return tuple(name for name, entry in MODELS.items() if entry.level == level)


def lead() -> str:
    """The geared model that others are measured against: it integrates in both ways."""
    return promising("reference", names("geared"))[0]


def same_integrator() -> tuple[str, ...]:
    """The geared models with the lead's fixed-step integrator, the lead first."""
    order = MODELS[lead()].order
    return tuple(n for n in promising("simulate", names("geared")) if MODELS[n].order == order)


def constrained() -> tuple[str, ...]:
    """The geared models that close their joints by constraint equations, and simulate."""
    return promising("constraint_residual", promising("simulate", names("geared")))


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
    except Diverged:
        raise
    except (ArithmeticError, LinAlgError) as error:
        reason = f"{type(error).__name__}: {error}"
        raise InputError(arm.name, "", None, f"{what} cannot use its numbers: {reason}") from None


def build(name: str, arm: Arm, scenario: Scenario, switches: Switches | None = None) -> Model:
    """The named model of this arm in this experiment. Raises InputError."""
    model = model_class(name)
    with usable_numbers(name, arm):
        return model(arm, scenario, switches)
