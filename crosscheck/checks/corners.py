"""States at the corners of the mesh laws, where random states seldom lie.

A contact law has a branch inside of the clearance and one on each flank, and damping may have more:
teeth that only just touch and move apart pull, ones that approach are pressed by the damper above
all. Whether teeth touch depends on x - e, not on x. Every mesh is brought to each side of these.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property, lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from crosscheck.checks.answers import Setting, States, generalized_force, sample_states
from crosscheck.checks.energy import springs_at
from crosscheck.checks.engines import plan_pair
from crosscheck.checks.first_principles.mesh_energy import MeshSpring
from crosscheck.checks.sampled import DIFFERENCE, Subjects, pair_models
from crosscheck.checks.scales import SLIDING_M_PER_S, geared_joints, mesh_damping
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import MESHES, Layout
from crosscheck.models.experiment.scenario import Switches
from crosscheck.planning.comparison import Comparison

POSES = 32  # random turns of a joint, of which that is taken at which a tooth error is largest
HALF = 0.5  # share of the way to the next branch, and of the usual sliding rate
METRIC = f"{DIFFERENCE} on each side of every branch of the mesh laws"
# Largest distance from a corner [m] if no damper, tooth error or clearance sets it.
FARTHEST_M = 1e-6


class CornerSetting(Setting):
    """An arm in a case at the corners of its mesh laws."""

    @cached_property
    def states(self) -> States:
        """A state for each of the corners."""
        arm, _, laws = self.case
        return sample_corner_states(self.layout, arm, laws, self.seed)


corner_force = replace(generalized_force, name="corner_force")


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of geared models' forces on each side of every branch of the mesh laws."""
    geared = [each for each in subjects.arms if each.group not in ("rigid", "form")]
    for pair in pair_models(geared):
        setting = pair[0].setting
        if setting.layout.mesh_joints:
            corners = CornerSetting(setting.case, setting.level, setting.count, setting.seed)
            left, right = (replace(each, setting=corners) for each in pair)
            yield plan_pair("states", corner_force, left, right, metric=METRIC)


class Corner(NamedTuple):
    """A side of each branch of a contact law.

    side: of sun or ring (0 or 1), the mesh whose tooth error is large; planet: from 0; flank: sign
    of x - e; direction: sign of x'; touching: whether the teeth touch, by less than d |x'| / k.
    """

    side: int
    planet: int
    flank: float
    direction: float
    touching: bool


def list_corners(layout: Layout, arm: Arm) -> list[Corner]:
    """The corners of all meshes: 8 for sun and for ring, of every planet if planets are free."""
    planets = max((arm.joints[joint].planet_count for joint in layout.mesh_joints), default=0)
    numbers = range(planets if layout.free else min(planets, 1))
    signs = (1.0, -1.0)
    places = product(range(len(MESHES)), numbers, signs, signs, (True, False))
    return [Corner(*place) for place in places]


def sample_corner_states(layout: Layout, arm: Arm, chosen: Switches, seed: int) -> States:
    """States on each side of every branch of the law of every mesh; none without meshes.

    Just in contact |x| is within the clearance, and just out of it |x| is beyond, where the tooth
    error is not 0. All else is random.

    Args:
        layout: The coordinates of the model.
        arm: The arm.
        chosen: The laws; the tooth error depends on the one of the phase.
        seed: Of what is random.

    Returns:
        A state for each of the corners, in their order.
    """
    return States(*map(np.copy, _find_corner_states(layout, arm, chosen, seed)))


@lru_cache(maxsize=16)  # every model of a layout is asked at the same ones
def _find_corner_states(layout: Layout, arm: Arm, chosen: Switches, seed: int) -> States:
    corners = list_corners(layout, arm)
    drawn = sample_states(layout, arm, POSES * len(corners), seed)
    if not corners:
        return drawn
    turned, theta = np.zeros_like(drawn.q), layout.theta
    time = np.repeat(drawn.t[::POSES], POSES)  # a corner's poses are all at its first one's time
    angles = time[:, None] * drawn.v if chosen.phase == "omega_t" else drawn.q
    turned[:, theta] = angles[:, theta]
    springs = [*springs_at(arm, chosen, layout, turned)]  # x is 0 there, so that a gap is -e
    states = []
    for number, corner in enumerate(corners):
        poses = slice(number * POSES, (number + 1) * POSES)
        there = (MeshSpring(s.backlash, s.stiffness[poses], s.gap[poses]) for s in springs)
        some = States(*(x[poses] for x in drawn))
        states.append(_move_to_corner(layout, arm, some, there, corner))
    return States(*map(np.array, zip(*states, strict=True)))


def _move_to_corner(
    layout: Layout, arm: Arm, poses: States, springs: Iterator[MeshSpring], corner: Corner
) -> tuple[float, np.ndarray, np.ndarray]:
    """One of random states with a planet's meshes of every joint at a corner: t, q (n,), v (n,).

    springs: of all meshes at the poses, the teeth centred.
    """
    t, q, v, theta = float(poses.t[0]), poses.q[0].copy(), poses.v[0].copy(), layout.theta
    for number, joint in geared_joints(arm):
        pairs = [(next(springs), next(springs)) for _ in range(joint.planet_count)]
        if corner.planet >= joint.planet_count:
            continue
        pair = pairs[corner.planet]
        inward = -1.0 if corner.touching else 1.0  # where an error makes |x| smaller than |x - e|
        pose = int(np.argmax(-corner.flank * inward * pair[corner.side].gap))
        place = theta[number]
        q[place], v[place] = poses.q[pose, place], poses.v[pose, place]
        rate = corner.direction * HALF * SLIDING_M_PER_S
        x = []
        for name, spring in zip(MESHES, pair, strict=True):
            error = -float(spring.gap[pose])
            pull = mesh_damping(joint, name, corner.planet) * abs(rate)
            lengths = pull / float(spring.stiffness[pose]), abs(error), spring.backlash, FARTHEST_M
            depth = HALF * min(length for length in lengths if length > 0)
            x.append(error + corner.flank * (spring.backlash - inward * depth))
        for values, (sun, ring) in ((q, x), (v, (rate, rate))):
            if layout.free:
                values[layout.at("x_s", number)] = sun + ring
                values[layout.at("x_pr", number, corner.planet)] = ring
            else:
                values[layout.at("x_sp", number)], values[layout.at("x_pr", number)] = sun, ring
    return t, q, v
