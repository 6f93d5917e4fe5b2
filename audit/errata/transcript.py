"""What the paper's text says, as data: for a program to compare with itself."""

from __future__ import annotations

from typing import NamedTuple


class SymbolDefinition(NamedTuple):
    """A symbol and the quantity that the paper gives it, and where."""

    symbol: str
    quantity: str
    where: str


# Of symbols that a reader can mistake: scalars of one section or table. Letters that a matrix or an
# index shares with a scalar are left out, and symbols that have one meaning in both models.
DEFINITIONS = (
    SymbolDefinition("T", "torque", "Eqs. 22, 23, Section 3"),
    SymbolDefinition("T", "meshing period", "Eq. 7, Fig. 5"),
    SymbolDefinition("T", "kinetic energy", "Eqs. 16-19"),
    SymbolDefinition("b", "half of the backlash clearance", "Section 2.1"),
    SymbolDefinition("k_m", "mean meshing stiffness", "Eq. 8"),
    SymbolDefinition("e", "contact ratio", "Eq. 7, Fig. 5"),
    SymbolDefinition("e", "tooth profile error", "Eqs. 14, 15"),
    SymbolDefinition("E", "amplitude of the tooth profile error, 5 um", "Eq. 14, Table I"),
    SymbolDefinition("E", "the given tooth error, about 10 um from peak to peak", "Section 3.1"),
    SymbolDefinition("m_p", "mass of a planet", "Eqs. 16, 18, m_j below Eq. 21"),
    SymbolDefinition("m_p", "payload mass, m_payload in Table I", "Eq. 19, a_2 and a_3"),
    SymbolDefinition("I'_c", "inertia turning with a link", "a_2 and a_3 below Eq. 21"),
    SymbolDefinition("I_cp", "inertia turning with a link", "below Eq. 21"),
    SymbolDefinition("a_1, a_2", "coefficients of M", "below Eq. 21"),
    SymbolDefinition("a_1, a_2", "cross-sections of the arms", "Table I"),
)
# Section 3: the detailed model's initial values.
INITIAL_VALUES = ("b", "b", "0", "b", "b", "0", "0", "0", "0", "0", "0")
# Below Eq. 21: what the abbreviations are made of.
MADE_OF = {
    "I_cip": ("I_ci", "m_pi", "r_ci", "I_i"),
    "r_cip": ("r_c",),
    "M_si": ("I_si", "r_si"),
    "M_pi": ("I_pi", "r_pi"),
    "M_ci": ("I_ci", "r_cip"),
    "m_j": ("m_s2", "m_p", "m_c2", "m_r2"),
    "a_1i": ("M_si", "M_pi", "r_cip"),
    "a_2": ("I'_c1", "m_1", "d_1", "m_2", "m_j", "m_p", "L_1"),
    "a_3": ("I'_c2", "m_2", "d_2", "m_p", "L_2"),
    "a_4": ("L_1", "a_6"),
    "a_5": ("m_1", "d_1", "m_2", "m_j", "m_p", "L_1"),
    "a_6": ("m_2", "d_2", "m_p", "L_2"),
}
# What the entries of M, C and F that are listed there name.
ENTRIES = ("M_si", "M_pi", "a_1i", "a_2", "a_3", "a_4", "r_cip", "r_si", "theta_2", "T_i", "F_i")
BACKLASHES_UM = (5.0, 10.0, 25.0, 50.0, 500.0, 1000.0, 3000.0)  # Section 4.1
TOOTH_ERRORS_UM = (1.6, 3.2, 5.0, 6.3)  # Section 4.2
QUIET_UM = 1.0  # what Section 4.2 says of 1 um
THICKNESS_SHARE = 1 / 3  # of the tooth that 6 mm are said to be nearly
# Section 3.1: what both joints deviate by, and what that is said to make at the tip.
DEVIATIONS_RAD, TIP_M = (0.02, 0.01), 0.03
