"""Meaning of the symbols of an arm's quantities: fields of its file, and other names."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import NamedTuple


class ArmSymbol(NamedTuple):
    """A symbol of a joint or link, whose number follows the stem; of the arm, without a number.

    field: of the arm's file, '' of what follows from others; letters: other usual names, in small
    letters without underscores.
    """

    stem: str
    field: str
    meaning: str
    letters: tuple[str, ...] = ()


ARM_SYMBOLS = (
    ArmSymbol("L", "length_m", "length of a link", ("a", "len", "length")),
    ArmSymbol("d", "com_m", "centre of mass of a link", ("lc", "lg", "r", "rc", "com", "ac")),
    ArmSymbol("m", "mass_kg", "mass of a link", ("mass", "ml")),
    ArmSymbol(
        "I_l",
        "inertia_kg_m2",
        "inertia of a link about its centre of mass",
        ("j", "i", "theta", "ic", "jc", "iz", "izz", "jz", "jl", "ig", "inertia"),
    ),
    ArmSymbol("c", "friction_N_m_s_per_rad", "viscous friction", ("b", "f", "fv", "mu", "beta")),
    ArmSymbol("m_m", "motor_mass_kg", "mass of a motor", ("mm", "mr", "mrotor", "mmotor")),
    ArmSymbol("J_m", "rotor_inertia_kg_m2", "inertia of a rotor", ("jr", "im", "ir", "jrotor")),
    ArmSymbol("m_payload", "payload_mass_kg", "payload", ("mp", "ml", "me", "mtip", "mload")),
    ArmSymbol("g_x", "gravity_m_per_s2", "gravity along the base's x", ("g",)),
    ArmSymbol("g_y", "gravity_m_per_s2", "gravity along the base's y", ("g",)),
    ArmSymbol("N", "planet_count", "number of planets", ("np", "nplanets")),
    ArmSymbol("n", "", "ratio of a planetary joint, z_r / z_s + 1", ("i", "r", "ratio", "gr")),
    ArmSymbol("z_s", "sun_teeth", "teeth of the sun", ("zs", "ns")),
    ArmSymbol("z_p", "planet_teeth", "teeth of a planet", ("zp",)),
    ArmSymbol("z_r", "ring_teeth", "teeth of the ring", ("zr", "nr")),
    ArmSymbol("m_s", "sun_mass_kg", "mass of the sun"),
    ArmSymbol("m_p", "planet_mass_kg", "mass of a planet"),
    ArmSymbol("m_c", "carrier_mass_kg", "mass of the carrier"),
    ArmSymbol("m_r", "ring_mass_kg", "mass of the ring"),
    ArmSymbol("J_r", "ring_inertia_kg_m2", "inertia of the ring"),
    ArmSymbol("M_s", "sun_equivalent_mass_kg", "J / r_s^2 of the sun", ("js", "is")),
    ArmSymbol("M_p", "planet_equivalent_mass_kg", "J / r_p^2 of a planet", ("jp", "ip")),
    ArmSymbol("M_c", "carrier_equivalent_mass_kg", "J / r_cp^2 of the carrier", ("jc", "ic")),
    ArmSymbol("d_sp", "", "damping of x_sp, all planets together"),
    ArmSymbol("d_pr", "", "damping of x_pr, all planets together"),
    ArmSymbol("r_s", "", "base radius of the sun", ("rs",)),
    ArmSymbol("r_p", "", "base radius of a planet", ("rp",)),
    ArmSymbol("r_c", "", "carrier radius", ("rc",)),
    ArmSymbol("r_cp", "", "r_c cos(alpha)", ("rcp",)),
)
SYMBOL_OF_FIELD = {
    symbol.field: symbol.stem for symbol in ARM_SYMBOLS if symbol.field != "gravity_m_per_s2"
} | {"gravity_m_per_s2": "g_x, g_y"}
OF_ARM = ("m_payload", "g_x", "g_y")  # stems without a number


def find_meant_symbols(name: str, available: Collection[str]) -> list[str]:
    """The symbols that another usual name of theirs may mean: ``I_l1`` of ``J1``.

    available: the symbols of the arm.
    """
    match = re.fullmatch(r"(.*?)_?(\d*)", name)
    assert match is not None  # as it matches anything
    bare, number = match[1].replace("_", "").lower(), match[2]
    symbols = (
        symbol.stem if symbol.stem in OF_ARM else f"{symbol.stem}{number}"
        for symbol in ARM_SYMBOLS
        if bare in symbol.letters
    )
    return [symbol for symbol in symbols if symbol in available]
