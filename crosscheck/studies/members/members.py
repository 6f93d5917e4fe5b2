"""The members of a study: counted through its grid, made into cases one after the other."""

from __future__ import annotations

import copy
import hashlib
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.paths import assign
from crosscheck.studies.definition.axes import (
    SAMPLE,
    START,
    VariedAxis,
    build_axes,
    varied_sections,
)
from crosscheck.studies.definition.definition import Definition
from crosscheck.studies.members.cases import MemberCase, Raw, build_case

CHECK_LIMIT = 500  # members that are checked before any of them is run


@dataclass(frozen=True)
class PreparedStudy:
    """A definition with all files that it names: all that its result depends on, except code.

    data: content of arm and scenario, and switches, settings applied; or of robot and scenario, and
    the text of its URDF. sources: text of the user's
    files of functions, by the names that the definition has for them. file: the study's, for
    messages.
    """

    definition: Definition
    data: Raw
    sources: dict[str, str]
    file: str

    @cached_property
    def text(self) -> str:
        """The whole study as JSON, for another process."""
        fields = {"definition": self.definition.model_dump(mode="json"), "file": self.file}
        return json.dumps({**fields, "data": self.data, "sources": self.sources}, sort_keys=True)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of what decides the study's numbers: not of the names of files."""
        excluded_fields = {"arm", "robot", "scenario", "name", "title"}
        defined = self.definition.model_dump(mode="json", exclude=excluded_fields)
        text = json.dumps([defined, self.data, self.sources], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    @cached_property
    def base(self) -> MemberCase:
        """The case that the axes start from. Raises InputError."""
        return build_case(self.data, self.definition)

    @cached_property
    def axes(self) -> list[VariedAxis]:
        """The study's axes with their values. Raises InputError."""
        definition = self.definition
        return build_axes(definition.axes, definition.samples, self.data, self.file)

    @cached_property
    def dimensions(self) -> dict[str, int]:
        """Sizes of the grid's dimensions by name: the axes' own, then samples, then starts."""
        axis_sizes = {axis.name: len(axis) for axis in self.axes if axis.dimension != SAMPLE}
        samples, starts = self.definition.samples, self.definition.starts
        drawn = {SAMPLE: samples.count} if samples is not None else {}
        return {**axis_sizes, **drawn, **({START: starts.count} if starts is not None else {})}

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the members' grid."""
        return tuple(self.dimensions.values())

    @property
    def count(self) -> int:
        """Number of members."""
        return math.prod(self.shape)

    def cases(self, begin: int, end: int) -> Iterator[MemberCase]:
        """The members' cases from one place to before another, in C order. Raises InputError."""
        maker = _CaseBuilder(self)
        for place in range(begin, end):
            yield maker.case(place)

    def points(self, place: int) -> dict[str, int]:
        """A member's place along every dimension, by the dimension's name."""
        where = np.unravel_index(place, self.shape) if self.shape else ()
        return dict(zip(self.dimensions, map(int, where), strict=True))


@lru_cache(maxsize=4)
def load_study(text: str) -> PreparedStudy:
    """The study whose ``PreparedStudy.text`` this is."""
    read = json.loads(text)
    definition = Definition.model_validate(read["definition"])
    return PreparedStudy(definition, read["data"], read["sources"], read["file"])


class _CaseBuilder:
    """Maker of members' cases in one copy of the files' content; what stayed is not read again."""

    def __init__(self, study: PreparedStudy) -> None:
        self.study, self.data = study, copy.deepcopy(study.data)
        self.of_section = {
            section: [axis for axis in study.axes if any(e[0] == section for e in axis.entries)]
            for section in varied_sections(study.data)
        }
        self.points: dict[str, tuple[int, ...]] = {}
        self.made: MemberCase | None = None

    def case(self, place: int) -> MemberCase:
        """The case of the member at a place. Raises InputError."""
        definition, points = self.study.definition, self.study.points(place)
        changed = [section for section in self.of_section if self._put(section, points)]
        if self.made is None or changed:
            previous, self.made = self.made, None
            try:
                self.made = build_case(self.data, definition, previous, changed)
            except InputError as error:
                raise explain_refusal(self.study, place, error) from None
        if definition.starts is None:
            return self.made
        seed = definition.starts.seed + points[START]
        return self.made.perturb(seed, definition.starts.size_m)

    def _put(self, section: str, points: dict[str, int]) -> bool:
        """Put a section's values at these points into the data; returns whether they changed."""
        axes = self.of_section[section]
        now = tuple(points[axis.dimension] for axis in axes)
        if self.points.get(section) == now:
            return False
        self.points[section] = now
        for axis, point in zip(axes, now, strict=True):
            for entry, value in zip(axis.entries, axis.entry_values(point), strict=True):
                assign(self.data, entry, value)
        return True


def require_members(study: PreparedStudy) -> None:
    """Raise InputError for a member that is refused, as far as a sample of them shows.

    Looked at are those where an axis has its least and largest values, and some spread over all;
    what else is wrong with two values only together shows when their batch is made.
    """
    extremes = {place for axis in study.axes for place in _extremes(study, axis)}
    spread = np.linspace(0, study.count - 1, min(CHECK_LIMIT, study.count)).astype(int)
    maker = _CaseBuilder(study)
    for place in sorted(extremes | set(map(int, spread))):
        maker.case(place)


def _extremes(study: PreparedStudy, axis: VariedAxis) -> Iterator[int]:
    """Places of the first members where an axis has its least and largest values, or each word."""
    points: Iterable[int] = range(len(axis))
    if isinstance(axis.values, np.ndarray):
        points = {*axis.values.argmin(axis=0).tolist(), *axis.values.argmax(axis=0).tolist()}
    stride = math.prod(study.shape[list(study.dimensions).index(axis.dimension) + 1 :])
    return (point * stride for point in points)


def explain_refusal(study: PreparedStudy, place: int, error: InputError) -> InputError:
    """The error of a refused member: names the axis to blame alone, else the member."""
    points = study.points(place)
    for axis in study.axes:
        data = copy.deepcopy(study.data)
        given = axis.entry_values(points[axis.dimension])
        for entry, value in zip(axis.entries, given, strict=True):
            assign(data, entry, value)
        try:
            build_case(data, study.definition)
        except InputError as alone:
            where, allowed = f"{study.file}: axis {axis.path}", f"{alone.field}: {alone.allowed}"
            return InputError(where, "", alone.value, allowed)
    where, allowed = f"{study.file}: member {place}", f"{error.allowed}, as varied"
    return InputError(where, error.field, error.value, allowed)
