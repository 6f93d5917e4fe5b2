"""Lagrange's equations for planar chains.

A planar chain of links with absolute angles Theta_k places every body's centre at
sum_k c_k e(Theta_k), e being the unit vector along link k. Its velocity is sum_k c_k n(Theta_k)
Theta_k', with n normal to e, and n(Theta_k) . n(Theta_l) = cos(Theta_k - Theta_l). So the mass
matrix sum J^T m J has only cosines of differences of absolute angles in it, the bias only their
sines, and neither needs simplification: both are lists of waves, sums w . q of joint angles with
whole w, and their coefficients, symbols or exact fractions alike.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from crosscheck.analytic.derivation.bodies import Body

AngleSum = tuple[int, ...]  # w, shape (n,), its first entry that is not 0 positive
MassTerms = Mapping[tuple[int, int, AngleSum], Any]  # M[row, col] += coefficient cos(w . q)
# bias[row] += coefficient sin(w . q) v_a v_b
BiasTerms = Mapping[tuple[int, AngleSum, int, int], Any]
# force[row] += coefficient cos(w . q), and another sin(w . q)
WeightTerms = Mapping[tuple[int, AngleSum], tuple[Any, Any]]


def build_mass_terms(bodies: Iterable[Body], links: Sequence[np.ndarray]) -> MassTerms:
    """M(q) = sum over bodies of J_v^T m J_v + J_w^T I J_w, as waves.

    links: row of each link's absolute angle.
    """
    terms: defaultdict[tuple[int, int, AngleSum], Any] = defaultdict(int)
    for body in bodies:
        _add_product(terms, body.inertia, 0 * links[0], body.angle, body.angle)
        for k, c_k in enumerate(body.centre):
            for j, c_j in enumerate(body.centre):
                overlap = links[k] - links[j]
                _add_product(terms, body.mass * c_k * c_j, overlap, links[k], links[j])
    return {place: coefficient for place, coefficient in terms.items() if coefficient != 0}


def _add_product(
    terms: defaultdict[tuple[int, int, AngleSum], Any],
    factor: Any,
    angle_sum: np.ndarray,
    left: np.ndarray,
    right: np.ndarray,
) -> None:
    """Add factor cos(wave . q) left^T right to the mass matrix."""
    oriented, columns = _orient_angle_sum(angle_sum)[0], [*enumerate(right.tolist())]
    for row, first in enumerate(left.tolist()):
        for column, second in columns:
            if first and second:
                terms[row, column, oriented] += factor * first * second


def _orient_angle_sum(angle_sum: np.ndarray) -> tuple[AngleSum, int]:
    """The wave, or its opposite with the sign that its sine takes."""
    first = next((int(entry) for entry in angle_sum if entry), 1)
    sign = 1 if first > 0 else -1
    return tuple(sign * int(entry) for entry in angle_sum), sign


def build_bias_terms(mass: MassTerms) -> BiasTerms:
    """C(q, v) v by Christoffel's symbols: sum (dM_ij/dq_k - 1/2 dM_jk/dq_i) v_j v_k, as waves."""
    terms: defaultdict[tuple[int, AngleSum, int, int], Any] = defaultdict(int)
    for (i, j, angle_sum), coefficient in mass.items():
        for k in map(int, np.flatnonzero(angle_sum)):
            slope = -coefficient * angle_sum[k]
            terms[i, angle_sum, min(j, k), max(j, k)] += slope
            terms[k, angle_sum, min(i, j), max(i, j)] -= slope / 2
    return {place: coefficient for place, coefficient in terms.items() if coefficient != 0}


def build_weight_terms(
    bodies: Iterable[Body], links: Sequence[np.ndarray], gravity: tuple[Any, Any]
) -> WeightTerms:
    """-dV/dq of V = -sum m g . r, as waves: links are pulled across themselves, by m c_k g . n."""
    g_x, g_y = gravity
    terms: defaultdict[tuple[int, AngleSum], tuple[Any, Any]] = defaultdict(lambda: (0, 0))
    for body in bodies:
        for k, c_k in enumerate(body.centre):
            angle_sum, sign = _orient_angle_sum(links[k])
            for row in np.flatnonzero(links[k]):
                lever = body.mass * c_k * links[k][row]
                cosine, sine = terms[int(row), angle_sum]
                terms[int(row), angle_sum] = cosine + lever * g_y, sine - sign * lever * g_x
    return {place: pair for place, pair in terms.items() if pair != (0, 0)}
