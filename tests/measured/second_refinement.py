"""A second program for links known by their file, gains and zeros: NumPy and Pinocchio alone.

Coupled rotors are armature of N (N - 1) J with moved inertias of links, by Pinocchio's regressor;
slopes in positions are differences of fourth order; least squares are solved by singular values of
rows and prior together, with all parameters of links.
"""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from crosscheck.identification.refinement import Knowledge
from crosscheck.recordings.record import Record
from tests.measured.second_robot import (
    Signals,
    identifiable,
    rows_alike,
    sample_rows,
    spread_of,
    weigh,
)

STEP = 1e-3


def find_deviations(signals: Signals) -> np.ndarray:
    """Of each joint's rows, counted by the number of those alike."""
    moving = signals.moving
    _, residual, _ = weigh(signals.table(), signals.torque, moving)
    shown = np.where(moving, residual, 0.0)
    return spread_of(shown, moving) * np.sqrt([rows_alike(signal) for signal in shown.T])


def add_rotors(model: pin.Model, table: np.ndarray, ratios: Sequence[float]) -> np.ndarray:
    """The table whose columns of armature are those of coupled rotors, N^2 J = 1."""
    count, table = model.nv, table.copy()
    for joint, ratio in enumerate(ratios):
        inertia, place = ratio**-2, 13 * count + joint
        axis = np.array(model.joints[joint + 1].shortname() == np.array(AXES), dtype=float)
        table[:, :, place] *= ratio * (ratio - 1) * inertia
        moves = [(joint, inertia * ratio)] + [(joint - 1, inertia * (1 - ratio))] * (joint > 0)
        for body, moment in moves:
            turned = moment * np.outer(axis, axis)  # frames of all bodies are parallel at rest
            parts = turned[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
            table[:, :, place] += table[:, :, 10 * body + 4 : 10 * body + 10] @ parts
    return table


AXES = ("JointModelRX", "JointModelRY", "JointModelRZ")


def prior_rows(model: pin.Model, share: float) -> tuple[np.ndarray, np.ndarray]:
    """One over the deviations of the links' parameters (10 n,), and what the file says of them."""
    mean, spread = [], []
    for body in list(model.inertias)[1:]:
        m, x, y, z, xx, xy, yy, xz, yz, zz = body.toDynamicParameters()
        mean += [m, x, y, z, xx, xy, yy, xz, yz, zz]
        moment = (xx + yy + zz) / 3
        spread += [m, *[np.sqrt(m * moment)] * 3, *[moment] * 6]
    return 1 / (share * np.array(spread)), np.array(mean)


def refine_again(
    urdf: str, given: Record, bandwidth: float, knowledge: Knowledge, ratios: Sequence[float] | None
) -> dict[str, tuple[float, float]]:
    """Estimates and standard errors by name; ratios: of coupled rotors, None for armature."""
    signals = sample_rows(urdf, given.time, given.position, given.motor_torque, bandwidth)
    model, count = signals.model, signals.q.shape[1]
    weights = signals.moving / find_deviations(signals)
    linear, late = 14 * count + 1, 14 * count
    kinds = ("offset", "viscous", "coulomb", "rotor" if ratios else "armature")
    joints = list(model.names)[1:]
    names = [f"{kind} of {name}" for kind in kinds for name in joints] + ["delay of all torques"]
    gains = count if "gains" in knowledge.unknown else 0
    turned = [] if "zeros" not in knowledge.unknown else [1, 2]
    if knowledge.links is None and turned:
        turned = [1]
    names += [f"drive gain of {name}" for name in joints[:gains]]
    names += [f"encoder zero of {joints[joint]}" for joint in turned]
    size = linear + gains + len(turned)
    state, prior, mean = np.zeros(size), np.zeros((0, size)), np.zeros(size)
    scale, values = prior_rows(model, knowledge.links or 1.0)
    state[: 10 * count] = values
    state[linear : linear + gains] = 1.0
    if knowledge.links is not None:
        prior = np.hstack([np.diag(scale), np.zeros((10 * count, size - 10 * count))])
        mean = state.copy()

    def table_at(zeros: np.ndarray) -> np.ndarray:
        table = signals.table(zeros)
        return add_rotors(model, table, ratios) if ratios else table

    for _ in range(8 if gains or turned else 1):
        zeros = np.zeros(count)
        zeros[turned] = state[linear + gains :]
        scales = state[linear : linear + gains] if gains else np.ones(count)
        table, plain = table_at(zeros), state[:linear].copy()
        plain[late] = 0.0
        scaled = table * scales[:, None]
        scaled[:, :, late] = table[:, :, late]
        parts = [scaled]
        if gains:
            parts.append((table @ plain)[:, :, None] * np.eye(count))
        for joint in turned:
            way = STEP * np.eye(count)[joint]
            far = [table_at(zeros + times * way) @ plain for times in (-2, -1, 1, 2)]
            slope = (far[0] - 8 * far[1] + 8 * far[2] - far[3]) / (12 * STEP)
            parts.append((slope * scales)[:, :, None])
        rows = np.concatenate(parts, axis=2) * weights[:, :, None]
        left = (signals.torque - scaled @ state[:linear]) * weights
        whole = np.vstack([rows.reshape(-1, size), prior])
        right = np.concatenate([left.ravel(), prior @ (mean - state)])
        length = np.linalg.norm(whole, axis=0)
        length = np.where(length > 1e-12 * length.max(), length, np.inf)
        u, singular, directions = np.linalg.svd(whole / length, full_matrices=False)
        able = singular > 1e-9 * singular[0]
        inverse = directions[able].T / singular[able] / length[:, None]
        state = state + inverse @ (u[:, able].T @ right)
    errors = np.sqrt((inverse**2).sum(axis=1))
    found = {
        name: (float(state[place]), float(errors[place]))
        for place, name in enumerate(names, 10 * count)
    }
    if knowledge.links is None:
        named = identifiable(model, count)[10 * count :]
        lost = [name for name, able in zip(names, named, strict=False) if not able]
        found = {name: pair for name, pair in found.items() if name not in lost}
    for name, (value, error) in found.items():
        if name.startswith("drive gain"):
            found[name] = (1 / value, error / value**2)
    return found
