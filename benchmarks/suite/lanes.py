"""Part 2: trajectories side by side, against one alone and the SIMD C reference, over cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np

from benchmarks.suite.c_numbers import NotCovered
from benchmarks.suite.c_reference import LANES, NoCompiler, VectorRun
from benchmarks.suite.cases import Counted, build_long_run
from benchmarks.suite.rows import Row, absent_row
from benchmarks.suite.single import largest_difference, simulate_states
from benchmarks.suite.timing import Times, divide_times, processor_s, run_in_turn
from crosscheck.analytic.ensemble import GROUP_SIZE, Group, group_models
from crosscheck.analytic.model import AnalyticModel, PhysicalModel
from crosscheck.models.arm.arm import Joint, Planetary

TABLE = "ensemble kernel"
COUNTED: tuple[Counted, ...] = ("lumped", "free")
STEPS, VECTORS = {2: 100_000, 6: 20_000}, (1, 2, 4)
MEMBERS = max(LANES * max(VECTORS), GROUP_SIZE * (os.cpu_count() or 1))  # a group for every core
ALONE, ONE, ALL = "one alone", "side by side, one core", "side by side, all cores"
KERNEL_TARGET = 1 / 6  # of a trajectory's time alone
C_TARGET = 1.0


def measure(repeats: int) -> list[Row]:
    """Two joints and six, lumped and free."""
    return [
        row
        for joints, steps in STEPS.items()
        for counted in COUNTED
        for row in _case(build_long_run(joints, counted, steps), counted, repeats)
    ]


def build_members(model: PhysicalModel, count: int) -> list[PhysicalModel]:
    """The model and others whose plays are up to a fifth larger."""
    scales = np.linspace(1.0, 1.2, count)
    return [_scale_model_play(model, scale) for scale in scales]


def _scale_model_play(model: PhysicalModel, scale: float) -> PhysicalModel:
    joints = tuple(_scale_joint_play(joint, scale) for joint in model.arm.joints)
    arm = model.arm.model_copy(update={"joints": joints})
    return PhysicalModel(arm, model.scenario, model.switches)


def _scale_joint_play(joint: Joint, scale: float) -> Joint:
    assert isinstance(joint, Planetary)
    meshes = {
        name: mesh.model_copy(update={"backlash_m": _scale_play(mesh.backlash_m, scale)})
        for name, mesh in (("sun_mesh", joint.sun_mesh), ("ring_mesh", joint.ring_mesh))
    }
    return joint.model_copy(update=meshes)


def _scale_play(play: float | tuple[float, ...], scale: float) -> float | tuple[float, ...]:
    if isinstance(play, tuple):
        return tuple(scale * each for each in play)
    return scale * play


def run_and_discard(models: Sequence[AnalyticModel], threads: int) -> None:
    """Run them and keep nothing; the kernel lets other threads run beside it."""
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(_drop, group_models(models)))


def _drop(group: Group) -> None:
    for _ in group.chunks():
        pass


def _case(model: PhysicalModel, counted: Counted, repeats: int) -> list[Row]:
    case = f"{len(model.arm.joints)} joints, {counted}"
    models, cores = build_members(model, MEMBERS), os.cpu_count() or 1
    one_core, shares = partial(run_and_discard, models, 1), {ALONE: 1, ONE: MEMBERS, ALL: MEMBERS}
    runs: dict[str, Callable[[], object]] = {ALONE: model.simulate, ONE: one_core}
    vectors, missing = compile_vectors(models), list[Row]()
    if isinstance(vectors, Exception):
        vectors, missing = {}, [absent_row(TABLE, case, str(vectors))]
    runs |= {name: each.run for name, each in vectors.items()}
    shares |= {name: len(each.models) for name, each in vectors.items()}
    times = divide_times(run_in_turn(runs, repeats, processor_s), shares)
    over = {ONE: one_core, ALL: partial(run_and_discard, models, cores)}
    by_clock = divide_times(run_in_turn(over, repeats), shares)
    steps = model.scenario.steps
    rows = {name: _step_row(case, name, name_times, steps) for name, name_times in times.items()}
    rows[ONE] = _compare_row(rows[ONE], times[ONE], ALONE, times[ALONE], KERNEL_TARGET)
    at_once = _step_row(case, f"{ALL} ({cores}), by the clock", by_clock[ALL], steps)
    at_once = _compare_row(at_once, by_clock[ALL], ONE, by_clock[ONE], None)
    return [*rows.values(), at_once, *_compare_with_c(rows[ONE], times, vectors, models), *missing]


def compile_vectors(models: Sequence[PhysicalModel]) -> dict[str, VectorRun] | Exception:
    """The SIMD C reference with one vector and more, by name; or why there is none."""
    try:
        return {
            f"SIMD C, {count} x {LANES}": VectorRun(models[: LANES * count]) for count in VECTORS
        }
    except (NoCompiler, NotCovered) as reason:
        return reason


def _step_row(case: str, who: str, times: Times, steps: int) -> Row:
    what = f"{who}, per step and trajectory"
    return Row(TABLE, case, what, times.median / steps * 1e9, "ns", spread=times.spread)


def _compare_row(row: Row, times: Times, against: str, other: Times, target: float | None) -> Row:
    return row._replace(against=against, ratio=times.median_ratio(other), target=target)


def _compare_with_c(
    row: Row, times: dict[str, Times], vectors: dict[str, VectorRun], models: list[PhysicalModel]
) -> list[Row]:
    if not vectors:
        return []
    best = min(vectors, key=lambda name: times[name].median)
    kernel_states = simulate_states(models[1])
    difference = largest_difference(models[1], vectors[best].states(1)[0], kernel_states)
    what = f"{best}: largest difference from simulate()"
    return [
        _compare_row(row, times[ONE], best, times[best], C_TARGET),
        Row(TABLE, row.case, what, difference, "of size"),
    ]
