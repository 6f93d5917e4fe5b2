"""Runs of robots side by side, by the names of a run's signals."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.analytic.ensemble import RunChunk
from crosscheck.models.arm.layout import Meaning
from crosscheck.models.robot.robot import JointStage

if TYPE_CHECKING:
    from crosscheck.analytic.robot.runs import RobotMember


class RobotChunk(RunChunk):
    """Records of robots: joints are all that move, in the robot's order."""

    models: Sequence[RobotMember]

    @cached_property
    def theta(self) -> np.ndarray:  # type: ignore[override]
        """Coordinates [rad], [m]; a joint that follows another with its offset."""
        _, offsets = self._joint_map
        return self._joint_values(self.records.q) + offsets[:, np.newaxis]

    @property
    def x_mesh(self) -> np.ndarray:
        """Displacements of rotors' meshes (records, joints, members) [m]."""
        return self._rotor_values(self.records.q, self._free)

    @property
    def x_mesh_dot(self) -> np.ndarray:
        """Rates of x_mesh [m/s], shaped as it."""
        return self._rotor_values(self.records.v, self._free)

    @property
    def F_mesh(self) -> np.ndarray:
        """Elastic forces of rotors' meshes [N], shaped as x_mesh."""
        return self._rotor_values(self.records.forces, 0)

    @cached_property
    def _joint_map(self) -> tuple[np.ndarray, np.ndarray]:
        return self.models[0].robot.joint_map

    @property
    def _free_joints(self) -> Sequence[int]:
        return self.models[0].robot.coordinates

    @property
    def _free(self) -> int:
        return len(self._free_joints)

    @property
    def _stages(self) -> tuple[tuple[JointStage, slice], ...]:
        """Stages that have meshes here and where their coordinates are."""
        robot = self.models[0].robot
        pairs = tuple(zip(robot.stages, robot.stage_columns, strict=True))
        return pairs if self.models[0].level == "geared" else ()

    def _joint_values(self, x: np.ndarray) -> np.ndarray:
        factors, _ = self._joint_map
        return np.einsum("jf,rfm->rjm", factors, x[:, : self._free])

    def _rotor_values(self, values: np.ndarray, first: int) -> np.ndarray:
        """Rows from ``first`` on, one of each rotor's mesh, by the joints of these rotors."""
        model = self.models[0]
        by_joint = np.full((len(values), len(model.robot.joints), len(self.models)), np.nan)
        meshes = model.robot.meshes[: model.equations.structure.rotor_meshes]
        for place, (rotor, _) in enumerate(meshes, first):
            by_joint[:, rotor.joint] = values[:, place]
        return by_joint

    def _displacements(self, mesh: Meaning, x: np.ndarray) -> np.ndarray:
        by_planet = {
            stage.joint: [
                np.einsum("n,rnm->rm", stage.displacement(mesh, planet), x[:, columns])
                for planet in stage.groups
            ]
            for stage, columns in self._stages
        }
        return self._planet_values(by_planet)

    def _forces(self, side: int) -> np.ndarray:
        equations = self.models[0].equations
        first, by_planet = equations.structure.rotor_meshes + side, {}
        for stage, _ in sorted(self._stages, key=lambda each: equations.labels[each[0].joint]):
            rows = [first + 2 * planet for planet in stage.groups]
            by_planet[stage.joint] = [self.records.forces[:, row] for row in rows]
            first += 2 * len(rows)
        return self._planet_values(by_planet)

    def _planet_values(self, by_planet: dict[int, list[np.ndarray]]) -> np.ndarray:
        """Values (records, joints, planets, members); one planet alone represents all.

        If only other joints' planets are free it is repeated.
        """
        joints, members = len(self.models[0].robot.joints), len(self.models)
        counts = [stage.gears.planet_count for stage, _ in self._stages]
        is_any_free = any(stage.has_free_planets for stage, _ in self._stages)
        planets = max(counts) if is_any_free else 1
        values = np.full((len(self.time), joints, planets, members), np.nan)
        for (stage, _), count in zip(self._stages, counts, strict=True):
            each = np.stack(by_planet[stage.joint], axis=1)
            values[:, stage.joint, : count if is_any_free else 1] = each
        return values
