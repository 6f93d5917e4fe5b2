"""What a careful reader finds in the text itself: contradictions, and what is missing."""

from __future__ import annotations

from typing import NamedTuple


class Contradiction(NamedTuple):
    """Two places of the paper that cannot both be right, paraphrased."""

    first: str
    first_says: str
    second: str
    second_says: str


class Gap(NamedTuple):
    """A quantity that a reader needs and the paper does not give, and what this project does."""

    quantity: str
    needed_for: str
    here: str


CONTRADICTIONS = (
    Contradiction(
        "Section 1, end",
        "accumulated positioning errors are the main cause of the acceleration fluctuations",
        "Summary; Section 3.2",
        "tooth profile error is their main cause",
    ),
    Contradiction(
        "Section 3.2, on the third fluctuation",
        "it does not follow a sudden excitation and is self-excited",
        "Section 3.2, one sentence before",
        "the first three fluctuations are all excited by meshing impacts",
    ),
    Contradiction(
        "Section 3.2, first paragraph on Fig. 14",
        "three instances of fluctuation",
        "Section 3.2, next paragraph",
        "a fourth fluctuation, smaller than the previous three",
    ),
    Contradiction(
        "Section 3.2, text on Fig. 14",
        "the baseline model is dashed and the rigid model solid",
        "Fig. 14, caption",
        "the rigid model is dashed and the detailed model solid",
    ),
    Contradiction(
        "Section 5",
        "the fluctuation becomes more severe as the backlash grows",
        "Section 4.1; Section 5, next sentence",
        "the self-excited fluctuation recedes as the backlash grows; small backlash intensifies it",
    ),
    Contradiction(
        "Section 2.2",
        "seen from the carrier both pairs of meshing become fixed-axis gear trains",
        "Eqs. 12, 13",
        "two meshes of one planet have different meshing frequencies",
    ),
    Contradiction(
        "Eq. 4",
        "the mesh force contains the clearance function",
        "Eq. 15",
        "the mesh force with tooth error contains none, yet backlash is studied with it",
    ),
    Contradiction(
        "Table I",
        "a payload mass m_payload",
        "Eq. 19, a_2 and a_3 below Eq. 21",
        "m_p, which elsewhere is the mass of a planet",
    ),
    Contradiction(
        "Section 2.4",
        "the damping matrix is diagonal and positive definite",
        "Eqs. 16-22",
        "nothing in the model resists the rigid motion of the joints, so its two entries are zero",
    ),
    Contradiction(
        "Section 3.1",
        "the deviations appear tolerable",
        "Section 3.1, next sentence",
        "about 30 mm at the tip is considerable",
    ),
    Contradiction(
        "Section 4.1",
        "a clearance error accumulates when the arm goes back and forth",
        "Section 4.1, same paragraph",
        "with encoder feedback it is erased whenever the links turn back",
    ),
    Contradiction(
        "Section 4.1",
        "clearances of 0.1 mm and 6 mm are compared",
        "Section 4.1, next paragraph",
        "b, half of the clearance, goes from 5 to 3000 um: 0.1 mm is b = 50 um, not the smallest",
    ),
)
GAPS = (
    Gap("damping matrix D", "every fluctuation", "a damping ratio per mesh, swept 0.003 to 0.1"),
    Gap("sigma of Eq. 6", "every run, if Eq. 6 was used", "the exact dead zone, Eq. 5"),
    Gap(
        "contact ratio, k_max, k_min of Eq. 7",
        "Fig. 5",
        "contact ratio 1.5, the only one that fits",
    ),
    Gap("gains other than P = 1000, D = 400", "Fig. 10", "chosen and stated at the figure"),
    Gap("duration and rigid reference", "Fig. 15", "chosen and stated at the figure"),
    Gap("M of the rigid model, Eq. 1", "Figs. 6, 7, 14", "four levels, from links to coupled"),
    Gap("step of the Runge-Kutta integration", "every run", "1e-5 s, with its measured error"),
    Gap("how the phase of a varying frequency was integrated", "third fluctuation", "both laws"),
    Gap("rotary inertia of the ring", "Eq. 18", "zero, its effect in the errata"),
    Gap("rotor inertia of the motors", "Eqs. 16, 18", "zero, as in the paper"),
    Gap("starting angle of the carrier", "phases of Eqs. 8 and 14", "zero"),
)
