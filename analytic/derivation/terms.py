"""Equations of motion with an arm's numbers put in, as flat arrays.

Every planar chain's mass matrix is a sum of cosines of sums of joint angles, its bias a sum of
sines times products of two rates, its weight a sum of both. They become lists of terms,
the same for every form.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.derivation.bodies import Body
from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.efforts import drive_rows, mesh_rows
from crosscheck.analytic.derivation.lagrange import (
    build_bias_terms,
    build_mass_terms,
    build_weight_terms,
)
from crosscheck.analytic.derivation.stage import exact_fraction
from crosscheck.models.arm.arm import Arm


class Terms(NamedTuple):
    """Terms of the mass matrix, the bias and the weight, as flat arrays.

    M[row, col] += coeff cos(waves[wave] . q); bias[row] += coeff sin(waves[wave] . q) v_a v_b.

    waves (K, n); mass (terms, 3), bias (terms, 4) and weight (terms, 2) hold the integer indices
    row, col, wave; row, wave, a, b; and row, wave; the coefficients are in SI units, of a weight
    (terms, 2) those of cosine and sine. mesh_map (n, meshes) and drive_map (n, joints) turn mesh
    forces per planet [N] and output torques [N m] into generalized force. theta (joints,): places
    of the joint angles; friction (joints,) [N m s/rad].
    """

    angle_sums: np.ndarray
    mass: np.ndarray
    mass_coeff: np.ndarray
    bias: np.ndarray
    bias_coeff: np.ndarray
    weight: np.ndarray
    weight_coeff: np.ndarray
    mesh_map: np.ndarray
    drive_map: np.ndarray
    theta: np.ndarray
    friction: np.ndarray


def select_rigid_terms(terms: Terms) -> Terms:
    """The terms of theta alone, with every displacement at rest; theta has the places 0, 1, ...

    Mesh forces must be absent from the rows of theta, where they are not the constraints' own.
    """
    places = np.full(terms.angle_sums.shape[1], -1)
    places[terms.theta] = np.arange(terms.theta.size)
    mass, bias, weight = (
        places[terms.mass[:, :2]],
        places[terms.bias[:, [0, 2, 3]]],
        places[terms.weight[:, 0]],
    )
    if terms.mesh_map[terms.theta].any() or terms.angle_sums[:, places < 0].any():
        raise ValueError("mesh displacements act on the joints")
    of_mass, of_bias = (mass >= 0).all(axis=1), (bias >= 0).all(axis=1)
    return terms._replace(
        angle_sums=terms.angle_sums[:, terms.theta],
        mass=np.column_stack([mass, terms.mass[:, 2]])[of_mass],
        mass_coeff=terms.mass_coeff[of_mass],
        bias=np.column_stack([bias[:, 0], terms.bias[:, 1], bias[:, 1:]])[of_bias],
        bias_coeff=terms.bias_coeff[of_bias],
        weight=np.column_stack([weight, terms.weight[:, 1]])[weight >= 0],
        weight_coeff=terms.weight_coeff[weight >= 0],
        mesh_map=np.zeros((terms.theta.size, 0)),
        drive_map=np.ascontiguousarray(terms.drive_map[terms.theta]),
        theta=np.arange(terms.theta.size),
    )


def mass_matrices(terms: Terms, q: np.ndarray) -> np.ndarray:
    """Mass matrices M(q) (..., n, n) at coordinates q (..., n)."""
    n = q.shape[-1]
    values = terms.mass_coeff * np.cos(q @ terms.angle_sums.T)[..., terms.mass[:, 2]]
    matrices = np.zeros((*q.shape[:-1], n * n))
    for place, value in zip(
        terms.mass[:, 0] * n + terms.mass[:, 1], np.moveaxis(values, -1, 0), strict=True
    ):
        matrices[..., place] += value
    return matrices.reshape(*q.shape[:-1], n, n)


def inverse_dynamics(terms: Terms, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Torques M(q) a + C(q, v) v - friction - weight of a rigid arm; all (states, n)."""
    angles = q @ terms.angle_sums.T
    cosines, sines = np.cos(angles), np.sin(angles)
    torques = np.zeros_like(q)
    for (row, column, wave), coeff in zip(terms.mass, terms.mass_coeff, strict=True):
        torques[:, row] += coeff * cosines[:, wave] * a[:, column]
    for (row, wave, first, second), coeff in zip(terms.bias, terms.bias_coeff, strict=True):
        torques[:, row] += coeff * sines[:, wave] * v[:, first] * v[:, second]
    for (row, wave), (cosine, sine) in zip(terms.weight, terms.weight_coeff, strict=True):
        torques[:, row] -= cosine * cosines[:, wave] + sine * sines[:, wave]
    torques[:, terms.theta] += terms.friction * v[:, terms.theta]
    return torques


class AngleSums:
    """Numbers the distinct angle sums w . q; sign is the caller's business."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.numbers: dict[tuple[float, ...], int] = {}

    def number(self, angle_sum: Iterable[float]) -> int:
        """The number of a wave, the next free one if it is new."""
        return self.numbers.setdefault(tuple(map(float, angle_sum)), len(self.numbers))

    def table(self) -> np.ndarray:
        """All waves in the order of their numbers, shape (K, n)."""
        return np.array(list(self.numbers), dtype=float).reshape(-1, self.size)


def build_chain_terms(chain: Chain, bodies: Sequence[Body], arm: Arm) -> Terms:
    """The terms of an arm's chain in exact numbers, with these of its bodies."""
    links, n, angle_sums = chain.angles[1:], len(chain.layout), AngleSums(len(chain.layout))
    derived = build_mass_terms(bodies, links)
    # Sorted, M[i, j] and M[j, i] add up the same waves in the same order: they are the same.
    mass = {(i, j, angle_sums.number(w)): c for (i, j, w), c in sorted(derived.items())}
    bias = {
        (i, angle_sums.number(w), a, b): c for (i, w, a, b), c in build_bias_terms(derived).items()
    }
    g_x, g_y = map(exact_fraction, arm.gravity_m_per_s2)
    pulled = build_weight_terms(bodies, links, (g_x, g_y)) if g_x or g_y else {}
    weight = {(i, angle_sums.number(w)): pair for (i, w), pair in pulled.items()}
    mesh_map, drive_map = _columns(mesh_rows(chain), n), _columns(drive_rows(chain), n)
    return Terms(
        angle_sums.table(),
        indices(mass, 3),
        np.array([*mass.values()], dtype=float),
        indices(bias, 4),
        np.array([*bias.values()], dtype=float),
        indices(weight, 2),
        np.array([*weight.values()], dtype=float).reshape(-1, 2),
        mesh_map,
        drive_map,
        chain.layout.theta,
        np.array([joint.friction_N_m_s_per_rad for joint in arm.joints]),
    )


def indices(terms: Iterable[tuple[int, ...]], width: int) -> np.ndarray:
    """Indices of where the terms belong, shape (terms, width)."""
    return np.array([*terms], dtype=np.int64).reshape(-1, width)


def _columns(rows: Sequence[np.ndarray], n: int) -> np.ndarray:
    """Rows over the coordinates as columns, shape (n, rows)."""
    columns: Any = [row.astype(float) for row in rows]
    return np.ascontiguousarray(np.reshape(columns, (-1, n)).T)
