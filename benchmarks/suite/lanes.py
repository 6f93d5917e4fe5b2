"""Part 2: trajectories side by side, against one alone and the SIMD C reference, over cores."""

from __future__ import annotations

import numba
import numpy as np

from analytic.ensemble import groups
from analytic.model import PhysicalModel
from benchmarks.suite.c_numbers import NotCovered
from benchmarks.suite.c_reference import LANES, NoCompiler, Vectors
from benchmarks.suite.cases import Counted, long_run
from benchmarks.suite.rows import Row, absent
from benchmarks.suite.single import largest_difference
from benchmarks.suite.timing import Times, in_turn, per_unit
from models.arm import Joint, Planetary

TABLE = "ensemble kernel"
COUNTED: tuple[Counted, ...] = ("lumped", "free")
STEPS, VECTORS = {2: 100_000, 6: 20_000}, (1, 2, 4)
MEMBERS = LANES * max(VECTORS) * 2  # one group of the ensemble, or more, for every core
ALONE, ONE, ALL = "one alone", "side by side, one core", "side by side, all cores"
SLIMMEST = 1 / 6  # of a trajectory's time alone
OF_C = 1.25


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
    arm = model.arm.model_copy(
        update={"joints": tuple(_widened(joint, scale) for joint in model.arm.joints)}
    )
    return PhysicalModel(arm, model.scenario, model.switches)


def _widened(joint: Joint, scale: float) -> Joint:
    assert isinstance(joint, Planetary)
    meshes = {
        name: mesh.model_copy(update={"backlash_m": scale * mesh.backlash_m})
        for name, mesh in (("sun_mesh", joint.sun_mesh), ("ring_mesh", joint.ring_mesh))
    }
    return joint.model_copy(update=meshes)


def _consume(models: list[PhysicalModel], threads: int) -> None:
    numba.set_num_threads(threads)
    for group in groups(models):
        for _ in group.chunks():
            pass


def _case(model: PhysicalModel, counted: Counted, repeats: int) -> list[Row]:
    case = f"{len(model.arm.joints)} joints, {counted}"
    models, cores = members_of(model, MEMBERS), numba.get_num_threads()
    runs = {
        ALONE: model.simulate,
        ONE: lambda: _consume(models, 1),
        ALL: lambda: _consume(models, cores),
    }
    shares = {ALONE: 1, ONE: MEMBERS, ALL: MEMBERS}
    vectors: dict[str, Vectors] = {}
    missing = []
    try:
        for count in VECTORS:
            name = f"SIMD C, {count} x {LANES}"
            vectors[name] = Vectors(models[: LANES * count])
            runs[name], shares[name] = vectors[name].run, LANES * count
    except (NoCompiler, NotCovered) as reason:
        missing = [absent(TABLE, case, str(reason))]
    times = per_unit(in_turn(runs, repeats), shares)
    steps = model.scenario.steps
    rows = [_per_step(case, name, found, steps) for name, found in times.items()]
    rows[1] = _held(rows[1], times[ONE], ALONE, times[ALONE], SLIMMEST)
    rows[2] = _held(rows[2], times[ALL], ONE, times[ONE], None)
    return [*rows, *_against_c(rows[1], times, vectors, models), *missing]


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
    plain, _ = models[1].integrated()
    apart = largest_difference(models[1], vectors[best].states(1)[0], plain)
    what = f"{best}: largest difference from the plain kernel"
    return [
        _held(row, times[ONE], best, times[best], OF_C),
        Row(TABLE, row.case, what, apart, "of size"),
    ]
