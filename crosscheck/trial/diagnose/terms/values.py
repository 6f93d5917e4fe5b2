"""The numbers behind an arm's symbols, and what people put where a symbol belongs."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.derivation.gears import damping
from crosscheck.analytic.derivation.symbols import parameter_values
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
# A ratio n = z_r / z_s + 1 of the wrong teeth, as code and as text: sun, planet, ring.
RATIOS: tuple[tuple[str, Callable[[Any, Any, Any], Any]], ...] = (
    ("z_r/z_p + 1", lambda s, p, r: r / p + 1),
    ("z_p/z_s + 1", lambda s, p, r: p / s + 1),
    ("z_r/z_s", lambda s, p, r: r / s),
    ("z_r/z_s - 1", lambda s, p, r: r / s - 1),
    ("1 - z_r/z_s", lambda s, p, r: 1 - r / s),
    ("z_s/z_r + 1", lambda s, p, r: s / r + 1),
    ("z_r/z_p", lambda s, p, r: r / p),
    ("z_p/z_s", lambda s, p, r: p / s),
    ("z_s/z_p + 1", lambda s, p, r: s / p + 1),
    ("z_p/z_r + 1", lambda s, p, r: p / r + 1),
)
# The planets' ratio z_r / z_p - 1, likewise.
PLANET_RATIOS: tuple[tuple[str, Callable[[Any, Any, Any], Any]], ...] = (
    ("z_r/z_p", lambda s, p, r: r / p),
    ("z_r/z_p + 1", lambda s, p, r: r / p + 1),
    ("z_s/z_p", lambda s, p, r: s / p),
    ("z_s/z_p - 1", lambda s, p, r: s / p - 1),
    ("z_r/z_s + 1", lambda s, p, r: r / s + 1),
    ("z_r/z_s - 1", lambda s, p, r: r / s - 1),
    ("z_r/z_s", lambda s, p, r: r / s),
    ("z_p/z_s", lambda s, p, r: p / s),
    ("z_p/z_r", lambda s, p, r: p / r),
)
# What spins by a ratio, which r_cp has in it: whose ratio, the right one, and wrong ones.
SPINNING = {
    "M_s": ("sun's", "z_r/z_s + 1", lambda s, p, r: r / s + 1, RATIOS),
    "M_p": ("planets'", "z_r/z_p - 1", lambda s, p, r: r / p - 1, PLANET_RATIOS),
}
# A carrier radius by the wrong teeth, in base radii r_s, r_p, r_r of these.
CARRIERS: tuple[tuple[str, Callable[[Any, Any, Any], Any]], ...] = (
    ("z_s + z_r", lambda s, p, r: s + r),
    ("z_p + z_r", lambda s, p, r: p + r),
    ("z_s - z_p", lambda s, p, r: s - p),
    ("z_s + 2 z_p", lambda s, p, r: s + 2 * p),
)


class SymbolName(NamedTuple):
    """The parts of a symbol's name: its stem, its joint (0: none); d_sp and 2 of ``d_sp2_1``."""

    stem: str
    joint: int
    rest: str = ""


class Alternative(NamedTuple):
    """A possible replacement of a symbol: its text, its value, and how far-fetched it is."""

    text: str
    value: Any
    cost: float


@cache
def parse_symbol(symbol: str) -> SymbolName:
    """The parts of a symbol's name."""
    match = re.fullmatch(r"(.*?)(\d+)(_\d+)?", symbol)
    return SymbolName(match[1], int(match[2]), match[3] or "") if match else SymbolName(symbol, 0)


def collect_arm_values(arm: Arm) -> dict[str, float]:
    """Every quantity of an arm in SI units, by the names of ``derivation.symbols`` and a few more.

    ``z_s1``, ``z_p1``, ``z_r1``: teeth; ``r_r1``: base radius of the ring; ``d_sp1``, ``d_pr1``
    (``d_sp1_2`` of planet 2, if planets differ): damping of all planets; ``c1``: friction;
    ``g_x``, ``g_y``: gravity.
    """
    values = {symbol.name: float(value) for symbol, value in parameter_values(arm).items()}
    values["g_x"], values["g_y"] = arm.gravity_m_per_s2
    for number, joint in enumerate(arm.joints, start=1):
        values[f"c{number}"] = joint.friction_N_m_s_per_rad
        if not isinstance(joint, Planetary):
            continue
        geometry = stage_geometry(joint)
        values[f"z_s{number}"] = float(joint.sun_teeth)
        values[f"z_p{number}"] = float(joint.planet_teeth)
        values[f"z_r{number}"] = float(joint.ring_teeth)
        values[f"r_r{number}"] = geometry.r_s + 2 * geometry.r_p
        for planet in range(joint.planet_count):
            for pair, d in zip(("sp", "pr"), damping(joint, planet), strict=True):
                values[damper_name(pair, joint, number, planet)] = d
    return values


def damper_name(pair: str, joint: Planetary, number: int, planet: int) -> str:
    """The name of the damping of a mesh: one for all planets where they are alike."""
    alike = len({damping(joint, p) for p in range(joint.planet_count)}) == 1
    return f"d_{pair}{number}" + ("" if alike else f"_{planet + 1}")


def draw_unrelated_values(symbols: Iterable[str]) -> dict[str, float]:
    """Other numbers for the same symbols, none of which has to do with another.

    Two errors that differ with these are two errors, whatever they come to on an arm at hand.
    """
    seeds = {name: [0, *name.encode()] for name in symbols}
    return {
        n: float(np.random.default_rng(entropy).uniform(0.5, 2.0)) for n, entropy in seeds.items()
    }


def generate_alternatives(symbol: str, values: Values) -> Iterator[Alternative]:
    """Alternatives that one might write where this symbol belongs."""
    symbol_name = parse_symbol(symbol)
    yield from _tooth_alternatives(symbol_name, values)
    kind = QUANTITY_OF_STEM.get(symbol_name.stem)
    for name in values:
        other = parse_symbol(name)
        if kind and name != symbol and QUANTITY_OF_STEM.get(other.stem) == kind:
            yield Alternative(name, values[name], _distance(symbol_name, other))
    if symbol_name.stem in RADII and f"r_cp{symbol_name.joint}" in values:
        cosine = values[f"r_cp{symbol_name.joint}"] / values[f"r_c{symbol_name.joint}"]
        if symbol_name.stem != "r_c":
            text = f"the pitch radius {symbol}/cos(alpha)"
            yield Alternative(text, values[symbol] / cosine, 0.15)
        yield Alternative(f"{symbol} cos(alpha)", values[symbol] * cosine, 0.25)
    if symbol_name.stem == "d":
        length = values[f"L{symbol_name.joint}"]
        yield Alternative(f"L{symbol_name.joint}/2", length / 2, 0.1)
        yield Alternative(f"L{symbol_name.joint} - {symbol}", length - values[symbol], 0.15)
    if kind == "gravity":
        sign = "-" if np.ravel(values[symbol])[0] < 0 else ""
        for text in G:
            yield Alternative(sign + text, float(sign + text) + 0 * values[symbol], 0.3)
    if symbol_name.stem == "I_l":
        mass, length = f"m{symbol_name.joint}", f"L{symbol_name.joint}"
        for by in (12, 3):
            rod = values[mass] * values[length] ** 2 / by if mass in values else 0.0
            yield Alternative(f"{mass} {length}^2/{by}", rod, 0.2)
    if symbol_name.stem == "n":
        yield Alternative(f"1/{symbol}", 1 / values[symbol], 0.3)
    if symbol_name.stem == "N":
        yield Alternative(f"sqrt({symbol})", values[symbol] ** 0.5, 0.4)
        for text, shift in ((f"{symbol} - 1", -1), (f"{symbol} + 1", 1)):
            yield Alternative(text, values[symbol] + shift, 0.4)


def generate_ratios(symbol: str, values: Values) -> Iterator[tuple[str, Alternative]]:
    """The right ratio by which a gear of this mass spins, and wrong ones as multiples of that."""
    stem, j, _ = parse_symbol(symbol)
    if stem not in SPINNING or f"z_s{j}" not in values:
        return
    gear, right_text, right_ratio, ratios = SPINNING[stem]
    teeth = [values[f"{z}{j}"] for z in ("z_s", "z_p", "z_r")]
    right, belongs = right_ratio(*teeth), _add_joint_number(right_text, j)
    others = [(_add_joint_number(text, j), ratio(*teeth)) for text, ratio in ratios]
    for k in (k for k in _list_joints(values) if k != j):
        elsewhere = [values[f"{z}{k}"] for z in ("z_s", "z_p", "z_r")]
        others.append((_add_joint_number(right_text, k), right_ratio(*elsewhere)))
    for text, ratio in (*others, (f"1/({belongs})", 1 / right)):
        yield belongs, Alternative(f"the {gear} ratio {text}", ratio / right, 0.15)


def _list_joints(values: Values) -> list[int]:
    """The joints with gears."""
    return [symbol.joint for symbol in map(parse_symbol, values) if symbol.stem == "z_s"]


def _distance(symbol_name: SymbolName, other: SymbolName) -> float:
    """Cost of confusing two symbols: lowest within one joint and kind."""
    cost = 0.1 if symbol_name.joint == other.joint else 0.3
    if {symbol_name.stem, other.stem} == {"L", "d"} and symbol_name.joint == other.joint:
        return 0.05 - 1e-3 * symbol_name.joint  # a body's own lever is that of its last link
    if symbol_name.stem != other.stem:
        cost += 0.05 if symbol_name.stem in RADII else 0.15
        cost += 0.3 if (symbol_name.stem in RADII) != (other.stem in RADII) else 0.0
        cost += 0.1 if (symbol_name.stem in GEAR_PARTS) != (other.stem in GEAR_PARTS) else 0.0
        cost += 0.3 if symbol_name.joint != other.joint else 0.0
    return cost


def _tooth_alternatives(symbol_name: SymbolName, values: Values) -> Iterator[Alternative]:
    """Alternatives that are the same quantity, worked out with the teeth of other gears."""
    j = symbol_name.joint
    if symbol_name.stem == "n":
        teeth = [values[f"{z}{j}"] for z in ("z_s", "z_p", "z_r")]
        for text, ratio in RATIOS:
            yield Alternative(_add_joint_number(text, j), ratio(*teeth), 0.1)
    if symbol_name.stem in ("r_c", "r_cp") and f"r_r{j}" in values:
        radii = [values[f"{r}{j}"] for r in ("r_s", "r_p", "r_r")]
        share = values[f"{symbol_name.stem}{j}"] / (radii[0] + radii[1])
        for text, sum_of in CARRIERS:
            name = f"{symbol_name.stem}{j} by {_add_joint_number(text, j)}"
            yield Alternative(name, share * sum_of(*radii), 0.2)


def _add_joint_number(text: str, joint: int) -> str:
    return re.sub(r"(z_[spr])", rf"\g<1>{joint}", text)
