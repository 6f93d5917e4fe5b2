"""The springs of a robot's planetary stage in Exudyn, by the compiled laws of the planar tree."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from crosscheck.models.arm.gears import PlanetaryStage
from crosscheck.models.experiment.scenario import switches
from crosscheck.models.exudyn.tree import mesh
from crosscheck.models.exudyn.tree.laws import Side, build_mesh_law
from crosscheck.models.exudyn.tree.mesh import MeshLaw

SIDES: tuple[Side, Side] = ("sun", "ring")


class ElasticStage(NamedTuple):
    """Planets of a stage that turn as one, on springs: joint, sun and they among the parts."""

    joint: int
    sun: int
    planet: int
    planets: int
    sun_law: MeshLaw
    ring_law: MeshLaw

    @property
    def meshes(self) -> Iterator[tuple[MeshLaw, int | None]]:
        """The laws of both meshes, each with its central wheel; None for the ring, which rests."""
        yield self.sun_law, self.sun
        yield self.ring_law, None

    def spring_forces(self, angles: Sequence[float]) -> list[float]:
        """Forces [N] of the springs of every planet, sun and ring in turn, by all parts' angles."""
        pulls = []
        for side_law, wheel in self.meshes:
            law = side_law.array
            x = self._stretch(law, wheel, angles)
            varied = mesh.variation(law, 0.0, angles[self.joint], 0.0)
            pulls.append(mesh.elastic_force(law, x, *varied))
        return pulls * self.planets

    def add_efforts(
        self, efforts: list[float], angles: Sequence[float], rates: Sequence[float]
    ) -> None:
        """Add the torques [N m] of the meshes on sun, planets and joint to those of all parts.

        The joint's is what the springs' potentials do, whose stiffness and error turn with it.
        """
        for side_law, wheel in self.meshes:
            law, theta = side_law.array, angles[self.joint]
            x, rate = (self._stretch(law, wheel, turned) for turned in (angles, rates))
            stiffness, error = mesh.variation(law, 0.0, theta, 0.0)
            pull = mesh.elastic_force(law, x, stiffness, error)
            pull += mesh.damping_force(law, x, rate, error)
            if wheel is not None:
                efforts[wheel] -= self.planets * side_law.wheel_radius * pull
            efforts[self.planet] -= self.planets * side_law.planet_radius * pull
            varied = mesh.variation(law, 0.0, complex(theta, mesh.STEP), 0.0)
            efforts[self.joint] += self.planets * mesh.turning_torque(law, x, *varied)

    def _stretch(self, law: np.ndarray, wheel: int | None, turned: Sequence[float]) -> float:
        """Displacement [m] of a mesh, or its rate, by the angles of all parts or theirs."""
        x: float = mesh.stretch(
            law, 0.0 if wheel is None else turned[wheel], turned[self.planet], 0.0
        )
        return x


def build_elastic_stage(
    gears: PlanetaryStage, number: int, joint: int, sun: int, planet: int, planets: int
) -> ElasticStage:
    """The stage with the laws of a planet, counted from 0, which stands for so many."""
    chosen = switches(damping="contact")
    laws = (build_mesh_law(gears, chosen, side, number) for side in SIDES)
    return ElasticStage(joint, sun, planet, planets, *laws)
