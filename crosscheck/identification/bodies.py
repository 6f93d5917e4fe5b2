"""Links that are possible bodies: least squares over their logarithmic Cholesky parameters.

Mass density is nowhere negative if and only if the pseudo-inertia [[S, h], [h', m]] is positive
definite, where S is half the trace of the inertia less the inertia, h the first moments, m the
mass. So is U U' of every upper triangle U = exp(alpha) [[exp(d1), s12, s13, t1], [0, exp(d2), s23,
t2], [0, 0, exp(d3), t3], [0, 0, 0, 1]]: its ten numbers are free (Rucker and Wensing, 2022).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag, solve_triangular
from scipy.optimize import minimize

BODY = 10  # parameters of a body: m, h, and of I xx, xy, yy, xz, yz, zz
# Share of a body's mass and second moments in its file below which it is at the border.
BORDER = 1e-4
LIGHTEST = 1e-3  # mass of a link without one in its file, over the mean mass
AT_REST = 1e-6  # slope of half of chi squared per unit of logarithms, at rest
MOST_PASSES = 1000
LARGEST_STEP = 1.0  # step of logarithms: far away there are valleys that never rise again
ROUNDED = 1e-13  # share of the largest curvature below which an unknown is not shown
DIAGONAL = np.arange(3)
ABOVE = (0, 1, 0, 0, 1, 2), (1, 2, 2, 3, 3, 3)  # s12, s23, s13, t1, t2, t3


class Solution(NamedTuple):
    """Least squares' unknowns with their standard errors, and whether they came to rest."""

    state: np.ndarray
    errors: np.ndarray
    settled: bool


class BodyScale(NamedTuple):
    """Masses [kg] and radii of gyration [m] of bodies (bodies,) as their file has them."""

    mass: np.ndarray
    radius: np.ndarray


def pseudo_inertias(values: np.ndarray) -> np.ndarray:
    """Pseudo-inertias (bodies, 4, 4) of links' parameters (10 each)."""
    m, x, y, z, xx, xy, yy, xz, yz, zz = values.reshape(-1, BODY).T
    half = (xx + yy + zz) / 2
    rows = [[half - xx, -xy, -xz, x], [-xy, half - yy, -yz, y], [-xz, -yz, half - zz, z]]
    return np.moveaxis(np.array([*rows, [x, y, z, m]]), 2, 0)


# Links' parameters are sums over the entries of a pseudo-inertia, with these weights (10, 4, 4).
WEIGHTS = np.linalg.pinv(pseudo_inertias(np.eye(BODY)).reshape(BODY, 16)).T.reshape(BODY, 4, 4)


def find_scale(values: np.ndarray) -> BodyScale:
    """The scale of links' parameters (10 each); without mass or size, that of the other links."""
    mass = values.reshape(-1, BODY)[:, 0]
    mass = np.where(mass > 0, mass, LIGHTEST * mass.mean())
    moments = np.trace(_centre(pseudo_inertias(values)), axis1=1, axis2=2)
    radius = np.sqrt(np.maximum(moments, 0.0) / mass)
    has_size = radius > 0
    return BodyScale(
        mass, np.where(has_size, radius, radius[has_size].mean() if has_size.any() else 1.0)
    )


def find_thickness(values: np.ndarray, scale: BodyScale) -> np.ndarray:
    """The distance of bodies (bodies,) from the border; at most 0 if no body has such parameters.

    The least of mass and central second moments, in parts of the file's.
    """
    pseudo = pseudo_inertias(values)
    least = np.linalg.eigvalsh(_centre(pseudo))[:, 0]
    return np.minimum(pseudo[:, 3, 3] / scale.mass, least / (scale.mass * scale.radius**2))


def compute_parameters(logarithms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Links' parameters of alpha, d1, d2, d3, s12, s23, s13, t1, t2, t3 (10 each); their slopes."""
    values, slopes = [], []
    for row in logarithms.reshape(-1, BODY):
        upper, turns = _differentiate_triangle(row)
        changes = 2 * turns @ upper.T  # weights are symmetric, so half of each sum is enough
        values.append(np.tensordot(WEIGHTS, upper @ upper.T, 2))
        slopes.append(np.tensordot(WEIGHTS, changes, ((1, 2), (1, 2))))
    return np.concatenate(values), block_diag(*slopes)


def compute_curvature(logarithms: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    """Second derivatives (10 bodies, 10 bodies) of gradient times the links' parameters."""
    parts = []
    pairs = zip(logarithms.reshape(-1, BODY), gradient.reshape(-1, BODY), strict=True)
    for row, along in pairs:
        upper, turns = _differentiate_triangle(row)
        weights = np.tensordot(along, WEIGHTS, 1)
        pulled = weights @ turns
        part = 2 * np.tensordot(turns, pulled, ((1, 2), (1, 2)))
        # Second derivatives of the triangle: by alpha it is itself again, then by each d.
        again = 2 * np.tensordot(turns, weights @ upper, 2)
        part[0] += again
        part[1:, 0] += again[1:]
        part[1 + DIAGONAL, 1 + DIAGONAL] += again[1 + DIAGONAL]
        parts.append(part)
    return block_diag(*parts)


def solve_bodies(
    right: np.ndarray, slopes: np.ndarray, state: np.ndarray, is_link: np.ndarray
) -> Solution:
    """Linear least squares with links that are possible bodies, by Newton's steps in a region.

    Gauss and Newton's would creep: at the border the residual is not small along what bodies would
    have to be, and curvature there is that of the logarithms. All else follows from the links.

    Args:
        right: Residual at a state (rows,).
        slopes: Of what the unknowns make (rows, unknowns).
        state: Its links say where to begin, and how large they are.
        is_link: Which of its numbers are links' parameters, 10 of each in turn.
    """
    scale = find_scale(state[is_link])
    basis, triangle = np.linalg.qr(np.hstack([slopes[:, ~is_link], slopes[:, is_link]]))
    others = int((~is_link).sum())
    made = basis.T @ right + triangle[:, others:] @ state[is_link]
    target, links = made[others:], triangle[others:, others:]
    sizes = np.hstack([np.ones((len(scale.mass), 4)), np.repeat(scale.radius[:, None], 6, axis=1)])
    sizes = sizes.ravel()

    def measure(scaled: np.ndarray) -> tuple[float, np.ndarray]:
        """Half the sum of squares, and its gradient."""
        values, turns = compute_parameters(sizes * scaled)
        left = target - links @ values
        return float(left @ left) / 2, -(left @ links) @ turns * sizes

    def bend(scaled: np.ndarray) -> np.ndarray:
        """Second derivatives of the same."""
        values, turns = compute_parameters(sizes * scaled)
        changes = links @ turns
        along = -(target - links @ values) @ links
        curvature = changes.T @ changes + compute_curvature(sizes * scaled, along)
        return curvature * np.outer(sizes, sizes)

    least = minimize(
        measure,
        _find_logarithms(state[is_link], scale) / sizes,
        jac=True,
        hess=bend,
        method="trust-exact",
        options={
            "gtol": AT_REST,
            "maxiter": MOST_PASSES,
            "initial_trust_radius": LARGEST_STEP / 4,
            "max_trust_radius": LARGEST_STEP,
        },
    )
    values, turns = compute_parameters(sizes * least.x)
    new, errors = state.copy(), np.empty(len(state))
    new[is_link] = values
    upper = triangle[:others, :others]
    coupling = triangle[:others, others:]
    new[~is_link] += solve_triangular(upper, made[:others] - coupling @ values)
    curvatures, ways = np.linalg.eigh(bend(least.x))
    able = curvatures > ROUNDED * curvatures[-1]
    spread = turns @ (sizes[:, None] * ways[:, able]) / np.sqrt(curvatures[able])
    errors[is_link] = np.sqrt((spread**2).sum(axis=1))
    alone = solve_triangular(upper, np.hstack([np.eye(others), coupling @ spread]))
    errors[~is_link] = np.sqrt((alone**2).sum(axis=1))
    return Solution(new, errors, bool(least.success))


def _centre(pseudo: np.ndarray) -> np.ndarray:
    """Second moments of mass (bodies, 3, 3) about centres of mass; about the frame without mass."""
    first, mass = pseudo[:, :3, 3], pseudo[:, 3, 3, None, None]
    about = first[:, :, None] * first[:, None, :]
    return pseudo[:, :3, :3] - about / np.where(mass > 0, mass, np.inf)


def _differentiate_triangle(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangle (4, 4) of ten numbers, and its slopes (10, 4, 4)."""
    turns = np.zeros((BODY, 4, 4))
    turns[1 + DIAGONAL, DIAGONAL, DIAGONAL] = np.exp(row[1:4])
    turns[np.arange(4, BODY), *ABOVE] = 1.0
    unscaled = turns[1:4].sum(axis=0) + np.tensordot(row[4:], turns[4:], 1)
    unscaled[3, 3] = 1.0
    turns[0] = unscaled
    turns *= np.exp(row[0])
    return turns[0], turns


def _find_logarithms(values: np.ndarray, scale: BodyScale) -> np.ndarray:
    """The ten numbers of each possible body next to links' parameters, a little off the border."""
    rows = []
    for pseudo, mass, radius in zip(pseudo_inertias(values), *scale, strict=True):
        place = pseudo[:3, 3] / mass
        moments, axes = np.linalg.eigh(_centre(pseudo[None])[0])
        moments = np.maximum(moments / mass, BORDER * radius**2)
        turned = (axes * moments) @ axes.T
        # The factor of the matrix in reverse order, reversed, is an upper triangle.
        upper = np.linalg.cholesky(turned[::-1, ::-1])[::-1, ::-1]
        shears = upper[ABOVE[0][:3], ABOVE[1][:3]]
        rows.append([np.log(mass) / 2, *np.log(np.diag(upper)), *shears, *place])
    return np.array(rows).ravel()
