"""By how much a part's numbers are larger than the right ones, where some of them are wrong."""

from collections.abc import Iterator

import numpy as np

from crosscheck.trial.judge import entries

STATES = 7
# Of each row, how many times too large; and what the whole part counts as.
RATIOS = [
    ([1.0, 1e6], 1.0),  # one entry that is wrong, however large, changes nothing
    ([1e6, 1.0], 1.0),
    ([1e3, 1e3, 1e9], 1e3),
    ([1e-3, 1e-3], 1e-3),
    ([4.0, 0.0], 4.0),  # a row that is nothing says nothing
    ([np.inf, 1.0, 1.0], 1.0),
    ([0.0, 0.0], 1.0),
]


def wrong_unit_ratios() -> Iterator[str]:
    """A line for every ratio that is not named, of vectors and of matrices by their diagonals."""
    draw = np.random.default_rng(3)
    for times, ratio in RATIOS:
        right = draw.uniform(1, 2, (STATES, len(times)))
        for values, reference in (
            (right * times, right),
            (
                np.array([np.diag(row * times) + 1e9 * (1 - np.eye(len(row))) for row in right]),
                np.array([np.diag(row) for row in right]),
            ),
        ):
            found = entries.unit_ratio(values, reference)
            if not np.isclose(found, ratio, rtol=1e-12):
                yield f"rows {times} times as large: {found}, must be {ratio}"
    for ratio, power in ((900.0, 1000.0), (0.011, 0.01), (1.5, 1.0), (4.0, 10.0)):
        if entries.power_of_ten(ratio) != power:
            yield f"{ratio} counts as {entries.power_of_ten(ratio)}"
