"""The experiment as data: drive law, duration, start, step; switches of the gear model.

Shared by every model.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import FailFast, Field, model_validator

from crosscheck.models.arm import quantities
from crosscheck.models.arm.quantities import Data, OfJoints, PerJoint, format_number

MOST_STEPS = 1e9  # an hour of the compiled integrator
# A state takes 430 bytes of a run for the paper's arm, 2.6 kB for seven joints with eight planets.
MOST_RECORDS = 1e6
# Phase of a sinusoid in a step [rad], six steps a period: with fewer, integrators with a fixed step
# see another drive than the adaptive ones.
MOST_TURN = 1.0
Rows = Field(min_length=2, max_length=50_000, strict=False)


class ConstantDrive(Data):
    """T = const, output side."""

    kind: Literal["constant"]
    """Which drive law this is."""
    torque_N_m: PerJoint[quantities.Torque]
    """T, output side."""


class PdDrive(Data):
    """Eq. 23: T = P (target - theta) - D theta', sensing the link."""

    kind: Literal["pd"]
    """Which drive law this is."""
    target_rad: PerJoint[quantities.Angle]
    """Joint angle to reach."""
    proportional_N_m_per_rad: PerJoint[quantities.Gain]
    """P."""
    derivative_N_m_s_per_rad: PerJoint[quantities.RateGain]
    """D."""


class SinusoidDrive(Data):
    """T = A sin(rate * t), or A sin(rate * sqrt(t)) as Section 4.1 prints it."""

    kind: Literal["sinusoid"]
    """Which drive law this is."""
    amplitude_N_m: PerJoint[quantities.Torque]
    """A, output side."""
    rate_rad_per_s: PerJoint[quantities.DriveRate]
    """Angular frequency; per sqrt(s) with sqrt_time."""
    argument: Literal["time", "sqrt_time"]
    """Factor of the rate: t or its square root."""


class TableDrive(Data):
    """T interpolated linearly between rows of a table, one column per joint."""

    kind: Literal["table"]
    """Which drive law this is."""
    time_s: Annotated[tuple[quantities.TableTime, ...], Rows, FailFast()]
    """Rising times of the rows, which cover the run."""
    torque_N_m: Annotated[
        tuple[Annotated[tuple[quantities.Torque, ...], Rows, FailFast()], ...],
        OfJoints,
        FailFast(),
    ]
    """A list for each joint, output side."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        if any(later <= earlier for earlier, later in pairwise(self.time_s)):
            raise ValueError("time_s|must increase")
        if any(len(column) != len(self.time_s) for column in self.torque_N_m):
            raise ValueError(f"torque_N_m|each joint needs {len(self.time_s)} values, as time_s")
        return self


Drive = ConstantDrive | PdDrive | SinusoidDrive | TableDrive


class Start(Data):
    """State at t = 0. Mesh displacements start at first contact (x = b) or at x = 0.

    Contact counts the static error. Of free planets every ring mesh touches, and the sun is
    advanced until the first of its meshes does. The offsets, added to them, are for starts
    perturbed on purpose.
    """

    mesh: Literal["contact", "centre"] = "contact"
    """Displacements at first contact, or 0."""
    theta_rad: PerJoint[quantities.Angle] = 0.0
    """Joint angles."""
    theta_dot_rad_per_s: PerJoint[quantities.AngularRate] = 0.0
    """Joint rates."""
    sun_planet_offset_m: PerJoint[quantities.Offset] = 0.0
    """Added to x_sp, or to x of a rotor's mesh."""
    planet_ring_offset_m: PerJoint[quantities.Offset] = 0.0
    """Added to x_pr."""
    planet_offset_m: Annotated[
        tuple[quantities.PlanetValues[quantities.Offset], ...],
        Field(max_length=64, strict=False),
        FailFast(),
    ] = ()
    """A list for each joint: added to x_pr, subtracted from x_sp."""


def make_bent_start(joints: int) -> Start:
    """A start at rest, every joint at another angle."""
    return Start(theta_rad=tuple(0.4 - 0.7 * number for number in range(joints)))


class Scenario(Data):
    """One experiment on an arm.

    ``step_s`` is the step of the fixed-step integrators and the base of the recording grid: a state
    is kept every ``record_every`` steps, or every largest common divisor of that and the number of
    steps, so that the last state is always on the grid.
    """

    schema_version: quantities.SchemaVersion
    """Version of the file."""
    name: quantities.Name
    """What reports and messages call the experiment."""
    title: quantities.Title = ""
    """One line about it."""
    duration_s: quantities.Duration
    """Duration of the simulation."""
    step_s: quantities.Step
    """Step of integrators; it divides the duration."""
    record_every: quantities.Count = 10
    """Steps between two recorded states."""
    start: Start = Start()
    """State at t = 0."""
    drive: Annotated[Drive, Field(discriminator="kind")]
    """Law of the torques on the joints."""

    @property
    def steps(self) -> int:
        """Number of steps in the duration."""
        return round(self.duration_s / self.step_s)

    @property
    def stride(self) -> int:
        """Steps between two recorded states."""
        return math.gcd(self.steps, self.record_every)

    @model_validator(mode="after")
    def _check_steps(self) -> Self:
        steps = self.duration_s / self.step_s
        if steps > MOST_STEPS:
            raise ValueError(
                f"step_s|is too small: {steps:.3g} steps, at most {format_number(MOST_STEPS)} are"
                " allowed"
            )
        if round(steps) < 1 or abs(steps - round(steps)) > 1e-6 * steps:
            raise ValueError(f"step_s|must divide duration_s = {self.duration_s:g}")
        if self.steps // self.stride > MOST_RECORDS:
            raise ValueError(
                f"record_every|keeps every {self.stride} of {self.steps} steps;"
                f" at most {format_number(MOST_RECORDS)} states are allowed"
            )
        return self

    @model_validator(mode="after")
    def _check_drive(self) -> Self:
        drive = self.drive
        if isinstance(drive, SinusoidDrive):
            advance = self.step_s if drive.argument == "time" else math.sqrt(self.step_s)
            rates = drive.rate_rad_per_s
            fastest = max(map(abs, rates if isinstance(rates, tuple) else (rates,)))
            if fastest * advance > MOST_TURN:
                most, step = format_number(MOST_TURN / advance), format_number(self.step_s)
                raise ValueError(
                    f"drive.rate_rad_per_s|must be at most {most} for a step_s of {step}: six steps"
                    " a period"
                )
        if isinstance(drive, TableDrive) and (
            drive.time_s[0] > 0 or drive.time_s[-1] < self.duration_s
        ):
            raise ValueError(f"drive.time_s|must cover 0 to duration_s = {self.duration_s:g}")
        return self


def expand_to_joints(value: float | tuple[float, ...], joints: int) -> tuple[float, ...]:
    """The value for each joint: one number is repeated. Raises ValueError on another length."""
    if isinstance(value, tuple):
        if len(value) != joints:
            raise ValueError(f"needs 1 or {joints} values, has {len(value)}")
        return value
    return (value,) * joints


def planet_offsets(start: Start, joint: int, planets: int) -> tuple[float, ...]:
    """``planet_offset_m`` of a joint, counted from 0, for each of so many planets."""
    given = start.planet_offset_m
    return given[joint] if given else (0.0,) * planets


def find_misfit(
    scenario: Scenario, planets: Sequence[int], motors: int
) -> tuple[str, object, str] | None:
    """(field, value, what is allowed) of the first list that does not fit a mechanism.

    planets: how many every joint has; motors: how many values a drive has.
    """
    for section, record in (("drive", scenario.drive), ("start", scenario.start)):
        joints = motors if section == "drive" else len(planets)
        for field, value in record:
            absent = field == "planet_offset_m" and value == ()
            if not isinstance(value, tuple) or field == "time_s" or absent or len(value) == joints:
                continue
            return f"{section}.{field}", value, f"needs {joints} values, has {len(value)}"
    for joint, offsets in enumerate(scenario.start.planet_offset_m):
        if len(offsets) != planets[joint]:
            needed = f"needs {planets[joint]} values, one for each planet; has {len(offsets)}"
            return f"start.planet_offset_m[{joint}]", offsets, needed
    return None


class Switches(Data):
    """The laws that models follow.

    phase: ``omega_t`` takes the mesh phase as current mesh frequency times time (Eqs. 8, 14 with
    12, 13), ``angle`` as its integral, proportional to the joint angle.
    ring_rate: meshing frequency of the ring mesh, ``eq13`` as printed or ``corrected`` (equal to
    the sun mesh's). Default: ``eq13`` with ``omega_t``, ``corrected`` with ``angle``.
    dead_zone: ``exact`` (Eq. 5) or ``tanh`` (Eq. 6).
    damping: ``always``, or ``contact`` (none while the teeth are apart).
    planets: ``lumped``, all planets of a stage one coordinate x_sp and x_pr as in the paper, or
    ``free``, a coordinate for each. An arm whose planets differ can only be free.
    mesh_work: ``paper``, or ``conservative``: the potential of teeth whose stiffness and error vary
    with an angle does work on that angle too.
    """

    phase: Literal["angle", "omega_t"] = "angle"
    ring_rate: Literal["eq13", "corrected"]
    dead_zone: Literal["exact", "tanh"] = "exact"
    damping: Literal["always", "contact"] = "always"
    planets: Literal["lumped", "free"] = "lumped"
    mesh_work: Literal["paper", "conservative"] = "paper"

    @model_validator(mode="before")
    @classmethod
    def _set_ring_rate(cls, data: Any) -> Any:
        if isinstance(data, dict) and data.get("ring_rate") is None:
            rate = "eq13" if data.get("phase") == "omega_t" else "corrected"
            return {**data, "ring_rate": rate}
        return data

    @model_validator(mode="after")
    def _check_mesh_work(self) -> Self:
        if self.mesh_work == "conservative" and self.phase == "omega_t":
            raise ValueError(
                "mesh_work|conservative needs phase = angle: with omega_t the stiffness depends on"
                " time and speed, so it has no potential"
            )
        if self.mesh_work == "conservative" and self.dead_zone == "tanh":
            raise ValueError(
                "mesh_work|conservative needs dead_zone = exact: the force of Eq. 6 is not the"
                " slope of k f^2 / 2"
            )
        return self


def switches(**chosen: str) -> Switches:
    """Switches with the given choices, the rest at their defaults.

    Args:
        **chosen: Values by the names of switches, such as ``phase="omega_t"``.

    Returns:
        The switches.

    Raises:
        pydantic.ValidationError: A switch or a value of it is unknown.
    """
    return Switches.model_validate(chosen)
