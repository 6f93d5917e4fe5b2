"""What the paper's text says, as data: for a program to compare with itself."""

from __future__ import annotations

from typing import NamedTuple


class SymbolDefinition(NamedTuple):
    """A symbol and the quantity that the paper gives it, and where."""

    symbol: str
    quantity: str
    where: str


DEFINITIONS = (
    SymbolDefinition("M", "inertia matrix of the links", "Eq. 1"),
    SymbolDefinition("M", "inertia matrix of links and gears", "Eq. 21"),
    SymbolDefinition("M", "inertia over a squared radius", "below Eq. 21, Table I"),
    SymbolDefinition("C", "velocity coupling matrix", "Eqs. 1, 21"),
    SymbolDefinition("D", "damping matrix", "Eqs. 1, 21"),
    SymbolDefinition("q", "angles of the rigid arm", "Eq. 1"),
    SymbolDefinition("q", "mesh displacements and angles", "Eq. 20"),
    SymbolDefinition("T", "torque on a link of the rigid arm", "Eqs. 1, 23, Section 3"),
    SymbolDefinition("T", "torque of a motor on its sun", "Eq. 22"),
    SymbolDefinition("n", "reduction ratio", "Section 2"),
    SymbolDefinition("z", "number of teeth", "Section 2"),
    SymbolDefinition("alpha", "pressure angle", "Eq. 2"),
    SymbolDefinition("r", "radius", "Eq. 2"),
    SymbolDefinition("r", "the ring, as an index", "Eq. 3"),
    SymbolDefinition("r_s", "base radius of the sun", "Eq. 2"),
    SymbolDefinition("r_p", "base radius of a planet", "Eq. 2"),
    SymbolDefinition("r_c", "carrier radius", "Eq. 2"),
    SymbolDefinition("x_sp", "difference of three displacements, named an error", "Eq. 3, Fig. 8"),
    SymbolDefinition("x_sp", "meshing displacement", "Section 3.2, Fig. 12"),
    SymbolDefinition("b", "half of the backlash clearance", "Section 2.1"),
    SymbolDefinition("k", "meshing stiffness", "Eq. 4"),
    SymbolDefinition("f_k", "clearance function", "Eqs. 4, 5"),
    SymbolDefinition("F", "mesh force", "Eqs. 4, 15"),
    SymbolDefinition("F", "vector of generalized forces", "Eqs. 21, 22"),
    SymbolDefinition("sigma", "sharpness of the tanh clearance function", "Eq. 6"),
    SymbolDefinition("T", "meshing period", "Eq. 7, Fig. 5"),
    SymbolDefinition("gamma", "phase difference among pairs", "Section 2.2"),
    SymbolDefinition("e", "contact ratio", "Eq. 7, Fig. 5"),
    SymbolDefinition("n", "number of harmonics", "Eq. 7"),
    SymbolDefinition("i", "number of a harmonic", "Eq. 7"),
    SymbolDefinition("i", "sun, planet or ring", "Eq. 10"),
    SymbolDefinition("i", "number of a joint", "Eqs. 15, 23, Table I"),
    SymbolDefinition("k_m", "mean meshing stiffness", "Eq. 8"),
    SymbolDefinition("k_a", "time-variant meshing stiffness, by its name", "below Eq. 8"),
    SymbolDefinition("k_a", "amplitude of that stiffness, by its place", "Eq. 8, Table I"),
    SymbolDefinition("omega_e", "meshing circular frequency", "Eqs. 8, 9"),
    SymbolDefinition("omega", "rate of a gear", "Eqs. 9, 10"),
    SymbolDefinition("omega", "rate of a joint, elsewhere theta'", "Section 3.1, Fig. 7"),
    SymbolDefinition("e", "tooth profile error", "Eq. 14"),
    SymbolDefinition("E", "amplitude of the tooth profile error, 5 um", "Eq. 14, Table I"),
    SymbolDefinition("E", "the given tooth error, about 10 um from peak to peak", "Section 3.1"),
    SymbolDefinition("T", "kinetic energy", "Eqs. 16-19"),
    SymbolDefinition("I", "rotary inertia", "Eqs. 16-19"),
    SymbolDefinition("m_p", "mass of a planet", "Eqs. 16, 18, m_j below Eq. 21"),
    SymbolDefinition("m_p", "payload mass", "Eq. 19, a_2 and a_3 below Eq. 21"),
    SymbolDefinition("m_payload", "payload mass", "Table I"),
    SymbolDefinition("L", "arm length", "Eqs. 17-19"),
    SymbolDefinition("l", "arm length", "Table I"),
    SymbolDefinition("d", "position of an arm's centre of mass", "Eqs. 17-19"),
    SymbolDefinition("m", "mass", "Section 2.4"),
    SymbolDefinition("J", "rotary inertia", "M = J / r^2 below Eq. 21"),
    SymbolDefinition("I'_c", "inertia turning with a link", "a_2 and a_3 below Eq. 21"),
    SymbolDefinition("I_cp", "inertia turning with a link", "below Eq. 21"),
    SymbolDefinition("a_1", "coefficients of M, a_11 and a_12", "below Eq. 21"),
    SymbolDefinition("a_2", "coefficient of M", "below Eq. 21"),
    SymbolDefinition("a_1", "cross-section of arm 1", "Table I"),
    SymbolDefinition("a_2", "cross-section of arm 2", "Table I"),
    SymbolDefinition("m", "module of the gears", "Table I"),
    SymbolDefinition("N", "reduction ratio", "Section 3"),
    SymbolDefinition("P", "proportional gain", "Eq. 23"),
    SymbolDefinition("D", "differential gain", "Eq. 23"),
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
QUIET_UM, SEPARATE_UM = 1.0, 500.0  # what Sections 4.2 and 4.1 say of 1 and 500 um
THICKNESS_SHARE = 1 / 3  # of the tooth that 6 mm are said to be nearly
# Section 3.1: what both joints deviate by, and what that is said to make at the tip.
DEVIATIONS_RAD, TIP_M = (0.02, 0.01), 0.03
