"""Random arms over all the ranges that the schema states, for promises made about every arm.

CROSSCHECK_DRAWS sets how long campaigns of other inputs in every run are: `make fuzz`.
"""

import math
import os
import random
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from crosscheck.models.arm.arm import Arm, Direct, Link, Planetary
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.quantities import NumberRange
from crosscheck.models.arm.stiffness import (
    FourierStiffness,
    SineStiffness,
    SquareStiffness,
    TableStiffness,
)

SAMPLE = 10
DRAWS = int(os.environ.get("CROSSCHECK_DRAWS", SAMPLE))
TEETH = ("sun_teeth", "planet_teeth", "ring_teeth", "planet_count")
GEARS = ("sun", "planet", "carrier")
PER_PLANET = ("backlash_m", "tooth_error_m", "tooth_error_phase_rad", "static_error_m")
MOST_REFUSALS = 2000
Drawn = TypeVar("Drawn", bound=BaseModel)
Make = Callable[[random.Random], dict[str, Any]]


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


def any_arm(generator: random.Random, joints: int) -> Arm:
    """An arm drawn from the whole of every range, those refused for other reasons left out."""
    pull = generator.choice((0.0, 9.81, 1000.0))
    return _drawn(
        Arm,
        generator,
        lambda generator: {
            "schema_version": 2,
            "name": "drawn",
            "payload_mass_kg": _number(generator, range_of(Arm.model_fields["payload_mass_kg"])),
            "gravity_m_per_s2": [generator.uniform(-pull, pull) for _ in range(2)],
            "joints": [_joint(generator) for _ in range(joints)],
            "links": [_drawn(Link, generator, _link) for _ in range(joints)],
        },
    )


def _drawn(record: type[Drawn], generator: random.Random, make: Make) -> Drawn:
    """The first one that is not refused. Raises the last refusal where all are."""
    for _ in range(MOST_REFUSALS):
        with suppress(ValidationError):
            return record.model_validate(make(generator))
    return record.model_validate(make(generator))


def _joint(generator: random.Random) -> Planetary | Direct:
    if generator.random() < 0.25:
        return _drawn(Direct, generator, lambda g: {"kind": "direct", **_numbers(g, Direct)})
    return _drawn(Planetary, generator, _planetary)


def _planetary(generator: random.Random) -> dict[str, Any]:
    forms = ("equivalent_mass_kg", "inertia_kg_m2")
    left_out = [f"{gear}_{generator.choice(forms)}" for gear in GEARS]
    teeth = _teeth(generator)

    def mesh(generator: random.Random) -> dict[str, Any]:
        return _mesh(generator, planets=teeth[-1])

    return {
        "kind": "planetary",
        **_numbers(generator, Planetary, (*TEETH, *left_out)),
        **dict(zip(TEETH, teeth, strict=True)),
        "sun_mesh": _drawn(Mesh, generator, mesh),
        "ring_mesh": _drawn(Mesh, generator, mesh),
    }


def _mesh(generator: random.Random, planets: int) -> dict[str, Any]:
    """Some fields one number, some one for each planet; phases of a list are held to the teeth."""
    left_out = generator.choice(("damping_ratio", "damping_N_s_per_m"))
    found = _numbers(generator, Mesh, (left_out,))
    for name in PER_PLANET:
        if generator.random() < 0.2:
            own = range_of(Mesh.model_fields[name])
            found[name] = [_number(generator, own) for _ in range(planets)]
    law = generator.choice((_sine, _fourier, _square, _table))
    return {"stiffness": law(generator), **found}


def _sine(generator: random.Random) -> SineStiffness:
    return _drawn(SineStiffness, generator, lambda g: {"law": "sine", **_numbers(g, SineStiffness)})


def _fourier(generator: random.Random) -> FourierStiffness:
    mean = _number(generator, ranges_of(FourierStiffness)["mean_N_per_m"])
    waves = [mean * generator.uniform(-0.1, 0.1) for _ in range(generator.randint(0, 8))]
    return FourierStiffness(
        law="fourier",
        mean_N_per_m=mean,
        cosine_N_per_m=tuple(waves[::2]),
        sine_N_per_m=tuple(waves[1::2]),
    )


def _square(generator: random.Random) -> SquareStiffness:
    def make(generator: random.Random) -> dict[str, Any]:
        harmonics = {"harmonics": generator.randint(1, 50)}
        return {"law": "square", **_numbers(generator, SquareStiffness), **harmonics}

    return _drawn(SquareStiffness, generator, make)


def _table(generator: random.Random) -> TableStiffness:
    def make(generator: random.Random) -> dict[str, Any]:
        inner = sorted(generator.random() for _ in range(generator.randint(3, 40)))
        largest = 10 ** generator.uniform(1, 12)
        values = [largest * generator.uniform(0.5, 1) for _ in range(len(inner) + 1)]
        return {
            "law": "table",
            "phase_cycles": [0.0, *inner, 1.0],
            "stiffness_N_per_m": [*values, values[0]],
        }

    return _drawn(TableStiffness, generator, make)


def _link(generator: random.Random) -> dict[str, Any]:
    forms = ("cross_section_m2", "density_kg_per_m3"), ("mass_kg", "inertia_kg_m2")
    return _numbers(generator, Link, generator.choice(forms))


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
        name: _number(generator, allowed)
        for name, allowed in ranges_of(record).items()
        if name not in without
    }


def _number(generator: random.Random, allowed: NumberRange) -> float:
    if allowed.or_zero and generator.random() < 0.15:
        return 0.0
    if allowed.least <= 0:
        return generator.uniform(allowed.least, allowed.most)
    exponent = generator.uniform(math.log(allowed.least), math.log(allowed.most))
    return min(max(math.exp(exponent), allowed.least), allowed.most)
