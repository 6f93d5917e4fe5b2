"""Random arms over all the ranges that the schema states, for promises made about every arm."""

from __future__ import annotations

import math
import random
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from models.arm import Arm, Joint, Link
from models.quantities import Within

TEETH = ("sun_teeth", "planet_teeth", "ring_teeth", "planet_count")
DAMPINGS = ("damping_ratio", "sun_planet_damping_N_s_per_m", "planet_ring_damping_N_s_per_m")


def fresh_seed() -> int:
    """Another one every time, printed so that a failure can be repeated."""
    seed = random.SystemRandom().randrange(2**32)
    print(f"seed {seed}")
    return seed


def range_of(field: FieldInfo) -> Within:
    """What a field may be; of a union's first member."""
    inside = (item for part in get_args(field.annotation) for item in part_metadata(part))
    return next(item for item in (*field.metadata, *inside) if isinstance(item, Within))


def part_metadata(part: Any) -> tuple[Any, ...]:
    """The metadata of an annotated type, else nothing."""
    return getattr(part, "__metadata__", ())


def any_arm(generator: random.Random, joints: int) -> Arm:
    """An arm drawn from the whole of every range, those refused for other reasons left out."""
    while True:
        data = {
            "schema_version": 1,
            "name": "drawn",
            "payload_mass_kg": _number(generator, range_of(Arm.model_fields["payload_mass_kg"])),
            "joints": [_joint(generator) for _ in range(joints)],
            "links": [_numbers(generator, Link) for _ in range(joints)],
        }
        try:
            return Arm.model_validate(data)
        except ValidationError:
            continue


def _joint(generator: random.Random) -> dict[str, Any]:
    left_out = DAMPINGS[:1] if generator.random() < 0.5 else DAMPINGS[1:]
    given = _numbers(generator, Joint, (*TEETH, *left_out))
    return given | dict(zip(TEETH, _teeth(generator), strict=True))


def _teeth(generator: random.Random) -> tuple[int, int, int, int]:
    """A gear set that can be assembled."""
    while True:
        sun, planet, count = generator.randint(5, 400), generator.randint(5, 400), 2
        if generator.random() < 0.8:
            count = generator.randint(3, 8)
        clear = (sun + planet) * math.sin(math.pi / count) > planet + 2
        if clear and (2 * sun + 2 * planet) % count == 0:
            return sun, planet, sun + 2 * planet, count


def _numbers(
    generator: random.Random, record: type[BaseModel], without: tuple[str, ...] = ()
) -> dict[str, Any]:
    return {
        name: _number(generator, range_of(field))
        for name, field in record.model_fields.items()
        if name not in without
    }


def _number(generator: random.Random, allowed: Within) -> float:
    if allowed.or_zero and generator.random() < 0.15:
        return 0.0
    if allowed.least <= 0:
        return generator.uniform(allowed.least, allowed.most)
    exponent = generator.uniform(math.log(allowed.least), math.log(allowed.most))
    return min(max(math.exp(exponent), allowed.least), allowed.most)
