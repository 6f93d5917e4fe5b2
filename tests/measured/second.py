"""A second program for an arm's torques and runs: NumPy, and of crosscheck an engine alone.

Of the content of an arm's TOML file, of two geared joints: torques by Pinocchio's engine, with
which `compare` estimates nothing; of a record's CSV file: splines by de Boor's recursion, their
noise in an orthonormal basis, runs by a closed form of the equations of motion.
"""

from collections.abc import Mapping
from copy import deepcopy
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import validate_record
from crosscheck.models.robot.planar import build_planar_robot
from crosscheck.recordings.record import Record
from crosscheck.registry import build_robot_model
from tests.measured.records import name_columns, sum_sines, write_table

DEGREE = 5


class Bodies:
    """The arm with coupled rotors, by Pinocchio."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        robot = build_planar_robot(validate_record(Arm, content, "unlike"))
        self.model, self.friction = build_robot_model("pinocchio", robot, "coupled"), robot.friction

    def torques(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Torques of the motors (rows, 2) [N m]."""
        return self.model.inverse_dynamics(q, v, a)

    def closed_form(self) -> np.ndarray:
        """Coefficients of M's, the rates' and the weights' sines and cosines, as one array."""
        straight, bent = self.model.mass_matrix(np.array([[0.0, 0.0], [0.0, np.pi / 2]]))
        inner, outer = self.model.gravity(np.array([[0.0, 0.0], [np.pi / 2, 0.0]])).T
        lever = straight[0, 1] - bent[0, 1]
        return np.array([*bent.ravel(), lever, *(inner - outer), *outer, *self.friction])


def value_at(content: Mapping[str, Any], path: str) -> float:
    """The number at a path."""
    inside, last = _find_owner(content, path)
    return float(inside[last])


def with_value(content: Mapping[str, Any], path: str, value: float) -> Mapping[str, Any]:
    """The content with another number at a path."""
    changed = deepcopy(content)
    inside, last = _find_owner(changed, path)
    inside[last] = value
    return changed


def _find_owner(content: Any, path: str) -> tuple[Any, str]:
    """The table that a path's last name is in, and that name."""
    *way, last = path.split(".")[1:]
    for step in way:
        content = content[int(step) if step.isdigit() else step]
    return content, last


def splines(time: np.ndarray, knots: np.ndarray, degree: int, derivative: int = 0) -> np.ndarray:
    """B-splines or their derivatives at times (rows, size), by the recursion in their degree."""
    if derivative:
        below = splines(time, knots, degree - 1, derivative - 1)
        spans = np.array([knots[i + degree] - knots[i] for i in range(len(knots) - degree)])
        share = np.divide(degree, spans, out=np.zeros_like(spans), where=spans > 0)
        return below[:, :-1] * share[:-1] - below[:, 1:] * share[1:]
    if degree == 0:
        last = np.flatnonzero(knots < knots[-1])[-1]
        found = (knots[:-1] <= time[:, None]) & (time[:, None] < knots[1:])
        found[time == knots[-1], last] = True
        return found.astype(float)
    below, found = splines(time, knots, degree - 1), []
    for i in range(len(knots) - degree - 1):
        rise, fall = knots[i + degree] - knots[i], knots[i + degree + 1] - knots[i + 1]
        left = (time - knots[i]) / rise * below[:, i] if rise else 0 * time
        right = (knots[i + degree + 1] - time) / fall * below[:, i + 1] if fall else 0 * time
        found.append(left + right)
    return np.column_stack(found)


def knots_of(time: np.ndarray, spacing: int) -> np.ndarray:
    """Knots with equally many samples between them."""
    count = max(round((len(time) - 1) / spacing), 1)
    inner = np.interp(np.linspace(0, len(time) - 1, count + 1), np.arange(len(time)), time)
    return np.array([inner[0]] * DEGREE + [*inner] + [inner[-1]] * DEGREE)


def spacing_of(time: np.ndarray, angles: np.ndarray) -> int:
    """Half of the most samples between knots that leave no more than noise (8192 rows at most)."""
    possible = [2**power for power in range(2, 11) if len(time) >= 8 * 2**power]
    variances = []
    for spacing in possible:
        basis = splines(time, knots_of(time, spacing), DEGREE)
        variances.append(_noise(np.linalg.qr(basis)[0], angles) ** 2)
    limit = (1 + 3 * np.sqrt(2 / len(time))) * variances[0]
    enough = 0
    while enough + 1 < len(possible) and (variances[enough + 1] <= limit).all():
        enough += 1
    return possible[max(enough - 1, 0)]


def _noise(ortho: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """Standard deviation about the splines, for as many degrees of freedom as they leave."""
    apart = signal - ortho @ (ortho.T @ signal)
    return np.sqrt((apart**2).sum(axis=0) / (len(ortho) - ortho.shape[1]))


class Piece(NamedTuple):
    """Rows with their spline; ortho, first: of the orthonormal basis and slopes, (rows, size)."""

    time: np.ndarray
    recorded: np.ndarray
    torques: np.ndarray
    ortho: np.ndarray
    first: np.ndarray
    angle_noise: np.ndarray
    torque_noise: np.ndarray

    @property
    def motion(self) -> tuple[np.ndarray, np.ndarray]:
        """Angles and rates (rows, joints)."""
        places = self.ortho.T @ self.recorded
        return self.ortho @ places, self.first @ places


def pieces(time: np.ndarray, angles: np.ndarray, torques: np.ndarray, spacing: int) -> list[Piece]:
    """The record in pieces of some 64 intervals between knots."""
    count = max(round(len(time) / (64 * spacing)), 1)
    edges = np.linspace(0, len(time), count + 1).round().astype(int)
    found = []
    for begin, end in pairwise(edges):
        own = slice(begin, end)
        knots = knots_of(time[own], spacing)
        basis, slopes = (splines(time[own], knots, DEGREE, order) for order in range(2))
        ortho, upper = np.linalg.qr(basis)
        first = np.linalg.solve(upper.T, slopes.T).T
        noises = _noise(ortho, angles[own]), _noise(ortho, torques[own])
        found.append(Piece(time[own], angles[own], torques[own], ortho, first, *noises))
    return found


class Runs:
    """Runs from the states of a record file by an arm with other contents than made it."""

    def __init__(
        self, path: Path, content: Mapping[str, Any], tolerances: Mapping[str, float]
    ) -> None:
        self.content, self.tolerances = content, tolerances
        time, *columns = np.loadtxt(path, delimiter=",", skiprows=1).T
        angles, torques = np.column_stack(columns[:2]), np.column_stack(columns[2:])
        self.pieces = pieces(time, angles, torques, spacing_of(time, angles))

    def windows(self) -> list[dict[str, Any]]:
        """Runs in the terms of ASME V&V 20, one in each piece."""
        return [self._window(piece) for piece in self.pieces]

    def _window(self, piece: Piece) -> dict[str, Any]:
        rows = len(piece.time)
        edge = rows // 8
        inner = slice(edge, rows - edge)
        clock, torques = piece.time[inner] - piece.time[edge], piece.torques[inner]
        smooth, rates = piece.motion
        of_data = np.linalg.norm(piece.ortho[inner], axis=1)[:, None] * piece.angle_noise
        of_slope = np.linalg.norm(piece.first[edge]) * piece.angle_noise
        nominal = Bodies(self.content).closed_form()
        runs = [(nominal, smooth[edge], rates[edge], torques)]
        draw = np.random.default_rng(0)
        for _ in range(32):
            q, v = smooth[edge] + draw.normal(size=2) * of_data[0], draw.normal(size=2) * of_slope
            noise = piece.torque_noise * draw.normal(size=torques.shape)
            runs.append((nominal, q, rates[edge] + v, torques + noise))
        bent = torques.copy()
        bent[1:-1] -= (torques[2:] - 2 * torques[1:-1] + torques[:-2]) / 12
        runs.append((nominal, smooth[edge], rates[edge], bent))
        for path, share in self.tolerances.items():
            other = with_value(self.content, path, value_at(self.content, path) * (1 + share))
            runs.append((Bodies(other).closed_form(), smooth[edge], rates[edge], torques))
        steps = max(len(clock) - 1, 1000)
        found = integrated(runs, clock, steps)
        finer = integrated(runs[:1], clock, 2 * steps)[0]
        apart = found - found[0]
        inputs = np.sqrt((apart[1:33] ** 2).mean(axis=0) + (apart[33:] ** 2).sum(axis=0))
        numerical, error = np.abs(found[0] - finer), finer - smooth[inner]
        validation = np.sqrt(numerical**2 + inputs**2 + of_data**2)
        outside = (np.abs(error) > 3 * validation).any(axis=1)
        last = int(np.argmax(outside)) if outside.any() else len(clock) - 1
        return {
            "from_s": piece.time[edge],
            "to_s": piece.time[rows - edge - 1],
            "stays_s": clock[last],
            "within_2_u_val": float((np.abs(error) <= 2 * validation).mean()),
            "last_E": error[-1],
            "last_u_num": numerical[-1],
            "last_u_input": inputs[-1],
            "last_u_D": of_data[-1],
            "last_u_val": validation[-1],
            "E": error,
            "u_val": validation,
        }


def integrated(
    runs: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]], clock: np.ndarray, steps: int
) -> np.ndarray:
    """Angles (runs, rows, 2) of Runge and Kutta's fourth-order method, all runs side by side."""
    forms = np.array([form for form, *_ in runs]).T
    q, v = (np.array([run[place] for run in runs]) for place in (1, 2))
    step = clock[-1] / steps
    halves = np.arange(2 * steps + 1) * step / 2
    driven = np.array(
        [
            [np.interp(halves, clock, torques[:, joint]) for joint in range(2)]
            for *_, torques in runs
        ]
    )

    def acceleration(half: int, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        m11, m12, _, m22, lever, across, along, tip_across, tip_along, one, two = forms
        cosine, sine = np.cos(q[:, 1]), np.sin(q[:, 1])
        torque = driven[:, :, half] - np.column_stack([one * v[:, 0], two * v[:, 1]])
        turned = q[:, 0] + q[:, 1]
        outer = tip_across * np.cos(turned) + tip_along * np.sin(turned)
        torque[:, 0] -= across * np.cos(q[:, 0]) + along * np.sin(q[:, 0]) + outer
        torque[:, 0] += lever * sine * (2 * v[:, 0] + v[:, 1]) * v[:, 1]
        torque[:, 1] -= outer + lever * sine * v[:, 0] ** 2
        a, b, d = m11 + 2 * lever * cosine, m12 + lever * cosine, m22
        solved = d * torque[:, 0] - b * torque[:, 1], a * torque[:, 1] - b * torque[:, 0]
        return np.column_stack(solved) / (a * d - b * b)[:, None]

    places, slopes = [q], [v]
    for number in range(steps):
        at = 2 * number
        k1 = acceleration(at, q, v)
        k2 = acceleration(at + 1, q + step / 2 * v, v + step / 2 * k1)
        k3 = acceleration(at + 1, q + step / 2 * (v + step / 2 * k1), v + step / 2 * k2)
        k4 = acceleration(at + 2, q + step * (v + step / 2 * k2), v + step * k3)
        q = q + step * v + step**2 / 6 * (k1 + k2 + k3)
        v = v + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        places.append(q)
        slopes.append(v)
    whole, rates = np.array(places), np.array(slopes)
    left = np.minimum((clock / step + 1e-9).astype(int), steps - 1)
    part = (clock - left * step)[:, None, None] / step
    one, other = whole[left], whole[left + 1]
    first, last = step * rates[left], step * rates[left + 1]
    found = one + part * first + part**2 * (3 * (other - one) - 2 * first - last)
    return (found + part**3 * (2 * (one - other) + first + last)).transpose(1, 0, 2)


def write_record(path: Path, content: Mapping[str, Any]) -> None:
    """A record at uneven times, with noise unlike at its joints."""
    draw = np.random.default_rng(4)
    time = np.cumsum(draw.uniform(2.5e-3, 3.5e-3, ROWS))
    rates = 2 * np.pi * np.array([[0.7, 1.9], [0.9, 2.6]])
    sizes, phases = np.array([[0.5, 0.12], [0.7, 0.1]]), np.array([[0.3, 1.1], [2.0, 4.0]])
    q, v, a = sum_sines(time, sizes, rates, phases)
    torques = Bodies(content).torques(q, v, a)
    q = q + np.array([2e-5, 6e-6]) * draw.normal(size=q.shape)
    torques = torques + np.array([0.4, 0.07]) * draw.normal(size=q.shape)
    write_table(path, name_columns(Record("made", time, q, torques)))


ROWS = 800
