"""The analytic model with the rounding of an engine that counts in angles.

A vibration that decays for half a second and grows again starts anew from rounding. The paper's
coordinates are the mesh displacements themselves, which hold 1e-20 m; the tree's are angles, whose
last place is worth r eps at the tooth. To compare what grows, both must start from the same floor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numba import njit

from analytic import kernel
from analytic.gears import Gears
from analytic.model import PhysicalModel
from analytic.terms import Terms
from crosscheck.paper.fluctuation import third_fluctuation
from crosscheck.paper.phase.fluctuations import Fluctuation, one_start
from crosscheck.paper.stage import paper_stage
from crosscheck.studies.study import Numbers, Variant
from crosscheck.studies.variant import simulate
from models.arm import Arm
from models.drive import DriveData
from models.scenario import Scenario, per_joint


@dataclass(frozen=True)
class Rounded:
    """The third fluctuation of the analytic model in a variant's experiment, so rounded.

    After every step each mesh displacement moves by a random part of ``tooth_rounding``.
    """

    variant: Variant

    @property
    def inputs(self) -> str:
        return "\n".join(record.model_dump_json() for record in self.variant.case())

    @property
    def cost(self) -> float:
        return 1.0

    def answer(self) -> Fluctuation:
        return one_start(self.variant, self._numbers)

    def _numbers(self, others: tuple[xr.Dataset, ...]) -> Numbers:
        """Rounded as at the largest angle of the run without rounding."""
        largest = float(np.abs(simulate(self.variant)["theta"]).max())
        floor = tooth_rounding(self.variant.case().arm, largest)
        return {**third_fluctuation(self._run(floor), others), "rounding_m": floor}

    def _run(self, floor: float) -> xr.Dataset:
        arm, scenario, switches = self.variant.case()
        model = PhysicalModel(arm, scenario, switches)
        q, v = model.start()
        noise = floor * _generator(scenario, arm).uniform(-1, 1, (scenario.steps, q.size))
        noise[:, model.layout.theta] = 0.0
        law = (model.terms, model.gears, model.drive)
        qs, vs = _integrate(*law, q, v, scenario.step_s, scenario.stride, noise)
        return model.record(scenario.step_s * scenario.stride * np.arange(len(qs)), qs, vs)


def tooth_rounding(arm: Arm, theta: float) -> float:
    """Last place [m] of x_sp made of a sun's and a planet's angle, the carrier at theta [rad]."""
    geometry = paper_stage(arm).geometry
    sun = geometry.r_s * np.spacing(theta * geometry.n)
    planet = geometry.r_p * np.spacing(theta * (geometry.r_cp / geometry.r_p + 1))
    return float(sun + planet)


def _generator(scenario: Scenario, arm: Arm) -> np.random.Generator:
    """Another sequence for every start."""
    offset = per_joint(scenario.start.sun_planet_offset_m, len(arm.joints))[0]
    return np.random.default_rng(round(abs(offset) * 1e18))


@njit(cache=True)
def _integrate(
    terms: Terms,
    gears: Gears,
    drive: DriveData,
    q: np.ndarray,
    v: np.ndarray,
    step: float,
    stride: int,
    noise: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """As analytic.kernel.integrate, noise (steps, n) added to q after every step."""
    records = noise.shape[0] // stride + 1
    qs, vs = np.empty((records, q.size)), np.empty((records, q.size))
    room, between = kernel.scratch(terms), kernel.stages(q.size)
    qs[0], vs[0] = q, v
    for k in range(noise.shape[0]):
        kernel.runge_kutta_step(terms, gears, drive, k * step, step, q, v, room, between)
        q += noise[k]
        if (k + 1) % stride == 0:
            qs[(k + 1) // stride], vs[(k + 1) // stride] = q, v
    return qs, vs
