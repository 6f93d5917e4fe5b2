"""The structure and code of a robot's kernel: algorithms, run on expressions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

from crosscheck.analytic.kernel.expressions import (
    ExpressionGraph,
    Number,
    StraightLines,
    write_lines,
)
from crosscheck.analytic.kernel.structure import Lines, StageShape, Structure
from crosscheck.analytic.kernel.text.meshes import (
    constant_mesh,
    mesh_forces,
    stiffness_and_error,
    torque,
)
from crosscheck.analytic.robot.algorithms import Mechanism, MovingTree
from crosscheck.analytic.robot.mechanism import replace_names


@dataclass(frozen=True)
class RobotStructure(Structure):
    """The structure of a robot at a level in an experiment.

    mechanism: numbers by their names; labels: of every joint the number that its names end with,
    free joints first; rotor_meshes: how many rotors have a mesh; stage_labels: of the joints with
    planetary meshes, in the order of their coordinates.
    """

    mechanism: Mechanism
    labels: tuple[int, ...]
    rotor_meshes: int
    stage_labels: tuple[int, ...]

    @property
    def driven_joints(self) -> range:
        """The free joints."""
        return range(1, self.mechanism.free + 1)

    @cached_property
    def rotor_names(self) -> tuple[str, ...]:
        """Names of the rotors' meshes."""
        return tuple(f"m{place + 1}" for place in range(self.rotor_meshes))

    @cached_property
    def displacements(self) -> tuple[str, ...]:
        """Names of the meshes' displacements: of rotors, then those of each stage."""
        stages = (name for j in self.stage_labels for name in self._stage_displacements(j))
        return (*(f"x_{name}" for name in self.rotor_names), *stages)

    def _stage_displacements(self, j: int) -> tuple[str, ...]:
        """Names of the displacements of a stage, of free planets if there are several."""
        stage = self.stages[j - 1]
        assert stage is not None  # as stage_labels say
        if stage.planets == 1:
            return f"x_sp{j}", f"x_pr{j}"
        return f"x_s{j}", *(f"x_pr{j}_{n}" for n in range(1, stage.planets + 1))

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of a robot's coordinates, in their order."""
        return (*(f"theta{j}" for j in self.driven_joints), *self.displacements)

    @cached_property
    def meshes(self) -> tuple[str, ...]:
        """Names of the meshes: of rotors, then of stages by their joints' labels."""
        return (*self.rotor_names, *super().meshes)

    def acceleration(self) -> Lines:
        """Lines from coordinates and rates to their accelerations and the mesh forces."""
        for j in self.driven_joints:
            yield from torque(self, j)
        yield from self.dynamics()

    def dynamics(self) -> Lines:
        """The same from coordinates, rates and the motors' torques ``T{j}``."""
        for name in self.rotor_names:
            yield from constant_mesh(self, name)
            yield f"push_x_{name} = -(F_{name} + D_{name})"
        for j, stage in self.geared_joints:
            yield from self._stage_meshes(j, stage)
        yield from trace_forward_dynamics(self).lines

    def _stage_meshes(self, j: int, stage: StageShape) -> Lines:
        """Lines of a stage's forces; the angle of a joint that follows another comes first."""
        if j > self.mechanism.free:
            joint = self.mechanism.joints[self.labels.index(j)]
            offset = joint.offset or 0.0
            yield f"q_theta{j} = {joint.factor} * q_theta{joint.coordinate + 1} + {offset}"
        yield from stiffness_and_error(self, j, stage)
        if stage.planets > 1:
            yield from self._free_meshes(j, stage)
            return
        for side in ("sp", "pr"):
            yield f"x_{side}{j}_1 = q_x_{side}{j}"
            yield f"v_{side}{j}_1 = v_x_{side}{j}"
        yield from mesh_forces(self, j, stage)
        for side in ("sp", "pr"):
            yield f"push_x_{side}{j} = -(F_{side}{j}_1 + D_{side}{j}_1)"

    def _free_meshes(self, j: int, stage: StageShape) -> Lines:
        """Lines of the forces of planets that move by themselves: x_sp is x_s - x_pr."""
        planets = range(1, stage.planets + 1)
        for n in planets:
            for x, loaded in (("x", "q"), ("v", "v")):
                yield f"{x}_pr{j}_{n} = {loaded}_x_pr{j}_{n}"
                yield f"{x}_sp{j}_{n} = {loaded}_x_s{j} - {loaded}_x_pr{j}_{n}"
        yield from mesh_forces(self, j, stage)
        for n in planets:
            yield f"pull{j}_{n} = F_sp{j}_{n} + D_sp{j}_{n}"
            yield f"push_x_pr{j}_{n} = pull{j}_{n} - (F_pr{j}_{n} + D_pr{j}_{n})"
        yield f"push_x_s{j} = -({' + '.join(f'pull{j}_{n}' for n in planets)})"


class TracedState:
    """The algorithms on expressions of a structure's numbers, coordinates and rates."""

    def __init__(self, structure: RobotStructure) -> None:
        graph = ExpressionGraph()
        mechanism = replace_names(structure.mechanism, graph.constant)
        self.structure, self._variable = structure, graph.variable
        free = structure.driven_joints
        q, v = ([graph.variable(f"{kind}_theta{j}") for j in free] for kind in "qv")
        self.rates = [joint.factor * v[joint.coordinate] for joint in mechanism.joints]
        values = [joint.factor * q[joint.coordinate] + joint.offset for joint in mechanism.joints]
        turned: list[tuple[Number, Number]] = [
            (1, 0) if joint.slides else graph.cos_and_sin(value)
            for joint, value in zip(mechanism.joints, values, strict=True)
        ]
        self.tree = MovingTree(mechanism, values, turned)

    def named(self, prefix: str, names: Sequence[str]) -> list[Number]:
        """Variables of the text by their names."""
        return [self._variable(f"{prefix}{name}") for name in names]


@lru_cache(maxsize=256)
def trace_forward_dynamics(structure: RobotStructure) -> StraightLines:
    """Text of the accelerations ``a_{coordinate}``."""
    state = TracedState(structure)
    torques = state.named("T", [str(j) for j in structure.driven_joints])
    rates, pushes = (state.named(kind, structure.displacements) for kind in ("v_", "push_"))
    staged = [j for j, _ in structure.geared_joints] if structure.conservative else []
    efforts = [state.named("on_theta", [str(j)])[0] if j in staged else 0 for j in structure.labels]
    result = state.tree.forward_dynamics(state.rates, rates, torques, pushes, efforts)
    names = (f"a_{name}" for name in structure.coordinates)
    return write_lines(dict(zip(names, result, strict=True)))


@lru_cache(maxsize=256)
def trace_mass_matrix(structure: RobotStructure) -> StraightLines:
    """Text of the lower half of M over the joints' coordinates, ``M{i}_{j}``, without rotors on
    meshes.
    """
    state = TracedState(structure)
    matrix = state.tree.collapse(state.tree.mass_matrix())
    entries = {f"M{i}_{j}": row[j] for i, row in enumerate(matrix) for j in range(i + 1)}
    return write_lines(entries)
