"""`show` of an arm: every number beside one that is worked out from the arm's file alone."""

import math
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest

from crosscheck.cli.show import derived_arm
from crosscheck.models.loading import load_arm
from crosscheck.provenance import ROOT
from crosscheck.trial.changes.arms.letters import collect_arm_values
from crosscheck.trial.input.arm_symbols import ARM_SYMBOLS, OF_ARM
from tests.loops import require_items

Shown = dict[str, tuple[float, str]]
UNITS = {  # the longer ends first
    "kg_per_m3": "kg/m^3",
    "N_m_s_per_rad": "N m s/rad",
    "N_s_per_m": "N s/m",
    "N_per_m": "N/m",
    "sharpness_per_m": "1/m",
    "kg_m2": "kg m^2",
    "_m2": "m^2",
    "_kg": "kg",
    "_deg": "deg",
    "_rad": "rad",
    "_m": "m",
}


def tables_of(text: str) -> dict[str, dict[str, list[str]]]:
    """Value and unit of each quantity, by the title of its table; rows are indented."""
    return {
        title: {name: [part for part in (value, unit) if part] for name, value, unit, _ in rows}
        for title, rows in rows_of(text).items()
    }


def rows_of(text: str) -> dict[str, list[tuple[str, ...]]]:
    """Quantity, value, unit and symbol of each row of each table, below the words of its head."""
    tables: dict[str, list[tuple[str, ...]]] = {}
    title, starts = "", [0]
    for line in filter(str.strip, text.splitlines()):
        if not line.startswith(" "):
            title = line.strip()
            tables[title] = []
            continue
        if line.split()[:3] == ["quantity", "value", "unit"]:
            starts = [line.index(word) for word in line.split()]
        ends = [*starts[1:], len(line)]
        cells = [line[a:b].strip() for a, b in zip(starts, ends, strict=True)]
        tables[title].append((*cells, *[""] * (4 - len(cells))))
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
        f"d_{pair}, damping of x_{pair}, {count} planets": (ratio * critical, "N s/m"),
        f"zeta_{pair}, damping ratio of x_{pair}": (ratio, ""),
    }


def stated_numbers(record: dict[str, Any]) -> Shown:
    """The numbers that a table of the file states itself; what a key ends with is their unit."""
    return {
        name: (value, next((unit for end, unit in UNITS.items() if name.endswith(end)), ""))
        for name, value in record.items()
        if isinstance(value, int | float)
    }


def wrong_modes(rows: list[list[str]], step: float) -> Iterator[str]:
    """Pairs of a frequency [Hz] and a damping ratio that RK4 at 1 or 1.2 steps contradicts.

    Its growth is the exponential's series up to the fourth power. The step is of the largest
    stiffness, at most a fifth above the mean one that the modes are of.
    """
    growths = []
    for (kind, frequency, unit), (of_it, ratio) in zip(rows[::2], rows[1::2], strict=True):
        if (kind, unit, of_it) != ("mesh mode", "Hz", "its damping ratio"):
            yield f"{kind} [{unit}], {of_it}"
        damping = float(ratio)
        if not 0.02 < damping < 0.08:  # about 0.05, as the file states of meshes
            yield f"damping ratio {damping}"
        pole = 2 * math.pi * float(frequency) * complex(-damping, math.sqrt(1 - damping**2))
        growths.append([growth_of_a_step(pole * step * share) for share in (1.0, 1.2)])
    if not max(now for now, _ in growths) < 1 < max(longer for _, longer in growths):
        yield f"RK4 grows by {growths} in a step of {step} s"


def growth_of_a_step(z: complex) -> float:
    """Of RK4, where the exact one is exp(z)."""
    return abs(sum(z**k / math.factorial(k) for k in range(5)))


@pytest.mark.parametrize("name", ["probe", "paper-labelled"])
def test_every_derived_number_is_that_of_the_file(crosscheck, monkeypatch, name):
    monkeypatch.setenv("COLUMNS", "200")
    content = tomllib.loads((ROOT / "models" / "arms" / f"{name}.toml").read_text())
    text, total = crosscheck("show", name).out, content["payload_mass_kg"]
    tables = tables_of(text)
    right: dict[str, Shown] = {}
    for number, (joint, link) in enumerate(
        zip(content["joints"], content["links"], strict=True), 1
    ):
        right[f"joint {number}"] = stated_numbers(joint)
        right[f"joint {number}, derived"] = of_stage(joint)
        for side in ("sun", "ring"):
            mesh = joint[f"{side}_mesh"]
            stated = stated_numbers(mesh) | stated_numbers(mesh["stiffness"])
            right[f"joint {number}, {side} mesh"] = stated | of_mesh(joint, side)
        length = link["length_m"]
        mass = link["cross_section_m2"] * link["density_kg_per_m3"] * length
        rod = {
            "mass": (mass, "kg"),
            "inertia about its centre of mass": (mass * length**2 / 12, "kg m^2"),
        }
        right[f"link {number}"] = stated_numbers(link) | rod
        total += mass + right[f"joint {number}, derived"]["mass at the joint's axis"][0]
    right["arm"] = stated_numbers(content) | {"total mass": (total, "kg")}
    right["arm"].pop("schema_version")
    for title, quantities in right.items():
        for quantity, (value, unit) in quantities.items():
            shown, *units = tables[title].pop(quantity)
            assert float(shown) == pytest.approx(value, rel=1e-9), f"{title}: {quantity}"
            assert units == [unit] * bool(unit), f"{title}: {quantity}"
    assert list(tables["joint 1, derived"]) == list(tables["joint 2, derived"]) == ["quantity"]
    modes = [
        [part for part in row if part]
        for row in rows_of(text)["arm"]
        if row[0] in ("mesh mode", "its damping ratio")
    ]
    assert len(modes) == 2 * 4  # sun and planets of both joints
    assert not list(wrong_modes(modes, float(tables["arm"]["largest stable step of RK4"][0])))


def test_each_of_unlike_planets_has_numbers_of_its_own(crosscheck, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    content = tomllib.loads((ROOT / "models" / "arms" / "planets-apart.toml").read_text())
    tables = tables_of(crosscheck("show", "planets-apart").out)
    own = [
        (f"joint {number}, {side} mesh of planet {planet}", name, value)
        for number, joint in enumerate(content["joints"], 1)
        for side in ("sun", "ring")
        for name, values in joint[f"{side}_mesh"].items()
        if isinstance(values, list)
        for planet, value in enumerate(values, 1)
    ]
    for title, name, value in require_items(own):
        assert float(tables[title][name][0]) == value, f"{title}: {name}"


def test_a_poles_frequency_and_ratio_are_its_size_and_its_angle(monkeypatch):
    monkeypatch.setattr("crosscheck.cli.show._mesh_poles", lambda model: [-30 + 40j])
    shown = {row.name: row.value for row in derived_arm(load_arm("probe"))}
    assert shown["mesh mode"] == pytest.approx(50 / (2 * math.pi))
    assert shown["its damping ratio"] == pytest.approx(0.6)


def test_experiments_of_an_arms_size_move_it_as_its_controller_does(crosscheck):
    """Gains of a second-order system of the shown rate, its damping ratio 0.7; half a radian."""
    rows = tables_of(crosscheck("show", "probe").out)["experiments of its size"]
    rate = float(rows.pop("rate of the controller")[0])
    for number, target in (("1", 0.5), ("2", -0.5)):
        inertia, unit = rows.pop(f"joint {number}: inertia of the rigid arm, stretched out")
        stiffness = float(inertia) * rate**2
        right = {
            "step of torque": (0.5 * stiffness, "N m"),
            "proportional gain": (stiffness, "N m/rad"),
            "derivative gain": (2 * 0.7 * float(inertia) * rate, "N m s/rad"),
            "target": (target, "rad"),
        }
        assert unit == "kg m^2"
        for name, (value, unit) in right.items():
            shown, *units = rows.pop(f"joint {number}: {name}")
            assert float(shown) == pytest.approx(value, rel=1e-5), name  # gains have six digits
            assert units == [unit]
    assert list(rows) == [
        "quantity",
        "duration of the step of torque",
        "duration of the controlled motion",
    ]
    times = [float(rows[name][0]) * rate for name in list(rows)[1:]]
    assert times == pytest.approx([2, 8], rel=5e-3)  # in radians of the controller; whole ms


def test_phases_that_the_teeth_say_are_shown_of_each_mesh(crosscheck, monkeypatch):
    """Planet n is n / N of a turn on: its mesh is as many cycles of sun and ring ahead or behind.

    At ring and sun its flanks that carry are half its teeth and half a tooth apart.
    """
    monkeypatch.setenv("COLUMNS", "200")
    content = tomllib.loads((ROOT / "models" / "arms" / "planets-apart.toml").read_text())
    tables = tables_of(crosscheck("show", "planets-apart").out)
    for number, joint in require_items(enumerate(content["joints"], 1)):
        for n in require_items(range(joint["planet_count"])):
            turn = n / joint["planet_count"]
            apart = (joint["planet_teeth"] + 1) / 2
            for side, lag in (
                ("sun", joint["sun_teeth"] * turn),
                ("ring", -joint["ring_teeth"] * turn + apart),
            ):
                rows = tables[f"joint {number}, {side} mesh of planet {n + 1}"]
                shown, unit = rows["phase from the teeth"]
                off = float(shown) / (2 * math.pi) + lag
                assert abs(off - round(off)) < 1e-9
                assert unit == "rad"


def test_every_symbol_of_an_arm_stands_beside_its_number(crosscheck, monkeypatch):
    """The symbols that SymPy equations may have, each once, with the number that they stand for."""
    monkeypatch.setenv("COLUMNS", "200")
    for name in ("probe", "direct-between"):
        values = collect_arm_values(load_arm(name))
        rows = [row for table in rows_of(crosscheck("show", name).out).values() for row in table]
        shown = {symbol: value for _, value, _, symbol in rows if symbol and symbol != "symbol"}
        x_and_y = shown.pop("g_x, g_y").split(", ")
        shown |= dict(zip(("g_x", "g_y"), x_and_y, strict=True))
        derived = {each for each in values if each.startswith("r_r")}  # of the ring, by its teeth
        assert set(values) - derived == set(shown)
        for symbol, value in shown.items():
            assert float(value) == pytest.approx(values[symbol], rel=1e-9)


def test_what_a_link_states_is_not_shown_twice(crosscheck, tmp_path):
    path = tmp_path / "plain.toml"
    crosscheck("init", str(path), "--direct")
    names = [row[0] for row in rows_of(crosscheck("show", str(path)).out)["link 1"]]
    assert names == ["quantity", "length_m", "com_m", "mass_kg", "inertia_kg_m2"]


def test_the_reference_has_the_symbols_of_an_arm():
    text = (ROOT / "docs" / "reference" / "arm-file.md").read_text(encoding="utf-8")
    rows = [row for row in text.splitlines() if row.startswith("| `")]
    for symbol in require_items(ARM_SYMBOLS):
        number = "" if symbol.stem in OF_ARM else "1"
        (row,) = (row for row in rows if f"`{symbol.stem}{number}`" in row)
        assert (f"`{symbol.field}`" if symbol.field else "follow") in row
