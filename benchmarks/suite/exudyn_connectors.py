"""What the mesh law in Python costs Exudyn's tree: the same steps with it and without."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

from benchmarks.suite.rows import Row
from benchmarks.suite.timing import divide_times, print_progress, run_in_turn
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.exudyn.engine import Engine
from crosscheck.models.exudyn.tree.tree import ExudynTree
from crosscheck.models.loading import load_case

TABLE = "Exudyn's tree with and without mesh law"
FULL = "the tree with all its forces"
TARGET = 2.0
RECORD = 1000  # steps: a run is all integration, and not what recording costs
SETTINGS = ("scenario.duration_s=0.2", f"scenario.record_every={RECORD}")
CASES: tuple[tuple[str, dict[str, str]], ...] = (
    ("paper-labelled", {"planets": "lumped"}),
    ("paper-labelled", {"planets": "free"}),
    ("paper-labelled", {"planets": "lumped", "mesh_work": "conservative"}),
    ("three-unlike", {"planets": "lumped"}),
)


class MotorTree(ExudynTree):
    """The tree with motors and friction, and no mesh: one call into Python each time, as ever."""

    @cached_property
    def _driven_engine(self) -> Engine:
        return self._engine([])


class ForceFreeTree(ExudynTree):
    """The tree without any force but gravity: the engine never calls into Python."""

    @cached_property
    def _driven_engine(self) -> Engine:
        return Engine(self.model.parts, self.model.robot.gravity)


REDUCED_TREES: dict[str, type[ExudynTree]] = {
    "the tree without any force": ForceFreeTree,
    "the tree with its motors alone": MotorTree,
}


def measure(repeats: int) -> list[Row]:
    """The tree with all its forces against both trees without meshes, arm by arm."""
    return [row for arm, chosen in CASES for row in _rows(arm, chosen, repeats)]


def _rows(arm: str, chosen: dict[str, str], repeats: int) -> Iterator[Row]:
    case = load_case(arm, "pd", settings=SETTINGS)
    case = case._replace(switches=usual_switches(case.arm, **chosen))
    tree_classes = {FULL: ExudynTree, **REDUCED_TREES}
    runs = {name: kind(*case).simulate for name, kind in tree_classes.items()}
    times = divide_times(run_in_turn(runs, repeats), dict.fromkeys(runs, case.scenario.steps))
    full, name = times[FULL], f"{arm}, {', '.join(chosen.values())}, PD 0.2 s"
    print_progress(f"{name}: {1e6 * full.median:.3g} us a step")
    row = Row(TABLE, name, "time per step of RK44", 1e6 * full.median, "us", spread=full.spread)
    for against in REDUCED_TREES:
        yield row._replace(against=against, ratio=full.median_ratio(times[against]), target=TARGET)
