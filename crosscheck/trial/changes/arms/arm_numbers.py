"""The numbers of an arm's file by name, such as links[0].com_m: read, replaced, or all redrawn.

An arm of the same structure with unequal numbers shows errors that equal ones hide.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cache, partial
from typing import Any

from pydantic import ValidationError

from crosscheck.models.arm.arm import Arm, Link, Planetary
from crosscheck.models.arm.quantities import Data
from crosscheck.models.errors import InputError
from crosscheck.models.robot.planar import build_planar_robot
from crosscheck.models.robot.robot import Robot
from crosscheck.schema import describe_fields
from crosscheck.trial.changes.numbers import Path, RobotNumber, get_value, put_value
from crosscheck.trial.input.arm_symbols import SYMBOL_OF_FIELD

Powers = Mapping[str, int]  # of numbers, by their names
# What a number that is 0 becomes where an arm has to have it: it may be left out of equations.
NONZERO_SUBSTITUTES = {
    "payload_mass_kg": 3.0,
    "motor_mass_kg": 2.0,
    "rotor_inertia_kg_m2": 0.3,
    "ring_inertia_kg_m2": 0.1,
    **{f"{gear}_mass_kg": 1.0 for gear in ("sun", "planet", "carrier", "ring")},
}
COM, INERTIA = 0.3, 0.1  # substitutes for 0: com over length, and inertia over mass x length^2
NEXT_TO_NOTHING = 1e-6  # largest negligible inertia, over mass x com^2
# Fields of a link that scale with one of its numbers, and the powers; rods keep their mass.
LINK_POWERS = {
    "length_m": {"com_m": 1, "inertia_kg_m2": 2, "density_kg_per_m3": -1},
    "mass_kg": {"inertia_kg_m2": 1},
}
# Numbers of one kind, of which one may stand for another that is equal to it.
INTERCHANGEABLE_FIELDS = (
    ("length_m", "com_m"),
    ("mass_kg", "payload_mass_kg", "motor_mass_kg"),
    ("inertia_kg_m2", "rotor_inertia_kg_m2"),
    ("cross_section_m2",),
    ("density_kg_per_m3",),
    ("friction_N_m_s_per_rad",),
)
TEETH_PER_PLANET = 20  # teeth of sun and planet together, per planet
WIDEST = 0.65  # share of the planet in these
OF_WIDEST = (0.75, 0.9, 0.55, 0.82, 0.65)  # planets of different joints
DRAWS = 100
MESH_SUBSTITUTES = {"backlash_m": 1e-5, "tooth_error_m": 1e-5}  # for zeros


def list_number_names(arm: Arm) -> Iterator[str]:
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


def get_number(arm: Arm, name: str) -> float:
    """The number of this name in an arm."""
    return float(get_value(arm, _find_path(name)))


def replace_numbers(arm: Arm, numbers: Mapping[str, float]) -> Arm:
    """The arm with these numbers, by name. Raises pydantic's ValidationError."""
    changed = arm
    for name, value in numbers.items():
        changed = put_value(changed, _find_path(name), value)
    return Arm.model_validate(changed.model_dump()) if numbers else arm


def list_robot_numbers(arm: Arm, *, has_gears: bool) -> Iterator[RobotNumber]:
    """The numbers of an arm by their symbols, each of which makes another robot of the arm.

    A rod has the mass and inertia of its own that it has in equations. Numbers are left out of
    which no arm has three times as much. has_gears: whether the robot has them; else it is links
    and payload alone.
    """
    bodies = tuple(
        Link(length_m=e.length_m, com_m=e.com_m, mass_kg=e.mass, inertia_kg_m2=e.inertia)
        for e in arm.links
    )
    arm = arm.model_copy(update={"links": bodies})

    @cache
    def build_robot(path: Path, value: float) -> Robot:
        return build_planar_robot(put_value(arm, path, value), has_gears=has_gears)

    for name in list_number_names(arm):
        path, value = _find_path(name), get_number(arm, name)
        record: Data = arm if len(path) < 3 else get_value(arm, path[:2])
        field = next(each for each in describe_fields(type(record)) if each.name in path)
        size, symbol = abs(value) or nonzero_substitute(arm, name), _find_symbol(path)
        if size and symbol and not field.name.startswith("friction"):  # which force alone has
            put = partial(build_robot, path)
            with suppress(InputError):
                put(value + 2 * size)
                yield RobotNumber(name, symbol, field.unit, value, size, put)


def _find_symbol(path: Path) -> str:
    """The symbol of the number at a path; '' where it has none."""
    if path[0] == "gravity_m_per_s2":
        return ("g_x", "g_y")[int(path[1])]
    symbol = SYMBOL_OF_FIELD.get(str(path[-1]), "")
    return f"{symbol}{int(path[1]) + 1}" if symbol and len(path) > 2 else symbol


def nonzero_substitute(arm: Arm, name: str) -> float:
    """Nonzero value to try for a number that is 0, scaled by the link's length and mass."""
    record_name, _, field = name.rpartition(".")
    if record_name.startswith("links"):
        length = get_number(arm, f"{record_name}.length_m")
        mass = 1.0 if field == "com_m" else get_number(arm, f"{record_name}.mass_kg") * length
        return (COM if field == "com_m" else INERTIA) * mass * length
    return NONZERO_SUBSTITUTES.get(field, 0.0)


def find_negligible_inertias(arm: Arm, names: Iterable[str]) -> tuple[str, ...]:
    """Those of these numbers that are a link's inertia about its centre, and next to nothing.

    A link whose radius of gyration is below a thousandth of its lever is a point mass that a file
    could not, or did not, write as one.
    """
    inertia_names = []
    for name in names:
        record_name, _, field = name.rpartition(".")
        if record_name.startswith("links") and field == "inertia_kg_m2":
            mass, com = (get_number(arm, f"{record_name}.{each}") for each in ("mass_kg", "com_m"))
            if 0 < get_number(arm, name) <= NEXT_TO_NOTHING * mass * com**2:
                inertia_names.append(name)
    return tuple(inertia_names)


def find_natural_powers(arm: Arm, driver: str) -> dict[str, int]:
    """Numbers that people write in terms of another, and its power in them.

    Of a link the centre of mass goes with its length, the inertia with mass and length squared; of
    an equal number of the same kind, what goes with that one too.
    """
    field = driver.rpartition(".")[2]
    kind = next((kind for kind in INTERCHANGEABLE_FIELDS if field in kind), ())
    names, value = list(list_number_names(arm)), get_number(arm, driver)
    same_kind = [name for name in names if name.rpartition(".")[2] in kind]
    alike = [name for name in same_kind if get_number(arm, name) == value]
    powers = {name: 1 for name in alike if name != driver}
    for name in alike:
        record_name, _, field = name.rpartition(".")
        for dependent, power in LINK_POWERS.get(field, {}).items():
            if (dependent_name := f"{record_name}.{dependent}") in names:
                powers.setdefault(dependent_name, power)
    powers.pop(driver, None)
    return powers


def _find_path(name: str) -> Path:
    """The path of a number: field names, and places in lists."""
    return tuple(int(key) if key.isdigit() else key for key in re.findall(r"\w+", name))


def draw_probe_arms(arm: Arm, count: int, kept: Mapping[str, Powers]) -> list[Arm]:
    """`count` arms of an arm's structure: kinds of joints, planets, stiffness laws, descriptions.

    Seeded, so the same every time. A mass, inertia or error that is 0 in the arm is not in them;
    weight and friction are as absent as they were.

    Args:
        arm: The arm whose numbers are changed.
        count: How many arms.
        kept: Numbers that are not drawn, by their names. Each stays as it is, or changes with the
            powers of other numbers' factors.

    Raises:
        InputError: No such arm can be made.
    """
    probes = []
    for number in range(1, count + 1):
        for draw in range(DRAWS):
            generator = random.Random(1000 * number + draw)
            with suppress(ValidationError):
                probe = _draw_arm(arm, generator, number)
                probes.append(replace_numbers(probe, _kept_values(arm, probe, kept)))
                break
        else:
            reason = "no arm of its structure with other numbers can be made"
            raise InputError(arm.name, "", None, reason)
    return probes


def _kept_values(arm: Arm, probe: Arm, kept: Mapping[str, Powers]) -> dict[str, float]:
    """The values that kept numbers of the arm have on a probe."""

    def factor(name: str) -> float:
        return get_number(probe, name) / get_number(arm, name)

    return {
        name: get_number(arm, name) * math.prod(factor(n) ** power for n, power in powers.items())
        for name, powers in kept.items()
    }


def _draw_arm(arm: Arm, generator: random.Random, number: int) -> Arm:
    """An arm with other numbers, whose zeros become what is given for them."""
    numbers = {
        name: _perturb_number(get_number(arm, name) or nonzero_substitute(arm, name), generator)
        for name in list_number_names(arm)
    }
    drawn = replace_numbers(arm, numbers)
    joints = [
        _draw_gears(joint, generator, number + place)
        if isinstance(joint, Planetary)
        else joint.model_dump()
        for place, joint in enumerate(drawn.joints)
    ]
    name = f"probe {number} of {arm.name}"[:80]
    return Arm.model_validate({**drawn.model_dump(), "name": name, "joints": joints})


def _perturb_number(value: float, generator: random.Random) -> float:
    return value * generator.uniform(0.7, 1.4)


def _draw_gears(joint: Planetary, generator: random.Random, place: int) -> dict[str, Any]:
    """The fields of a joint with other gears and meshes; place: so that joints differ."""
    fields: dict[str, Any] = joint.model_dump()
    sun, planet = _gear_set(joint, OF_WIDEST[place % len(OF_WIDEST)])
    fields |= {"sun_teeth": sun, "planet_teeth": planet, "ring_teeth": sun + 2 * planet}
    for mesh in (fields["sun_mesh"], fields["ring_mesh"]):  # law and lists stay
        for field, value in mesh.items():
            if isinstance(value, float):
                mesh[field] = _perturb_number(value or MESH_SUBSTITUTES.get(field, 0.0), generator)
    return {**fields, "pressure_angle_deg": generator.uniform(18, 25)}


def _gear_set(joint: Planetary, of_widest: float) -> tuple[int, int]:
    """Teeth of sun and planet for the joint's planets.

    Their sum is a multiple of the planets, so that these can be assembled at equal distances, and
    tips stay apart by a tooth. The sun's teeth leave the same remainder as the joint's, so that
    planets mesh in the same order and phases that are given stay right.
    """
    planets = joint.planet_count
    together = TEETH_PER_PLANET * planets
    widest = min(WIDEST * together, together * math.sin(math.pi / planets) - 3)
    planet = int(of_widest * widest)
    planet -= (planet + joint.sun_teeth) % planets
    return together - planet, planet
