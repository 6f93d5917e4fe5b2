"""Virtual work: how mesh forces and torques act on the coordinates (Section 2.4)."""

from __future__ import annotations

import numpy as np

from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.stage import DirectStage, Stage
from crosscheck.models.arm.layout import MESHES


def mesh_rows(chain: Chain) -> list[np.ndarray]:
    """Rows of generalized force per force of one planet: sun-planet 1, planet-ring 1, ...

    Rows exist only for joints whose mesh displacements are coordinates; free planets follow one
    another.
    """
    return [
        row
        for joint, stage in chain.geared_joints
        if joint - 1 in chain.layout.mesh_joints
        for row in _stage_rows(chain, joint, stage)
    ]


def _stage_rows(chain: Chain, joint: int, stage: Stage) -> list[np.ndarray]:
    if not chain.layout.free:
        return [-stage.N * chain.row(mesh, joint) for mesh in MESHES]
    advance = chain.row("x_s", joint)
    planets = [chain.row("x_pr", joint, planet + 1) for planet in range(int(stage.N))]
    return [row for x_pr in planets for row in (x_pr - advance, -x_pr)]


def drive_rows(chain: Chain) -> list[np.ndarray]:
    """Rows of generalized force per output torque: T / n on the sun, back on the previous link.

    Without mesh displacements, and without gears, that is the torque on the joint itself.
    """
    rows = []
    for joint, stage in zip(chain.numbers, chain.stages, strict=True):
        if isinstance(stage, DirectStage) or joint - 1 not in chain.layout.mesh_joints:
            rows.append(chain.row("theta", joint))
        else:
            rows.append(chain.sun_row(joint) / stage.n)
    return rows
