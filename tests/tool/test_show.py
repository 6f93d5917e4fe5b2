"""`show` of an arm: every number beside one that is worked out from the arm's file alone."""

import math
import re
import tomllib
from typing import Any

import pytest

from crosscheck.provenance import ROOT
from tests.loops import require_items

Shown = dict[str, tuple[float, str]]


def tables_of(text: str) -> dict[str, dict[str, list[str]]]:
    """Value and unit of each quantity, by the title of its table; rows are indented."""
    tables: dict[str, dict[str, list[str]]] = {}
    title = ""
    for line in filter(str.strip, text.splitlines()):
        if not line.startswith(" "):
            title = line.strip()
            tables[title] = {}
        else:
            name, *rest = re.split(r"\s{2,}", line.strip())
            tables[title][name] = rest
    return tables


def of_stage(joint: dict[str, Any]) -> Shown:
    """Of a stage whose ring stands: the sun turns 1 + z_r / z_s times, a planet 1 - z_r / z_p."""
    sun, planet, ring = (joint[f"{gear}_teeth"] for gear in ("sun", "planet", "ring"))
    half, count = joint["module_m"] / 2, joint["planet_count"]
    base = half * math.cos(math.radians(joint["pressure_angle_deg"]))
    radii = {"sun": base * sun, "planet": base * planet, "carrier": base * (sun + planet)}
    mass = {gear: joint[f"{gear}_equivalent_mass_kg"] for gear in radii}
    inertia = {gear: mass[gear] * radii[gear] ** 2 for gear in radii}
    reflected = inertia["sun"] * (1 + ring / sun) ** 2
    reflected += count * inertia["planet"] * (1 - ring / planet) ** 2
    own = {gear: joint[f"{gear}_mass_kg"] for gear in (*radii, "ring")}
    shown: Shown = {
        "r_s, base radius of the sun": (radii["sun"], "m"),
        "r_p, base radius of a planet": (radii["planet"], "m"),
        "r_c, carrier radius": (half * (sun + planet), "m"),
        "r_cp = r_c cos(alpha)": (radii["carrier"], "m"),
        "n, reduction ratio": (1 + ring / sun, ""),
        "sun mesh: cycles per turn of the carrier": (ring, ""),
        "ring mesh: the same, eq13": (sun, ""),
        "ring mesh: the same, corrected": (ring, ""),
        "reflected inertia of sun and planets": (reflected, "kg m^2"),
        "mass at the joint's axis": (sum(own.values()) + (count - 1) * own["planet"], "kg"),
    }
    for index, gear, article in (
        ("s", "sun", "the"),
        ("p", "planet", "a"),
        ("c", "carrier", "the"),
    ):
        shown[f"M_{index}, equivalent mass of {article} {gear}"] = mass[gear], "kg"
        shown[f"I_{index}, inertia of {article} {gear}"] = inertia[gear], "kg m^2"
    for gear in ("sun", "planet"):
        gyration = math.sqrt(mass[gear] / own[gear]), ""
        shown[f"{gear}: radius of gyration over base radius"] = gyration
    return shown


def of_mesh(joint: dict[str, Any], side: str) -> Shown:
    """Of the meshes with sun or ring; damping is of N planets together, as is what swings."""
    mesh, count = joint[f"{side}_mesh"], joint["planet_count"]
    law = mesh["stiffness"]
    mean = law["mean_N_per_m"]
    swinging = joint["sun_equivalent_mass_kg"]
    if side == "ring":
        swinging = count * joint["planet_equivalent_mass_kg"]
    critical = 2 * math.sqrt(count * mean * swinging)
    ratio = mesh.get("damping_ratio")
    if ratio is None:
        ratio = mesh["damping_N_s_per_m"] / critical
    pair = "sp" if side == "sun" else "pr"
    return {
        "mean stiffness, per planet": (mean, "N/m"),
        "largest stiffness, per planet": (mean + law["amplitude_N_per_m"], "N/m"),
        f"d_{pair}, damping of x_{pair}, {count} planets alike": (ratio * critical, "N s/m"),
        f"zeta_{pair}, damping ratio of x_{pair}": (ratio, ""),
    }


def test_every_derived_number_is_that_of_the_file(crosscheck, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    content = tomllib.loads((ROOT / "models" / "arms" / "probe.toml").read_text())
    tables, total = tables_of(crosscheck("show", "probe").out), content["payload_mass_kg"]
    right: dict[str, Shown] = {}
    for number, (joint, link) in enumerate(
        zip(content["joints"], content["links"], strict=True), 1
    ):
        right[f"joint {number}, derived"] = of_stage(joint)
        for side in ("sun", "ring"):
            right[f"joint {number}, {side} mesh"] = of_mesh(joint, side)
        length = link["length_m"]
        mass = link["cross_section_m2"] * link["density_kg_per_m3"] * length
        rod = {
            "mass": (mass, "kg"),
            "inertia about its centre of mass": (mass * length**2 / 12, "kg m^2"),
        }
        right[f"link {number}"] = rod
        total += mass + right[f"joint {number}, derived"]["mass at the joint's axis"][0]
    right["arm"] = {"total mass": (total, "kg")}
    for title, quantities in right.items():
        for name, (value, unit) in quantities.items():
            shown, *units = tables[title].pop(name)
            assert float(shown) == pytest.approx(value, rel=1e-9), f"{title}: {name}"
            assert units == [unit] * bool(unit), f"{title}: {name}"
    assert list(tables["joint 1, derived"]) == list(tables["joint 2, derived"]) == ["quantity"]


def test_phases_from_the_teeth_are_of_each_planets_own_meshes(crosscheck, monkeypatch):
    """A planet of evenly many teeth has the flanks that carry half a turn of phase apart."""
    monkeypatch.setenv("COLUMNS", "200")
    content = tomllib.loads((ROOT / "models" / "arms" / "planets-apart.toml").read_text())
    tables = tables_of(crosscheck("show", "planets-apart").out)
    turn = 2 * math.pi
    for number, joint in require_items(enumerate(content["joints"], 1)):
        apart = turn / 2 * (joint["planet_teeth"] % 2 == 0)
        for planet in require_items(range(joint["planet_count"])):
            sun = -turn * joint["sun_teeth"] * planet / joint["planet_count"]
            for side, phase in (("sun", sun), ("ring", sun - apart)):
                title = f"joint {number}, {side} mesh of planet {planet + 1}"
                shown, unit = tables[title]["phase from the teeth"]
                off = math.remainder(float(shown) - phase, turn)
                assert (unit, off) == ("rad", pytest.approx(0, abs=1e-8)), title
