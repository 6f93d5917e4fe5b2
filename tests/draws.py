"""Random arms over all the ranges that the schema states, for promises made about every arm.

CROSSCHECK_DRAWS sets how long campaigns of other inputs in every run are: `make fuzz`.
"""

import math
import os
import random
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.quantities import NumberRange
from tests import arms

SAMPLE = 10
DRAWS = int(os.environ.get("CROSSCHECK_DRAWS", SAMPLE))
TEETH = ("sun_teeth", "planet_teeth", "ring_teeth", "planet_count")
MOST_REFUSALS = 2000
Drawn = TypeVar("Drawn", bound=BaseModel)


def examples(few: int, many: int) -> int:
    """How many examples of a property are looked at: few in the suite, many in a campaign."""
    return many if "CROSSCHECK_DRAWS" in os.environ else few


def fresh_seed() -> int:
    """Of a campaign another one every time, printed so that it can be repeated; else the same."""
    seed = random.SystemRandom().randrange(2**32) if "CROSSCHECK_DRAWS" in os.environ else 0
    print(f"seed {seed}")
    return seed


def range_of(field: FieldInfo) -> NumberRange:
    """What a field may be; of a union's first member that has a range."""
    found = (*field.metadata, *_all_metadata(field.annotation))
    return next(item for item in found if isinstance(item, NumberRange))


def _all_metadata(kind: Any) -> Iterator[Any]:
    """The metadata of a type and, of a union, of each member, however deep they stand."""
    yield from getattr(kind, "__metadata__", ())
    for part in get_args(kind):
        yield from _all_metadata(part)


def ranges_of(record: type[BaseModel]) -> dict[str, NumberRange]:
    """The ranges of a record's single numbers, by field."""
    found = {}
    for name, field in record.model_fields.items():
        if get_origin(field.annotation) is not tuple:
            with suppress(StopIteration):
                found[name] = range_of(field)
    return found


def any_arm(generator: random.Random, joints: int, decades: float | None = None) -> Arm:
    """An arm drawn from the whole of every range, those refused for other reasons left out.

    decades: or from so many about a usual arm's numbers, as far as their ranges go.
    """
    dice = arms.Dice(generator.uniform, generator.randint)
    kinds = [arms.direct_joint if dice.chance(0.25) else _planetary for _ in range(joints)]
    return _spread(arms.any_arm(dice, "drawn", kinds), generator, decades)


def _planetary(dice: arms.Dice) -> Planetary:
    """Of teeth as few and as many as there may be; some with unlike planets."""
    content, gears = arms.planetary_joint(dice).model_dump(), arms.any_gears(dice, 5, 400, 8)
    teeth = gears.sun, gears.planet, gears.sun + 2 * gears.planet, gears.planets
    content |= dict(zip(TEETH, teeth, strict=True))
    if dice.chance(0.2):
        arms.part_planets(dice, content)
    return Planetary.model_validate(content)


def _spread(record: Drawn, generator: random.Random, decades: float | None) -> Drawn:
    """The record with other numbers, in the records that it holds too, until it is not refused."""
    ranges = ranges_of(type(record))

    def spread(name: str, value: Any, stiffer: float) -> Any:
        if isinstance(value, BaseModel):
            return _spread(value, generator, decades)
        if isinstance(value, tuple) and name != "phase_rad":
            return tuple(spread(name, each, stiffer) for each in value)
        if name.endswith("_N_per_m"):
            return stiffer * value
        if isinstance(value, float) and name in ranges:
            return _number(generator, ranges[name], value, decades)
        return value

    for _ in range(MOST_REFUSALS):
        stiffer = 10 ** (
            generator.uniform(-7, 4) if decades is None else _shift(generator, decades)
        )
        own = {name: spread(name, value, stiffer) for name, value in record}
        with suppress(ValidationError):
            return type(record).model_validate(own)
    return type(record).model_validate(own)


def _shift(generator: random.Random, decades: float) -> float:
    return generator.uniform(-decades, decades) / 2


def _number(
    generator: random.Random, allowed: NumberRange, value: float, decades: float | None
) -> float:
    if decades is not None:
        sized = value * 10 ** _shift(generator, decades)
    elif allowed.or_zero and generator.random() < 0.15:
        return 0.0
    elif allowed.least <= 0:
        return generator.uniform(allowed.least, allowed.most)
    else:
        sized = math.exp(generator.uniform(math.log(allowed.least), math.log(allowed.most)))
    return min(max(sized, allowed.least), allowed.most) if sized else 0.0
