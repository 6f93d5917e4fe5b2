"""Exudyn systems in minimal coordinates: any tree, and bodies on revolute joints with forces."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

os.environ.setdefault("EXUDYN_NO_USER_SETTINGS", "1")  # no run may depend on a user's file
exudyn: Any = import_module("exudyn")  # Any: its stubs declare the solver's methods without self
items: Any = import_module("exudyn.itemInterface")

CURRENT, INITIAL = exudyn.ConfigurationType.Current, exudyn.ConfigurationType.Initial
UserFunction = Callable[[object, float, int, list[float], list[float]], list[float]]


class TreeBody(NamedTuple):
    """A body of the tree: planar inertia [kg m^2] about its com, com and joint in [m]."""

    parent: int
    joint_at: tuple[float, float]
    mass: float
    com_x: float
    inertia: float


def quiet_settings() -> Any:
    """Settings of a simulation that writes no file and prints nothing."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.active = False
    settings.timeIntegration.verboseMode = 0
    return settings


def solve(solver: Any, system: Any, settings: Any) -> bool:
    """Let a solver run a system; returns whether it came to the end."""
    try:
        return solver.SolveSystem(system, settings)
    except (SystemError, exudyn.ExudynError) as error:  # how Ctrl-C in a user function comes out
        if isinstance(error.__cause__, KeyboardInterrupt) or "KeyboardInterrupt" in str(error):
            raise KeyboardInterrupt from None
        raise


class System:
    """An assembled system: states in, mass matrix and right-hand side out.

    size: of its coordinates, all of one node; objects: made of the node's number, numbered from 0.
    """

    def __init__(
        self, size: int, objects: Callable[[int], Sequence[Any]], sensors: Sequence[Any] = ()
    ) -> None:
        self.container = exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        node = self.system.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=[0.0] * size,
                initialCoordinates=[0.0] * size,
                initialCoordinates_t=[0.0] * size,
                numberOfODE2Coordinates=size,
            )
        )
        for each in objects(node):
            self.system.AddObject(each)
        for each in sensors:
            self.system.AddSensor(each)
        self.system.Assemble()
        self.settings = _settings()
        self.solver = exudyn.MainSolverExplicit()
        self.solver.InitializeSolver(self.system, self.settings)

    def put(self, q: np.ndarray, v: np.ndarray) -> None:
        """Put the system into a state at time 0."""
        data = self.system.systemData
        for configuration in (INITIAL, CURRENT):
            data.SetTime(0.0, configuration)
            data.SetODE2Coordinates(q, configuration)
            data.SetODE2Coordinates_t(v, configuration)

    def mass_matrix(self) -> np.ndarray:
        """M of the state, shape (size, size)."""
        self.solver.ComputeMassMatrix(self.system)
        return np.array(self.solver.GetSystemMassMatrix())

    def right_hand_side(self) -> np.ndarray:
        """M q'' of the state, shape (size,)."""
        self.solver.ComputeODE2RHS(self.system)
        return np.array(self.solver.GetSystemResidual())


class Engine(System):
    """Bodies of an arm under a force: also advanced states out.

    force: the generalized forces on the tree, which calls it itself: a connector beside the tree
    costs the engine more. gravity [m/s^2]: along the base's x and y.
    The engine's own clock counts from the last ``place``; the force adds ``clock[0]``. Summing
    0.00001 s over a whole run instead would drift by 1e-11 s in 3 s, and with it the step.
    """

    def __init__(
        self,
        bodies: Sequence[TreeBody],
        force: UserFunction | None,
        clock: list[float],
        gravity: tuple[float, float],
    ) -> None:
        super().__init__(len(bodies), lambda node: [_tree(node, bodies, force, gravity)])
        self.clock = clock

    def place(self, t: float, q: np.ndarray, v: np.ndarray) -> None:
        """Put the arm into a state at a time [s]."""
        self.clock[0] = t
        self.put(q, v)

    def linearize(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """M, K and D of M q'' + D q' + K q = 0 about the state, each (bodies, bodies)."""
        mass, stiffness, damping = self.system.ComputeLinearizedSystem()
        return np.array(mass), np.array(stiffness), np.array(damping)

    def advance(self, steps: int, step_s: float) -> tuple[np.ndarray, np.ndarray]:
        """q and v after this many steps of RK44 from the state.

        Raises FloatingPointError if the solver fails or its result is not finite.
        """
        time = self.settings.timeIntegration
        time.numberOfSteps, time.endTime = steps, steps * step_s
        solved = solve(self.solver, self.system, self.settings)
        data = self.system.systemData
        q, v = np.array(data.GetODE2Coordinates()), np.array(data.GetODE2Coordinates_t())
        if not (solved and np.isfinite(q).all() and np.isfinite(v).all()):
            raise FloatingPointError(self.solver.GetErrorString() or "not finite")
        return q, v


def _settings() -> Any:
    settings = quiet_settings()
    settings.timeIntegration.solverType = exudyn.DynamicSolverType.RK44
    settings.timeIntegration.explicit.computeEndOfStepAccelerations = False
    return settings


def _tree(
    node: int, bodies: Sequence[TreeBody], force: UserFunction | None, gravity: tuple[float, float]
) -> Any:
    return items.ObjectKinematicTree(
        nodeNumber=node,
        jointTypes=[exudyn.JointType.RevoluteZ] * len(bodies),
        linkParents=[body.parent for body in bodies],
        jointTransformations=exudyn.Matrix3DList([np.eye(3)] * len(bodies)),
        jointOffsets=exudyn.Vector3DList([np.array([*body.joint_at, 0.0]) for body in bodies]),
        linkInertiasCOM=exudyn.Matrix3DList([np.diag([0, 0, body.inertia]) for body in bodies]),
        linkCOMs=exudyn.Vector3DList([np.array([body.com_x, 0.0, 0.0]) for body in bodies]),
        linkMasses=[body.mass for body in bodies],
        gravity=[*gravity, 0.0],
        forceUserFunction=force or 0,  # 0: none
    )
