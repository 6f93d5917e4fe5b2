"""Quantities that a study measures of every member, as data: signal, place and time."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import Field, model_validator

from crosscheck.models.arm.quantities import Data, Limit, NumberRange, PrintableText

JointSignal = Literal["theta", "theta_dot", "theta_ddot", "torque"]
MeshSignal = Literal["x_sp", "x_pr", "x_sp_dot", "x_pr_dot", "F_sp", "F_pr"]
RotorSignal = Literal["x_mesh", "x_mesh_dot", "F_mesh"]  # signals of robots' meshes
MeshForce = Literal["F_sp", "F_pr", "F_mesh"]
Signal = Literal[JointSignal, MeshSignal, RotorSignal]
JOINT_SIGNALS: tuple[str, ...] = get_args(JointSignal)
MESH_SIGNALS: tuple[str, ...] = get_args(MeshSignal)
ROTOR_SIGNALS: tuple[str, ...] = get_args(RotorSignal)
ARM_SIGNALS: tuple[str, ...] = (*JOINT_SIGNALS, *MESH_SIGNALS)
SIGNALS: tuple[str, ...] = get_args(Signal)
JointNumber = Annotated[int, NumberRange(1, 100)]
Second = Annotated[float, NumberRange(0, 1e6, "s")]
Hertz = Annotated[float, NumberRange(0, 1e9, "Hz")]
Level = Annotated[float, NumberRange(-1e15, 1e15)]
Pair = Field(strict=False)


class Rule(Limit):
    """Metadata of a field: the rule in words; ``holds``: the part the schema does not check."""

    def __init__(self, description: str, holds: Callable[[Any], bool] = lambda value: True) -> None:
        self.description, self.holds = description, holds

    def __str__(self) -> str:
        return self.description

    def allows(self, value: object) -> bool:
        """Whether a value may stand in the field, see Limit."""
        return self.holds(value)


def _is_plain(value: object) -> bool:
    """Whether a name needs no quotes in files; the schema refuses values that are no text."""
    return not isinstance(value, str) or bool(re.fullmatch(r"[A-Za-z_][\w.+-]{0,79}", value))


PlainName = Annotated[str, Rule("1 to 80 letters, digits, or _ . + -", _is_plain)]
UNITS = Rule("units by name, as { ripple = 'rad/s^2' }", lambda value: value != {})


class MeasuredQuantity(Data):
    """A quantity of any kind: its name in the result."""

    name: PlainName | None = None
    """Name in the result; by default made of signal and kind."""

    @model_validator(mode="after")
    def _ranges_rise(self) -> Self:
        for field in ("window_s", "band_Hz"):
            pair = getattr(self, field, None)
            if pair is not None and pair[1] <= pair[0]:
                raise ValueError(f"{field}|must end after it begins")
        return self

    @property
    def words(self) -> tuple[str, ...]:
        """Words that the quantity's name is made of where the user gives none: signal and kind."""
        return getattr(self, "signal", "theta"), getattr(self, "kind", "")

    @property
    def result_name(self) -> str:
        """The quantity's name in the result."""
        joint = getattr(self, "joint", None)
        joint_name = f"joint{joint}" if joint else ""
        return self.name or "_".join(filter(None, (*self.words, joint_name)))


class WindowedQuantity(MeasuredQuantity):
    """A quantity of a joint, in a part of the run."""

    joint: JointNumber | None = None
    """Number of the joint; all joints if left out."""
    window_s: Annotated[tuple[Second, Second], Pair] | None = None
    """From the first time until before the second; by default the whole run."""


class SignalQuantity(WindowedQuantity):
    """A quantity of one of a run's signals."""

    signal: Signal
    """The joint's angles and torque, or its meshes' (x_mesh, F_mesh: a rotor's)."""
    planet: Annotated[int, NumberRange(1, 8)] = 1
    """Number of the planet; lumped, all are the same."""


class Size(SignalQuantity):
    """A recorded signal's largest magnitude, largest minus smallest, mean, RMS or last value."""

    kind: Literal["peak", "peak_to_peak", "mean", "rms", "final"]
    """Kind of size."""


class BandRms(SignalQuantity):
    """RMS of a signal within a band, without the mean; Hann window."""

    kind: Literal["band_rms"]
    """Which quantity this is."""
    band_Hz: Annotated[tuple[Hertz, Hertz], Pair]
    """From the first frequency until below the second."""


class SpectralPeak(SignalQuantity):
    """Frequency and amplitude of the largest line in a band; Hann window."""

    kind: Literal["spectral_peak"]
    """Which quantity this is."""
    band_Hz: Annotated[tuple[Hertz, Hertz], Pair] = (0.0, 1e9)
    """From the first frequency until below the second."""


class FinalError(MeasuredQuantity):
    """Angle at the end minus the PD drive's target [rad]."""

    kind: Literal["final_error"]
    """Which quantity this is."""
    joint: JointNumber | None = None
    """Number of the joint; all joints if left out."""


class Crossing(SignalQuantity):
    """Time at which a signal is first above, or below, a level [s]."""

    kind: Literal["crossing"]
    """Which quantity this is."""
    level: Level
    """Level in the signal's unit."""
    side: Literal["above", "below"]
    """Side of the level."""

    @property
    def words(self) -> tuple[str, ...]:
        return self.signal, self.side, f"{self.level:g}"


class Settling(WindowedQuantity):
    """Time after which an angle stays within a band about a target [s]."""

    kind: Literal["settling"]
    """Which quantity this is."""
    band_rad: Annotated[float, NumberRange(1e-15, 1e4, "rad")]
    """Largest distance from the target."""
    target_rad: Annotated[float, NumberRange(-1e4, 1e4, "rad")] | None = None
    """Target that replaces the PD drive's."""


class ContactQuantity(WindowedQuantity):
    """A quantity of the contact in a mesh."""

    signal: MeshForce
    """Force of the mesh: F_sp of the sun, F_pr of the ring, F_mesh of a robot's rotor."""
    planet: Annotated[int, NumberRange(1, 8)] = 1
    """Number of the planet; lumped, all are the same."""


class ContactLoss(ContactQuantity):
    """Time at which a mesh that carried a force first carries none [s]."""

    kind: Literal["contact_loss"]
    """Which quantity this is."""


class NoContactShare(ContactQuantity):
    """Share of the time in which a mesh carries no force."""

    kind: Literal["apart_share"]
    """Which quantity this is."""


class RigidDeviation(WindowedQuantity):
    """Largest distance of an angle from that of the rigid arm in the same experiment [rad]."""

    kind: Literal["rigid_deviation"]
    """Which quantity this is."""
    level: Annotated[str, PrintableText(40)] = "coupled"
    """Links, carriers, armature or coupled."""

    @property
    def words(self) -> tuple[str, ...]:
        return "theta", self.kind, self.level


class Function(MeasuredQuantity):
    """Numbers that a user's function returns for a member's run, a Dataset."""

    kind: Literal["user_function"]
    """Which quantity this is."""
    function: Annotated[str, PrintableText(200)]
    """module:function, or file.py:function beside the study's file."""
    returns: Annotated[dict[PlainName, str], UNITS]
    """The numbers that it returns by name, with their units."""

    @property
    def words(self) -> tuple[str, ...]:
        return (self.function.rpartition(":")[2],)


class Trajectories(MeasuredQuantity):
    """Signals over the whole run, of every joint, and of meshes of every planet."""

    kind: Literal["trajectories"]
    """Which quantity this is."""
    signals: Annotated[tuple[Signal, ...], Field(min_length=1, max_length=10, strict=False)]
    """Signals to keep whole."""

    @property
    def words(self) -> tuple[str, ...]:
        return (self.kind,)


Quantity = Annotated[
    Size
    | BandRms
    | SpectralPeak
    | FinalError
    | Crossing
    | Settling
    | ContactLoss
    | NoContactShare
    | RigidDeviation
    | Function
    | Trajectories,
    Field(discriminator="kind"),
]


def list_kinds(union: Any) -> frozenset[str]:
    """The words by which the records of a union differ."""
    kinds = [each.model_fields["kind"].annotation for each in get_args(get_args(union)[0])]
    return frozenset(word for kind in kinds for word in get_args(kind))
