"""Every number of an arm or a scenario has a range that the schema states and the errors repeat."""

from collections.abc import Iterator
from contextlib import nullcontext
from typing import Any

import pytest
from pydantic import BaseModel

from crosscheck.models.arm.arm import Arm, Direct, Link, Planetary
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.quantities import NumberRange
from crosscheck.models.arm.stiffness import FourierStiffness, SineStiffness, SquareStiffness
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.loading import load_arm, load_case, load_scenario
from crosscheck.models.pinocchio import arm as pinocchio_arm
from crosscheck.registry import build
from tests.draws import range_of, ranges_of
from tests.loops import require_items
from tests.mixed_arms import arm_of, geared
from tests.tool.test_bad_input import assert_one_line

ARM, SCENARIO = "paper-labelled", "constant-torque"


def leaves(node: Any) -> Iterator[dict[str, Any]]:
    """Every number and text of a JSON schema."""
    if isinstance(node, dict):
        if node.get("type") in ("number", "integer", "string") and "enum" not in node:
            yield node
        for inner in node.values():
            yield from leaves(inner)
    elif isinstance(node, list):
        for inner in node:
            yield from leaves(inner)


@pytest.mark.parametrize("record", [Arm, Scenario])
def test_schema_describes_every_number_and_text(record):
    found = [leaf for leaf in leaves(record.model_json_schema()) if "const" not in leaf]
    assert len(found) > 10
    assert [leaf for leaf in found if not leaf.get("description")] == []


RECORDS: list[tuple[str, str, type[BaseModel]]] = [
    ("three-unlike", "arm.joints.0", Planetary),
    ("three-unlike", "arm.joints.1", Planetary),
    ("three-unlike", "arm.joints.0.sun_mesh", Mesh),
    ("three-unlike", "arm.joints.1.ring_mesh", Mesh),
    ("three-unlike", "arm.joints.0.sun_mesh.stiffness", SineStiffness),
    ("three-unlike", "arm.joints.0.ring_mesh.stiffness", FourierStiffness),
    ("three-unlike", "arm.joints.1.sun_mesh.stiffness", SquareStiffness),
    ("direct-between", "arm.joints.1", Direct),
    ("three-unlike", "arm.links.0", Link),
    ("three-unlike", "arm.links.1", Link),
    ("three-unlike", "arm", Arm),
]


def limits() -> Iterator[tuple[str, str, NumberRange]]:
    """Arm, path and range of every number of an arm, and of a scenario with one drive."""
    for arm, path, record in RECORDS:
        for name, limit in ranges_of(record).items():
            if name not in ("schema_version", "name", "title"):
                yield arm, f"{path}.{name}", limit
    for name in ("duration_s", "step_s", "record_every"):
        yield "three-unlike", f"scenario.{name}", range_of(Scenario.model_fields[name])
    for place in (0, 1):
        yield "three-unlike", f"arm.gravity_m_per_s2.{place}", NumberRange(-1e3, 1e3, "m/s^2")


def _last(path: str) -> str:
    """Of a path, as messages write it."""
    *_, name = path.split(".")
    return f"[{name}]" if name.isdigit() else name


OUTSIDE = ("1e308", "1e155", "-1e308", "nan", "inf", "-inf", "9" * 400)
LIMITS = {f"{arm} {path}": (arm, path, limit) for arm, path, limit in limits()}


@pytest.mark.parametrize("number", LIMITS)
def test_number_outside_its_range_is_refused_at_its_field(number):
    arm, path, limit = LIMITS[number]
    least = [] if limit.or_zero or limit.least <= 0 else ["0", "-0.0"]
    below = [] if limit.least <= 0 else ["5e-324", "1e-308", "-5e-324", repr(0.5 * limit.least)]
    for value in (*OUTSIDE, *least, *below, repr(2 * limit.most), repr(-2 * limit.most)):
        with pytest.raises(InputError) as refused:
            load_case(arm, SCENARIO, {}, [f"{path}={value}"])
        assert refused.value.field.endswith(_last(path))
        if isinstance(refused.value.value, float):
            assert refused.value.allowed == f"must be {limit}"


@pytest.mark.parametrize("scenario", ["pd", "back-and-forth"])
def test_numbers_of_drive_and_start_are_held_to_ranges(scenario):
    given = load_scenario(scenario)
    records = {"drive": given.drive, "start": given.start}
    for section, record in require_items(records.items()):
        numbers = [field for field, value in record if isinstance(value, float)]
        for field in require_items(numbers):
            for bad in ("1e308", "[1e308, 0.0]", "nan", "9" * 300):
                with pytest.raises(InputError, match="must be -") as refused:
                    load_case(ARM, scenario, {}, [f"scenario.{section}.{field}={bad}"])
                assert refused.value.field.startswith(f"{section}.{field}")


@pytest.mark.parametrize(("share", "is_refused"), [(0.98, False), (1.02, True)])
def test_a_planet_has_a_millionth_of_the_suns_inertia(share, is_refused):
    sun = share * 1e6 * load_arm(ARM).joints[1].planet_equivalent_mass_kg
    with pytest.raises(InputError, match="1e-6 of the sun") if is_refused else nullcontext():
        load_case(ARM, SCENARIO, {}, [f"arm.joints.1.sun_equivalent_mass_kg={sun!r}"])


@pytest.mark.parametrize(("place", "share"), [(0, 0.98), (0, 1.02), (1, 0.98), (1, 1.02)])
def test_a_link_is_weighed_against_all_that_its_joint_turns(place, share):
    """Its own gears reflected, the next joint's as they turn, and every mass at its reach."""
    heavy, reach, radius = 2e-2, 0.01, 0.0025 * (30 + 30) / 2
    load = (4 * 0.5 + 4 * 0.7) * radius**2 + 1e-3 * reach**2
    if place == 0:
        load += (0.5 + 6.0 + 4 * 0.7) * radius**2 + 0.01 + 1e-3 * (2 * reach) ** 2
        load += (0.36 + 4 * 0.52 + 5.5 + 8.0) * reach**2
    light = share * 1e-9 * load
    links = [
        {"length_m": reach, "com_m": 0.0, "mass_kg": 1e-3, "inertia_kg_m2": inertia}
        for inertia in ((heavy, light) if place else (light, heavy))
    ]
    masses = {"sun_equivalent_mass_kg": 0.5, "carrier_equivalent_mass_kg": 6.0}
    inertias = {"sun_inertia_kg_m2": None, "carrier_inertia_kg_m2": None}
    joints = [geared(**masses, **inertias, ring_inertia_kg_m2=0.01)] * 2
    if share > 1:
        arm_of(*joints, links=links, payload_kg=0.0)
        return
    with pytest.raises(ValueError, match="must have at least") as refused:
        arm_of(*joints, links=links, payload_kg=0.0)
    assert f"links[{place}]|" in str(refused.value)
    assert f"it has {light:.3g} of {load:.3g} kg m^2 about that joint" in str(refused.value)


def sinusoid(rate: float, argument: str) -> str:
    """A setting of the drive."""
    return (
        f'scenario.drive={{kind = "sinusoid", amplitude_N_m = 1.0, rate_rad_per_s = {rate!r},'
        f' argument = "{argument}"}}'
    )


@pytest.mark.parametrize(
    ("step", "argument", "most"), [("1e-5", "time", 1e5), ("1e-4", "sqrt_time", 100.0)]
)
def test_drive_that_the_steps_cannot_follow_is_refused(step, argument, most):
    settings = [f"scenario.step_s={step}"]
    load_case(ARM, SCENARIO, {}, [*settings, sinusoid(0.99 * most, argument)])
    with pytest.raises(InputError, match="six steps a period") as refused:
        load_case(ARM, SCENARIO, {}, [*settings, sinusoid(-1.01 * most, argument)])
    assert (refused.value.field, refused.value.value) == ("drive.rate_rad_per_s", -1.01 * most)


def test_recording_that_no_memory_holds_is_refused():
    """Of 99,999,971 steps, a prime number, none but every single one can be kept."""
    settings = ["scenario.step_s=1e-8", "scenario.record_every=10"]
    load_case(ARM, SCENARIO, {}, [*settings[:1], "scenario.record_every=100"])
    with pytest.raises(InputError, match="at most 1e6 states"):
        load_case(ARM, SCENARIO, {}, settings)
    with pytest.raises(InputError, match="keeps every 1 of 99999971 steps"):
        load_case(ARM, SCENARIO, {}, [*settings, "scenario.duration_s=0.99999971"])


def test_adaptive_run_without_end_says_how_far_it_came(short, monkeypatch, tmp_path):
    monkeypatch.setattr(pinocchio_arm, "MOST_EVALUATIONS", 100)
    answer = short("--scenario", "pd", model="pinocchio:links")
    assert_one_line(answer, "duration_s = 3.0", "pinocchio:links came to t = ", "100 evaluations")
    assert list(tmp_path.iterdir()) == []


def test_title_may_be_empty_and_has_200_characters():
    for title in ('""', "a" * 200):
        load_case(ARM, SCENARIO, {}, [f"arm.title={title}", f"scenario.title={title}"])
    with pytest.raises(InputError, match="must be 0 to 200 printable"):
        load_case(ARM, SCENARIO, {}, [f"arm.title={'a' * 201}"])


def test_numbers_that_break_the_arithmetic_name_model_and_arm(monkeypatch):
    def broken(*_: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("crosscheck.registry.load_model_class", lambda name: broken)
    with pytest.raises(InputError) as refused:
        build("analytic:physical", load_arm(ARM), load_scenario(SCENARIO))
    assert str(refused.value).startswith("paper-labelled: analytic:physical cannot use")
