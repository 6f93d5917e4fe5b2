"""What every solver of the work-precision table offers."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np


class Solver(NamedTuple):
    """A way to integrate one model over one grid.

    run(value) gives q (records, n) on the grid; what the value is, `setting` says: a relative
    tolerance, or a step [s]. trajectories: how many it computes at once, the time being shared.
    """

    name: str
    setting: str
    run: Callable[[float], np.ndarray]
    trajectories: int = 1
