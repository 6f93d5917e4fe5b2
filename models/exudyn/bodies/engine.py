"""An Exudyn system of planar rigid bodies on revolute joints, coupled by custom connectors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from crosscheck.models.exudyn.bodies.poses import GROUND, Part, RigidBody
from crosscheck.models.exudyn.engine import (
    CURRENT,
    INITIAL,
    System,
    UserFunction,
    exudyn,
    items,
    quiet_settings,
    solve,
)

QUARTER_TURN = np.pi / 2
# A step's last residual [N, N m, m/s], or that over its first one. 1e-10 moves x by 1e-15 m in 5 ms
# of the paper's arm, 1e-13 by 1e-16 m.
NEWTON = 1e-12


class Connector(NamedTuple):
    """A force on some bodies; its arguments and results are theirs, GROUND left out."""

    bodies: tuple[int, ...]
    force: UserFunction


class BodyEngine(System):
    """An assembled system: states in; mass, forces, constraints, accelerations or a motion out.

    Poses, velocities and accelerations have shape (3 bodies,): x, y [m] and angle [rad] of body
    after body. The reference pose is zero, so that coordinates are poses. gravity [m/s^2] is along
    the ground's x and y.
    """

    def __init__(
        self,
        bodies: Sequence[RigidBody],
        connectors: Sequence[Connector],
        gravity: tuple[float, float],
        pose: np.ndarray,
    ) -> None:
        super().__init__(len(pose))
        self.nodes = [
            self.system.AddNode(items.NodeRigidBody2D(initialCoordinates=coordinates))
            for coordinates in pose.reshape(-1, 3)
        ]
        self._add_bodies(bodies, gravity)
        for connector in connectors:
            self.system.AddObject(_connector(connector, self.nodes))
        self.assemble(exudyn.MainSolverImplicitSecondOrder(), _settings())

    def _add_bodies(self, bodies: Sequence[RigidBody], gravity: tuple[float, float]) -> None:
        """Add the bodies to the system; parts of one body share its node, which welds them."""
        ground = self.system.AddObject(items.ObjectGround())
        first = {GROUND: ground}
        for number, body in enumerate(bodies):
            parts = [self.system.AddObject(_part(part, self.nodes[number])) for part in body.parts]
            first[number] = parts[0]
            for part in parts:
                self._add_weight(part, gravity)
        for number, body in enumerate(bodies):
            self._add_joint(first[body.seat_body], body.seat, first[number])

    def _add_weight(self, part: Any, gravity: tuple[float, float]) -> None:
        if any(gravity):
            marker = self.system.AddMarker(items.MarkerBodyMass(bodyNumber=part))
            load = items.LoadMassProportional(markerNumber=marker, loadVector=[*gravity, 0.0])
            self.system.AddLoad(load)

    def _add_joint(self, holder: Any, seat: complex, body: Any) -> None:
        markers = [
            self.system.AddMarker(
                items.MarkerBodyPosition(bodyNumber=number, localPosition=[at.real, at.imag, 0.0])
            )
            for number, at in ((holder, seat), (body, 0j))
        ]
        self.system.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))

    def place(self, t: float, pose: np.ndarray, velocity: np.ndarray) -> None:
        """Put the system into a state; joints carry nothing."""
        self.put(pose, velocity, t)
        data = self.system.systemData
        for configuration in (INITIAL, CURRENT):
            data.SetAECoordinates(np.zeros(len(data.GetAECoordinates())), configuration)

    def joints(self, velocity_level: bool = False) -> np.ndarray:
        """Gaps [m], or their rates [m/s], between the joints' two points, shape (2 joints,)."""
        self.solver.ComputeAlgebraicEquations(self.system, velocity_level)
        return np.array(self.solver.GetSystemResidual())[self.size :]

    def joint_jacobian(self) -> np.ndarray:
        """G, derivative of ``joints`` by the poses, shape (2 joints, 3 bodies)."""
        self.solver.ComputeJacobianODE2RHS(self.system, 0.0, 0.0, 0.0)
        self.solver.ComputeJacobianAE(self.system, 1.0, 0.0, 0.0, False)
        return np.array(self.solver.GetSystemJacobian())[self.size :, : self.size]

    def swing(self, t: float, pose: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """G' v [m/s^2], shape (2 joints,); leaves another state behind.

        G v holds a lever at angle phi as omega i exp(i phi), whose rate is that of a lever a
        quarter turn on at omega^2: no differences need to be taken.
        """
        on, squared = np.zeros_like(pose), np.zeros_like(pose)
        on[2::3], squared[2::3] = QUARTER_TURN, velocity[2::3] ** 2
        self.place(t, pose + on, squared)
        return self.joints(velocity_level=True)

    def solve(
        self, t: float, pose: np.ndarray, velocity: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations (3 bodies,) and r [N], (2 joints,): M a + G^T r = f, G a = -G' v."""
        swing = self.swing(t, pose, velocity)
        self.place(t, pose, velocity)
        jacobian = self.joint_jacobian()
        nothing = np.zeros((len(swing), len(swing)))
        system = np.block([[self.mass_matrix(), jacobian.T], [jacobian, nothing]])
        solved = np.linalg.solve(system, np.concatenate([self.right_hand_side(), -swing]))
        return solved[: self.size], solved[self.size :]

    def run(
        self, pose: np.ndarray, velocity: np.ndarray, steps: int, step_s: float, stride: int
    ) -> np.ndarray:
        """Every stride-th state from t = 0 by the trapezoidal rule, (times, 2, 3 bodies).

        The joints are held at velocity level (index 2). States end before the first step that does
        not converge.
        """
        states: list[np.ndarray] = []
        data, time = self.system.systemData, self.settings.timeIntegration

        def keep(_: object, t: float) -> bool:  # the engine calls it at t = 0 as well
            if round(t / step_s) % stride == 0:
                states.append(np.array([data.GetODE2Coordinates(), data.GetODE2Coordinates_t()]))
            return True

        self.place(0.0, pose, velocity)
        self.system.SetPostStepUserFunction(keep)
        time.numberOfSteps, time.endTime = steps, steps * step_s
        solve(self.solver, self.system, self.settings)
        return np.array(states).reshape(-1, 2, self.size)  # none where the start cannot be solved


def _settings() -> Any:
    settings = quiet_settings()
    time = settings.timeIntegration
    time.adaptiveStep = False
    time.generalizedAlpha.useNewmark = True  # beta 1/4, gamma 1/2: the trapezoidal rule
    time.generalizedAlpha.useIndex2Constraints = True
    time.newton.relativeTolerance = NEWTON
    time.newton.absoluteTolerance = NEWTON
    return settings


def _part(part: Part, node: Any) -> Any:
    return items.ObjectRigidBody2D(
        mass=part.mass,
        inertia=part.inertia + part.mass * part.x**2,  # the engine's is about the frame's origin
        centerOfMass=[part.x, 0.0],
        nodeNumber=node,
    )


def _connector(connector: Connector, nodes: Sequence[Any]) -> Any:
    touched = [nodes[body] for body in connector.bodies]
    size = 3 * len(touched)
    nothing = exudyn.MatrixContainer()
    nothing.SetWithSparseMatrix([], size, size)
    return items.ObjectGenericODE2(
        nodeNumbers=touched,
        massMatrix=nothing,
        forceUserFunction=connector.force,
        visualization=items.VObjectGenericODE2(show=False),
    )
