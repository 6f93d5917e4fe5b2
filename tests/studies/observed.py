"""Which numbers of a chunk are measured: of the planet that is named, of every member."""

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np

from crosscheck.studies.measures import measurement

RECORDS, JOINTS, PLANETS, MEMBERS = 2, 2, 3, 4


def wrong_signals() -> Iterator[str]:
    """A line for every signal that is of another planet, or of none."""
    whole = np.arange(RECORDS * JOINTS * PLANETS * MEMBERS, dtype=float)
    single = whole.reshape(RECORDS, JOINTS, PLANETS, MEMBERS)
    theta = -single[:, :, 0]
    apart = SimpleNamespace(time=np.zeros(RECORDS), theta=theta, x_sp=single)
    for planet in range(1, PLANETS + 2):
        right = np.full_like(theta, np.nan) if planet > PLANETS else single[:, :, planet - 1]
        for chunk, name, expected in (
            (apart, "x_sp", right),
            (apart, "theta", theta),
        ):
            found = measurement._signal(chunk, name, planet)
            if not np.array_equal(found, expected, equal_nan=True):
                yield f"{name} of planet {planet}: {found}, must be {expected}"
