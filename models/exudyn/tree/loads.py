"""All forces on the Exudyn tree in one call from the engine: meshes and motors.

What such a call costs is getting in and out of Python, not the forces. So time, coordinates, rates
and forces share one array: numba unwraps every array it is passed anew in every call.
"""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct
from typing import Any, NamedTuple

import numpy as np
from numba import typeof

from crosscheck.models.experiment import drive as drives
from crosscheck.models.experiment.drive import DriveData
from crosscheck.models.exudyn.engine import UserFunction
from crosscheck.models.exudyn.tree import mesh
from crosscheck.models.exudyn.tree.mesh import Gearing
from crosscheck.models.numba_cache import njit

joint_torque: Any = njit(cache=True, inline="always")(drives.joint_torque)


class MotorPlaces(NamedTuple):
    """What drives the links, one row per joint (joints,).

    places (joints, 2): tree coordinates of the link and of what its motor turns; ratios: torque at
    the link over the motor's.
    """

    places: np.ndarray
    ratios: np.ndarray


@njit(cache=True, inline="always")
def add_motors(
    drive: DriveData,
    motors: MotorPlaces,
    t: float,
    q: np.ndarray,
    q_t: np.ndarray,
    forces: np.ndarray,
) -> None:
    """Add every motor's torque to ``forces`` at time t [s].

    A motor gives T / n, with T from the link's angle and rate.
    """
    for joint in range(len(motors.places)):
        link, driven = motors.places[joint]
        gains, table = drive.gains[joint], drive.table_torque[joint]
        torque = joint_torque(drive.code, gains, drive.table_time, table, t, q[link], q_t[link])
        forces[driven] += torque / motors.ratios[joint]


@njit(cache=True, inline="always")
def write_mesh_loads(gears: Gearing, state: np.ndarray) -> None:
    """Write the meshes' generalized forces [N m] on the tree to the end of ``state``.

    state (1 + 3 bodies,): time [s], coordinates, rates, forces.
    """
    size = len(state) // 3
    t, q, q_t, forces = state[0], state[1 : size + 1], state[size + 1 : -size], state[-size:]
    forces[:] = 0.0
    mesh.add_meshes(gears, t, q, q_t, forces)


@njit(cache=True)
def write_tree_loads(
    gears: Gearing, drive: DriveData, motors: MotorPlaces, state: np.ndarray
) -> None:
    """Write all generalized forces [N m] on the tree to the end of ``state``, as meshes' are."""
    write_mesh_loads(gears, state)
    size = len(state) // 3
    t, q, q_t, forces = state[0], state[1 : size + 1], state[size + 1 : -size], state[-size:]
    add_motors(drive, motors, t, q, q_t, forces)


def build_load_function(
    write: Callable[..., None], data: tuple[object, ...], size: int, clock: list[float]
) -> UserFunction:
    """The engine's user function on so many bodies: ``clock[0]`` [s] is added to its time.

    write: one of the compiled functions above, and data what it takes before the state.
    """
    memory = bytearray(8 * (1 + 3 * size))
    state = np.frombuffer(memory)
    forces, put = state[-size:], Struct(f"{1 + 2 * size}d").pack_into
    arguments = (*data, state)
    add = _entry(write, *arguments)

    def force(_: object, t: float, _item: int, q: list[float], q_t: list[float]) -> list[float]:
        put(memory, 0, clock[0] + t, *q, *q_t)
        add(*arguments)
        return forces.tolist()

    return force


def _entry(function: Any, *arguments: object) -> Callable[..., None]:
    """A compiled function for such arguments, past numba's choice among signatures (3 us)."""
    return function.compile(tuple(typeof(a) for a in arguments))
