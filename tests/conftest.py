"""What all tests share: arms and experiments as the project ships them."""

from __future__ import annotations

import pytest
from hypothesis import settings

from models.arm import Arm
from models.loading import load_arm

# A first call may compile, and a machine may be busy: no example fails by the clock.
settings.register_profile("no-deadline", deadline=None)
settings.load_profile("no-deadline")


@pytest.fixture(scope="session")
def labelled() -> Arm:
    """The paper's arm, Table I as its labels say."""
    return load_arm("paper-labelled")


@pytest.fixture(params=["paper-labelled", "paper-swapped"], scope="session")
def reading(request: pytest.FixtureRequest) -> Arm:
    """Both readings of Table I."""
    return load_arm(request.param)
