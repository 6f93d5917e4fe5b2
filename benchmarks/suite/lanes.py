"""Part 2: trajectories side by side, against one alone and the SIMD C reference, over cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np

from benchmarks.suite.c_numbers import NotCovered
from benchmarks.suite.c_reference import LANES, NoCompiler, Vectors
from benchmarks.suite.cases import Counted, long_run
from benchmarks.suite.rows import Row, absent
from benchmarks.suite.single import largest_difference, states_of
from benchmarks.suite.timing import Times, in_turn, per_unit, processor
from crosscheck.analytic.ensemble import ABREAST, Group, groups
from crosscheck.analytic.model import AnalyticModel, PhysicalModel
from crosscheck.models.arm.arm import Joint, Planetary

TABLE = "ensemble kernel"
COUNTED: tuple[Counted, ...] = ("lumped", "free")
STEPS, VECTORS = {2: 100_000, 6: 20_000}, (1, 2, 4)
MEMBERS = max(LANES * max(VECTORS), ABREAST * (os.cpu_count() or 1))  # a group for every core
ALONE, ONE, ALL = "one alone", "side by side, one core", "side by side, all cores"
SLIMMEST = 1 / 6  # of a trajectory's time alone
OF_C = 1.0


def measure(repeats: int) -> list[Row]:
    """Two joints and six, lumped and free."""
    return [
        row
        for joints, steps in STEPS.items()
        for counted in COUNTED
        for row in _case(long_run(joints, counted, steps), counted, repeats)
    ]


def members_of(model: PhysicalModel, count: int) -> list[PhysicalModel]:
    """The model and others whose plays are up to a fifth larger."""
    scales = np.linspace(1.0, 1.2, count)
    return [_with_play(model, scale) for scale in scales]


def _with_play(model: PhysicalModel, scale: float) -> PhysicalModel:
    joints = tuple(_widened(joint, scale) for joint in model.arm.joints)
    arm = model.arm.model_copy(update={"joints": joints})
    return PhysicalModel(arm, model.scenario, model.switches)


def _widened(joint: Joint, scale: float) -> Joint:
    assert isinstance(joint, Planetary)
    meshes = {
        name: mesh.model_copy(update={"backlash_m": _scaled(mesh.backlash_m, scale)})
        for name, mesh in (("sun_mesh", joint.sun_mesh), ("ring_mesh", joint.ring_mesh))
    }
    return joint.model_copy(update=meshes)


def _scaled(play: float | tuple[float, ...], scale: float) -> float | tuple[float, ...]:
    if isinstance(play, tuple):
        return tuple(scale * each for each in play)
    return scale * play


def dropped(models: Sequence[AnalyticModel], threads: int) -> None:
    """Run them and keep nothing; the kernel lets other threads run beside it."""
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(_drop, groups(models)))


def _drop(group: Group) -> None:
    for _ in group.chunks():
        pass


def _case(model: PhysicalModel, counted: Counted, repeats: int) -> list[Row]:
    case = f"{len(model.arm.joints)} joints, {counted}"
    models, cores = members_of(model, MEMBERS), os.cpu_count() or 1
    on_one, shares = partial(dropped, models, 1), {ALONE: 1, ONE: MEMBERS, ALL: MEMBERS}
    runs: dict[str, Callable[[], object]] = {ALONE: model.simulate, ONE: on_one}
    vectors, missing = vectors_of(models), list[Row]()
    if isinstance(vectors, Exception):
        vectors, missing = {}, [absent(TABLE, case, str(vectors))]
    runs |= {name: each.run for name, each in vectors.items()}
    shares |= {name: len(each.models) for name, each in vectors.items()}
    times = per_unit(in_turn(runs, repeats, processor), shares)
    over = {ONE: on_one, ALL: partial(dropped, models, cores)}
    by_clock = per_unit(in_turn(over, repeats), shares)
    steps = model.scenario.steps
    rows = {name: _per_step(case, name, found, steps) for name, found in times.items()}
    rows[ONE] = _held(rows[ONE], times[ONE], ALONE, times[ALONE], SLIMMEST)
    at_once = _per_step(case, f"{ALL} ({cores}), by the clock", by_clock[ALL], steps)
    at_once = _held(at_once, by_clock[ALL], ONE, by_clock[ONE], None)
    return [*rows.values(), at_once, *_against_c(rows[ONE], times, vectors, models), *missing]


def vectors_of(models: Sequence[PhysicalModel]) -> dict[str, Vectors] | Exception:
    """The SIMD C reference with one vector and more, by name; or why there is none."""
    try:
        return {f"SIMD C, {count} x {LANES}": Vectors(models[: LANES * count]) for count in VECTORS}
    except (NoCompiler, NotCovered) as reason:
        return reason


def _per_step(case: str, who: str, times: Times, steps: int) -> Row:
    what = f"{who}, per step and trajectory"
    return Row(TABLE, case, what, times.median / steps * 1e9, "ns", spread=times.spread)


def _held(row: Row, times: Times, against: str, other: Times, target: float | None) -> Row:
    return row._replace(against=against, ratio=times.over(other), target=target)


def _against_c(
    row: Row, times: dict[str, Times], vectors: dict[str, Vectors], models: list[PhysicalModel]
) -> list[Row]:
    if not vectors:
        return []
    best = min(vectors, key=lambda name: times[name].median)
    own = states_of(models[1])
    apart = largest_difference(models[1], vectors[best].states(1)[0], own)
    what = f"{best}: largest difference from simulate()"
    return [
        _held(row, times[ONE], best, times[best], OF_C),
        Row(TABLE, row.case, what, apart, "of size"),
    ]
