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


class TreePart(NamedTuple):
    """A body of a tree, with its joint's place in the parent's frame; the joint is about its z."""

    joint: Any
    parent: int
    rotation: np.ndarray
    position: np.ndarray
    mass: float
    com: np.ndarray
    inertia: np.ndarray


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

    size: of its coordinates.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.container = exudyn.SystemContainer()
        self.system = self.container.AddSystem()

    def assemble(self, solver: Any, settings: Any) -> None:
        """Assemble what was added, for a solver."""
        self.system.Assemble()
        self.settings, self.solver = settings, solver
        solver.InitializeSolver(self.system, settings)

    def put(self, q: np.ndarray, v: np.ndarray, t: float = 0.0) -> None:
        """Put the system into a state at a time [s]."""
        data = self.system.systemData
        for configuration in (INITIAL, CURRENT):
            data.SetTime(t, configuration)
            data.SetODE2Coordinates(q, configuration)
            data.SetODE2Coordinates_t(v, configuration)

    def mass_matrix(self) -> np.ndarray:
        """M of the state, shape (size, size)."""
        self.solver.ComputeMassMatrix(self.system)
        return np.array(self.solver.GetSystemMassMatrix())

    def right_hand_side(self) -> np.ndarray:
        """M q'' of the state without constraints' reactions, shape (size,)."""
        self.solver.ComputeODE2RHS(self.system)
        return np.array(self.solver.GetSystemResidual())[: self.size]


class Engine(System):
    """A tree of bodies: also advanced states out.

    gravity [m/s^2]: along the base's axes. force: the generalized forces on the tree, which calls
    it itself: a connector beside the tree costs the engine more. friction [N m s/rad], [N s/m]: of
    the first joints' rates. diagonal: added to M's, of the first joints, too.
    The engine's own clock counts from the last ``place``; the force adds ``clock[0]``. Summing
    0.00001 s over a whole run instead would drift by 1e-11 s in 3 s, and with it the step.
    """

    def __init__(
        self,
        parts: Sequence[TreePart],
        gravity: np.ndarray,
        *,
        force: UserFunction | None = None,
        clock: list[float] | None = None,
        friction: Sequence[float] = (),
        diagonal: Sequence[float] = (),
        sensors: Sequence[Any] = (),
    ) -> None:
        size = len(parts)
        super().__init__(size)
        node = self.system.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=[0.0] * size,
                initialCoordinates=[0.0] * size,
                initialCoordinates_t=[0.0] * size,
                numberOfODE2Coordinates=size,
            )
        )
        self.system.AddObject(build_tree(node, parts, gravity, force, friction))
        if any(diagonal):
            added = np.diag([*diagonal, *[0.0] * (size - len(diagonal))])
            self.system.AddObject(items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=added))
        for each in sensors:
            self.system.AddSensor(each)
        self.clock = clock or [0.0]
        self.assemble(exudyn.MainSolverExplicit(), _settings())

    def place(self, t: float, q: np.ndarray, v: np.ndarray) -> None:
        """Put the tree into a state at a time [s]."""
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


def build_tree(
    node: int,
    parts: Sequence[TreePart],
    gravity: np.ndarray,
    force: UserFunction | None,
    friction: Sequence[float],
) -> Any:
    """The engine's tree of these bodies, on a node; friction is its own control at rest."""
    matrices, vectors = exudyn.Matrix3DList, exudyn.Vector3DList
    damping = [*friction, *[0.0] * (len(parts) - len(friction))] if any(friction) else []
    still = [0.0] * len(damping)
    return items.ObjectKinematicTree(
        nodeNumber=node,
        jointTypes=[part.joint for part in parts],
        linkParents=[part.parent for part in parts],
        jointTransformations=matrices([part.rotation for part in parts]),
        jointOffsets=vectors([part.position for part in parts]),
        linkInertiasCOM=matrices([part.inertia for part in parts]),
        linkCOMs=vectors([part.com for part in parts]),
        linkMasses=[part.mass for part in parts],
        gravity=gravity.tolist(),
        jointPositionOffsetVector=still,
        jointVelocityOffsetVector=still,
        jointPControlVector=still,
        jointDControlVector=damping,
        forceUserFunction=force or 0,  # 0: none
    )
