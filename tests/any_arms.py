"""Random arms of a machine's usual sizes: every kind of joint, mesh, stiffness law and link."""

import math
from collections.abc import Sequence
from typing import Any

from hypothesis import strategies as st

from crosscheck.models.arm.arm import Arm

# Sun and planet teeth, and a number of planets that assembles and clears.
GEAR_SETS = [
    (sun, planet, count)
    for sun in range(15, 46)
    for planet in range(15, 46)
    for count in range(2, 7)
    if (2 * sun + 2 * planet) % count == 0
    and (sun + planet) * math.sin(math.pi / count) > planet + 2
]
LAWS = ("sine", "fourier", "square", "table")
PAPERS_MODULE_M = 0.003


def around(value: float, factor: float = 3.0) -> st.SearchStrategy[float]:
    """Numbers up to a factor away from a value, evenly in their logarithm."""
    return st.floats(-1, 1).map(lambda power: value * factor**power)


@st.composite
def any_arms(draw: st.DrawFn, joints: int, unlike: bool = False) -> Arm:
    """Valid arms of so many joints, with weight or in free fall, some without any gears.

    unlike: planets of one stage may differ from each other.
    """
    geared = draw(st.lists(st.booleans(), min_size=joints, max_size=joints))
    across, along = draw(st.tuples(*[st.floats(-10, 10)] * 2))
    weight = {"gravity_m_per_s2": [across, along]} if draw(st.booleans()) else {}
    return Arm.model_validate(
        {
            "schema_version": 2,
            "name": f"any-{joints}",
            "payload_mass_kg": draw(st.just(0.0) | around(5.0)),
            "joints": [draw(planetary_joints(unlike) if g else direct_joints()) for g in geared],
            "links": [draw(rods() if draw(st.booleans()) else bodies()) for _ in geared],
            **weight,
        }
    )


@st.composite
def planetary_joints(
    draw: st.DrawFn,
    unlike: bool = False,
    sets: Sequence[tuple[int, int, int]] = GEAR_SETS,
    listed: bool = False,
) -> dict[str, Any]:
    """A geared joint's fields: inertias as masses or as they are, two meshes unlike each other.

    unlike: planets may differ; listed: in every field of their meshes.
    """
    sun, planet, count = draw(st.sampled_from(sets))
    module = 1e-3 * 0.5 * 10 ** draw(st.floats(0, 1))
    area = (module / PAPERS_MODULE_M) ** 2
    cosine = math.cos(math.radians(angle := draw(st.floats(14.5, 28.0))))
    radii = {"sun": sun, "planet": planet, "carrier": sun + planet}
    sizes = {"sun": 0.5, "planet": 0.7, "carrier": 5.5}
    joint: dict[str, Any] = {
        "kind": "planetary",
        "sun_teeth": sun,
        "planet_teeth": planet,
        "ring_teeth": sun + 2 * planet,
        "planet_count": count,
        "module_m": module,
        "pressure_angle_deg": angle,
        "ring_mass_kg": draw(around(9.5 * area)),
        "ring_inertia_kg_m2": draw(st.just(0.0) | around(0.18 * area**2)),
        "friction_N_m_s_per_rad": draw(frictions()),
        "sun_mesh": draw(meshes_unlike(sun, count, listed) if unlike else meshes()),
        "ring_mesh": draw(meshes_unlike(sun, count, listed) if unlike else meshes()),
    }
    for part, teeth in radii.items():
        mass = draw(around(sizes[part] * area))
        joint[f"{part}_mass_kg"] = draw(around(mass, 2.0))
        if draw(st.booleans()):
            joint[f"{part}_equivalent_mass_kg"] = mass
        else:
            joint[f"{part}_inertia_kg_m2"] = mass * (module * teeth / 2 * cosine) ** 2
    return joint


def direct_joints() -> st.SearchStrategy[dict[str, Any]]:
    """A direct joint's fields."""
    return st.fixed_dictionaries(
        {
            "kind": st.just("direct"),
            "motor_mass_kg": st.just(0.0) | around(4.0),
            "rotor_inertia_kg_m2": st.just(0.0) | around(0.02),
            "friction_N_m_s_per_rad": frictions(),
        }
    )


@st.composite
def meshes(draw: st.DrawFn) -> dict[str, Any]:
    """A mesh's fields, alike for all planets, its damping either way."""
    name, damping = draw(dampings())
    return {
        "stiffness": draw(stiffness_laws()),
        "backlash_m": draw(plays()),
        "tooth_error_m": draw(errors()),
        "phase_rad": draw(st.floats(-3, 3)),
        name: draw(damping),
    }


@st.composite
def meshes_unlike(
    draw: st.DrawFn, sun_teeth: int, planets: int, listed: bool = False
) -> dict[str, Any]:
    """A mesh's fields, each one value or a list of one per planet, phases as the teeth allow.

    listed: none is one value.
    """
    name, damping = draw(dampings())
    fields = {
        "stiffness": stiffness_laws(),
        "backlash_m": plays(),
        "tooth_error_m": errors(),
        "tooth_error_phase_rad": st.just(0.0) | st.floats(-3, 3),
        "static_error_m": st.just(0.0) | st.floats(-5e-6, 5e-6),
        name: damping,
    }
    own = {}
    for field, one in fields.items():
        each = st.lists(one, min_size=planets, max_size=planets)
        own[field] = draw(each if listed else one | each)
    return own | {"phase_rad": draw(phases(sun_teeth, planets))}


def phases(sun_teeth: int, planets: int) -> st.SearchStrategy[Any]:
    """From the teeth, one number for all, or the numbers that the teeth allow."""
    turns = [-2 * math.pi * (sun_teeth * place % planets) / planets for place in range(planets)]
    listed = st.floats(-3, 3).map(lambda first: [first + turn for turn in turns])
    return st.just("from-teeth") | st.floats(-3, 3) | listed


def plays() -> st.SearchStrategy[float]:
    """Half the clearance of a mesh, or none."""
    return st.just(0.0) | around(5e-5)


def errors() -> st.SearchStrategy[float]:
    """Of a tooth's profile, or none."""
    return st.just(0.0) | around(5e-6)


def dampings() -> st.SearchStrategy[tuple[str, st.SearchStrategy[float]]]:
    """A field that damps, and its values."""
    ratio = ("damping_ratio", around(0.05))
    return st.sampled_from([ratio, ("damping_N_s_per_m", st.just(0.0) | around(1000.0))])


@st.composite
def stiffness_laws(draw: st.DrawFn) -> dict[str, Any]:
    """One of the four laws about a mean of 1e6 to 5e8 N/m, never below a fifth of it."""
    mean, law = 1e6 * 500 ** draw(st.floats(0, 1)), draw(st.sampled_from(LAWS))
    parts = st.lists(st.floats(-0.1, 0.1), max_size=4).map(lambda p: [mean * part for part in p])
    if law == "sine":
        return {
            "law": law,
            "mean_N_per_m": mean,
            "amplitude_N_per_m": mean * draw(st.just(0.0) | st.floats(0.01, 0.4)),
        }
    if law == "fourier":
        return {
            "law": law,
            "mean_N_per_m": mean,
            "cosine_N_per_m": draw(parts),
            "sine_N_per_m": draw(parts),
        }
    if law == "square":
        return {
            "law": law,
            "contact_ratio": draw(st.floats(1.0, 2.0)),
            "least_N_per_m": mean,
            "largest_N_per_m": mean * draw(st.floats(1.0, 2.0)),
            "harmonics": draw(st.integers(1, 12)),
        }
    return {"law": law, **draw(tables(mean))}


@st.composite
def tables(draw: st.DrawFn, mean: float) -> dict[str, Any]:
    """Rows at unequal phases whose values wander about a mean by a tenth."""
    widths = draw(st.lists(st.floats(1.0, 2.0), min_size=4, max_size=20))
    ends = [sum(widths[:place]) / sum(widths) for place in range(len(widths))]
    values = [mean * (1 + draw(st.floats(-0.1, 0.1))) for _ in widths]
    return {"phase_cycles": [*ends, 1.0], "stiffness_N_per_m": [*values, values[0]]}


@st.composite
def rods(draw: st.DrawFn) -> dict[str, Any]:
    """A rod's fields, its centre of mass anywhere near its middle."""
    length = draw(around(0.5))
    return {
        "length_m": length,
        "com_m": length * draw(st.floats(0.2, 0.8)),
        "cross_section_m2": draw(around(0.006, 2.0)),
        "density_kg_per_m3": draw(around(2700.0, 2.0)),
    }


@st.composite
def bodies(draw: st.DrawFn) -> dict[str, Any]:
    """A link from CAD: heavier or lighter than such a rod, and more or less spread out."""
    length, mass = draw(around(0.5)), draw(around(8.0))
    return {
        "length_m": length,
        "com_m": length * draw(st.floats(0.2, 0.8)),
        "mass_kg": mass,
        "inertia_kg_m2": mass * length**2 * draw(st.floats(0.02, 0.2)),
    }


def frictions() -> st.SearchStrategy[float]:
    """Viscous, or none."""
    return st.just(0.0) | around(2.0)
