"""The links' equations without the gears' spin, in numbers.

With the absolute spin of every gear as a coordinate of its own, the mass matrix of the links has
nothing of the gears' spin in it: eliminating the displacements, which are constant combinations of
spin and angles, is exact and is done once. Left are, over absolute link angles Theta_k,
M_kl = m_kl cos(Theta_k - Theta_l) + G_kl and the lever W_k of the weight.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from crosscheck.analytic.derivation.bodies import build_bodies, rigid_bodies
from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.stage import DirectStage, Stage, stage_values
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout


class Links(NamedTuple):
    """Numbers of the links' equations: m, G (joints, joints) [kg m^2] and W (joints,) [kg m]."""

    coupling: np.ndarray
    constant: np.ndarray
    lever: np.ndarray

    @property
    def spread(self) -> bool:
        """Whether G has entries off its diagonal."""
        return bool((self.constant != np.diag(np.diag(self.constant))).any())


def build_links(arm: Arm, layout: Layout, level: str | None) -> Links:
    """Numbers of an arm's links' equations, with all its bodies or those of a rigid level."""
    stages = tuple(
        stage_values(j, link, float) for j, link in zip(arm.joints, arm.links, strict=True)
    )
    return _build_links(stages, arm.payload_mass_kg, layout, level)


@lru_cache(maxsize=128)
def _build_links(
    stages: tuple[Stage | DirectStage, ...], payload: float, layout: Layout, level: str | None
) -> Links:
    chain = Chain(stages, payload, layout)
    bodies = build_bodies(chain) if level is None else rigid_bodies(chain, level)
    centres = np.zeros((len(bodies), len(stages)))
    for row, body in zip(centres, bodies, strict=True):
        row[: len(body.centre)] = body.centre
    masses = np.array([body.mass for body in bodies], dtype=float)
    # The others spin by a displacement of their own.
    turned = [body for body in bodies if not body.angle[~layout.angular].any()]
    turns = np.array([body.angle[layout.theta] for body in turned], dtype=float)
    turns[:, :-1] -= turns[:, 1:]  # over absolute angles, in place of those between links
    inertias = np.array([body.inertia for body in turned], dtype=float)
    return Links(
        np.einsum("b,bi,bj->ij", masses, centres, centres),
        np.einsum("b,bi,bj->ij", inertias, turns, turns),
        np.einsum("b,bi->i", masses, centres),
    )
