"""Whatever arm the schema lets through is planned, or refused in one line: never an internal error.

Each number alone at the least and the greatest that its range has, and arms of one to seven joints
whose every number is drawn.
"""

import math
import random
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

from crosscheck.models.arm.arm import Arm, Direct, Link, Planetary
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_arm, validate_record
from crosscheck.planning.arms import plan_comparisons
from crosscheck.planning.plan import CrossCheckRequest, draft_experiments, set_stable_step
from crosscheck.planning.preparation import Preparation
from crosscheck.planning.sizing import compute_sizes
from crosscheck.registry import build, reference_model
from tests.arms import arm_of
from tests.draws import DRAWS, SAMPLE, fresh_seed, ranges_of

DRAWN = 20 if DRAWS == SAMPLE else DRAWS
SPREAD = 6.0  # decades about a number of an arm of a metre, within its range
NOT_NUMBERS = ("schema_version", "name", "title", "sun_teeth", "planet_teeth", "ring_teeth")
RECORDS: list[tuple[tuple[Any, ...], type[BaseModel]]] = [
    ((), Arm),
    (("links", 0), Link),
    (("joints", 0), Planetary),
    (("joints", 1), Direct),
    (("joints", 0, "sun_mesh"), Mesh),
    (("joints", 0, "sun_mesh", "stiffness"), SineStiffness),
]


def content() -> dict[str, Any]:
    """Of an arm with a joint of each kind, that has every number of one form."""
    arm = arm_of(2, direct=(1,))
    return arm.model_dump(exclude_none=True)


def at(data: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        data = data[key]
    return data


def ends() -> Iterator[tuple[tuple[Any, ...], float]]:
    """Path and value of every number at both ends of its range."""
    present = content()
    for path, record in RECORDS:
        for name, allowed in ranges_of(record).items():
            if name in NOT_NUMBERS or name not in at(present, path):
                continue
            yield from (((*path, name), value) for value in (allowed.least, allowed.most))


def drawn(generator: random.Random) -> dict[str, Any]:
    """An arm of unlike joints whose numbers are any in their ranges, within some decades."""
    joints = generator.randint(1, 7)
    direct = [number for number in range(joints) if generator.random() < 0.3]
    data = arm_of(joints, direct=direct).model_dump(exclude_none=True)
    decades = generator.choice((0.5, 2.0, SPREAD))
    for kind, places in ((Link, data["links"]), (None, data["joints"])):
        for place in places:
            record = kind or (Planetary if place["kind"] == "planetary" else Direct)
            _spread(place, record, generator, decades)
    _spread(data, Arm, generator, decades)
    return data


def _spread(
    place: dict[str, Any], record: type[BaseModel], generator: random.Random, decades: float
) -> None:
    for name, allowed in ranges_of(record).items():
        value = place.get(name)
        if name in NOT_NUMBERS or not isinstance(value, float) or value <= 0:
            continue
        exponent = math.log10(value) + generator.uniform(-decades, decades) / 2
        place[name] = float(np.clip(10**exponent, allowed.least, allowed.most))


def plan(data: dict[str, Any]) -> bool:
    """Whether an arm's cross-check is planned, as far as no run is needed; else it is refused."""
    try:
        arm = validate_record(Arm, data, "arm")
    except InputError:
        return False
    wanted = CrossCheckRequest(arm, quick=True)
    try:
        sizes = compute_sizes(arm)
        outline = draft_experiments(wanted, sizes)
        model = build(reference_model(), arm, outline[0].case.scenario, usual_switches(arm))
        limit = model.largest_stable_step()
        chosen = Preparation([set_stable_step(each, limit) for each in outline], limit, ())
        assert all(Scenario.model_validate(e.case.scenario.model_dump()) for e in outline)
        plan_comparisons(wanted, chosen)
    except InputError:
        return False
    return True


@pytest.mark.parametrize(("path", "value"), [*ends()], ids=lambda of: str(of))
def test_a_number_at_the_end_of_its_range_is_planned_or_refused(path, value):
    data = content()
    data = _mutable(data)
    at(data, path[:-1])[path[-1]] = value
    plan(data)


def _mutable(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _mutable(value) for key, value in data.items()}
    return [_mutable(each) for each in data] if isinstance(data, list | tuple) else data


def test_an_arm_of_a_kilometre_is_planned():
    """A torque beyond the range of a scenario would lift it."""
    data = _mutable(load_arm("paper-labelled").model_dump())
    data["links"][0]["length_m"] = 1000.0
    assert plan(data)


@pytest.mark.campaign
def test_drawn_arms_are_planned_or_refused():
    seed = fresh_seed()
    generator = random.Random(seed)
    found = [plan(_mutable(drawn(generator))) for _ in range(DRAWN)]
    assert any(found), seed
