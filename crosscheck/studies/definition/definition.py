"""The study's file as data: its arm or robot, experiment, axes and quantities."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Discriminator, Field, JsonValue, Tag, model_validator

from crosscheck import LARGEST_SEED
from crosscheck.models.arm.quantities import Data, Name, NumberRange, PrintableText, Title
from crosscheck.models.robot.robot import Level
from crosscheck.studies.definition.quantities import PlainName, Quantity, Rule, list_kinds

Path = Annotated[str, PrintableText(200)]
Value = Annotated[float, NumberRange(-1e15, 1e15)]
Amount = Annotated[int, NumberRange(1, 1e7)]
Seed = Annotated[int, NumberRange(0, LARGEST_SEED)]
Perturbation = Annotated[float, NumberRange(0, 0.1, "m")]


Paths = Annotated[
    Annotated[Path, Tag("word")]
    | Annotated[tuple[Path, ...], Field(min_length=1, max_length=100, strict=False), Tag("list")],
    Discriminator(lambda value: "list" if isinstance(value, list | tuple) else "word"),
]
Tolerance = Annotated[float, NumberRange(0, 1e15)]


class AxisBase(Data):
    """An axis of any kind: the entries that it varies."""

    path: Paths
    """Path as for --set, or a list of paths that get the same value."""
    name: PlainName | None = None
    """Name of the axis in the result; by default the last key of its path."""

    @property
    def paths(self) -> tuple[str, ...]:
        """All paths of the axis, also where it has only one."""
        return self.path if isinstance(self.path, tuple) else (self.path,)


class ListAxis(AxisBase):
    """The values themselves: numbers, words, or lists of one value per joint or planet."""

    kind: Literal["list"]
    """Which sort of axis this is."""
    values: Annotated[
        tuple[JsonValue, ...],
        Rule("a list of 1 to 100000 values that the entry may have"),
        Field(min_length=1, max_length=100_000, strict=False),
    ]
    """The values of the axis."""


class GridAxis(AxisBase):
    """Equally spaced values, both ends among them."""

    kind: Literal["grid"]
    """Which sort of axis this is."""
    start: Value
    """The first."""
    stop: Value
    """The last."""
    count: Amount
    """How many."""
    spacing: Literal["linear", "log"] = "linear"
    """Equal differences, or equal ratios."""

    @model_validator(mode="after")
    def _has_logarithms(self) -> Self:
        if self.spacing == "log" and (self.start <= 0 or self.stop <= 0):
            raise ValueError("spacing|log needs start and stop above 0")
        return self


class SampledAxisBase(AxisBase):
    """An axis of any kind along the study's samples."""

    each: bool = False
    """Whether every entry of the path has its own draw."""


class HypercubeAxis(SampledAxisBase):
    """Latin hypercube: one sample in each of as many equal parts of the range as samples."""

    kind: Literal["latin_hypercube"]
    """Which sort of axis this is."""
    low: Value
    """Lower end of the range."""
    high: Value
    """Upper end of the range."""
    spacing: Literal["linear", "log"] = "linear"
    """Equal differences, or equal ratios."""

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        if self.high <= self.low:
            raise ValueError(f"high|must be above low = {self.low:g}")
        if self.spacing == "log" and self.low <= 0:
            raise ValueError("spacing|log needs low above 0")
        return self


class NormalAxis(SampledAxisBase):
    """Normally distributed about the file's own value, entry by entry."""

    kind: Literal["normal"]
    """Which sort of axis this is."""
    centre: Value | None = None
    """In place of the file's own values."""
    sd: Tolerance | None = None
    """Standard deviation, or relative_sd."""
    relative_sd: Tolerance | None = None
    """Standard deviation over the mean's magnitude."""
    within_sd: Annotated[float, NumberRange(0.1, 100)] | None = None
    """Largest distance in standard deviations."""

    @model_validator(mode="after")
    def _require_single_width(self) -> Self:
        if (self.sd is None) == (self.relative_sd is None):
            raise ValueError("sd|give either this or relative_sd")
        return self


class UniformAxis(SampledAxisBase):
    """Equally likely anywhere within a tolerance of the file's own value, entry by entry."""

    kind: Literal["uniform"]
    """Which sort of axis this is."""
    centre: Value | None = None
    """In place of the file's own values."""
    tolerance: Tolerance | None = None
    """Plus or minus, or relative_tolerance."""
    relative_tolerance: Tolerance | None = None
    """Plus or minus, over the middle's magnitude."""

    @model_validator(mode="after")
    def _require_single_width(self) -> Self:
        if (self.tolerance is None) == (self.relative_tolerance is None):
            raise ValueError("tolerance|give either this or relative_tolerance")
        return self


SampledAxis = HypercubeAxis | NormalAxis | UniformAxis
Axis = Annotated[ListAxis | GridAxis | SampledAxis, Field(discriminator="kind")]


class Samples(Data):
    """Draws of the axes with a distribution, all of them at once."""

    count: Amount
    """How many."""
    seed: Seed = 0
    """Seed of the random numbers."""


class StudyStarts(Data):
    """Every member again from starts that differ by next to nothing."""

    count: Amount
    """How many."""
    seed: Seed = 0
    """Seed of the first start; the others follow."""
    size_m: Perturbation = 1e-12
    """Largest change of a mesh displacement."""


class Definition(Data):
    """A study. Axes of values span a grid, over which samples and starts are repeated.

    Nothing of arm, scenario and switches is changed but at the paths of settings and axes.
    """

    union_tags: ClassVar[frozenset[str]] = list_kinds(Axis) | list_kinds(Quantity)

    schema_version: Annotated[int, NumberRange(1, 1)]
    """Version of the file."""
    name: Name
    """What results and drawings call the study."""
    title: Title = ""
    """One line about it."""
    arm: Path | None = None
    """Built-in name, or file beside this one; or robot."""
    robot: Path | None = None
    """Built-in name, or file beside this one; or arm."""
    level: Level | None = None
    """Level of a robot's model; the most detailed if left out."""
    scenario: Path
    """Built-in name, or file beside this one."""
    switches: Annotated[
        dict[str, str], Field(default_factory=dict), Rule("words by the switches' names")
    ]
    """Choices of law, as those of --set switches.phase=omega_t."""
    settings: Annotated[dict[str, JsonValue], Field(default_factory=dict), Rule("values by path")]
    """Other values, each by its path in quotes as --set names it."""
    axes: Annotated[tuple[Axis, ...], Field(max_length=50, strict=False)] = ()
    """Varied values."""
    samples: Samples | None = None
    """Draws, for axes with a distribution."""
    starts: StudyStarts | None = None
    """Perturbed starts."""
    quantities: Annotated[tuple[Quantity, ...], Field(min_length=1, max_length=200, strict=False)]
    """What to measure in every member."""
    spot_checks: Annotated[int, NumberRange(0, 1000)] = 0
    """Members that a second engine runs again, evenly chosen."""

    @property
    def mechanism(self) -> str:
        """Name of the arm or the robot."""
        return self.arm or self.robot or ""

    @property
    def section(self) -> str:
        """The first word of the mechanism's paths: arm or robot."""
        return "arm" if self.robot is None else "robot"

    @model_validator(mode="after")
    def _requires_mechanism(self) -> Self:
        if (self.arm is None) == (self.robot is None):
            raise ValueError("arm|give either this or robot")
        return self

    @model_validator(mode="after")
    def _samples_serve_axes(self) -> Self:
        drawn = [place for place, axis in enumerate(self.axes) if isinstance(axis, SampledAxisBase)]
        if drawn and self.samples is None:
            raise ValueError("samples|is missing; axes with a distribution need its count")
        if self.samples is not None and not drawn:
            raise ValueError("samples|needs an axis with a distribution")
        return self
