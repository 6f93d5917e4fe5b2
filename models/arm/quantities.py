"""The physical range of every kind of number in an arm or an experiment, stated once.

A range is generous to any machine that could be built, from a gear of ten microns to a bridge: it
keeps out what no machine is and no arithmetic can use, such as 1e308 kg or 5e-324 N/m.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import pydantic
from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag
from pydantic_core import CoreSchema, PydanticCustomError, core_schema


class Data(BaseModel):
    """A frozen record that refuses unknown keys and silent conversions."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, defer_build=True)
    if TYPE_CHECKING:
        _hash: int
    __slots__ = ("_hash",)  # in a slot it is neither copied with the record nor pickled

    def __hash__(self) -> int:
        """The hash of all fields, worked out once: tables of results are keyed by whole arms."""
        try:
            return self._hash
        except AttributeError:
            fields = map(self.__dict__.__getitem__, type(self).model_fields)
            object.__setattr__(self, "_hash", hash((type(self), *fields)))
            return self._hash


class Limit:
    """Metadata of a type whose values have the limits of ``str`` of it.

    The error of another value shows that, and the JSON schema where a field has no other meaning.
    """

    def allows(self, value: Any) -> bool:
        """Whether the limit allows a value; one of another type is judged by the type, not here."""
        raise NotImplementedError

    def _check(self, value: Any) -> Any:
        if not self.allows(value):
            raise PydanticCustomError("limit", "must be {limit}", {"limit": str(self)})
        return value

    def __get_pydantic_core_schema__(
        self, source: Any, handler: pydantic.GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._check, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: pydantic.GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {**handler(schema), "description": str(self)}


@dataclass(frozen=True)
class NumberRange(Limit):
    """A number from `least` to `most`, in `unit`; zero too if `or_zero`."""

    least: float
    most: float
    unit: str = ""
    or_zero: bool = False

    def __str__(self) -> str:
        ends = dict.fromkeys(
            map(format_number, (self.least, self.most))
        )  # one, if they are the same
        return f"{'0, or ' * self.or_zero}{' to '.join(ends)} {self.unit}".rstrip()

    def allows(self, value: Any) -> bool:
        """Whether a number is in the range; NaN and infinities are not."""
        if not isinstance(value, int | float) or isinstance(value, bool):
            return True
        return self.least <= value <= self.most or (self.or_zero and value == 0)


@dataclass(frozen=True)
class PrintableText(Limit):
    """A text of one line, up to `longest` characters; it may be empty if `may_be_empty`."""

    longest: int
    may_be_empty: bool = False

    def __str__(self) -> str:
        least = 0 if self.may_be_empty else 1
        return f"{least} to {self.longest} printable characters, not blanks alone"

    def allows(self, value: Any) -> bool:
        """Whether a text is printable, at most ``longest`` characters and not blanks alone."""
        if not isinstance(value, str) or (self.may_be_empty and value == ""):
            return True
        return bool(value.strip()) and len(value) <= self.longest and value.isprintable()


@dataclass(frozen=True)
class SharedValue:
    """Metadata of a type: one value for all, or a list with one for each."""

    what: str

    def __str__(self) -> str:
        return f"; one for all {self.what}, or a list"


def format_number(value: float) -> str:
    """A number as text in short form, such as 1e-5 or 1e9."""
    return f"{value:g}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def _form(value: object) -> str:
    return "list" if isinstance(value, list | tuple) else "number"


def _form_or_word(value: object) -> str:
    return "word" if isinstance(value, str) else _form(value)


UpToSeven = Field(min_length=1, max_length=7, strict=False)  # an arm's joints
OfJoints = Field(
    min_length=1, max_length=64, strict=False
)  # what goes by an arm's or robot's joint
UpToEight = Field(max_length=8, strict=False)  # planets, or what goes by planet
Number = TypeVar("Number")
# One number stands for all joints, a list for one number per joint.
PerJoint = Annotated[
    Annotated[Number, Tag("number")] | Annotated[tuple[Number, ...], OfJoints, Tag("list")],
    Discriminator(_form),
    SharedValue("joints"),
]

# One number, or law, stands for all planets of a stage, a list for one of each planet.
PlanetValues = Annotated[tuple[Number, ...], UpToEight]
PerPlanet = Annotated[
    Annotated[Number, Tag("number")] | Annotated[PlanetValues[Number], Tag("list")],
    Discriminator(_form),
    SharedValue("planets"),
]

Finite = Annotated[float, Field(allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]

Name = Annotated[str, PrintableText(80)]
Title = Annotated[str, PrintableText(200, may_be_empty=True)]
SchemaVersion = Annotated[int, NumberRange(1, 1)]
ArmVersion = Annotated[int, NumberRange(2, 2)]
ToothCount = Annotated[int, NumberRange(5, 2000)]
PlanetCount = Annotated[int, NumberRange(2, 8)]
Module = Annotated[float, NumberRange(1e-5, 1, "m")]
PressureAngle = Annotated[float, NumberRange(1, 45, "deg")]
GearMass = Annotated[float, NumberRange(1e-12, 1e9, "kg")]
GearInertia = Annotated[float, NumberRange(1e-24, 1e15, "kg m^2")]
Mass = Annotated[float, NumberRange(1e-12, 1e9, "kg", or_zero=True)]
Inertia = Annotated[float, NumberRange(1e-24, 1e15, "kg m^2", or_zero=True)]
Length = Annotated[float, NumberRange(1e-5, 1e3, "m")]
Place = Annotated[float, NumberRange(1e-9, 1e3, "m", or_zero=True)]
Area = Annotated[float, NumberRange(1e-12, 1e3, "m^2")]
Density = Annotated[float, NumberRange(1e-3, 1e6, "kg/m^3")]
Stiffness = Annotated[float, NumberRange(1, 1e12, "N/m")]
StiffnessPart = Annotated[float, NumberRange(1e-6, 1e12, "N/m", or_zero=True)]
Play = Annotated[float, NumberRange(1e-12, 0.1, "m", or_zero=True)]
Damping = Annotated[float, NumberRange(1e-9, 1e12, "N s/m", or_zero=True)]
DampingRatio = Annotated[float, NumberRange(1e-9, 10, or_zero=True)]
Sharpness = Annotated[float, NumberRange(1, 1e15, "1/m")]
Phase = Annotated[float, NumberRange(-1000, 1000, "rad")]
Friction = Annotated[float, NumberRange(1e-15, 1e12, "N m s/rad", or_zero=True)]
Acceleration = Annotated[float, NumberRange(-1e3, 1e3, "m/s^2")]
ContactRatio = Annotated[float, NumberRange(1, 2)]
Harmonics = Annotated[int, NumberRange(1, 50)]
Wave = Annotated[float, NumberRange(-1e12, 1e12, "N/m")]
Cycles = Annotated[float, NumberRange(0, 1, "cycles")]
Phases = Annotated[
    Annotated[Literal["from-teeth"], Tag("word")]
    | Annotated[Phase, Tag("number")]
    | Annotated[PlanetValues[Phase], Tag("list")],
    Discriminator(_form_or_word),
    SharedValue("planets"),
]

Torque = Annotated[float, NumberRange(-1e9, 1e9, "N m")]
Gain = Annotated[float, NumberRange(-1e12, 1e12, "N m/rad")]
RateGain = Annotated[float, NumberRange(-1e12, 1e12, "N m s/rad")]
Angle = Annotated[float, NumberRange(-1e4, 1e4, "rad")]
AngularRate = Annotated[float, NumberRange(-1e4, 1e4, "rad/s")]
DriveRate = Annotated[float, NumberRange(-1e6, 1e6, "rad/s")]
Offset = Annotated[float, NumberRange(-0.1, 0.1, "m")]
Duration = Annotated[float, NumberRange(1e-9, 1e6, "s")]
Step = Annotated[float, NumberRange(1e-12, 1, "s")]
TableTime = Annotated[float, NumberRange(-1e6, 1e6, "s")]
Count = Annotated[int, NumberRange(1, 1e9)]
