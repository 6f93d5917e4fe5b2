"""Coulomb and viscous friction of every joint that would explain a record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.errors import InputError
from crosscheck.recordings.parameters import NORMAL, Parameter, change_parameters
from crosscheck.recordings.residual import NormalEquations

LEAST_EIGENVALUE = 1e-8  # of an eigenvalue of the scaled equations: less is rounding


@dataclass(frozen=True)
class JointFriction:
    """Friction of a joint, counted from 1, with halves of 95 % intervals.

    coulomb [N m]: size of the torque against the motion; viscous [N m s/rad]; in_file: the viscous
    friction of the arm file, which has no Coulomb friction.
    """

    joint: int
    coulomb: float
    coulomb_half_width: float
    viscous: float
    viscous_half_width: float
    in_file: float


@dataclass(frozen=True)
class FrictionFit:
    """A level with the friction of all joints estimated at once.

    better: by how much chi squared falls; left: what it is then, per degree of freedom; arm: with
    this viscous friction; None where a friction is negative beyond its interval.
    """

    level: str
    joints: tuple[JointFriction, ...]
    better: float
    left: float
    arm: Arm | None

    @property
    def coulomb(self) -> np.ndarray:
        """Coulomb friction (joints,) [N m]."""
        return np.array([each.coulomb for each in self.joints])


def fit_friction(
    normal: NormalEquations, level: str, arm: Arm, among: Sequence[Parameter]
) -> FrictionFit:
    """The friction of all joints that explains most; normal: Coulomb friction's columns last."""
    joints = len(arm.joints)
    paths = [f"arm.joints.{joint}.friction_N_m_s_per_rad" for joint in range(joints)]
    places = [parameter.path for parameter in among]
    count = len(normal.right)
    chosen = [*(places.index(path) for path in paths), *range(count - joints, count)]
    matrix, right = normal.matrix[np.ix_(chosen, chosen)], normal.right[chosen]
    size = np.sqrt(np.where(np.diag(matrix) > 0, np.diag(matrix), 1.0))  # of a joint that stands
    inverse = np.linalg.pinv(matrix / np.outer(size, size), rcond=LEAST_EIGENVALUE, hermitian=True)
    covariance = inverse / np.outer(size, size)
    more = covariance @ right
    better = float(right @ more)
    left = normal.left(better)
    half = NORMAL * np.sqrt(max(left, 1.0) * np.diag(covariance))
    in_file = np.array([joint.friction_N_m_s_per_rad for joint in arm.joints])
    viscous, coulomb = in_file + more[:joints], more[joints:]
    frictions = tuple(
        JointFriction(number + 1, *map(float, row))
        for number, row in enumerate(
            zip(coulomb, half[joints:], viscous, half[:joints], in_file, strict=True)
        )
    )
    possible = (viscous + half[:joints] >= 0).all() and (coulomb + half[joints:] >= 0).all()
    values = {path: max(float(value), 0.0) for path, value in zip(paths, viscous, strict=True)}
    return FrictionFit(
        level, frictions, better, left, _change_arm(arm, values) if possible else None
    )


def _change_arm(arm: Arm, values: dict[str, float]) -> Arm | None:
    try:
        return change_parameters(arm, values)
    except InputError:
        return None
