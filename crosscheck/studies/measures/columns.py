"""The variables of a study's result: names, units, meanings and dimensions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import PdDrive
from crosscheck.models.trajectory import meaning_of, unit_of
from crosscheck.studies.definition import quantities
from crosscheck.studies.members.cases import MemberCase
from crosscheck.studies.members.members import PreparedStudy

DIVERGED = "diverged_s"
SECOND = "s"


@dataclass(frozen=True)
class Column:
    """A variable: its name, unit and meaning; dims and shape: those after the members'.

    missing: in words, why a member that ran to the end has no value, if it can have none.
    """

    name: str
    unit: str
    meaning: str
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    missing: str = ""


def list_columns(study: PreparedStudy) -> list[Column]:
    """Every variable of the result, over the members. Raises InputError."""
    result_columns = [Column(DIVERGED, SECOND, "time at which the run diverged, if it did")]
    for quantity in study.definition.quantities:
        require_measurable(quantity, study.base, study.file)
        result_columns += _columns(quantity, study.base)
    return result_columns


def require_measurable(quantity: quantities.Quantity, case: MemberCase, file: str) -> None:
    """Raise InputError unless a quantity is defined for a member."""
    where = f"{file}: {quantity.result_name}"
    joints = len(case.planet_counts)
    joint = getattr(quantity, "joint", None)
    if joint is not None and joint > joints:
        raise InputError(where, "joint", joint, f"the {case.mechanism.section} has {joints}")
    for signal in (getattr(quantity, "signal", "theta"), *getattr(quantity, "signals", ())):
        signals = case.list_signals(joint)
        if signal not in signals:
            raise InputError(where, "signal", signal, f"must be one of {', '.join(signals)}")
    planets = max(case.planet_counts)
    planet = getattr(quantity, "planet", None)
    if planet is not None and planet > max(planets, 1):
        allowed = f"the {case.mechanism.section}'s joints have up to {planets}"
        raise InputError(where, "planet", planet, allowed)
    of_contact = isinstance(quantity, quantities.ContactQuantity)
    if of_contact and case.switches is not None and case.switches.dead_zone != "exact":
        allowed = "needs dead_zone = exact: by Eq. 6 no force is ever 0"
        raise InputError(where, "kind", quantity.kind, allowed)
    aims = isinstance(quantity, quantities.FinalError) or (
        isinstance(quantity, quantities.Settling) and quantity.target_rad is None
    )
    if aims and not isinstance(case.scenario.drive, PdDrive):
        raise InputError(where, "kind", quantity.kind, "needs a PD drive, which has a target")
    if isinstance(quantity, quantities.RigidDeviation) and quantity.level not in case.rigid_levels:
        allowed = f"allowed: {', '.join(case.rigid_levels)}"
        raise InputError(where, "level", quantity.level, allowed)
    window = quantity.window_s if isinstance(quantity, quantities.WindowedQuantity) else None
    if window is not None and window[0] >= case.scenario.duration_s:
        allowed = f"must begin before the run's end, {case.scenario.duration_s:g} s"
        raise InputError(where, "window_s", list(window), allowed)


def _columns(quantity: quantities.Quantity, case: MemberCase) -> Iterator[Column]:
    joints = len(case.planet_counts)
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    if isinstance(quantity, quantities.Function):
        for name, unit in quantity.returns.items():
            yield Column(name, unit, f"{name} by {quantity.function}")
    elif isinstance(quantity, quantities.Trajectories):
        records = case.scenario.steps // case.scenario.stride + 1
        for signal in quantity.signals:
            name = signal if quantity.name is None else f"{quantity.name}_{signal}"
            dims, shape = ("time", "joint"), (records, joints)
            if signal in quantities.MESH_SIGNALS:
                dims, shape = (*dims, "planet"), (*shape, max(case.planet_counts))
            yield Column(name, unit_of(signal), meaning_of(signal), dims, shape)
    else:
        every = getattr(quantity, "joint", None) is None
        dims, shape = (("joint",), (joints,)) if every else ((), ())
        if isinstance(quantity, quantities.SpectralPeak):
            about = f"largest line of {quantity.signal}"
            name, unit = quantity.result_name, unit_of(quantity.signal)
            yield Column(f"{name}_frequency", "Hz", f"frequency of the {about}", dims, shape)
            yield Column(f"{name}_amplitude", unit, f"amplitude of the {about}", dims, shape)
        else:
            unit, meaning, *missing = _describe(quantity)
            meaning += "" if every else f", joint {getattr(quantity, 'joint', None)}"
            yield Column(quantity.result_name, unit, meaning, dims, shape, *missing)


def _describe(quantity: quantities.Quantity) -> tuple[str, ...]:
    """Unit and meaning of a quantity, and why a member that ran to the end has none, if so."""
    match quantity:
        case quantities.Size() | quantities.BandRms():
            kind = quantity.kind.replace("_", " ")
            return unit_of(quantity.signal), f"{kind} of the recorded {meaning_of(quantity.signal)}"
        case quantities.Crossing():
            beyond = f"{quantity.side} {quantity.level:g}"
            return SECOND, f"time when {quantity.signal} is first {beyond}", f"never {beyond}"
        case quantities.ContactLoss():
            meaning = f"time when contact is first lost ({quantity.signal})"
            return SECOND, meaning, "never loses contact"
        case quantities.NoContactShare():
            return "1", f"share of the time without contact ({quantity.signal})"
        case quantities.Settling():
            band = f"{quantity.band_rad:g} rad of its target"
            meaning = f"time until the joint angle stays within {band}"
            return SECOND, meaning, "does not settle before the end"
        case quantities.FinalError():
            return "rad", "joint angle at the end minus its target"
    assert isinstance(quantity, quantities.RigidDeviation)
    return "rad", f"largest deviation of the joint angle from the rigid arm's ({quantity.level})"
