"""Signals of recordings: what is put at their ends, and rows that are left out."""

import numpy as np
import pytest

from crosscheck.identification.decimation import continue_signal


def test_a_line_goes_on_as_a_line():
    """Turned about its ends a signal keeps value and slope there, so no filter sees a step."""
    time = np.arange(-3.0, 14.0)[:, None]
    lines = np.hstack([time, 5 - 2 * time])
    assert continue_signal(lines[3:-4], 3, 4) == pytest.approx(lines)
