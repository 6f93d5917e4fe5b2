"""`crosscheck show`: an arm's values and derived quantities, or a robot with its doubts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from crosscheck.analytic.derivation.gears import damping
from crosscheck.analytic.derivation.stage import equivalent_masses, stage_values
from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.analytic.paper.mesh_frequency import mesh_phases, ring_mesh_rate, sun_mesh_rate
from crosscheck.analytic.paper.stiffness import mean_stiffness, peak_stiffness, stiffness_data
from crosscheck.checks.scales import largest_weights
from crosscheck.mechanisms import supply
from crosscheck.models.arm.arm import Arm, Direct, Link, Planetary, describe_loads, joint_mass
from crosscheck.models.arm.mesh import Mesh, PlanetMesh
from crosscheck.models.arm.planets import find_unlike_fields
from crosscheck.models.arm.quantities import Data
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.models.errors import InputError, make_printable
from crosscheck.models.loading import is_the_papers, load_arm, load_scenario
from crosscheck.models.mechanism import find_section
from crosscheck.models.robot.file import load_robot, load_urdf, read_robot_file
from crosscheck.models.robot.inertias import format_values
from crosscheck.models.robot.robot import Robot
from crosscheck.models.robot.tree import survey_inertias
from crosscheck.planning.sizing import Sizes, compute_sizes, make_pd_scenario, make_step_scenario
from crosscheck.registry import require_usable_numbers
from crosscheck.schema import describe_fields
from crosscheck.trial.input.arm_symbols import SYMBOL_OF_FIELD

MOST_LISTED = 6  # numbers of a list that are shown
OF_THE_FILE = ("schema_version", "name", "title")
RIGID = 1e-3  # share of the fastest eigenvalue below which one is of the rigid arm, or rounding


def show_command(name: str) -> None:
    """Print an arm or a robot. Raises InputError."""
    supply("show", find_section(name))(name)


def show_arm(name: str) -> None:
    """Print an arm, once all of it is worked out. Raises InputError."""
    arm = load_arm(name)
    with require_usable_numbers("show", arm):
        tables = list(_tables(arm))
    print(make_printable(arm.title))
    print(make_printable(f"{arm.name}: {describe_loads(arm)}"))
    print(*map(make_printable, arm.described), "", sep="\n")
    Console().print(*tables, sep="\n")


def show_robot(name: str) -> None:
    """Print every doubtful inertia of a robot's URDF, then the robot and the notes on its files.

    Raises InputError.
    """
    urdf, where = load_urdf(name)
    doubts = survey_inertias(urdf, where)
    for doubt in doubts:
        repair = f"; {doubt.repair}" if doubt.repair else ""
        print(make_printable(f"link {doubt.link}: {doubt.reason}{repair}"))
    robot = load_robot(name)
    print(*map(make_printable, repr(robot).splitlines()), sep="\n")
    for number, joint in enumerate(robot.joints):
        body = robot.bodies[number]
        values = format_values(np.linalg.eigvalsh(body.inertia))
        unit = "N m s/rad" if joint.kind == "revolute" else "N s/m"
        single = any(stage.joint == number and stage.has_free_planets for stage in robot.stages)
        planets = "; planets move by themselves" if single else ""
        friction = f"; friction {joint.friction:g} {unit}" if joint.friction else ""
        follows = ""
        if (law := joint.mimic) is not None:
            follows = f", follows {robot.joints[law.joint].name} times {law.multiplier:g}"
        load = f"moves {body.mass:.4g} kg with all that is fixed to it, of principal inertias"
        moves = f"{load} {values} kg m^2" if body.mass or body.inertia.any() else "massless"
        line = f"{joint.name}: {joint.kind}{follows}, {moves}{friction}{planets}"
        print(make_printable(line))
    shown = [f"link {doubt.link}: {doubt.reason}" for doubt in doubts]
    for note in (*robot.notes, *_list_assumptions(robot, read_robot_file(name))):
        if note not in shown:
            print(make_printable(f"note: {note}"))


def _list_assumptions(robot: Robot, content: Mapping[str, Any]) -> Iterator[str]:
    """Lines on assumptions that no file of a robot states; content: of the robot's own file."""
    if "gravity_m_per_s2" not in content:
        yield "gravity is assumed, along -z of the root link"
    if "tip" not in content:
        yield f"tip {robot.tip} is assumed, the last link with most joints before it"


def _tables(arm: Arm) -> Iterator[Table]:
    """Tables of each joint, its meshes and the link behind it; the arm's; its experiments'."""
    for place, joint in enumerate(arm.joints):
        title = f"joint {place + 1}"
        yield _table(title, _stated_quantities(joint), place + 1)
        if isinstance(joint, Planetary):
            for mesh_title, rows in _mesh_rows(joint):
                yield _table(f"{title}, {mesh_title}", rows, place + 1)
        yield _table(f"{title}, derived", derived_joint(joint), place + 1)
        link = arm.links[place]
        rows = [*_stated_quantities(link), *_derived_link(joint, link)]
        yield _table(f"link {place + 1}", rows, place + 1)
    yield _table("arm", [*_stated_quantities(arm), *derived_arm(arm)])
    if is_the_papers(arm):
        return
    try:
        rows = list(derived_experiments(compute_sizes(arm)))
    except InputError as error:
        rows = [DerivedQuantity("none", error.allowed)]
    yield _table("experiments of its size", rows)


def _stated_quantities(record: Data | PlanetMesh) -> Iterator[DerivedQuantity]:
    """Values of a record's fields, except nested records and those about the file itself."""
    for field in describe_fields(Mesh if isinstance(record, PlanetMesh) else type(record)):
        value = getattr(record, field.name)
        if value is not None and not field.records and field.name not in OF_THE_FILE:
            symbol = SYMBOL_OF_FIELD.get(field.name, "")
            yield DerivedQuantity(field.name, value, field.unit, symbol)


def _derived_link(joint: Planetary | Direct, link: Link) -> Iterator[DerivedQuantity]:
    """Mass and inertia of a rod, which its file does not state."""
    values = stage_values(joint, link)
    if link.mass_kg is None:
        yield DerivedQuantity("mass", float(values.m), "kg", "m")
        name = "inertia about its centre of mass"
        yield DerivedQuantity(name, float(values.I_l), "kg m^2", "I_l")


def _table(
    title: str, rows: Iterator[DerivedQuantity] | list[DerivedQuantity], number: int | None = None
) -> Table:
    """A table of quantities; number: of the joint or link, that its symbols have."""
    listed = list(rows)
    has_symbols = any(quantity.symbol for quantity in listed)
    columns = ("quantity", "value", "unit", *(["symbol"] if has_symbols else []))
    table = Table(*columns, title=title, title_justify="left", box=None)
    for quantity in listed:
        name = quantity.symbol and f"{quantity.symbol}{'' if number is None else number}"
        cells = quantity.name, _format_value(quantity.value), quantity.unit, name
        table.add_row(*cells[: len(columns)])
    return table


def _format_value(value: float | str | tuple[float, ...]) -> str:
    """A value as text; of a long list its first values and their number."""
    if isinstance(value, str):
        return value
    if isinstance(value, tuple):
        listed = ", ".join(f"{entry:.10g}" for entry in value[:MOST_LISTED])
        more = f", ... ({len(value)} values)" if len(value) > MOST_LISTED else ""
        return listed + more
    return f"{value:.10g}"


class DerivedQuantity(NamedTuple):
    """A number, numbers or a word, with its name, its unit and its symbol without an index."""

    name: str
    value: float | str | tuple[float, ...]
    unit: str = ""
    symbol: str = ""


def _mesh_rows(joint: Planetary) -> Iterator[tuple[str, list[DerivedQuantity]]]:
    """Titles and quantities of the meshes: of all planets, or of each where they differ."""
    sun, planet, _ = equivalent_masses(joint)
    count, masses = joint.planet_count, (sun, joint.planet_count * planet)  # that move in a mesh
    alike = next(find_unlike_fields(joint), None) is None
    for n in range(1 if alike else count):
        suffix = "" if alike else f" of planet {n + 1}"
        meshes = (side.planet_mesh(n) for side in (joint.sun_mesh, joint.ring_mesh))
        values = zip(meshes, masses, damping(joint, n), mesh_phases(joint, n), strict=True)
        for side, (mesh, mass, d, phase) in zip(("sun", "ring"), values, strict=True):
            rows = [*_stated_quantities(mesh.stiffness), *_stated_quantities(mesh)]
            pair = "sp" if side == "sun" else "pr"
            rows += _derived_mesh(mesh, pair, count, d, mass)
            if mesh.phase_rad is None:
                rows.append(DerivedQuantity("phase from the teeth", phase, "rad"))
            yield f"{side} mesh{suffix}", rows


def _derived_mesh(
    mesh: PlanetMesh, pair: str, count: int, d: float, mass: float
) -> Iterator[DerivedQuantity]:
    """Stiffness of one planet's contact, and the damping of all [N s/m] in both forms."""
    law, mean = mesh.stiffness, mean_stiffness(mesh.stiffness)
    ratio = d / (2 * math.sqrt(count * mean * mass))
    amplitude = np.array([law.amplitude_N_per_m if isinstance(law, SineStiffness) else 0.0])
    largest = float(peak_stiffness(stiffness_data([law]), np.array([mean]), amplitude)[0])
    yield DerivedQuantity("mean stiffness, per planet", mean, "N/m")
    yield DerivedQuantity("largest stiffness, per planet", largest, "N/m")
    damped = f"d_{pair}, damping of x_{pair}, {count} planets"
    yield DerivedQuantity(damped, d, "N s/m", f"d_{pair}")
    yield DerivedQuantity(f"zeta_{pair}, damping ratio of x_{pair}", ratio)


def derived_joint(joint: Planetary | Direct) -> Iterator[DerivedQuantity]:
    """Quantities of a joint's gears, if it has any, and their part in a rigid arm."""
    if isinstance(joint, Planetary):
        yield from _stage(joint)
        sun, planet, _ = equivalent_masses(joint)
        source, radius = "sun and planets", stage_geometry(joint).r_cp
        reflected = (4 * sun + joint.planet_count * planet) * radius**2
    else:
        source, reflected = "the rotor", joint.rotor_inertia_kg_m2
    yield DerivedQuantity(f"reflected inertia of {source}", reflected, "kg m^2")
    yield DerivedQuantity("mass at the joint's axis", joint_mass(joint), "kg")


def _stage(joint: Planetary) -> Iterator[DerivedQuantity]:
    """Geometry and rates of a stage; inertias as equivalent masses M and as I = M r^2."""
    geometry = stage_geometry(joint)
    yield DerivedQuantity("r_s, base radius of the sun", geometry.r_s, "m", "r_s")
    yield DerivedQuantity("r_p, base radius of a planet", geometry.r_p, "m", "r_p")
    yield DerivedQuantity("r_c, carrier radius", geometry.r_c, "m", "r_c")
    yield DerivedQuantity("r_cp = r_c cos(alpha)", geometry.r_cp, "m", "r_cp")
    yield DerivedQuantity("n, reduction ratio", geometry.n, symbol="n")
    cycles = sun_mesh_rate(joint, geometry)
    yield DerivedQuantity("sun mesh: cycles per turn of the carrier", cycles)
    for rate in ("eq13", "corrected"):
        cycles = ring_mesh_rate(joint, geometry, rate)
        yield DerivedQuantity(f"ring mesh: the same, {rate}", cycles)
    parts = (("s", "the sun"), ("p", "a planet"), ("c", "the carrier"))
    radii = geometry.r_s, geometry.r_p, geometry.r_cp
    masses = equivalent_masses(joint)
    for (index, part), mass, radius in zip(parts, masses, radii, strict=True):
        name = f"M_{index}, equivalent mass of {part}"
        yield DerivedQuantity(name, mass, "kg", f"M_{index}")
        yield DerivedQuantity(f"I_{index}, inertia of {part}", mass * radius**2, "kg m^2")
    given = {"sun": joint.sun_mass_kg, "planet": joint.planet_mass_kg}
    for (part, mass), equivalent_mass in zip(given.items(), masses, strict=False):
        if mass:
            ratio = math.sqrt(equivalent_mass / mass)
            yield DerivedQuantity(f"{part}: radius of gyration over base radius", ratio)


def derived_arm(arm: Arm) -> Iterator[DerivedQuantity]:
    """Masses and weight; modes with all teeth in contact, arm stretched out, not controlled."""
    masses = *(link.mass for link in arm.links), *map(joint_mass, arm.joints), arm.payload_mass_kg
    yield DerivedQuantity("total mass", sum(masses), "kg")
    for number, moment in enumerate(largest_weights(arm), start=1):
        yield DerivedQuantity(f"joint {number}: largest moment of weight", float(moment), "N m")
    model = PhysicalModel(arm, load_scenario("constant-torque"))
    for pole in _mesh_poles(model):
        yield DerivedQuantity("mesh mode", abs(pole) / (2 * math.pi), "Hz")
        yield DerivedQuantity("its damping ratio", -pole.real / abs(pole))
    yield DerivedQuantity("largest stable step of RK4", model.largest_stable_step(), "s")


def _mesh_poles(model: PhysicalModel) -> list[complex]:
    """Eigenvalues [1/s] of the teeth, slowest first: the fastest vibrations, of suns and planets.

    Overdamped modes and swings under gravity are left out.
    """
    poles = model.contact_poles()
    teeth = int((~model.layout.angular).sum())
    fastest = poles[np.argsort(poles.imag)[poles.size - teeth :]]
    vibrating = fastest[fastest.imag > RIGID * np.abs(poles).max()]
    return sorted(map(complex, vibrating), key=abs)


def derived_experiments(sizes: Sizes) -> Iterator[DerivedQuantity]:
    """Quantities of the experiments that a cross-check makes for an arm not the paper's."""
    yield DerivedQuantity("rate of the controller", sizes.rate, "rad/s")
    step_s, motion_s = make_step_scenario(sizes).duration_s, make_pd_scenario(sizes).duration_s
    yield DerivedQuantity("duration of the step of torque", step_s, "s")
    yield DerivedQuantity("duration of the controlled motion", motion_s, "s")
    columns = (
        ("inertia of the rigid arm, stretched out", sizes.inertia, "kg m^2"),
        ("step of torque", sizes.step, "N m"),
        ("proportional gain", sizes.proportional, "N m/rad"),
        ("derivative gain", sizes.derivative, "N m s/rad"),
        ("target", sizes.target, "rad"),
    )
    for place in range(len(sizes.inertia)):
        for name, values, unit in columns:
            yield DerivedQuantity(f"joint {place + 1}: {name}", values[place], unit)
