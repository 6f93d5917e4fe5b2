"""The links' equations without the gears' spin, in numbers.

With the absolute spin of every gear as a coordinate of its own, the mass matrix of the links has
nothing of the gears' spin in it: eliminating the displacements, which are constant combinations of
spin and angles, is exact and is done once. Left are, over absolute link angles Theta_k,
M_kl = m_kl cos(Theta_k - Theta_l) + G_kl and the lever W_k of the weight.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.derivation.bodies import Body, build_bodies
from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.rigid import rigid_bodies
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
    joints = len(stages)
    links = Links(np.zeros((joints, joints)), np.zeros((joints, joints)), np.zeros(joints))
    for body in bodies:
        _add_body(body, layout, links)
    return links


def _add_body(body: Body, layout: Layout, links: Links) -> None:
    centre = np.array(body.centre, dtype=float)
    reached = slice(len(centre))
    links.coupling[reached, reached] += body.mass * (centre[:, None] * centre)
    links.lever[reached] += body.mass * centre
    if not body.angle[~layout.angular].any():  # else it spins by a displacement of its own
        row = absolute_row(body.angle[layout.theta])
        links.constant[:] += body.inertia * (row[:, None] * row)


def absolute_row(row: Any) -> np.ndarray:
    """A row over joint angles, relative to the link before, as one over absolute angles."""
    values = np.array(row, dtype=float)
    values[:-1] -= values[1:]
    return values
