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
# Times are recorded to 0.1 ns.
SAME_TIME_S = 1e-9


class BoundedRecord(Data):
    """The change that a repetition may make, in ``unit``, and why; None: it is not compared.

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
            raise ValueError(f"tolerance|at most {most:g} {self.unit}")
        return self


class Measurement(BoundedRecord):
    """The number of a Finding."""

    measured: Finite


class RecordedTable(BoundedRecord):
    """Numbers of one quantity of a run (planet 1); a row's first entry names its place.

    joints: the numbers of the joints that have the quantity, in their order.
    """

    joints: Annotated[tuple[JointNumber, ...], UpToSeven]
    rows: Annotated[tuple[Row, ...], Field(min_length=1, strict=False)]


class SampledQuantity(RecordedTable):
    """A quantity at some times; rows of time [s] and a value per joint."""

    @property
    def values(self) -> list[int]:
        """Indices of the columns that are compared, from 0."""
        return list(range(1, len(self.joints) + 1))

    def place(self, row: int, column: int) -> str:
        """The place of a value in the run, such as ``joint 1 at 0.5 s``."""
        return f"joint {self.joints[column - 1]} at {self.rows[row][0]:g} s"

    def find_row_fault(self, duration_s: float) -> str:
        """The rule that the rows break in a run of so many seconds; empty if none."""
        if any(len(row) != len(self.joints) + 1 for row in self.rows):
            return f"a time and {len(self.joints)} numbers in every row"
        times = [row[0] for row in self.rows]
        ends = times[0] == 0 and abs(times[-1] - duration_s) <= SAME_TIME_S
        rise = all(earlier < later for earlier, later in pairwise(times))
        return "" if ends and rise else f"times that rise from 0 to {duration_s:g} s"


class Extremes(RecordedTable):
    """Extreme values over a run; rows of joint, minimum, its time, maximum, its time.

    The times [s] are for the reader: of two peaks of one height, rounding picks the higher.
    """

    @property
    def values(self) -> list[int]:
        """Indices of the columns that are compared, from 0."""
        return [1, 3]

    def place(self, row: int, column: int) -> str:
        """The place of a value in the run, such as ``minimum of joint 1``."""
        return f"{'minimum' if column == 1 else 'maximum'} of joint {self.joints[row]}"

    def find_row_fault(self, duration_s: float) -> str:
        """The rule that the rows break in a run of so many seconds; empty if none."""
        if any(len(row) != 5 or row[1] > row[3] for row in self.rows):
            return "joint, minimum, its time, maximum, its time in every row"
        if tuple(row[0] for row in self.rows) != self.joints:
            return f"a row for each of the joints {self.joints}"
        times = [time for row in self.rows for time in (row[2], row[4])]
        within = all(0 <= time <= duration_s + SAME_TIME_S for time in times)
        return "" if within else f"times from 0 to {duration_s:g} s"


class RecordedRun(Data):
    """One simulation, reduced: the experiment as its Dataset states it, and numbers."""

    scenario: Scenario
    switches: Switches
    sampled: dict[SampledName, SampledQuantity]
    extremes: dict[ExtremesName, Extremes]

    @property
    def tables(self) -> dict[str, SampledQuantity | Extremes]:
        """All tables of the run, by quantity."""
        sampled = {str(quantity): table for quantity, table in self.sampled.items()}
        return {**sampled, **{str(quantity): table for quantity, table in self.extremes.items()}}

    @model_validator(mode="after")
    def _tables_are_of_this_run(self) -> Self:
        every = tuple(sorted({joint for table in self.tables.values() for joint in table.joints}))
        geared = [table.joints for name, table in self.tables.items() if name in BY_PLANET]
        for quantity, table in self.tables.items():
            where = f"{'sampled' if quantity in self.sampled else 'extremes'}.{quantity}"
            joints = geared[0] if quantity in BY_PLANET else every
            if table.unit != UNITS[quantity]:
                raise ValueError(f"{where}.unit|must be {UNITS[quantity]}")
            if table.joints != joints or list(joints) != sorted(set(joints)):
                raise ValueError(f"{where}.joints|must be those of the other quantities, in order")
            if needed := table.find_row_fault(self.scenario.duration_s):
                raise ValueError(f"{where}.rows|must be {needed}")
        return self


class AcceptedFailure(Data):
    """A check that had failed when it was accepted: its message, and its number, if it had one."""

    said: str
    number: Measurement | None


class Baseline(Data):
    """A cross-check of an arm on record; checks and measurements by id, runs by key."""

    schema_version: Literal[4] = 4
    project_version: str
    checks: dict[str, CheckVerdict]
    known: dict[str, AcceptedFailure]
    measurements: dict[str, Measurement]
    runs: dict[str, RecordedRun]
    provenance: Provenance

    @model_validator(mode="after")
    def _require_accepted_failures(self) -> Self:
        for name in sorted({*self.checks, *self.known}):
            verdict, failure = self.checks.get(name), self.known.get(name)
            if (verdict in (None, "agree")) != (failure is None):
                allowed = "a check is agree, or red and in known: one of the two"
                raise ValueError(f"checks.{name}|{allowed}")
            if failure is not None and (failure.number is None) != (verdict == "failed"):
                raise ValueError(f"known.{name}.number|a number, unless failed ({verdict})")
        return self


def find_differences(left: Any, right: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Each (dotted path, left, right) where two trees of JSON values differ; None where missing."""
    if isinstance(left, dict) and isinstance(right, dict):
        for key in sorted({*left, *right}):
            place = f"{path}.{key}" if path else key
            yield from find_differences(left.get(key), right.get(key), place)
    elif isinstance(left, list) and isinstance(right, list) and len(left) == len(right):
        for index, (left_item, right_item) in enumerate(zip(left, right, strict=True)):
            yield from find_differences(left_item, right_item, f"{path}[{index}]")
    elif left != right:
        yield path, left, right
