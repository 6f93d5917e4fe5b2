"""Views of what shortcuts cost a robot."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
import pytest

from crosscheck.cost import output
from crosscheck.cost.shortcuts import ShortcutCosts
from crosscheck.report.plots import figures
from tests.robots.cost_guard import found_cost
from tests.views.shown_numbers import View, mark


@lru_cache
def worked_out() -> ShortcutCosts:
    """The costs whose numbers are varied, worked out by code without a fault."""
    return found_cost("oblique", engines=True)


def derive_numbers(costs: ShortcutCosts) -> Iterator[tuple[str, float]]:
    """Largest torques, and medians of distances."""
    for name, values in zip(costs.names, costs.torques.T, strict=True):
        yield f"largest torque of {name}", float(np.abs(values).max())
    for number, rotor in enumerate(costs.robot.rotors):
        yield f"ratio of rotor {number}", rotor.ratio
        yield f"inertia of rotor {number}", rotor.inertia
    assert costs.geared is not None
    for each in (*costs.tips, costs.geared):
        level = getattr(each, "level", "geared")
        yield f"median distance of {level}", float(np.median(each.distances))


def render_page(costs: ShortcutCosts) -> str:
    """The page without what is drawn, which has another guard."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "to_svg", lambda figure: "<svg></svg>")
        return output.cost_page(costs)


RENDER = {
    "terminal": lambda costs: "\n".join(output.describe_result(costs)),
    "JSON": output.cost_json,
    "page": render_page,
}
VIEWS = {
    f"{name} of cost": View(lambda: mark(worked_out()), render, derive_numbers)
    for name, render in RENDER.items()
}
