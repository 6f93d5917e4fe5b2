"""An arm of the same structure with unequal numbers: it shows errors that equal ones hide."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from contextlib import suppress
from types import MappingProxyType
from typing import Any

from pydantic import ValidationError

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.errors import InputError
from crosscheck.trial.changes.arms.arm_numbers import (
    Powers,
    get_number,
    list_number_names,
    nonzero_substitute,
    replace_numbers,
    scale_by_powers,
)

TEETH_PER_PLANET = 20  # teeth of sun and planet together, per planet
WIDEST = 0.65  # share of the planet in these
OF_WIDEST = (0.75, 0.9, 0.55, 0.82, 0.65)  # planets of different joints
DRAWS = 100
MESH_SUBSTITUTES = {"backlash_m": 1e-5, "tooth_error_m": 1e-5}  # for zeros
NONE_KEPT: Mapping[str, Powers] = MappingProxyType({})


def draw_probe_arms(arm: Arm, count: int, kept: Mapping[str, Powers] = NONE_KEPT) -> list[Arm]:
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
        name: scale_by_powers(get_number(arm, name), powers, factor)
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
