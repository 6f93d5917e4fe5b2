"""Whether what `cost` tells of a robot is right, by guards that share nothing with it."""

from collections.abc import Callable, Iterator
from functools import lru_cache

from crosscheck.cost.shortcuts import ShortcutCosts
from tests.faults.planting import Seen, judge_guard
from tests.robots import cost_views
from tests.robots.cost_guard import (
    found_cost,
    robot,
    wrong_given,
    wrong_limits,
    wrong_motion,
    wrong_numbers,
    wrong_states,
    wrong_steps,
    wrong_tip,
)
from tests.robots.cost_judge import wrong_condition, wrong_verdicts


@lru_cache
def right_cost(name: str) -> ShortcutCosts:
    """Worked out before any fault is planted; views show it."""
    return found_cost(name, engines=True)


def _motion(name: str) -> Iterator[str]:
    for seed in range(2):
        yield from wrong_motion(robot(name), seed)


GUARDS: dict[str, Callable[[str], Iterator[str]]] = {
    "numbers": lambda name: wrong_numbers(name, found_cost(name, runs=0)),
    "runs": lambda name: wrong_numbers(name, found_cost(name)),
    "tip": wrong_tip,
    "motion": _motion,
    "limits": lambda name: wrong_limits(),
    "states": lambda name: wrong_states(),
    "given motion": lambda name: wrong_given(),
    "steps": lambda name: wrong_steps(),
    "verdicts": lambda name: wrong_verdicts(),
    "condition": lambda name: wrong_condition(),
    "picture": lambda name: cost_views.wrong_picture(right_cost(name)),
}


def cost_is_right(seen: Seen) -> str:
    """The verdict of a guard on the robot."""
    return judge_guard(GUARDS[seen.quantity](seen.arm))
