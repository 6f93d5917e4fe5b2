"""The numbers of an arm's file by name, such as links[0].com_m, read and replaced one by one."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from crosscheck.models.arm.arm import Arm

Powers = Mapping[str, int]  # of numbers, by their names
# What a number that is 0 becomes where an arm has to have it: it may be left out of equations.
INSTEAD_OF_0 = {
    "payload_mass_kg": 3.0,
    "motor_mass_kg": 2.0,
    "rotor_inertia_kg_m2": 0.3,
    "ring_inertia_kg_m2": 0.1,
    **{f"{gear}_mass_kg": 1.0 for gear in ("sun", "planet", "carrier", "ring")},
}
COM, INERTIA = 0.3, 0.1  # of a link's length, and of its mass times that squared: instead of 0
NEXT_TO_NOTHING = 1e-6  # of mass x com^2
# Numbers of one kind, of which one may stand for another that is equal to it.
KINDS = (
    ("length_m", "com_m"),
    ("mass_kg", "payload_mass_kg", "motor_mass_kg"),
    ("inertia_kg_m2", "rotor_inertia_kg_m2"),
    ("cross_section_m2",),
    ("density_kg_per_m3",),
    ("friction_N_m_s_per_rad",),
)


def names_of_numbers(arm: Arm) -> Iterator[str]:
    """Names of the numbers that equations of an arm may follow, those of meshes left out.

    Weight and friction that are 0 are absent; every other 0 might be a number.
    """
    yield from (f"gravity_m_per_s2[{axis}]" for axis in (0, 1) if arm.gravity_m_per_s2[axis])
    yield "payload_mass_kg"
    for group in ("joints", "links"):
        for place, record in enumerate(getattr(arm, group)):
            for field, value in record.model_dump().items():
                absent = field == "friction_N_m_s_per_rad" and not value
                if isinstance(value, float) and not absent:
                    yield f"{group}[{place}].{field}"


def number_at(arm: Arm, name: str) -> float:
    """The number of this name in an arm."""
    found: Any = arm
    for step in _steps(name):
        found = found[step] if isinstance(step, int) else getattr(found, step)
    return float(found)


def with_numbers(arm: Arm, numbers: Mapping[str, float]) -> Arm:
    """The arm with these numbers, by name. Raises pydantic's ValidationError."""
    if not numbers:
        return arm
    content = arm.model_dump()
    content["gravity_m_per_s2"] = list(arm.gravity_m_per_s2)
    for name, value in numbers.items():
        *way, last = _steps(name)
        place: Any = content
        for step in way:
            place = place[step]
        place[last] = value
    return Arm.model_validate(content)


def scaled_by(value: float, powers: Powers, factor: Callable[[str], float]) -> float:
    """A number times the powers of other numbers' factors."""
    for name, power in powers.items():
        value *= factor(name) ** power
    return value


def instead_of_0(arm: Arm, name: str) -> float:
    """What a number that is 0 may be: of a link in proportion to its length and mass."""
    own, _, field = name.rpartition(".")
    if own.startswith("links"):
        length = number_at(arm, f"{own}.length_m")
        mass = 1.0 if field == "com_m" else number_at(arm, f"{own}.mass_kg") * length
        return (COM if field == "com_m" else INERTIA) * mass * length
    return INSTEAD_OF_0.get(field, 0.0)


def negligible_inertias(arm: Arm, names: Iterable[str]) -> tuple[str, ...]:
    """Those of these numbers that are a link's inertia about its centre, and next to nothing.

    A link whose radius of gyration is below a thousandth of its lever is a point mass that a file
    could not, or did not, write as one.
    """
    found = []
    for name in names:
        own, _, field = name.rpartition(".")
        if own.startswith("links") and field == "inertia_kg_m2":
            about_joint = number_at(arm, f"{own}.mass_kg") * number_at(arm, f"{own}.com_m") ** 2
            if 0 < number_at(arm, name) <= NEXT_TO_NOTHING * about_joint:
                found.append(name)
    return tuple(found)


def natural_powers(arm: Arm, driver: str) -> dict[str, int]:
    """Numbers that people write in terms of another, and its power in them.

    Of a link the centre of mass goes with its length, the inertia with mass and length squared; of
    an equal number of the same kind, what goes with that one too.
    """
    field = driver.rpartition(".")[2]
    kind = next((kind for kind in KINDS if field in kind), ())
    value = number_at(arm, driver)
    alike = [
        name
        for name in names_of_numbers(arm)
        if name.rpartition(".")[2] in kind and number_at(arm, name) == value
    ]
    found = {name: 1 for name in alike if name != driver}
    for name in alike:
        own, _, field = name.rpartition(".")
        for dependent, power in _of_link(field).items():
            if own.startswith("links") and f"{own}.{dependent}" in set(names_of_numbers(arm)):
                found.setdefault(f"{own}.{dependent}", power)
    found.pop(driver, None)
    return found


def _of_link(field: str) -> dict[str, int]:
    """What of a link goes with a number of it, and its power; a rod's density keeps its mass."""
    if field == "length_m":
        return {"com_m": 1, "inertia_kg_m2": 2, "density_kg_per_m3": -1}
    return {"inertia_kg_m2": 1} if field == "mass_kg" else {}


def _steps(name: str) -> list[str | int]:
    """The way to a number: field names, and places in lists."""
    return [int(step) if step.isdigit() else step for step in re.findall(r"\w+", name)]
