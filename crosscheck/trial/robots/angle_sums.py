"""A difference of an entry as one wave of the joints' angles, in words."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from crosscheck.models.robot.robot import Robot

MOST_ANGLES = 7  # of which sums are tried: 3^n of them
FITS = 1e-8  # what a wave may leave of the difference


def describe_angle_sum(difference: np.ndarray, q: np.ndarray, robot: Robot) -> str:
    """The difference (states,) at q (states, n) in words, such as `-20.6 cos(j1)`; '' for no wave.

    A wave is of the sum of some angles, each with a sign; its factor may be one displacement.
    """
    joints = [robot.joints[number] for number in robot.coordinates]
    turning = [n for n, joint in enumerate(joints) if joint.kind == "revolute"]
    factors = {"": np.ones(len(q))}
    factors |= {f" {each.name}": q[:, n] for n, each in enumerate(joints) if n not in turning}
    size = float(np.abs(difference).max())
    if len(turning) > MOST_ANGLES or not size:
        return ""
    for signs in _signs(len(turning)):
        angle = q[:, turning] @ signs
        for name, factor in factors.items():
            columns = np.stack([factor * np.cos(angle), factor * np.sin(angle)], axis=1)
            fit, *_ = np.linalg.lstsq(columns, difference, rcond=1e-12)
            if np.abs(difference - columns @ fit).max() <= FITS * size:
                return _format_wave(
                    fit, _format_sum(signs, [joints[n].name for n in turning]), name
                )
    return ""


def _signs(count: int) -> Sequence[np.ndarray]:
    """Signs of angles in a sum, the sums of the fewest first; of two opposite ones there is one."""
    sign_vectors = [np.array(each, float) for each in product((0, 1, -1), repeat=count)]
    sign_vectors = [each for each in sign_vectors if not each.any() or each[each != 0][0] > 0]
    return sorted(sign_vectors, key=lambda each: np.abs(each).sum())


def _format_sum(signs: np.ndarray, names: Sequence[str]) -> str:
    pairs = [(sign, name) for sign, name in zip(signs, names, strict=True) if sign]
    text = "".join(f" {'+' if sign > 0 else '-'} {name}" for sign, name in pairs)
    return text.removeprefix(" + ")


def _format_wave(fit: np.ndarray, angle: str, factor: str) -> str:
    size = float(np.abs(fit).max())
    if not angle:
        return f"{fit[0]:.6g}{factor}"
    pairs = [(k, f"{name}({angle})") for k, name in zip(fit, ("cos", "sin"), strict=True)]
    kept = [(k, wave) for k, wave in pairs if abs(k) > FITS * size]
    first, *others = kept
    text = f"{first[0]:.6g}{factor} {first[1]}"
    return text + "".join(
        f" {'+' if k > 0 else '-'} {abs(k):.6g}{factor} {wave}" for k, wave in others
    )
