"""The experiments behind the claims: which are simulated in which cell, and their numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import xarray as xr

from crosscheck.paper.claims.measures import back_and_forth, constant_torque
from crosscheck.paper.claims.pd import transient, whole
from crosscheck.paper.claims.rule import LAWS, Cell
from crosscheck.paper.claims.statics import statics
from crosscheck.paper.scale import Scale
from crosscheck.studies.study import Numbers, Study, Variant

READINGS = ("paper-labelled", "paper-swapped")
SHORT_S = 1.2  # Fig. 14's length
RECORD_EVERY = 4  # 40 us: 17 samples per period even at 1.5 kHz
TORQUE_RECORD = 10  # constant torque and back and forth: nothing fast decides there
DEFAULT_B_UM, DEFAULT_E_UM = "50", "5"
# From where the controller flutters by itself to twice the default.
ZETAS = (0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.01, 0.015, 0.02, 0.03, 0.05, 0.1)
ABLATED_ZETAS = (0.003, 0.004, 0.006, 0.01, 0.02, 0.05)
SWEPT_ZETAS = (0.004, 0.006, 0.05)


class Experiment(NamedTuple):
    """One kind of run: its name among the numbers, what it changes, what is measured."""

    name: str
    variant: Variant
    measure: Callable[[xr.Dataset], Numbers]


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
    backlashes: tuple[str, ...] = ("5", "10", "25", "500", "1000")
    errors: tuple[str, ...] = ("0.8", "1.6", "3.2", "6.3")
    extreme: tuple[str, ...] = ("3000",)
    back: tuple[str, ...] = ("0", "50", "100", "500")


FULL = Plan()
QUICK = Plan(
    readings=READINGS[:1],
    zetas=(0.006, 0.05),
    swept=(0.006,),
    ablated=(0.006,),
    shaken=(0.05,),
    backlashes=("5",),
    errors=("1.6", "6.3"),
    planets=False,
    extreme=(),
    back=("0", "50"),
)


def cells(study: Study, scale: Scale) -> list[Cell]:
    """Every cell with its numbers."""
    plan = QUICK if scale.quick else FULL
    known = {reading: statics(reading) for reading in plan.readings}
    found = [Cell(*where) for where in product(LAWS, plan.readings, plan.zetas)]
    wanted = [(cell, experiment) for cell in found for experiment in experiments(plan, cell)]
    for measure in (constant_torque, whole, transient, back_and_forth):
        asked = [(cell, e) for cell, e in wanted if e.measure is measure]
        variants = [scale.cut(experiment.variant) for _, experiment in asked]
        numbers = study.measures(variants, measure, "claims: " + measure.__name__.replace("_", " "))
        for (cell, experiment), values in zip(asked, numbers, strict=True):
            cell.numbers.add(experiment.name, values)
    for cell in found:
        cell.numbers.add("static", known[cell.reading])
        _share_defaults(cell)
    return found


def _share_defaults(cell: Cell) -> None:
    """The default run is a member of both sweeps."""
    own = {name.removeprefix("pd."): v for name, v in cell.numbers.items() if name[:3] == "pd."}
    if any(name.startswith("E") for name in cell.numbers):
        cell.numbers.add(f"b{DEFAULT_B_UM}", dict(own))
        cell.numbers.add(f"E{DEFAULT_E_UM}", dict(own))


def experiments(plan: Plan, cell: Cell) -> Iterator[Experiment]:
    """What is simulated in a cell."""
    base = Variant(arm=cell.reading, phase=cell.phase, zeta=cell.zeta, record_every=RECORD_EVERY)
    constant = replace(base, scenario="constant-torque", record_every=TORQUE_RECORD)
    yield Experiment("pd", base, whole)
    yield Experiment("constant", constant, constant_torque)
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
    yield Experiment("no_backlash", _set(short, "backlash_m", 0), transient)
    yield Experiment("no_error", _set(short, "tooth_error_m", 0), transient)
    rigid = _set(short, "mesh_stiffness_amplitude_N_per_m", 0)
    yield Experiment("constant_stiffness", rigid, transient)
    yield Experiment("constant_no_error", _set(constant, "tooth_error_m", 0), constant_torque)


def _sweeps(plan: Plan, base: Variant) -> Iterator[Experiment]:
    """Figs. 16-20, and a stage with two planets."""
    short = replace(base, duration_s=SHORT_S)
    for b in plan.backlashes:
        yield Experiment(f"b{b}", _set(short, "backlash_m", float(b) * 1e-6), transient)
    for b in plan.extreme:
        yield Experiment(f"b{b}", _set(base, "backlash_m", float(b) * 1e-6), whole)
    for error in plan.errors:
        name = "E" + error.replace(".", "_")
        yield Experiment(name, _set(short, "tooth_error_m", float(error) * 1e-6), transient)
    if plan.planets:
        yield Experiment("two_planets", _set(short, "planet_count", 2), transient)


def _shaken(plan: Plan, base: Variant) -> Iterator[Experiment]:
    """Fig. 15."""
    for b in plan.back:
        yield Experiment(f"back{b}", _set(base, "backlash_m", float(b) * 1e-6), back_and_forth)


def _set(variant: Variant, field: str, value: float) -> Variant:
    """The variant with a field of all its joints changed."""
    return replace(variant, settings=(*variant.settings, f"arm.joints.*.{field}={value!r}"))
