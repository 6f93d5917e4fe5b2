"""What the benchmark says: one record for every figure."""

from __future__ import annotations

import math
from typing import NamedTuple


class Row(NamedTuple):
    """One figure.

    table: the part it belongs to; case: what was run; quantity: what was measured of it; value: the
    median of the repeats, in unit, NaN where it could not be measured (quantity says why); against:
    what 1 is in the ratio, "" without one; ratio: the median over the repeats of value over what
    it is compared with in the same repeat; target: the most that the ratio may be; spread: largest
    less least value over the median.
    """

    table: str
    case: str
    quantity: str
    value: float
    unit: str
    against: str = ""
    ratio: float | None = None
    target: float | None = None
    spread: float = 0.0

    @property
    def is_within_target(self) -> bool | None:
        """Whether the ratio is within the target; None where nothing is asked."""
        if self.ratio is None or self.target is None:
            return None
        return self.ratio <= self.target


def absent_row(table: str, case: str, why: str) -> Row:
    """A part that cannot be measured here."""
    return Row(table, case, f"not measured: {why}", math.nan, "")
