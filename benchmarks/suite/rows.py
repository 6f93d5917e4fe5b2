"""What the benchmark's parts measure: rows of tables."""

from __future__ import annotations

from typing import NamedTuple


class Row(NamedTuple):
    """One measured figure.

    table: the part it belongs to; case: the arm and run; quantity, value, unit: what was measured,
    the median of all rounds; against: what it stands beside in every round; ratio: median of the
    rounds' ratios to that, None where nothing stands beside; target: the largest ratio aimed at,
    None without one; spread: interquartile range of the rounds over their median, of the ratios
    where there is one, else of the values.
    """

    table: str
    case: str
    quantity: str
    value: float
    unit: str
    against: str
    ratio: float | None
    target: float | None
    spread: float
