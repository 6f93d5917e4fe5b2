"""The letters of an arm's quantities, their numbers, and what people put where one belongs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from itertools import permutations, product
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.derivation.gears import damping
from crosscheck.analytic.derivation.stage import stage_values
from crosscheck.analytic.paper.kinematics import stage_geometry
from crosscheck.models.arm.arm import Arm, Planetary

Values = Mapping[str, Any]  # numbers, or arrays of numbers: one for each arm
STEMS_BY_QUANTITY = {
    "count": ("N",),
    "ratio": ("n",),
    "mass": ("m_payload", "m", "m_s", "m_p", "m_c", "m_r", "m_m", "M_s", "M_p", "M_c"),
    "inertia": ("I_l", "J_r", "J_m"),
    "damping": ("d_sp", "d_pr", "c"),
    "gravity": ("g_x", "g_y"),
    "length": ("L", "d", "r_s", "r_p", "r_c", "r_cp", "r_r"),
}
QUANTITY_OF_STEM = {stem: kind for kind, stems in STEMS_BY_QUANTITY.items() for stem in stems}
ORDER = {stem: place for place, stem in enumerate(QUANTITY_OF_STEM)}
GEAR_PARTS = frozenset(("N", "n", "m_s", "m_p", "m_c", "m_r", "M_s", "M_p", "M_c", "J_r"))
RADII = frozenset(("r_s", "r_p", "r_c", "r_cp", "r_r"))
G = ("9.81", "9.8", "9.80665", "10")  # [m/s^2] as people write it
TEETH = ("z_s", "z_p", "z_r")
SHIFTS = {" + 1": 1, "": 0, " - 1": -1}  # of a ratio of teeth


class Letter(NamedTuple):
    """The parts of a letter's name: its stem, its joint (0: none); d_sp and 2 of ``d_sp2_1``."""

    stem: str
    joint: int
    rest: str = ""


class Alternative(NamedTuple):
    """A possible replacement of a letter: its text, its value, and how far-fetched it is."""

    text: str
    value: Any
    cost: float


@cache
def parse_letter(name: str) -> Letter:
    """The parts of a letter's name."""
    match = re.fullmatch(r"(.*?)(\d+)(_\d+)?", name)
    return Letter(match[1], int(match[2]), match[3] or "") if match else Letter(name, 0)


def collect_arm_values(arm: Arm) -> dict[str, float]:
    """Every quantity of an arm in SI units, by the names of ``derivation.stage`` and a few more.

    ``z_s1``, ``z_p1``, ``z_r1``: teeth; ``r_r1``: base radius of the ring; ``d_sp1``, ``d_pr1``
    (``d_sp1_2`` of planet 2, if planets differ): damping of all planets; ``c1``: friction;
    ``g_x``, ``g_y``: gravity.
    """
    g_x, g_y = arm.gravity_m_per_s2
    values = {"m_payload": arm.payload_mass_kg, "g_x": g_x, "g_y": g_y}
    for number, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), start=1):
        stage = stage_values(joint, link, float)
        values |= {f"{name}{number}": value for name, value in stage._asdict().items()}
        values[f"c{number}"] = joint.friction_N_m_s_per_rad
        if not isinstance(joint, Planetary):
            continue
        geometry = stage_geometry(joint)
        for letter, gear in zip(TEETH, ("sun", "planet", "ring"), strict=True):
            values[f"{letter}{number}"] = float(getattr(joint, f"{gear}_teeth"))
        values[f"r_r{number}"] = geometry.r_s + 2 * geometry.r_p
        for planet in range(joint.planet_count):
            for pair, d in zip(("sp", "pr"), damping(joint, planet), strict=True):
                values[damper_name(pair, joint, number, planet)] = d
    return values


def damper_name(pair: str, joint: Planetary, number: int, planet: int) -> str:
    """The name of the damping of a mesh: one for all planets if they are equal."""
    alike = len({damping(joint, p) for p in range(joint.planet_count)}) == 1
    return f"d_{pair}{number}" + ("" if alike else f"_{planet + 1}")


def draw_unrelated_values(letters: Iterable[str]) -> dict[str, float]:
    """Other numbers for the same letters, none of which has to do with another.

    Two errors that differ with these are two errors, whatever they come to on an arm at hand.
    """
    return {
        name: float(np.random.default_rng([0, *name.encode()]).uniform(0.5, 2.0))
        for name in letters
    }


def generate_alternatives(name: str, values: Values) -> Iterator[Alternative]:
    """Alternatives that one might write where this letter belongs."""
    (stem, j, _), value = parse_letter(name), values[name]
    kind = QUANTITY_OF_STEM.get(stem)
    if stem == "n":
        for text, ratio in _generate_ratios(j, values):
            yield Alternative(text, ratio, 0.1)
    if stem in ("r_c", "r_cp") and f"r_r{j}" in values:
        s, p, r = (values[f"{radius}{j}"] for radius in ("r_s", "r_p", "r_r"))
        sums = {"z_s{0} + z_r{0}": s + r, "z_p{0} + z_r{0}": p + r, "z_s{0} - z_p{0}": s - p}
        for text, total in (sums | {"z_s{0} + 2 z_p{0}": s + 2 * p}).items():
            yield Alternative(f"{name} by {text.format(j)}", value / (s + p) * total, 0.2)
    for other, number in values.items():
        if kind and other != name and QUANTITY_OF_STEM.get(parse_letter(other).stem) == kind:
            yield Alternative(other, number, _distance(parse_letter(name), parse_letter(other)))
    if stem in RADII and f"r_cp{j}" in values:
        cosine = values[f"r_cp{j}"] / values[f"r_c{j}"]
        if stem != "r_c":
            yield Alternative(f"the pitch radius {name}/cos(alpha)", value / cosine, 0.15)
        yield Alternative(f"{name} cos(alpha)", value * cosine, 0.25)
    if stem == "d":
        length = values[f"L{j}"]
        yield Alternative(f"L{j}/2", length / 2, 0.1)
        yield Alternative(f"L{j} - {name}", length - value, 0.15)
    if stem == "m" and f"L{j}" in values:
        yield Alternative(f"{name}/L{j}", value / values[f"L{j}"], 0.35)
    if kind == "gravity":
        sign = "-" if np.ravel(value)[0] < 0 else ""
        for text in G:
            yield Alternative(sign + text, float(sign + text) + 0 * value, 0.3)
        yield Alternative("-1", -1 + 0 * value, 0.45)  # g is written as a positive number
    if stem == "I_l" and f"m{j}" in values:
        for text in (f"m{j} L{j}^2/12", f"m{j} L{j}^2/3"):
            by = float(text.rpartition("/")[2])
            yield Alternative(text, values[f"m{j}"] * values[f"L{j}"] ** 2 / by, 0.2)
        square = values[f"m{j}"] * values[f"d{j}"] ** 2
        for sign, by in (("+", 1.0), ("-", -1.0)):
            yield Alternative(f"{name} {sign} m{j} d{j}^2", value + by * square, 0.35)
    if stem == "n":
        yield Alternative(f"1/{name}", 1 / value, 0.3)
    if stem == "N":
        yield Alternative(f"sqrt({name})", value**0.5, 0.4)
        yield Alternative(f"{name} - 1", value - 1, 0.4)
        yield Alternative(f"{name} + 1", value + 1, 0.4)


def generate_forms(name: str, values: Values) -> Iterator[Alternative]:
    """Forms of the letter itself: its square, nothing, in another unit, and last its multiples."""
    value = values[name]
    yield Alternative(f"{name}^2", value**2, 0.5)
    yield Alternative("1", np.ones_like(value), 0.45)
    multiples = {"1000 {}": 1e3, "{}/1000": 1e-3, "-{}": -1.0, "2 {}": 2.0, "{}/2": 0.5}
    for text, by in multiples.items():
        yield Alternative(text.format(name), by * value, 0.3)


def _generate_ratios(joint: int, values: Values) -> Iterator[tuple[str, Any]]:
    """Ratios of any two gears' teeth, one more or less, and the right one of whole numbers."""
    teeth = {name: values[name] for each in TEETH if (name := f"{each}{joint}") in values}
    for (words, shift), (a, b) in product(SHIFTS.items(), permutations(teeth, 2)):
        if not (a.startswith("z_r") and b.startswith("z_s") and shift == 1):
            yield f"{a}/{b}{words}", teeth[a] / teeth[b] + shift
    if teeth:
        sun, _, ring = teeth
        yield f"{ring}//{sun} + 1", np.floor(teeth[ring] / teeth[sun]) + 1


def _distance(name: Letter, other: Letter) -> float:
    """Cost of confusing two letters: lowest within one joint and kind."""
    same_joint, stems = name.joint == other.joint, {name.stem, other.stem}
    if stems == {"L", "d"} and same_joint:
        return 0.05 - 1e-3 * name.joint  # a body's own lever is that of its last link
    cost = 0.1 if same_joint else 0.3
    if name.stem != other.stem:
        cost += 0.05 if name.stem in RADII else 0.15
        cost += 0.3 * ((name.stem in RADII) != (other.stem in RADII))
        cost += 0.1 * ((name.stem in GEAR_PARTS) != (other.stem in GEAR_PARTS))
        cost += 0.3 * (not same_joint)
    return cost


def format_power(name: str, power: int) -> str:
    """A power as text, such as L1^2."""
    return name if power == 1 else f"{name}^{power}"


def sort_powers(powers: Iterable[tuple[str, int]]) -> list[tuple[str, int]]:
    """Powers of letters in the order in which they are written: masses before lengths."""

    def order(power: tuple[str, int]) -> tuple[int, int]:
        stem, joint, _ = parse_letter(power[0])
        return ORDER.get(stem, len(ORDER)), joint

    return sorted(powers, key=order)
