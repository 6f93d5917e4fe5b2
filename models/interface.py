"""What every model offers, whichever engine is behind it."""

from __future__ import annotations

from abc import ABC
from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from crosscheck.models.abilities import STATE_ABILITIES
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout
from crosscheck.models.arm.planets import require_alike, usual_switches
from crosscheck.models.errors import CannotDo, Diverged, InputError
from crosscheck.models.experiment.drive import drive_data, torques_along
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.loading import require_fit

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["STATE_ABILITIES", "Model", "require_finite"]


class Model(ABC):
    """Equations of motion M(q) a + bias(q, v) = f(t, q, v) of an arm in one experiment.

    Arrays are float64. q and v, shape (n,), are in the coordinates of ``layout``, whatever
    coordinates the engine uses inside: angles [rad], relative to the previous link, and mesh
    displacements [m], with their rates [rad/s], [m/s]. Forces are N m along angles and N along
    displacements; t is the time [s]. ``abilities`` names the methods that this model has; the
    others raise CannotDo. Those of a single state take lists as well, and raise InputError for what
    is no state; with ``takes_many_states`` they also take t (states,), q and v (states, n), and
    answer along a first axis.

    Args:
        arm: The arm.
        scenario: The experiment; its lists of one value per joint must fit the arm.
        chosen_switches: Laws of the gear model; without them, the usual ones of the arm.

    Raises:
        InputError: Arm, scenario and switches do not fit each other.
    """

    name: str
    abilities: ClassVar[frozenset[str]]
    takes_many_states: ClassVar[bool] = False
    layout: Layout

    def __init_subclass__(cls, **options: Any) -> None:
        """Have every model take lists as well as arrays, and refuse what is no state."""
        super().__init_subclass__(**options)
        for name in set(STATE_ABILITIES) & set(vars(cls)):
            setattr(cls, name, _take_states(vars(cls)[name]))

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        require_fit(scenario, arm)
        self.arm = arm
        self.scenario = scenario
        self.switches = chosen_switches or usual_switches(arm)
        require_alike(arm, scenario, self.switches)

    def __repr__(self) -> str:
        """Which model it is, of what, and what it can be asked."""
        laws = ", ".join(f"{name} {value}" for name, value in self.switches)
        return "\n".join(
            (
                f"Model {self.name} of {self.arm.name}, experiment {self.scenario.name}",
                f"coordinates: {', '.join(self.coordinates)}",
                f"methods: {', '.join(sorted(self.abilities))}",
                f"laws: {laws}",
            )
        )

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates (n,), in the order of q."""
        return self.layout.names

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """Mass matrix M(q) (n, n) on the left of the equation.

        kg m^2 between angles, kg between displacements, kg m between an angle and a displacement.
        """
        raise CannotDo(f"{self.name} has no mass_matrix")

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal force C(q, v) v (n,) on the left, of which weight is no part."""
        raise CannotDo(f"{self.name} has no bias")

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Generalized force f (n,) on the right: drive, meshes, dampers, friction and gravity."""
        raise CannotDo(f"{self.name} has no generalized_force")

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Accelerations q'' (n,) [rad/s^2], [m/s^2] that solve the equation."""
        raise CannotDo(f"{self.name} has no acceleration")

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Torques on the output side that a rigid arm's motors must give, whatever the drive.

        Angles q, rates v, accelerations a [rad/s^2] and the torques [N m] are (states, joints).
        """
        torques = [
            self.mass_matrix(at) @ acceleration
            + self.bias(at, rate)
            - self.generalized_force(0.0, at, rate)
            for at, rate, acceleration in zip(q, v, a, strict=True)
        ]
        drive = drive_data(self.scenario, q.shape[1])
        return np.array(torques).reshape(q.shape) + torques_along(drive, np.zeros(len(q)), q, v)

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates q and rates v of the scenario's start."""
        raise CannotDo(f"{self.name} has no start")

    def simulate(self) -> xr.Dataset:
        """Run the scenario from its start, with its fixed step where the integrator has one.

        Returns:
            The run over ``time`` [s], see ``crosscheck.models.trajectory``.

        Raises:
            Diverged: The run left the range in which its numbers mean anything.
        """
        raise CannotDo(f"{self.name} has no simulate")

    def reference(self, rtol: float) -> xr.Dataset:
        """The run of ``simulate`` by adaptive steps; rtol: relative tolerance of a step."""
        raise CannotDo(f"{self.name} has no reference")

    def precise(self, rtol: float) -> xr.Dataset:
        """The same by steps that end where contacts change. Raises CannotDo, Diverged."""
        raise CannotDo(f"{self.name} has no precise run")

    def mesh_modes(self) -> np.ndarray:
        """Frequencies of the modes with every tooth in contact at mean stiffness.

        In Hz, ascending; without mesh damping, with the drive's feedback, in the scenario's start
        pose.
        """
        raise CannotDo(f"{self.name} has no mesh_modes")

    def contact_poles(self) -> np.ndarray:
        """Complex eigenvalues (2 n,) [1/s] of the motion about the start pose at rest.

        With every tooth in contact at mean stiffness, damping, friction, weight and the drive's
        feedback.
        """
        raise CannotDo(f"{self.name} has no contact_poles")

    def constraint_residual(
        self, q: np.ndarray, v: np.ndarray, a: np.ndarray, opened: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """How far open the joints are that a model closes by constraint equations.

        Args:
            q: Coordinates (n,).
            v: Their rates (n,).
            a: Their accelerations (n,).
            opened: Gaps, rates and accelerations (3, gaps) by which the bodies are displaced before
                they are asked, so that this is what a right answer is.

        Returns:
            Gaps [m], their rates [m/s] and accelerations [m/s^2], each of shape (gaps,).
        """
        raise CannotDo(f"{self.name} has no constraint_residual")

    def largest_stable_step(self) -> float:
        """Largest stable step [s] of the integrator; inf where steps are adaptive or implicit."""
        return float("inf")


def _take_states(method: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """Wrap a method of a model so that its states are arrays of one number per coordinate.

    A model that takes many states at once gets an array (states, n) as it is.
    """
    names = method.__code__.co_varnames[1 : method.__code__.co_argcount]
    places = [place for place, name in enumerate(names) if name in ("q", "v")]

    @wraps(method)
    def take_states(self: Model, *values: Any, **named: Any) -> np.ndarray:
        if named:
            values += tuple(named[name] for name in names[len(values) :] if name in named)
        shape = (len(self.coordinates),)
        for place in places[: len(values)]:
            value = values[place]
            many = self.takes_many_states and np.ndim(value) == 2
            if type(value) is not np.ndarray or value.shape[many:] != shape:
                state = _state(value, names[place], self)
                values = (*values[:place], state, *values[place + 1 :])
        return method(self, *values)

    return take_states


def _state(value: Any, name: str, model: Model) -> np.ndarray:
    """The value as an array (n,). Raises InputError."""
    allowed = (
        f"must be numbers of shape ({len(model.coordinates)},): {', '.join(model.coordinates)}"
    )
    try:
        state = value if isinstance(value, np.ndarray) else np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(model.name, name, value, allowed) from None
    if state.shape != (len(model.coordinates),):
        raise InputError(model.name, name, None, f"{allowed}; has shape {state.shape}")
    return state


def require_finite(name: str, time: np.ndarray, *values: np.ndarray) -> None:
    """Raise Diverged at the first time [s] at which a value, shape (times, ...), is not finite."""
    finite = np.ones(len(time), dtype=bool)
    for value in values:
        finite &= np.isfinite(value.reshape(len(time), -1)).all(axis=1)
    if not finite.all():
        raise Diverged(name, float(time[np.argmin(finite)]))
