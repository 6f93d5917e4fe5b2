"""A rigid model as a user would hand it over, in a file of its own."""

from pathlib import Path

TWO_LINK = """
import ctypes, os, random, sys, time
from dataclasses import replace

import numpy as np

from crosscheck.testing import Coordinates, Equations


def two_link(arm):
    one, two = arm.links
    L1, L2, d1, d2, mp = one.length_m, two.length_m, one.com_m, two.com_m, arm.payload_mass_kg
    m1, m2 = (rod.cross_section_m2 * rod.density_kg_per_m3 * rod.length_m for rod in arm.links)
    I1, I2 = m1 * L1**2 / 12, m2 * L2**2 / 12
    own = I2 + m2 * d2**2 + mp * L2**2

    def mass_matrix(q):
        c = (m2 * d2 + mp * L2) * L1 * np.cos(q[1])
        return [[I1 + m1 * d1**2 + (m2 + mp) * L1**2 + own + 2 * c, own + c], [own + c, own]]

    def bias(q, v):
        s = (m2 * d2 + mp * L2) * L1 * np.sin(q[1])
        return [-s * (2 * v[0] * v[1] + v[1] ** 2), s * v[0] ** 2]

    return Equations(mass_matrix=mass_matrix, bias=bias, force=lambda torque: torque)
"""


def model_file(folder: Path, more: str = "", name: str = "mine.py") -> Path:
    """A file with ``two_link`` of the paper's arm, and more."""
    file = folder / name
    file.write_text(f"{TWO_LINK}\n\n{more}\n", encoding="utf-8")
    return file
