"""Models of one structure, side by side in blocks of lanes, stepped and recorded together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import sqrt
from typing import NamedTuple, Protocol

import numpy as np

from analytic.fast.compiled import module_of
from analytic.fast.energy import kinetic_energy
from analytic.fast.links import Links
from analytic.fast.numbers import Numbers, numbers_of
from analytic.fast.program import STATE, program_of
from analytic.fast.structure import Structure
from analytic.gears import Gears
from models.arm import Arm
from models.drive import DriveData
from models.layout import Layout
from models.scenario import Scenario

WIDE = 8  # lanes of a block: as many numbers as the widest registers hold
LINE = 64  # bytes at whose multiples blocks begin, so that no load spans two lines of the cache


class FastModel(Protocol):
    """What is asked of a model that a specialised kernel runs."""

    arm: Arm
    scenario: Scenario
    layout: Layout
    drive: DriveData
    gears: Gears

    @property
    def links(self) -> Links | None: ...

    @property
    def structure(self) -> Structure | None: ...

    def start(self) -> tuple[np.ndarray, np.ndarray]: ...


class Records(NamedTuple):
    """States q, v and accelerations a (records, n, members), in the coordinates of the layout.

    forces (records, meshes, members): elastic force per planet [N], in the order of Gears.
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    forces: np.ndarray


class Batch:
    """At least one model, all of one structure, step and drive table; stepped from their starts.

    What one member does is not changed by the others: they share no number. lanes: 1 for the kernel
    of one member alone.
    """

    def __init__(self, models: Sequence[FastModel], lanes: int = WIDE) -> None:
        first = models[0]
        assert first.structure is not None  # the caller asks it
        self.models, self.step_s = models, first.scenario.step_s
        self.program = program_of(first.structure, lanes)
        self.module = module_of(self.program)
        self.numbers = [numbers(model) for model in models]
        self.done = 0  # steps
        blocks = -(-len(models) // lanes)
        self.work = _aligned(blocks, self.program.rows * lanes)
        lanes_of = self.work.reshape(blocks, self.program.rows, lanes)
        for place in range(blocks * lanes):
            member = min(place, len(models) - 1)  # spare lanes repeat the last
            lanes_of[place // lanes, :, place % lanes] = self._column(member)

    def _column(self, member: int) -> np.ndarray:
        """All rows of a member at its start."""
        program, model = self.program, self.models[member]
        q, v = (advances(model.layout, x) for x in model.start())
        state = {"q": q, "v": v, "stage_q": q, "stage_v": v}
        rows = [state.get(name, 0 * q) for name in STATE]
        values = [self.numbers[member][name] for name in program.numbers]
        return np.concatenate([*rows, np.zeros(len(program.meshes)), values])

    def advance(self, records: int, stride: int) -> Records:
        """So many records, each ``stride`` steps after the one before; the first is of now.

        With stride 0 the batch stays where it is.
        """
        program, (blocks, _) = self.program, self.work.shape
        drive, n = self.models[0].drive, len(program.coordinates)
        rows = 3 * n + len(program.meshes)
        out = np.empty((records, blocks, rows * program.lanes))
        table = drive.table_time, drive.table_torque
        self.module.advance(self.work, self.done, stride, self.step_s, *table, out)
        self.done += records * stride
        by_lane = out.reshape(records, blocks, rows, program.lanes).transpose(0, 2, 1, 3)
        members = by_lane.reshape(records, rows, -1)[:, :, : len(self.models)]
        layout = self.models[0].layout
        q, v, a = (displacements(layout, members[:, k * n : (k + 1) * n]) for k in range(3))
        return Records(q, v, a, members[:, 3 * n :])

    def run(self, records: int, stride: int, most: int) -> Iterator[Records]:
        """So many records, at most ``most`` at a time, and by itself the one where they end."""
        while records:
            part = min(records, most)
            yield self.advance(part, stride)
            records -= part
        yield self.advance(1, 0)

    def staged(self, steps: int) -> np.ndarray:
        """So many steps, and the states q, v that their four stages were evaluated at.

        Shape (steps, 4, blocks, 2 n, lanes), in the kernel's coordinates. No table for a drive.
        """
        module, program, h = self.module, self.program, self.step_s
        n, blocks = len(program.coordinates), len(self.work)
        rows = self.work.reshape(blocks, program.rows, program.lanes)
        now, ahead = rows[:, : 2 * n], rows[:, 2 * n : 4 * n]  # q, v; stage_q, stage_v
        out = np.empty((steps, 4, *now.shape))
        table = np.zeros(len(self.models[0].drive.gains))
        addresses = [part.ctypes.data for part in self.work]
        for step in range(steps):
            t = (self.done + step) * h
            middle, end = (t + h / 2, sqrt(t + h / 2)), (t + h, sqrt(t + h))
            for block, address in enumerate(addresses):
                out[step, 0, block] = now[block]
                module.first_stage(address, t, sqrt(t), table, h)
                out[step, 1, block] = ahead[block]
                module.middle_stage(address, *middle, table, h, 0.5)
                out[step, 2, block] = ahead[block]
                module.middle_stage(address, *middle, table, h, 1.0)
                out[step, 3, block] = ahead[block]
                module.last_stage(address, *end, table, h)
        self.done += steps
        return out


def numbers(model: FastModel) -> Numbers:
    """Those of a model that a specialised kernel knows."""
    assert model.structure is not None
    assert model.links is not None
    return numbers_of(model.arm, model.structure, model.links, model.gears, model.drive)


def _aligned(blocks: int, size: int) -> np.ndarray:
    """Zeros (blocks, size) that begin at a line of the cache."""
    room = np.zeros(blocks * size + LINE // 8)
    first = -room.ctypes.data % LINE // 8
    return room[first : first + blocks * size].reshape(blocks, size)


def energy_of(model: FastModel, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Kinetic energy (records,) [J] at states q, v (records, n) of a model's layout."""
    assert model.structure is not None
    assert model.links is not None
    x, rate = advances(model.layout, q), advances(model.layout, v)
    return kinetic_energy(model.structure, model.links, numbers(model), x, rate)


def advances(layout: Layout, x: np.ndarray) -> np.ndarray:
    """From a layout's coordinates (..., n) to a kernel's: the sun's advance, planets, angles."""
    if layout.free:
        return x
    found = []
    for joint in layout.meshing:
        x_sp, x_pr = x[..., layout.at("x_sp", joint)], x[..., layout.at("x_pr", joint)]
        found += [x_sp + x_pr, x_pr]
    return np.stack([*found, *np.moveaxis(x[..., layout.theta], -1, 0)], axis=-1)


def displacements(layout: Layout, x: np.ndarray) -> np.ndarray:
    """The way back, of x (records, n, members)."""
    if layout.free:
        return x
    found = np.empty_like(x)
    with np.errstate(invalid="ignore"):  # of members that diverge
        _take_apart(layout, x, found)
    return found


def _take_apart(layout: Layout, x: np.ndarray, found: np.ndarray) -> None:
    for place, joint in enumerate(layout.meshing):
        x_pr = x[:, 2 * place + 1]
        found[:, layout.at("x_sp", joint)] = x[:, 2 * place] - x_pr
        found[:, layout.at("x_pr", joint)] = x_pr
    found[:, layout.theta] = x[:, 2 * len(layout.meshing) :]
