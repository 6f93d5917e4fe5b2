"""Cross-checks with every check in them, each of a few states and steps."""

import pytest

from crosscheck.planning import arms, plan

STATES = 4


def brief(patch: pytest.MonkeyPatch, experiment_s: float = 2e-3) -> None:
    """The quick plan; experiment_s: how long the paper's experiments are in it."""
    for name in plan.QUICK_S:
        patch.setitem(plan.QUICK_S, name, experiment_s)
    patch.setattr(plan, "QUICK_STEPS", 500)
    patch.setattr(plan, "PROBE_S", 1e-3)
    patch.setattr(plan, "SHORT_STEPS", 200)
    patch.setattr(plan, "ENERGY_STEPS", 200)
    patch.setattr(arms, "QUICK_COUNT", STATES)
