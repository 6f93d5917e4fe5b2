"""The experiments behind the claims: which are simulated in which cell, and their numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

from crosscheck.paper.claims.measures import BACK_AND_FORTH, CONSTANT_TORQUE
from crosscheck.paper.claims.pd import TRANSIENT, WHOLE
from crosscheck.paper.claims.quantities import (
    BACK,
    BACKLASH,
    CONSTANT,
    CONSTANT_NO_ERROR,
    CONSTANT_STIFFNESS,
    ERROR,
    NO_BACKLASH,
    NO_ERROR,
    PD,
    STATIC,
    TWO_PLANETS,
    Source,
)
from crosscheck.paper.claims.rule import LAWS, Cell
from crosscheck.paper.claims.statics import Statics
from crosscheck.paper.scale import Scale
from crosscheck.studies.study import Asked, Comparison, Study, Variant

READINGS = ("paper-labelled", "paper-swapped")
SHORT_S = 1.2  # Fig. 14's length
RECORD_EVERY = 4  # 40 us: 17 samples per period even at 1.5 kHz
TORQUE_RECORD = 10  # constant torque and back and forth: nothing fast decides there
DEFAULT_B_UM, DEFAULT_E_UM = 50.0, 5.0
# From where the controller flutters by itself to twice the default.
ZETAS = (0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.01, 0.015, 0.02, 0.03, 0.05, 0.1)
ABLATED_ZETAS = (0.003, 0.004, 0.006, 0.01, 0.02, 0.05)
SWEPT_ZETAS = (0.004, 0.006, 0.05)


class Experiment(NamedTuple):
    """One kind of run: where its numbers are found, what it changes, what is measured."""

    source: Source
    variant: Variant
    measure: Comparison


@dataclass(frozen=True)
class Plan:
    """Which cells are simulated, and what at which damping ratios.

    ablated: one effect left out; swept: backlashes, errors and extreme (3 s) [um], two planets;
    shaken: back and forth for the backlashes ``back`` [um].
    """

    readings: tuple[str, ...] = READINGS
    zetas: tuple[float, ...] = ZETAS
    swept: tuple[float, ...] = SWEPT_ZETAS
    ablated: tuple[float, ...] = ABLATED_ZETAS
    shaken: tuple[float, ...] = (0.006, 0.05)
    planets: bool = True
    backlashes: tuple[float, ...] = (5.0, 10.0, 25.0, 500.0, 1000.0)
    errors: tuple[float, ...] = (0.8, 1.6, 3.2, 6.3)
    extreme: tuple[float, ...] = (3000.0,)
    back: tuple[float, ...] = (0.0, 50.0, 100.0, 500.0)


FULL = Plan()
QUICK = Plan(
    readings=READINGS[:1],
    zetas=(0.006, 0.05),
    swept=(0.006,),
    ablated=(0.006,),
    shaken=(0.05,),
    backlashes=(5.0,),
    errors=(1.6, 6.3),
    planets=False,
    extreme=(),
    back=(0.0, 50.0),
)


def cells(study: Study, scale: Scale) -> list[Cell]:
    """Every cell with its numbers."""
    plan = QUICK if scale.quick else FULL
    asked_of = [Statics(reading) for reading in plan.readings]
    known = dict(zip(plan.readings, study.answers(asked_of, "claims: statics"), strict=True))
    found = [Cell(*where) for where in product(LAWS, plan.readings, plan.zetas)]
    wanted = [(cell, experiment) for cell in found for experiment in experiments(plan, cell)]
    asked = [Asked(scale.cut(experiment.variant), experiment.measure) for _, experiment in wanted]
    for (cell, experiment), values in zip(wanted, study.numbers(asked, "claims"), strict=True):
        cell.numbers.add(experiment.source, values)
    for cell in found:
        cell.numbers.add(STATIC, known[cell.reading])
        if cell.numbers.members(ERROR):  # the default run is a member of both sweeps
            cell.numbers.share(PD, BACKLASH(DEFAULT_B_UM))
            cell.numbers.share(PD, ERROR(DEFAULT_E_UM))
    return found


def experiments(plan: Plan, cell: Cell) -> Iterator[Experiment]:
    """What is simulated in a cell."""
    base = Variant(arm=cell.reading, phase=cell.phase, zeta=cell.zeta, record_every=RECORD_EVERY)
    constant = replace(base, scenario="constant-torque", record_every=TORQUE_RECORD)
    yield Experiment(PD, base, WHOLE)
    yield Experiment(CONSTANT, constant, CONSTANT_TORQUE)
    if cell.zeta in plan.ablated:
        yield from _ablations(base, constant)
    if cell.zeta in plan.swept:
        yield from _sweeps(plan, base)
    if cell.zeta in plan.shaken:
        yield from _shaken(
            plan, replace(base, scenario="back-and-forth", record_every=TORQUE_RECORD)
        )


def _ablations(base: Variant, constant: Variant) -> Iterator[Experiment]:
    """One effect of the gears left out at a time."""
    short = replace(base, duration_s=SHORT_S)
    yield Experiment(NO_BACKLASH, _set(short, "backlash_m", 0), TRANSIENT)
    yield Experiment(NO_ERROR, _set(short, "tooth_error_m", 0), TRANSIENT)
    rigid = _set(short, "mesh_stiffness_amplitude_N_per_m", 0)
    yield Experiment(CONSTANT_STIFFNESS, rigid, TRANSIENT)
    yield Experiment(CONSTANT_NO_ERROR, _set(constant, "tooth_error_m", 0), CONSTANT_TORQUE)


def _sweeps(plan: Plan, base: Variant) -> Iterator[Experiment]:
    """Figs. 16-20, and a stage with two planets."""
    short = replace(base, duration_s=SHORT_S)
    for b in plan.backlashes:
        yield Experiment(BACKLASH(b), _set(short, "backlash_m", b * 1e-6), TRANSIENT)
    for b in plan.extreme:
        yield Experiment(BACKLASH(b), _set(base, "backlash_m", b * 1e-6), WHOLE)
    for error in plan.errors:
        yield Experiment(ERROR(error), _set(short, "tooth_error_m", error * 1e-6), TRANSIENT)
    if plan.planets:
        two = replace(short, settings=("arm.joints.*.planet_count=2",))
        yield Experiment(TWO_PLANETS, two, TRANSIENT)


def _shaken(plan: Plan, base: Variant) -> Iterator[Experiment]:
    """Fig. 15."""
    for b in plan.back:
        yield Experiment(BACK(b), _set(base, "backlash_m", b * 1e-6), BACK_AND_FORTH)


def _set(variant: Variant, field: str, value: float) -> Variant:
    """The variant with a field of all its joints' meshes changed."""
    return replace(variant, meshes=(*variant.meshes, f"arm.joints.*.{field}={value!r}"))
