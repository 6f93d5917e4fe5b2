"""A cross-check on record: what is kept of it, and what such a record may hold."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from crosscheck.checks.records import BY_PLANET
from crosscheck.checks.trajectories import UNITS
from crosscheck.models.arm.quantities import Data, Finite, NotNegative, UpToSeven
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.provenance import Provenance

SCHEMA_VERSION = 4
SampledName = Literal["theta", "theta_dot", "x_sp", "x_pr"]
ExtremesName = Literal["theta_ddot", "F_sp", "F_pr"]
CheckVerdict = Literal["agree", "unresolved", "differ", "failed"]
BEST_FIRST = ("agree", "unresolved", "unfinished", "differ", "failed")
JointNumber = Annotated[int, Field(ge=1, le=7)]
Row = Annotated[tuple[Finite, ...], Field(min_length=2, strict=False)]
Rows = Annotated[tuple[Row, ...], Field(min_length=1, strict=False)]
# Times are recorded to 0.1 ns.
SAME_TIME_S = 1e-9


class Misfit(ValueError):
    """A value that its neighbours in the record do not allow: dotted field, value, allowed."""

    def __init__(self, field: str, value: object, allowed: str) -> None:
        self.field, self.value, self.allowed = field, value, allowed
        super().__init__(allowed)


class Bounded(Data):
    """What a repetition may differ by, in ``unit``, and why; None: it is not compared.

    ``uncertainty``: numerical uncertainty by step refinement, None where it was not measured.
    ``widest``: the tolerance above which a comparison would mean nothing, where there is one.
    """

    unit: str
    tolerance: NotNegative | None
    basis: str
    uncertainty: NotNegative | None = None
    widest: NotNegative | None = None

    @model_validator(mode="after")
    def _tolerance_means_something(self) -> Self:
        most = math.inf if self.widest is None else self.widest
        if self.tolerance is not None and self.tolerance > most:
            raise Misfit("tolerance", self.tolerance, f"at most {most:g} {self.unit}")
        return self


class Measurement(Bounded):
    """The number of a Finding."""

    measured: Finite


class RecordedTable(Bounded):
    """Numbers of one quantity of a run (planet 1); a row's first entry says what it is about.

    joints: the numbers of those that have the quantity, in their order.
    """

    joints: Annotated[tuple[JointNumber, ...], UpToSeven]
    rows: Rows

    @model_validator(mode="after")
    def _is_rectangular(self) -> Self:
        for number, row in enumerate(self.rows):
            if len(row) != len(self.rows[0]):
                raise Misfit(f"rows.{number}", row, f"{len(self.rows[0])} numbers, as the first")
        if any(later <= earlier for earlier, later in pairwise(self.joints)):
            raise Misfit("joints", self.joints, "numbers of joints in their order")
        return self


class SampledQuantity(RecordedTable):
    """A quantity at some times; rows of time [s] and a value per joint."""

    @property
    def values(self) -> list[int]:
        """The columns that are compared."""
        return list(range(1, len(self.joints) + 1))

    @property
    def times_s(self) -> list[float]:
        """Every time that it names."""
        return [row[0] for row in self.rows]

    def place(self, row: int, column: int) -> str:
        """Where a value lies, for a reader."""
        return f"joint {self.joints[column - 1]} at {self.rows[row][0]:g} s"

    @model_validator(mode="after")
    def _has_a_column_per_joint(self) -> Self:
        if len(self.rows[0]) - 1 != len(self.joints):
            raise Misfit("rows.0", self.rows[0], f"a time and {len(self.joints)} numbers")
        return self

    @model_validator(mode="after")
    def _time_goes_on(self) -> Self:
        for number, (earlier, later) in enumerate(pairwise(self.times_s), start=1):
            if later <= earlier:
                raise Misfit(f"rows.{number}.0", later, f"a time after {earlier:g} s")
        return self


class Extremes(RecordedTable):
    """Extreme values over a run; rows of joint, minimum, its time, maximum, its time.

    The times [s] are for the reader: of two peaks of one height, rounding picks the higher.
    """

    @property
    def values(self) -> list[int]:
        """The columns that are compared."""
        return [1, 3]

    @property
    def times_s(self) -> list[float]:
        """Every time that it names."""
        return [row[column] for row in self.rows for column in (2, 4)]

    def place(self, row: int, column: int) -> str:
        """Where a value lies, for a reader."""
        return f"{'minimum' if column == 1 else 'maximum'} of joint {self.joints[row]}"

    @model_validator(mode="after")
    def _are_extremes_of_every_joint(self) -> Self:
        if len(self.rows) != len(self.joints):
            raise Misfit("rows", len(self.rows), f"must cover {len(self.joints)} joints")
        for number, row in enumerate(self.rows):
            if len(row) != 5:
                raise Misfit(f"rows.{number}", row, "joint, minimum, its time, maximum, its time")
            if row[0] != self.joints[number]:
                raise Misfit(f"rows.{number}.0", row[0], f"joint {self.joints[number]}")
            if row[1] > row[3]:
                raise Misfit(f"rows.{number}.1", row[1], f"at most the maximum, {row[3]:g}")
        return self


class RecordedRun(Data):
    """One simulation, reduced: the experiment as its Dataset states it, and numbers."""

    scenario: Scenario
    switches: Switches
    sampled: dict[SampledName, SampledQuantity]
    extremes: dict[ExtremesName, Extremes]

    @property
    def tables(self) -> dict[str, SampledQuantity | Extremes]:
        """Quantity -> its table."""
        sampled = {str(quantity): table for quantity, table in self.sampled.items()}
        return {**sampled, **{str(quantity): table for quantity, table in self.extremes.items()}}

    @model_validator(mode="after")
    def _tables_are_of_this_run(self) -> Self:
        every = sorted({joint for table in self.tables.values() for joint in table.joints})
        geared = {t.joints for quantity, t in self.tables.items() if quantity in BY_PLANET}
        for quantity, table in self.tables.items():
            where = f"{'sampled' if quantity in self.sampled else 'extremes'}.{quantity}"
            if table.unit != UNITS[quantity]:
                raise Misfit(f"{where}.unit", table.unit, f"must be {UNITS[quantity]}")
            _require_within(where, table, self.scenario.duration_s)
            if quantity not in BY_PLANET and table.joints != tuple(every):
                raise Misfit(f"{where}.joints", table.joints, f"must be {every}")
            if quantity in BY_PLANET and len(geared) > 1:
                raise Misfit(f"{where}.joints", table.joints, "must be those of the other meshes")
        return self


def _require_within(where: str, table: SampledQuantity | Extremes, duration_s: float) -> None:
    times = table.times_s
    for time in times:
        if not 0 <= time <= duration_s + SAME_TIME_S:
            raise Misfit(f"{where}.rows", time, f"times from 0 to {duration_s:g} s")
    if isinstance(table, SampledQuantity) and (
        times[0] > 0 or duration_s - times[-1] > SAME_TIME_S
    ):
        ends = [times[0], times[-1]]
        raise Misfit(f"{where}.rows", ends, f"must reach from 0 to {duration_s:g} s")


class KnownFailure(Data):
    """A check that was red when it was accepted: what it said, and its number, if it had one."""

    said: str
    number: Measurement | None


class Baseline(Data):
    """A cross-check of an arm on record; checks and measurements by id, runs by key."""

    schema_version: Literal[4] = 4
    project_version: str
    checks: dict[str, CheckVerdict]
    known: dict[str, KnownFailure]
    measurements: dict[str, Measurement]
    runs: dict[str, RecordedRun]
    provenance: Provenance

    @model_validator(mode="after")
    def _every_red_check_is_known(self) -> Self:
        for name in sorted({*self.checks, *self.known}):
            verdict, known = self.checks.get(name), self.known.get(name)
            if (verdict in (None, "agree")) != (known is None):
                allowed = "a check is agree, or red and in known: one of the two"
                raise Misfit(f"checks.{name}", verdict, allowed)
            if known is not None and (known.number is None) != (verdict == "failed"):
                raise Misfit(f"known.{name}.number", None, f"a number, unless failed ({verdict})")
        return self


def differences(one: Any, other: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """(dotted path, left, right) wherever two trees of JSON values differ; None where missing."""
    if isinstance(one, dict) and isinstance(other, dict):
        for key in sorted({*one, *other}):
            yield from differences(one.get(key), other.get(key), f"{path}.{key}" if path else key)
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for index, (left, right) in enumerate(zip(one, other, strict=True)):
            yield from differences(left, right, f"{path}[{index}]")
    elif one != other:
        yield path, one, other
