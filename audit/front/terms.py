"""What the page's words mean, in numbers: teeth counted, and teeth by the paper's formula."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.audit.experiments.torque import RING_CYCLES
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.course import course_of
from crosscheck.audit.measures.rigid import rigid_arm
from crosscheck.audit.page.material import Material

TURN = 2 * np.pi


class TeethPassed(NamedTuple):
    """Of the shoulder in the controlled motion, (times,): how many, and how many a second.

    angle, rate: as they pass, z_r theta and its rate; clock, clock_rate: z_r theta' t and its rate.
    """

    time: np.ndarray
    angle: np.ndarray
    rate: np.ndarray
    clock: np.ndarray
    clock_rate: np.ndarray


def teeth_passed(material: Material) -> TeethPassed:
    """Of the rigid arm, whose motion has no vibration. Raises Diverged."""
    variant = material.scale.cut(rigid_arm(Variant()))
    run = course_of(material.study.runs([variant], "teeth that pass")[variant])
    time, factor = run.time, RING_CYCLES / TURN
    theta, speed, acceleration = (
        signal[:, 0] for signal in (run.theta, run.theta_dot, run.theta_ddot)
    )
    return TeethPassed(
        time,
        factor * theta,
        factor * speed,
        factor * speed * time,
        factor * (speed + acceleration * time),
    )
