"""A difference of an entry as one wave of the joints' angles, in words."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from crosscheck.models.robot.robot import Robot

MOST_ANGLES = 7  # largest number of angles whose sums are tried: 3^n of them
FITS = 1e-8  # largest residual of a fitted wave, relative to the difference


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
    signs = _list_signs(len(turning))
    angles = signs @ q[:, turning].T
    waves = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    columns = np.stack([factor * waves for factor in factors.values()], axis=1)
    rest = measure_rest(difference, columns[..., 0, :], columns[..., 1, :])
    near = np.sqrt(len(q)) * 10 * FITS * size  # no wave further off fits, whatever the rounding
    for wave, place in np.argwhere(rest <= near).tolist():
        fit, *_ = np.linalg.lstsq(columns[wave, place].T, difference, rcond=1e-12)
        if np.abs(difference - fit @ columns[wave, place]).max() <= FITS * size:
            angle = _format_sum(signs[wave], [joints[n].name for n in turning])
            return _format_wave(fit, angle, list(factors)[place])
    return ""


def measure_rest(difference: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The norm of what two columns (..., states) together leave of a difference (states,)."""
    rest = _remove_part(np.broadcast_to(difference, first.shape), first)
    return np.linalg.norm(_remove_part(rest, _remove_part(second, first)), axis=-1)


def _remove_part(values: np.ndarray, column: np.ndarray) -> np.ndarray:
    """The values (..., states) less their part along a column, which may be 0."""
    square = (column * column).sum(axis=-1, keepdims=True)
    part: np.ndarray = (values * column).sum(axis=-1, keepdims=True) / np.where(square, square, 1)
    return values - part * column


def _list_signs(count: int) -> np.ndarray:
    """Signs of angles in a sum, those of the fewest first; of two opposite ones there is one."""
    signs = np.array(list(product((0.0, 1.0, -1.0), repeat=count))).reshape(3**count, count)
    first = np.take_along_axis(signs, (signs != 0).argmax(axis=1)[:, None], 1) if count else signs
    signs = signs[(first >= 0).all(axis=1)]
    return signs[np.argsort(np.abs(signs).sum(axis=1), kind="stable")]


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
