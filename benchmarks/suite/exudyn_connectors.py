"""What the mesh law in Python costs Exudyn's tree: the same steps with it and without."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from time import perf_counter

import numpy as np

from benchmarks.suite.rows import Row
from models.exudyn_engine import Engine
from models.exudyn_tree import ExudynTree
from models.exudyn_tree_parts import bodies_of
from models.loading import load_case
from models.planets import usual_switches

TARGET = 2.0
RECORD = 1000  # steps: a run is all integration, and not what recording costs
SETTINGS = ("scenario.duration_s=0.2", f"scenario.record_every={RECORD}")
CASES: tuple[tuple[str, dict[str, str]], ...] = (
    ("paper-labelled", {"planets": "lumped"}),
    ("paper-labelled", {"planets": "free"}),
    ("paper-labelled", {"planets": "lumped", "mesh_work": "conservative"}),
    ("three-unlike", {"planets": "lumped"}),
)


class MotorsAlone(ExudynTree):
    """The tree with motors and friction, and no mesh: one call into Python each time, as ever."""

    @cached_property
    def _driven(self) -> Engine:
        return self._engine([])


class Bare(ExudynTree):
    """The tree without any force but gravity: the engine never calls into Python."""

    @cached_property
    def _driven(self) -> Engine:
        return Engine(bodies_of(self.arm), None, [0.0], self.arm.gravity_m_per_s2)


WITHOUT: dict[str, type[ExudynTree]] = {
    "the tree without any force": Bare,
    "the tree with its motors alone": MotorsAlone,
}


def measure(repeats: int) -> list[Row]:
    """The tree with all its forces against both trees without meshes, arm by arm."""
    return [row for arm, chosen in CASES for row in _rows(arm, chosen, repeats)]


def _rows(arm: str, chosen: dict[str, str], repeats: int) -> Iterator[Row]:
    case = load_case(arm, "pd", settings=SETTINGS)
    case = case._replace(switches=usual_switches(case.arm, **chosen))
    trees = [kind(*case) for kind in (ExudynTree, *WITHOUT.values())]
    seconds = np.array([[_seconds(tree) for tree in trees] for _ in range(repeats + 1)])[1:]
    full, *others = 1e6 * seconds.T / case.scenario.steps
    for against, other in zip(WITHOUT, others, strict=True):
        yield _row(f"{arm}, {', '.join(chosen.values())}, PD 0.2 s", full, against, other)


def _seconds(tree: ExudynTree) -> float:
    began = perf_counter()
    tree.simulate()
    return perf_counter() - began


def _row(case: str, values: np.ndarray, against: str, others: np.ndarray) -> Row:
    ratios = values / others
    low, ratio, high = np.percentile(ratios, (25, 50, 75))
    return Row(
        table="Exudyn's tree with and without mesh law",
        case=case,
        quantity="time per step of RK44",
        value=float(np.median(values)),
        unit="us",
        against=against,
        ratio=float(ratio),
        target=TARGET,
        spread=float((high - low) / ratio),
    )
