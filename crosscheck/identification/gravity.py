"""Gravity as a record shows it: another direction than the file's is a base that is tilted."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees

import numpy as np

STANDARD = 9.81  # [m/s^2]
# Share of gravity's size by which a tilt may change it: on Earth it varies by half of that.
SIZE_SHARE = 0.01


@dataclass(frozen=True)
class GravityEstimate:
    """Gravity (3,) [m/s^2] in the base's frame.

    value, half_width: estimated, with halves of 95 % intervals; in_file: as the file has it; axes:
    those along which torques show it, two of a planar arm; along the others it is the file's.
    """

    value: np.ndarray
    half_width: np.ndarray
    in_file: np.ndarray
    axes: tuple[int, ...] = (0, 1, 2)

    @property
    def angle_deg(self) -> tuple[float, float] | None:
        """Angle to the file's direction and half of its interval [degrees]; None without one."""
        size, there = np.linalg.norm(self.value), np.linalg.norm(self.in_file)
        if not size or not there:
            return None
        ways = self.value / size, self.in_file / there
        angle = 2 * np.arctan2(np.linalg.norm(ways[0] - ways[1]), np.linalg.norm(ways[0] + ways[1]))
        across = ways[1] - (ways[1] @ ways[0]) * ways[0]
        across = across / (np.linalg.norm(across) or 1.0)
        # Components are shown by different torques: their errors are taken for independent.
        return degrees(angle), degrees(float(np.linalg.norm(across * self.half_width) / size))

    @property
    def is_tilted(self) -> bool:
        """Whether it has the file's size in another direction, beyond its interval.

        Where the file has none, the plane that torques show may be tilted by any angle.
        """
        size, there = np.linalg.norm(self.value), np.linalg.norm(self.in_file)
        if not size:
            return False
        allowed = np.abs(self.value) @ self.half_width / size + SIZE_SHARE * STANDARD
        angle = self.angle_deg
        if angle is None:
            over = size - STANDARD
            return bool((over if len(self.axes) < 3 else abs(over)) <= allowed)
        return bool(abs(size - there) <= allowed and angle[0] > angle[1])

    def describe(self) -> str:
        """The angle, and the gravity that alone explains the torques, in a sentence."""
        angle = self.angle_deg
        gravity = f"gravity {_format_vector(self.value, self.half_width)} m/s^2 in the base's frame"
        tail = (
            f"{gravity} (the file says {_format_vector(self.in_file)}) alone explains the torques"
        )
        if angle is None:
            return f"Is the base tilted? With the file's links {tail}."
        digits = max(0, min(6, int(1 - np.floor(np.log10(max(angle[1], 1e-6))))))
        # Seen from a base that turns, gravity turns the other way.
        axis = np.cross(self.value, self.in_file)
        about = _format_vector(np.round(axis / np.linalg.norm(axis), 2) + 0.0)
        return (
            f"The base is tilted by {angle[0]:.{digits}f} ± {angle[1]:.{digits}f} degrees about"
            f" {about}: with the file's links {tail}."
        )


def _format_vector(values: np.ndarray, half_width: np.ndarray | None = None) -> str:
    """Components, with halves of their intervals where there are any."""
    if half_width is None:
        return f"({', '.join(f'{value:.5g}' for value in values)})"
    widest = float(half_width.max())
    digits = max(0, min(9, int(1 - np.floor(np.log10(max(widest, 1e-9))))))
    return f"({', '.join(f'{value:.{digits}f}' for value in values)}) ± {widest:.{digits}f}"
