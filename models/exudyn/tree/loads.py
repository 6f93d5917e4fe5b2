"""All forces on the Exudyn tree in one call from the engine: meshes, motors and friction.

What such a call costs is getting in and out of Python, not the forces. So time, coordinates, rates
and forces share one array, and what the forces depend on two more: numba unwraps every array it is
passed anew in every call.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from struct import Struct
from typing import Any, NamedTuple

import numpy as np
from numba import typeof

from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.experiment import drive as drives
from crosscheck.models.experiment.drive import DriveData
from crosscheck.models.exudyn.engine import UserFunction
from crosscheck.models.exudyn.tree import mesh
from crosscheck.models.exudyn.tree.mesh import Gearing, StageCoordinates
from crosscheck.models.numba_cache import njit

joint_torque: Any = njit(cache=True, inline="always")(drives.joint_torque)
SIZES = 7  # entries of LoadArrays.places before its tables


class Joints(NamedTuple):
    """What acts between the links, one row per joint (joints,).

    links, driven: tree coordinates of the link and of what its motor turns; ratios: torque at the
    link over the motor's; friction [N m s/rad].
    """

    links: np.ndarray
    driven: np.ndarray
    ratios: np.ndarray
    friction: np.ndarray


class LoadArrays(NamedTuple):
    """Gearing, drive and joints end to end, as ``unpack_loads`` cuts them up again.

    numbers: float64; places: int64, first of all the SIZES: stages, planets, longest law, joints,
    rows of the drive's table, and the two values of the laws that are no tables.
    """

    numbers: np.ndarray
    places: np.ndarray


def build_joints(arm: Arm, stages: Sequence[StageCoordinates]) -> Joints:
    """Motors and friction of the arm's joints."""
    ratios = [
        joint.ring_teeth / joint.sun_teeth + 1 if isinstance(joint, Planetary) else 1.0
        for joint in arm.joints
    ]
    return Joints(
        np.array([stage.link for stage in stages]),
        np.array([stage.driven for stage in stages]),
        np.array(ratios),
        np.array([joint.friction_N_m_s_per_rad for joint in arm.joints]),
    )


def pack_loads(gears: Gearing, drive: DriveData, joints: Joints) -> LoadArrays:
    """Gearing, drive and joints packed end to end into flat arrays."""
    sizes = [*gears.places.shape[:1], *gears.sun_laws.shape, *drive.table_torque.shape]
    laws = [gears.sun_laws, gears.ring_laws, drive.gains, drive.table_time, drive.table_torque]
    head = np.array([*sizes, drive.code, gears.conservative])
    places = [head, gears.places, joints.links, joints.driven]
    return LoadArrays(
        np.concatenate([x.ravel() for x in (*laws, joints.ratios, joints.friction)]),
        np.concatenate([x.ravel() for x in places], dtype=np.int64),
    )


@njit(cache=True, inline="always")
def unpack_loads(numbers: np.ndarray, places: np.ndarray) -> tuple[Gearing, DriveData, Joints]:
    """Gearing, drive and joints as views of the fields of LoadArrays."""
    stages, planets, longest, count, rows, code, conservative = places[:SIZES]
    laws, link = planets * longest, SIZES + 4 * stages
    time = 2 * laws + 3 * count
    torque = time + rows
    ratio = torque + rows * count
    gears = Gearing(
        numbers[:laws].reshape((planets, longest)),
        numbers[laws : 2 * laws].reshape((planets, longest)),
        places[SIZES:link].reshape((stages, 4)),
        conservative,
    )
    gains, table = numbers[2 * laws : time], numbers[torque:ratio]
    drive = DriveData(
        code, gains.reshape((count, 3)), numbers[time:torque], table.reshape((count, rows))
    )
    links, driven = places[link : link + count], places[link + count :]
    joints = Joints(links, driven, numbers[ratio : ratio + count], numbers[ratio + count :])
    return gears, drive, joints


@njit(cache=True, inline="always")
def add_joints(
    drive: DriveData, joints: Joints, t: float, q: np.ndarray, q_t: np.ndarray, forces: np.ndarray
) -> None:
    """Add every motor's torque and the friction to ``forces`` at time t [s].

    A motor gives T / n, with T from the link's angle and rate.
    """
    for joint in range(len(joints.links)):
        link, driven = joints.links[joint], joints.driven[joint]
        gains, table = drive.gains[joint], drive.table_torque[joint]
        torque = joint_torque(drive.code, gains, drive.table_time, table, t, q[link], q_t[link])
        forces[driven] += torque / joints.ratios[joint]
        forces[link] -= joints.friction[joint] * q_t[link]


@njit(cache=True)
def write_tree_loads(numbers: np.ndarray, places: np.ndarray, state: np.ndarray) -> None:
    """Write all generalized forces [N m] on the tree, by LoadArrays, to the end of ``state``.

    state (1 + 3 bodies,): time [s], coordinates, rates, forces.
    """
    gears, drive, joints = unpack_loads(numbers, places)
    size = len(state) // 3
    t, q, q_t, forces = state[0], state[1 : size + 1], state[size + 1 : -size], state[-size:]
    forces[:] = 0.0
    mesh.add_meshes(gears, t, q, q_t, forces)
    if gears.conservative:
        mesh.add_turning_torques(gears, q, forces)
    add_joints(drive, joints, t, q, q_t, forces)


def build_load_function(laws: LoadArrays, size: int, clock: list[float]) -> UserFunction:
    """The engine's user function on so many bodies: ``clock[0]`` [s] is added to its time."""
    memory = bytearray(8 * (1 + 3 * size))
    state = np.frombuffer(memory)
    forces, put = state[-size:], Struct(f"{1 + 2 * size}d").pack_into
    (numbers, places), add = laws, _entry(write_tree_loads, *laws, state)

    def force(_: object, t: float, _item: int, q: list[float], q_t: list[float]) -> list[float]:
        put(memory, 0, clock[0] + t, *q, *q_t)
        add(numbers, places, state)
        return forces.tolist()

    return force


def _entry(function: Any, *arguments: object) -> Callable[..., None]:
    """A compiled function for such arguments, past numba's choice among signatures (3 us)."""
    return function.compile(tuple(typeof(a) for a in arguments))
