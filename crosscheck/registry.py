"""The one place that knows which models exist, where, and what each promises."""

from __future__ import annotations

import importlib
import threading
from collections import UserDict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any, Literal, get_args

from crosscheck.analytic.paper.coverage import is_covered_by_paper
from crosscheck.entry import entry_point_error, foreign_code, load_record
from crosscheck.mechanisms import supply
from crosscheck.models.abilities import ROBOT_ABILITIES, STATE_ABILITIES
from crosscheck.models.errors import Diverged, InputError
from crosscheck.models.refusals import refuse

if TYPE_CHECKING:  # the names of models are asked for without any schema
    from crosscheck.models.arm.arm import Arm
    from crosscheck.models.arm.layout import Layout
    from crosscheck.models.experiment.scenario import Scenario, Switches
    from crosscheck.models.interface import Model
    from crosscheck.models.robot.interface import RobotModel
    from crosscheck.models.robot.robot import Level, Robot

ENTRY_POINTS = "geararm_crosscheck.models"  # the group by which installed packages offer models
Role = Literal["geared", "form", "rigid", "limit", "supplied", "robot"]
STATES = frozenset(STATE_ABILITIES)
RUNS = STATES | {"simulate"}
BOTH_WAYS = RUNS | {"reference"}
KERNEL_LANES = 32  # runs in the lanes of the analytic models' kernel
EVERY_MODELS_PACKAGES = ("numpy", "scipy", "xarray")
ANALYTIC_PACKAGES = ("sympy", "llvmlite")


@dataclass(frozen=True)
class Entry:
    """A model: where its class is, and what a cross-check may count on.

    Args:
        module: The module that has the class.
        attribute: Name of the class there.
        role: ``geared`` must agree with every other geared model; a ``form`` is the paper's and is
            measured against them; ``rigid`` has no gears, and a level that others of it share;
            ``limit`` is a form without its gears, compared with nothing; ``supplied`` is a user's,
            of whose teeth only the whole force is known; ``robot`` is an engine of robots, whose
            model at a level is called ``engine:level``.
        promises: Methods that a cross-check uses; it plans by these and never by what the class
            says of itself, so that nothing goes unnoticed.
        packages: Distributions, beside every model's, whose versions its results depend on.
        order: The order of its fixed-step integrator, None for one that chooses its steps.
        free_planets: Whether every planet moves by itself inside.
        call_s: Estimated cost of a step or state [s].
        level: The rigid level of a rigid model: ``links``, ``carriers``, ``armature``, ``coupled``.
        levels: Of an engine of robots, those that it has; empty for all.
        abreast: How many runs it makes at once.
        title: What to know of it.
        covers: Whether it is about an arm under switches.
        made: The class itself, where it is in no module that can be imported.
    """

    module: str
    attribute: str
    role: Role
    promises: frozenset[str]
    packages: tuple[str, ...] = ()
    order: int | None = None
    free_planets: bool = False
    call_s: float = 1e-5
    level: str = ""
    levels: tuple[Level, ...] = ()
    abreast: int = 1
    title: str = ""
    covers: Callable[[Arm, Switches], bool] = lambda arm, chosen: True
    made: type[Model] | type[RobotModel] | None = None

    @property
    def is_rigid(self) -> bool:
        """Whether the model has the joints' angles alone."""
        return self.role in ("rigid", "limit")

    def has_level(self, level: Level) -> bool:
        """Whether an engine of robots has this level."""
        return self.role == "robot" and (not self.levels or level in self.levels)

    def layout(self, arm: Arm, chosen: Switches) -> Layout:
        """The coordinates that the model must have for an arm and switches."""
        from crosscheck.models.arm.layout import geared_layout, rigid_layout

        return rigid_layout(arm) if self.is_rigid else geared_layout(arm, chosen)

    @property
    def versioned_packages(self) -> tuple[str, ...]:
        """Distributions whose versions the model's results depend on."""
        return (*EVERY_MODELS_PACKAGES, *self.packages)


LEVELS = {
    "links": "rigid arm of links and payload alone",
    "carriers": "rigid arm with the masses of its joints and their carriers",
    "armature": "as carriers, with the gears' inertia on the diagonal, uncoupled from other links",
    "coupled": "as carriers, with the gears' spin coupled to the links: rigid gears, exactly",
}
RIGID_LEVELS = tuple(LEVELS)
RIGID_ARM = "rigid arm"  # name of the only level of an arm without gears


def group_equal_levels(arm: Arm) -> list[tuple[str, ...]]:
    """The rigid levels of an arm, those that are equal on it together, the simplest first.

    What joints carry decides. A mass at the first joint's axis does not move, and gears there turn
    against the ground, so that their inertia on the diagonal is all of it.
    """
    geared = [joint.kind == "planetary" for joint in arm.joints]
    moving = [
        joint.kind == "planetary"
        or joint.rotor_inertia_kg_m2 > 0
        or joint.motor_mass_kg * number > 0
        for number, joint in enumerate(arm.joints)
    ]
    differs = {"carriers": any(moving), "armature": any(geared), "coupled": any(geared[1:])}
    groups: list[tuple[str, ...]] = [RIGID_LEVELS[:1]]
    for level in RIGID_LEVELS[1:]:
        if differs[level]:
            groups.append((level,))
        else:
            groups[-1] = (*groups[-1], level)
    return groups


def find_distinct_levels(arm: Arm) -> tuple[str, ...]:
    """The rigid levels that differ on an arm: of equal ones the simplest."""
    return tuple(group[0] for group in group_equal_levels(arm))


def is_rigid_arm(arm: Arm) -> bool:
    """Whether all rigid levels of an arm are one, called ``RIGID_ARM``: links without motors."""
    return len(group_equal_levels(arm)) == 1


def _is_papers(arm: Arm, chosen: Switches) -> bool:
    return is_covered_by_paper(arm) and chosen.planets == "lumped"


def _level_entries(package: str, template: Entry) -> dict[str, Entry]:
    """A rigid model of each level, by name; template: what they share, and how classes begin."""
    entries = {}
    for level, title in LEVELS.items():
        attribute = f"{template.attribute}{level.capitalize()}"
        entry = replace(template, attribute=attribute, level=level, title=title)
        entries[f"{package}:{level}"] = entry
    return entries


_ANALYTIC = "crosscheck.analytic.model"
_RIGID = Entry(_ANALYTIC, "Rigid", "rigid", RUNS, ANALYTIC_PACKAGES, order=4, abreast=KERNEL_LANES)
_PAPER = "crosscheck.analytic.paper.model"
_FORM = Entry(_PAPER, "", "form", RUNS, ANALYTIC_PACKAGES, order=4, covers=_is_papers)
_PINOCCHIO = Entry(
    "crosscheck.models.pinocchio.arm", "Pinocchio", "rigid", BOTH_WAYS, ("pin",), call_s=3e-6
)


BUILT_IN = {
    "analytic:physical": replace(
        _RIGID,
        attribute="PhysicalModel",
        role="geared",
        promises=BOTH_WAYS | {"precise", "mesh_modes", "contact_poles"},
        title="the project's derivation by Lagrange's equations, with every body",
    ),
    "analytic:energies": replace(
        _FORM, attribute="EnergiesModel", title="the paper's energies as printed, Eqs. 16-19"
    ),
    "analytic:printed": replace(
        _FORM,
        attribute="PrintedModel",
        title="the paper's equations of motion as printed, Eqs. 21-22",
    ),
    "analytic:printed-rigid": replace(
        _FORM,
        attribute="PrintedRigidModel",
        role="limit",
        title="the same with meshes that do not move: their own rigid limit",
    ),
    **_level_entries("analytic", _RIGID),
    **_level_entries("pinocchio", _PINOCCHIO),
    "pinocchio:gears": Entry(
        "crosscheck.models.pinocchio.arm",
        "PinocchioGears",
        "geared",
        STATES,
        ("pin",),
        free_planets=True,
        title="gears as bodies of a tree, pushed by contact forces",
    ),
    "exudyn:tree": Entry(
        "crosscheck.models.exudyn.tree.tree",
        "ExudynTree",
        "geared",
        RUNS | {"mesh_modes"},
        ("exudyn", "numba"),
        order=4,
        free_planets=True,
        call_s=4e-5,
        title="kinematic tree in minimal coordinates, with mesh springs",
    ),
    "exudyn:bodies": Entry(
        "crosscheck.models.exudyn.bodies.bodies",
        "ExudynBodies",
        "geared",
        RUNS | {"constraint_residual"},
        ("exudyn", "numba"),
        order=2,
        free_planets=True,
        call_s=2e-4,
        title="separate bodies on constraints, contacts found from their poses",
    ),
    "analytic": Entry(
        "crosscheck.analytic.robot.model",
        "AnalyticRobot",
        "robot",
        ROBOT_ABILITIES,
        title="the project's derivation by Kane's method",
    ),
    "pinocchio": Entry(
        "crosscheck.models.pinocchio.robot",
        "PinocchioRobot",
        "robot",
        ROBOT_ABILITIES,
        ("pin",),
        title="its own reader of URDFs, rotors as bodies of the tree",
    ),
    "exudyn": Entry(
        "crosscheck.models.exudyn.robot",
        "ExudynRobot",
        "robot",
        ROBOT_ABILITIES,
        ("exudyn", "numba"),
        title="kinematic tree in minimal coordinates, rotors as bodies of it",
    ),
}


# What a package may have written into an entry, before any of it is used.
FIELDS: dict[str, type | tuple[type, ...]] = {
    **dict.fromkeys(("module", "attribute", "role", "level", "title"), str),
    "promises": frozenset,
    **dict.fromkeys(("packages", "levels"), tuple),
    "call_s": (int, float),
    "abreast": int,
}


class Registry(UserDict[str, Entry]):
    """Entries by the model's name: the program's own, then those of installed packages.

    Packages are looked for when an entry is first asked for, which raises InputError for one whose
    model cannot be used.
    """

    def __init__(self) -> None:
        """Look for no package yet."""

    @cached_property
    def data(self) -> dict[str, Entry]:  # type: ignore[override]
        """All entries."""
        return add_installed_models(BUILT_IN)

    def __iter__(self) -> Iterator[str]:
        return iter(tuple(self.data))


MODELS = Registry()


def add_installed_models(built_in: dict[str, Entry]) -> dict[str, Entry]:
    """The known models, then those that installed packages offer, sorted by name.

    Raises InputError for an offer that cannot be imported, is no Entry or has a name that is taken.
    """
    entries = dict(built_in)
    offers = entry_points(group=ENTRY_POINTS)
    for offer in sorted(offers, key=lambda each: (each.name, each.value)):
        if offer.name in entries:
            raise entry_point_error(offer, "a model of this name exists already")
        entry = load_record(offer, Entry, FIELDS)
        if entry.role not in get_args(Role):
            wrong = f"role is {entry.role!r}; must be one of {get_args(Role)}"
            raise entry_point_error(offer, wrong)
        package = (offer.dist.name,) if offer.dist else ()  # whose version counts for its results
        entries[offer.name] = replace(entry, packages=(*entry.packages, *package))
    return entries


_one_at_a_time = threading.RLock()


@contextmanager
def register(name: str, entry: Entry) -> Iterator[None]:
    """Add a model for as long as the context lasts; processes forked meanwhile know it too.

    Of several threads one after the other, for their models may share a name. Raises InputError
    for a name that is taken.
    """
    with _one_at_a_time:
        if name in MODELS:
            raise InputError("model", "", name, "a model of this name exists already")
        MODELS[name] = entry
        try:
            yield
        finally:
            del MODELS[name]


def is_plugin(name: str) -> bool:
    """Whether a model, or a robot's model's engine, came in by ``register`` or a package."""
    entry = name if name in MODELS else engine_of(name)
    return entry in MODELS and entry not in BUILT_IN


def engine_of(model: str) -> str:
    """The engine of a model ``engine:what``."""
    return model.partition(":")[0]


def packages() -> tuple[str, ...]:
    """Distributions that results of any model depend on."""
    names = (name for entry in MODELS.values() for name in entry.versioned_packages)
    return tuple(dict.fromkeys(names))


def model_names(role: Role) -> tuple[str, ...]:
    """Names of all models of a role, in the order of the registry."""
    return tuple(name for name, entry in MODELS.items() if entry.role == role)


def find_covering_models(role: Role, arm: Arm, chosen: Switches) -> tuple[str, ...]:
    """Names of the models of a role that are about an arm under switches."""
    return select_covering(model_names(role), arm, chosen)


def select_covering(among: Sequence[str], arm: Arm, chosen: Switches) -> tuple[str, ...]:
    """Names among the given ones whose models are about an arm under switches."""
    return tuple(name for name in among if is_covering(name, arm, chosen))


def is_covering(name: str, arm: Arm, chosen: Switches) -> bool:
    """Whether a model of arms is about an arm under switches."""
    if MODELS[name].role == "robot":
        return False
    if not is_plugin(name):
        return MODELS[name].covers(arm, chosen)
    with foreign_code(f"model {name}: covers"):
        return bool(MODELS[name].covers(arm, chosen))


def select_with_method(ability: str, among: tuple[str, ...]) -> tuple[str, ...]:
    """Names among the given ones whose models promise a method."""
    return tuple(name for name in among if ability in MODELS[name].promises)


def find_level_models(level: str) -> tuple[str, ...]:
    """Names of the rigid models of a level."""
    return tuple(name for name, entry in MODELS.items() if entry.level == level)


def reference_model() -> str:
    """Name of the reference model of gears: it integrates with fixed and adaptive steps."""
    return select_with_method("reference", model_names("geared"))[0]


def find_same_integrator_models() -> tuple[str, ...]:
    """Names of the geared models with the reference model's fixed-step integrator, it first."""
    order = MODELS[reference_model()].order
    able = select_with_method("simulate", model_names("geared"))
    return tuple(name for name in able if MODELS[name].order == order)


def reference_engine() -> str:
    """Name of the engine of robots whose numbers give differences their sizes."""
    return model_names("robot")[0]


def find_level_engines(level: Level) -> tuple[str, ...]:
    """Names of the engines of robots that have a level."""
    return tuple(name for name in model_names("robot") if MODELS[name].has_level(level))


def second_engine() -> str:
    """Name of the model that stands for all with the reference model's integrator."""
    return find_same_integrator_models()[1]


def get_entry(name: str, arm: Arm | None = None) -> Entry:
    """The Entry of a model of arms, of any arm. Raises InputError for any other name."""
    if name not in MODELS or MODELS[name].role == "robot":
        raise _unknown_model(name)
    return MODELS[name]


def find_robot_entry(name: str, robot: Robot) -> Entry:
    """The Entry of the engine of a robot's model ``engine:level``. Raises InputError."""
    return MODELS[find_robot_model(name, robot)[0]]


def _unknown_model(name: str) -> InputError:
    allowed = ", ".join(each for each, entry in MODELS.items() if entry.role != "robot")
    return InputError("model", "", name, f"unknown; allowed: {allowed}")


def load_model_class(name: str) -> Any:
    """The class of a model name, or of an engine of robots, imported on first use.

    Raises InputError for an unknown name or an engine that cannot be imported.
    """
    if name not in MODELS:
        raise _unknown_model(name)
    entry = MODELS[name]
    if entry.made is not None:
        return entry.made
    try:
        whose = f"model {name}: its engine cannot be imported"
        with foreign_code(whose) if is_plugin(name) else nullcontext():
            return getattr(importlib.import_module(entry.module), entry.attribute)
    except (ImportError, AttributeError) as error:
        reason = " ".join(str(error).split())
        raise InputError("model", "", name, f"its engine cannot be imported: {reason}") from None


def build_robot_model(engine: str, robot: Robot, level: Level) -> RobotModel:
    """A new model of the robot at the level, by an engine of robots that has it."""
    return load_model_class(engine)(robot, level)


def find_robot_model(name: str, robot: Robot) -> tuple[str, Level]:
    """Engine and level of a model ``engine:level`` of a robot. Raises InputError."""
    engine, _, wanted = name.partition(":")
    if engine not in model_names("robot"):
        allowed = f"must be ENGINE:LEVEL, ENGINE one of {', '.join(model_names('robot'))}"
        raise InputError("model", "", name, allowed)
    level = robot.find_level(wanted)
    if level is not None and MODELS[engine].has_level(level):
        return engine, level
    levels = [level for level in robot.levels if MODELS[engine].has_level(level)]
    allowed = f"{robot.name} has the levels {', '.join(levels)} in {engine}"
    raise InputError("model", "", name, allowed)


@contextmanager
def require_usable_numbers(what: str, arm: Arm | Robot) -> Iterator[None]:
    """Raise InputError, naming ``what`` and arm, where the arm's numbers break the arithmetic."""
    from numpy.linalg import LinAlgError

    try:
        yield
    except Diverged:
        raise
    except (ArithmeticError, LinAlgError) as error:
        reason = f"{type(error).__name__}: {error}"
        raise InputError(arm.name, "", None, f"{what} cannot use its numbers: {reason}") from None


def build(
    name: str, arm: Arm | Robot, scenario: Scenario, switches: Switches | None = None
) -> Model:
    """Build the named model of an arm or a robot in an experiment.

    Args:
        name: A model, as ``crosscheck list`` shows them: ``engine:what``, of a robot
            ``engine:level``.
        arm: The arm or robot.
        scenario: The experiment; its lists of one value per joint must fit the arm.
        switches: Laws of the gear model; without them, the usual ones of the arm. A robot has none.

    Returns:
        The model, with states in the coordinates that its ``coordinates`` name.

    Raises:
        InputError: There is no such model, arm, scenario and switches do not fit each other, or
            numbers of the arm are out of the engine's range.
    """
    return supply("build", arm.section)(name, arm, scenario, switches)


def build_arm_model(name: str, arm: Arm, scenario: Scenario, switches: Switches | None) -> Model:
    """The named model of an arm, see ``build``."""
    get_entry(name)
    with require_usable_numbers(name, arm):
        return load_model_class(name)(arm, scenario, switches)


def build_robot_experiment(
    name: str, robot: Robot, scenario: Scenario, switches: Switches | None
) -> Model:
    """The named model of a robot, see ``build``."""
    from crosscheck.robot_experiment import RobotExperiment

    refuse("robot", "build", switches=switches)
    engine, level = find_robot_model(name, robot)
    return RobotExperiment(build_robot_model(engine, robot, level), scenario)
