"""Numbers that a record asks for: those of an arm file on which torques depend linearly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.models.loading import validate_record
from crosscheck.models.paths import assign, find_paths
from crosscheck.recordings.residual import NormalEquations

UNITS = {
    "mass_kg": "kg",
    "inertia_kg_m2": "kg m^2",
    "density_kg_per_m3": "kg/m^3",
    "friction_N_m_s_per_rad": "N m s/rad",
}
STEP = 2.0**-10  # relative; of a number that is zero, its own unit
NORMAL = 1.96  # of a 95 % interval
# Of a column, what the others leave of its square: less is no information but rounding.
LEAST_PIVOT = 1e-8


@dataclass(frozen=True)
class Parameter:
    """A number of the arm file by its path, as in `--set`, and its value there."""

    path: str
    value: float

    @property
    def unit(self) -> str:
        """Its unit, as people write it."""
        return next(unit for ending, unit in UNITS.items() if self.path.endswith(ending))

    @property
    def name(self) -> str:
        """What people call it, joints and links counted from 1."""
        return ": ".join(filter(None, self._place_and_noun()))

    @property
    def phrase(self) -> str:
        """The same inside a sentence."""
        place, noun = self._place_and_noun()
        return f"the {noun} of {place}" if place else f"the {noun}"

    def _place_and_noun(self) -> tuple[str, str]:
        *place, field = self.path.split(".")[1:]
        ending = next(ending for ending in UNITS if field.endswith(ending))
        noun = field.removesuffix(ending) + ending.split("_")[0]
        noun = {"payload_mass": "payload", "friction": "viscous_friction"}.get(noun, noun)
        where = f"{place[0].removesuffix('s')} {int(place[1]) + 1}" if place else ""
        return where, noun.replace("_", " ")


@dataclass(frozen=True)
class Estimate:
    """What a record asks a parameter to be, with half its 95 % interval.

    better: by how much chi squared falls; left: what it is then, per degree of freedom. holds:
    other parameters by how much of each is in it, for the record cannot distinguish them.
    """

    parameter: Parameter
    value: float
    half_width: float
    better: float
    left: float
    holds: tuple[tuple[Parameter, float], ...] = ()

    @property
    def is_possible(self) -> bool:
        """Whether its interval holds a number that is not negative, as all of these must be."""
        return self.value + self.half_width >= 0


def find_parameters(arm: Arm) -> list[Parameter]:
    """The parameters that an arm has."""
    return list(_walk(arm.model_dump(), "arm"))


def _walk(data: Any, path: str) -> Iterator[Parameter]:
    if isinstance(data, Mapping):
        for name, value in data.items():
            if isinstance(value, float) and name.endswith(tuple(UNITS)):
                yield Parameter(f"{path}.{name}", value)
            else:
                yield from _walk(value, f"{path}.{name}")
    elif isinstance(data, list | tuple):
        for number, value in enumerate(data):
            yield from _walk(value, f"{path}.{number}")


def increase_parameter(arm: Arm, parameter: Parameter) -> tuple[Arm, float]:
    """The arm with a little more of a parameter, and how much that is."""
    step = STEP * parameter.value or STEP
    return change_parameters(arm, {parameter.path: parameter.value + step}), step


def apply_estimate(arm: Arm, estimate: Estimate) -> Arm | None:
    """The arm with the estimate in place of the file's number; None where no arm can have it."""
    if not estimate.is_possible:
        return None
    try:
        return change_parameters(arm, {estimate.parameter.path: max(estimate.value, 0.0)})
    except InputError:
        return None


def change_parameters(arm: Arm, values: Mapping[str, float]) -> Arm:
    """The arm with other values of its parameters, by path. Raises InputError."""
    data = {"arm": arm.model_dump(mode="json")}
    for path, value in values.items():
        for place in find_paths(data, path, "--tolerance"):
            assign(data, place, value)
    return validate_record(Arm, data["arm"], arm.name)


def estimate_separately(equations: NormalEquations, among: Sequence[Parameter]) -> list[Estimate]:
    """The estimate of each parameter as if it alone were wrong, the one that explains most first.

    What a fit leaves beyond noise, such as what the model lacks, counts as noise for the intervals.
    """
    estimates = []
    for parameter, square, right in zip(
        among, np.diag(equations.matrix), equations.right, strict=True
    ):
        if square > 0:
            better = float(right**2 / square)
            left = equations.left(better)
            half = NORMAL * np.sqrt(max(left, 1.0) / square)
            value = parameter.value + right / square
            estimates.append(Estimate(parameter, float(value), float(half), better, left))
    return sorted(estimates, key=lambda each: -each.better)


def estimate_together(
    equations: NormalEquations, among: Sequence[Parameter]
) -> tuple[list[Estimate], float]:
    """Estimates, all at once, of those parameters that the record distinguishes; condition number.

    By a Cholesky factorisation with pivots of the scaled normal equations: a parameter whose
    column the chosen ones explain is contained in them (Gautier's base parameters).
    """
    size = np.sqrt(np.diag(equations.matrix))
    used = np.flatnonzero(size > 0)
    scaled = equations.matrix[np.ix_(used, used)] / np.outer(size[used], size[used])
    left, chosen = scaled.copy(), []
    while (largest_pivot := np.diag(left).max(initial=0.0)) > LEAST_PIVOT:
        pivot = int(np.argmax(np.diag(left)))
        chosen.append(pivot)
        left = left - np.outer(left[:, pivot], left[pivot]) / largest_pivot
        left[chosen] = left[:, chosen] = 0.0
    base = scaled[np.ix_(chosen, chosen)]
    covariance = np.linalg.inv(base)
    right = equations.right[used][chosen] / size[used][chosen]
    more = covariance @ right
    remains = equations.left(float(right @ more))
    scatter = np.sqrt(max(remains, 1.0))
    mixed = covariance @ scaled[chosen]  # of every column, how much each chosen one holds
    estimates = []
    for place, index in enumerate(chosen):
        parameter, unit = among[used[index]], size[used[index]]
        holds = tuple(
            (among[used[other]], float(mixed[place, other] * size[used[other]] / unit))
            for other in range(used.size)
            if other not in chosen and abs(mixed[place, other]) > np.sqrt(LEAST_PIVOT)
        )
        half = NORMAL * scatter * np.sqrt(covariance[place, place]) / unit
        value = parameter.value + more[place] / unit
        better = float(more[place] ** 2 / covariance[place, place])
        estimates.append(Estimate(parameter, float(value), float(half), better, remains, holds))
    return estimates, float(np.sqrt(np.linalg.cond(base))) if chosen else 1.0
