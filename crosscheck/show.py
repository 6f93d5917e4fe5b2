"""`crosscheck show`: an arm's values and what follows from them."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from rich.console import Console
from rich.table import Table

from analytic.gears import damping
from analytic.kinematics import stage_geometry
from analytic.mesh_frequency import ring_mesh_rate, sun_mesh_rate
from analytic.model import PhysicalModel
from analytic.stability import contact_eigenvalues
from crosscheck.registry import usable_numbers
from models.arm import Arm, Joint, Link
from models.loading import load_arm, load_scenario

Row = tuple[str, float, str]
UNIT_SUFFIXES = (
    ("_N_s_per_m", "N s/m"),
    ("_N_per_m", "N/m"),
    ("_kg_per_m3", "kg/m^3"),
    ("_kg_m2", "kg m^2"),
    ("_per_m", "1/m"),
    ("_deg", "deg"),
    ("_rad", "rad"),
    ("_kg", "kg"),
    ("_m2", "m^2"),
    ("_m", "m"),
)


def show_command(name: str) -> None:
    """Print an arm, once all of it is worked out. Raises InputError."""
    arm = load_arm(name)
    with usable_numbers("show", arm):
        tables = list(_tables(arm))
    print(f"{arm.name}: {arm.title}")
    Console().print(*tables, sep="\n")


def _tables(arm: Arm) -> Iterator[Table]:
    for number, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), start=1):
        yield _table(f"joint {number}", _given(joint))
        yield _table(f"joint {number}, derived", _derived_joint(joint))
        yield _table(f"link {number}", [*_given(link), *_derived_link(link)])
    yield _table("arm", _derived_arm(arm))


def _table(title: str, rows: list[Row] | Iterator[Row]) -> Table:
    table = Table("quantity", "value", "unit", title=title, title_justify="left", box=None)
    for quantity, value, unit in rows:
        table.add_row(quantity, f"{value:.10g}", unit)
    return table


def _given(record: Joint | Link) -> Iterator[Row]:
    for field, value in record:
        if value is not None:
            unit = next((u for suffix, u in UNIT_SUFFIXES if field.endswith(suffix)), "")
            yield field, value, unit


def _derived_joint(joint: Joint) -> Iterator[Row]:
    geometry = stage_geometry(joint)
    yield "r_s, base radius of the sun", geometry.r_s, "m"
    yield "r_p, base radius of a planet", geometry.r_p, "m"
    yield "r_c, carrier radius", geometry.r_c, "m"
    yield "r_cp = r_c cos(alpha)", geometry.r_cp, "m"
    yield "n, reduction ratio", geometry.n, ""
    yield "I_s, inertia of the sun", joint.sun_equivalent_mass_kg * geometry.r_s**2, "kg m^2"
    yield "I_p, inertia of a planet", joint.planet_equivalent_mass_kg * geometry.r_p**2, "kg m^2"
    yield (
        "I_c, inertia of the carrier",
        joint.carrier_equivalent_mass_kg * geometry.r_cp**2,
        "kg m^2",
    )
    yield "reflected inertia of sun and planets", _reflected(joint, geometry.r_cp), "kg m^2"
    if joint.sun_mass_kg:
        gyration = math.sqrt(joint.sun_equivalent_mass_kg / joint.sun_mass_kg)
        yield "sun: radius of gyration over base radius", gyration, ""
    yield "sun mesh: cycles per turn of the carrier", sun_mesh_rate(joint, geometry), ""
    for rate in ("eq13", "corrected"):
        yield f"ring mesh: the same, {rate}", ring_mesh_rate(joint, geometry, rate), ""
    d_sp, d_pr = damping(joint)
    yield "d_sp, damping of x_sp, all planets", d_sp, "N s/m"
    yield "d_pr, damping of x_pr, all planets", d_pr, "N s/m"


def _reflected(joint: Joint, r_cp: float) -> float:
    planets = joint.planet_count * joint.planet_equivalent_mass_kg
    return (4 * joint.sun_equivalent_mass_kg + planets) * r_cp**2


def _derived_link(link: Link) -> Iterator[Row]:
    mass = link.density_kg_per_m3 * link.cross_section_m2 * link.length_m
    yield "mass", mass, "kg"
    yield "inertia about its centre, slender rod", mass * link.length_m**2 / 12, "kg m^2"


def _derived_arm(arm: Arm) -> Iterator[Row]:
    """Modes with every tooth in contact, arm stretched out, under no control."""
    yield "payload_mass_kg", arm.payload_mass_kg, "kg"
    model = PhysicalModel(arm, load_scenario("constant-torque"))
    pose = np.zeros(len(model.coordinates))
    poles = contact_eigenvalues(model.terms, model.gears, model.drive, pose, model.gears.k_m)
    for pole in sorted(poles[poles.imag > 1], key=abs):
        yield "mesh mode", abs(pole) / (2 * math.pi), "Hz"
        yield "its damping ratio", -pole.real / abs(pole), ""
    yield "largest stable step of RK4", model.largest_stable_step(), "s"
