"""The user's input: functions that are equations of motion, and their coordinates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.files import read_toml
from crosscheck.models.loading import validate_record

Function = Callable[..., Any]
Gearing = Literal["rigid", "lumped", "free"]
SINGLE = 2.0**-24  # relative rounding of single precision
Level = Literal["", "links", "carriers", "armature", "coupled"]
RobotsLevel = Level | Literal["elastic"]
Motors = Sequence[int | str]  # numbers of joints, from 1, or their names
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=40)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
MOST = 100  # coordinates of an arm, and more


@dataclass(frozen=True)
class Coordinates:
    """Definition of the user's coordinates x (n,) of an arm.

    The project's own coordinates q (n,) are joint angles [rad] relative to the previous link, and
    mesh displacements [m]. Without arguments, x are the joint angles.

    Args:
        gearing: ``rigid``, a coordinate per joint; ``lumped``, each geared joint has two more, for
            all its planets together; ``free``, one more for its sun and one for each planet.
        links: ``relative``, angles to the previous link; ``absolute``, to the base [rad].
        gears: ``displacements`` of meshes [m]; ``angles`` of sun and planets [rad], relative to
            the ring's body (theta_s and theta_p of Eqs. 2-3), in their place.
        order: Names of the coordinates in the order of x, where it is another than that of q.
        matrix: A matrix (n, n) by which q = matrix @ x, in place of what links, gears and order
            say.
        function: A function of x (n,) that returns q (n,), likewise; or a sympy Matrix over
            ``symbols``, in which the arm's quantities (``r_s1``) stand for their numbers.
        symbols: The sympy symbols of x in ``function``.
        jacobian: A function of x (n,) that returns dq/dx (n, n); without it, the trial works it
            out.
        names: What the report calls the coordinates x.
        velocities: Of a robot, in place of all that: a function of its q (n,) that returns the
            matrix S (n, n) of velocities S(q) q' that stand for rates, such as a base's twist.
    """

    gearing: Gearing = "rigid"
    links: Literal["relative", "absolute"] = "relative"
    gears: Literal["displacements", "angles"] = "displacements"
    order: tuple[str, ...] = ()
    matrix: np.ndarray | Sequence[Sequence[float]] | None = None
    function: Any = None
    symbols: tuple[Any, ...] = ()
    jacobian: Function | None = None
    names: tuple[str, ...] = ()
    velocities: Function | None = None


@dataclass(frozen=True)
class Symbolic:
    """The sympy expressions behind Equations, for a difference that can be typeset.

    x, v, torque: symbols of coordinates (n,), rates (n,) and output torques, of each joint or of
    each motor of ``drive`` (as in Equations); t: of time.
    values: what each other symbol is, a number or the name of a quantity of the arm (``L1``,
    ``r_s2``, ``m_payload``: ``analytic.derivation.symbols``); one of such a name needs none.
    """

    x: tuple[Any, ...]
    v: tuple[Any, ...]
    torque: tuple[Any, ...] = ()
    t: Any = None
    values: Mapping[Any, float | str] = field(default_factory=dict)
    drive: Motors | None = None
    mass_matrix: Any = None
    bias: Any = None
    force: Any = None
    gravity: Any = None


@dataclass(frozen=True, eq=False)
class AnswerTable:
    """Facts about equations whose answers stand in a table.

    again: those answers that were given when the same states were asked a second time. precision:
    relative rounding of the numbers.
    """

    again: Equations
    precision: float = 0.0


class PartReading(NamedTuple):
    """Which parts hold weights or friction beside M a + bias, and what stands on the left."""

    held: frozenset[tuple[str, str]] = frozenset()
    left: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Equations:
    """M(x) x'' + bias(x, v) + gravity(x) = force(t, x, v, torque): any of these alone is judged.

    Each function names the arguments it needs, arrays (n,), in any order:
    ``t`` [s], ``q`` or ``x`` (the coordinates), ``v``, ``a``, ``torque`` (joints,), the drive's
    torques [N m] on the output side. They return arrays of floats, or what numpy makes arrays of.
    All are in the coordinates x and in SI units.

    Args:
        mass_matrix: M, shape (n, n), by (x).
        bias: C(x, v) v, shape (n,), by (x, v); with the weights where nothing else has them.
        coriolis: C itself, shape (n, n), by (x, v), in place of the bias.
        force: Drive, meshes, dampers and friction, shape (n,), by (t, x, v, torque); and weight,
            where there is no gravity beside it.
        acceleration: x'', shape (n,), by (t, x, v, torque).
        inverse_dynamics: M a + bias, shape (n,), by (x, v, a); gravity and friction may be in it.
        coordinates: What x are; joint angles [rad] relative to the previous link, if not given.
        level: Which rigid level a rigid model is meant to be: ``links``, ``carriers``,
            ``armature`` or ``coupled``; of a robot also ``elastic``, links and motors with springs
            between; '' lets the trial find out.
        switches: Laws that the model follows, where not those of the command line.
        symbolic: The sympy expressions behind the functions.
        rebuild: Makes the equations anew for an arm and a scenario, of equations that know how.
        any_arm: Whether that is worth doing for another arm; else, and once a part of them is
            replaced, they are of one alone.
        any_scenario: Whether they are made anew for another scenario.
        table: Where the answers stand of equations that are no code.
        drive: The joints that have a motor, by numbers from 1 or by names: all, if not given, and
            none where no function takes a torque. ``torque`` is what the function's author made it:
            a number for each joint (0 without a motor), for each motor, or the only motor's number.
        viscous_friction: Of a robot's equations alone, what its file does not have: a number
            [N m s/rad] for each coordinate, which times v is in the equations.
        coulomb_friction: The same, a number [N m] for each coordinate, which times the sign of v is
            in the equations.
        gravity: What holds the weights, shape (n,), by (x). With M and bias beside it, and without
            a force, the drive's torques are the force.
        unused: Names of other functions of the object that the equations came from.
        find_code: Finds their source, a UserCode or None, of equations that may have one; not for
            users.
        rebuilt_as: The parts as ``rebuild`` made them; not for users.
        reading: What parts hold beside what their names say, once that is known; not for users.
    """

    mass_matrix: Function | None = None
    bias: Function | None = None
    coriolis: Function | None = None
    force: Function | None = None
    acceleration: Function | None = None
    inverse_dynamics: Function | None = None
    coordinates: Coordinates = Coordinates()
    drive: Motors | None = None
    viscous_friction: Sequence[float] | None = None
    coulomb_friction: Sequence[float] | None = None
    level: RobotsLevel = ""
    switches: Switches | None = None
    symbolic: Symbolic | None = None
    rebuild: Callable[[Arm, Scenario | None], Equations] | None = None
    any_arm: bool = False
    any_scenario: bool = False
    table: AnswerTable | None = None
    gravity: Function | None = None
    unused: tuple[str, ...] = ()
    find_code: Callable[[], Any] | None = field(default=None, repr=False, compare=False)
    rebuilt_as: tuple[Any, ...] = field(default=(), repr=False, compare=False)
    reading: PartReading | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Forget ``rebuild`` once a part was replaced, for it would make the old part again."""
        functions = (self.mass_matrix, self.bias, self.coriolis, self.gravity, self.force)
        settings = (self.coordinates, self.drive, self.level, self.switches)
        whole = (*functions, self.acceleration, self.inverse_dynamics, *settings)
        before = self.rebuilt_as
        if not before or before[0] is not self.rebuild:
            object.__setattr__(self, "rebuilt_as", (self.rebuild, *whole))
        elif any(now is not then for now, then in zip(whole, before[1:], strict=True)):
            object.__setattr__(self, "rebuild", None)
            object.__setattr__(self, "symbolic", None)
            object.__setattr__(self, "any_arm", False)
            if any(now is not then for now, then in zip(functions, before[1:], strict=False)):
                object.__setattr__(self, "find_code", None)

    @property
    def has_open_angles(self) -> bool:
        """Whether functions state nothing about their coordinates, which are read as relative."""
        is_code = self.table is None and self.symbolic is None
        return is_code and self.coordinates.matrix is None and self.coordinates == Coordinates()

    def read_in(self, coordinates: Coordinates) -> Equations:
        """The same functions, read in other coordinates on this arm and on any other."""
        rebuild = self.rebuild
        if rebuild is None:
            return replace(self, coordinates=coordinates)
        return replace(
            self,
            coordinates=coordinates,
            rebuild=lambda arm, scenario: rebuild(arm, scenario).read_in(coordinates),
            rebuilt_as=(),
        )

    def adapt_to_arm(self, arm: Arm, scenario: Scenario | None = None) -> Equations:
        """These equations with the numbers of an arm. Raises InputError."""
        if self.rebuild is None:
            return self
        rebuilt = self.rebuild(arm, scenario)
        find_code = rebuilt.find_code or self.find_code
        return replace(rebuilt, reading=self.reading, find_code=find_code)


class CoordinatesFile(BaseModel):
    """Coordinates but for functions; level: the rigid level that a model is meant to be."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    gearing: Gearing = "rigid"
    links: Literal["relative", "absolute"] = "relative"
    gears: Literal["displacements", "angles"] = "displacements"
    order: tuple[Name, ...] = Field(default=(), max_length=MOST)
    matrix: tuple[tuple[Finite, ...], ...] | None = Field(default=None, max_length=MOST)
    names: tuple[Name, ...] = Field(default=(), max_length=MOST)
    level: Level = ""


def load_coordinates(path: Path | None) -> tuple[Coordinates, Level]:
    """Coordinates and level of a file; without, relative joint angles. Raises InputError."""
    if path is None:
        return Coordinates(), ""
    coordinates_file = validate_record(CoordinatesFile, read_toml(path), str(path))
    return Coordinates(**coordinates_file.model_dump(exclude={"level"})), coordinates_file.level
