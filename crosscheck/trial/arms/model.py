"""A user's equations as a Model of the arm, so that all that is done with models can be done."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.experiment.drive import drive_data, torques_at
from crosscheck.models.experiment.integration import integrate_scenario
from crosscheck.models.experiment.scenario import Scenario, Switches
from crosscheck.models.interface import STATE_ABILITIES, Model, require_finite
from crosscheck.models.signal_map import map_arm
from crosscheck.models.trajectory import recorded_times, trajectory
from crosscheck.registry import Entry, build, find_level_models, reference_model
from crosscheck.trial.coordinates.build import build_frame
from crosscheck.trial.coordinates.functions import map_calls
from crosscheck.trial.input.equations import Equations
from crosscheck.trial.input.supplied import SuppliedEquations, bind_equations
from crosscheck.trial.judge.checks import WHOLE

if TYPE_CHECKING:
    import xarray as xr

CALL_S = 2e-4  # [s] that a tooth force or a bias takes a user's Python, at most


class SuppliedModel(Model):
    """Supplied equations as a model in the project's coordinates; RK4 in Python."""

    equations: ClassVar[Equations]

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        super().__init__(arm, scenario, select_switches(self.equations, arm, chosen_switches))
        equations = self.equations.adapt_to_arm(arm, scenario)
        self.frame = build_frame(equations.coordinates, arm)
        self.layout: Layout = self.frame.layout
        self.supplied: SuppliedEquations = bind_equations(equations, arm, self.frame)
        again = equations if equations.table is None else equations.table.again
        self.repeated_equations: SuppliedEquations = bind_equations(again, arm, self.frame)
        self.drive = drive_data(scenario, len(arm.joints))
        answers = {part: partial(self.supplied.answer, part) for part in WHOLE}
        answers["force"] = partial(self.supplied.answer, "whole_force")
        self.calls = map_calls(answers, self.frame, self.name)

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M, shape (n, n)."""
        return self.calls["mass_matrix"]({"x": q})

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Coriolis and centrifugal force, shape (n,)."""
        return self.calls["bias"]({"x": q, "v": v})

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The force with the weights, shape (n,)."""
        return self.calls["force"]({"t": t, "x": q, "v": v, "torque": self.torques(t, q, v)})

    def acceleration(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q'', shape (n,)."""
        return self.calls["acceleration"]({"t": t, "x": q, "v": v, "torque": self.torques(t, q, v)})

    def torques(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Output torques [N m] of the scenario's drive, shape (joints,)."""
        theta = self.layout.theta
        return torques_at(self.drive, t, q[theta], v[theta])

    def largest_stable_step(self) -> float:
        """Largest stable step [s] of the model that it is compared with: same integrator."""
        return _build_reference(self).largest_stable_step()

    def simulate(self) -> xr.Dataset:
        """Trajectory by fixed-step RK4, from the start of the model that it is compared with."""
        time, start = recorded_times(self.scenario), _build_reference(self).start()
        qs, vs = integrate_scenario(self.acceleration, start, self.scenario)
        require_finite(self.name, time, qs, vs)
        return self._make_trajectory(time, qs, vs)

    def _make_trajectory(self, time: np.ndarray, qs: np.ndarray, vs: np.ndarray) -> xr.Dataset:
        """The trajectory through states (times, n)."""
        moments = list(zip(time, qs, vs, strict=True))
        accelerations = np.array([self.acceleration(*moment) for moment in moments])
        energy = np.array([v @ self.mass_matrix(q) @ v / 2 for _, q, v in moments])
        signals = map_arm(self.arm, self.layout)
        variables = signals.record_run(self.drive, time, (qs, vs, accelerations))
        return trajectory(self, time, **variables, kinetic_energy=energy)


def _build_reference(supplied: SuppliedModel) -> Model:
    """The model that equations are compared with: it says where to start, which step is stable."""
    level = supplied.equations.level or "links"
    name = reference_model() if supplied.layout.mesh_joints else find_level_models(level)[0]
    return build(name, supplied.arm, supplied.scenario, supplied.switches)


def select_switches(equations: Equations, arm: Arm, chosen: Switches | None) -> Switches:
    """The laws that equations follow: what was chosen, or their own; planets as they count them.

    A model with these raises InputError for an arm whose planets differ if they are counted as one.
    """
    laws = chosen or equations.switches or usual_switches(arm)
    gearing = equations.coordinates.gearing
    if gearing == "rigid":
        return laws
    return laws.model_copy(update={"planets": gearing})


def make_registry_entry(name: str, equations: Equations, has: frozenset[str]) -> Entry:
    """The entry that stands for equations in the registry during a trial."""
    part_abilities = {"generalized_force" if p == "force" else p for p in has.intersection(WHOLE)}
    abilities = frozenset(
        part_abilities | ({"simulate"} if part_abilities >= {*STATE_ABILITIES} else set())
    )
    attributes = {"name": name, "equations": equations, "abilities": abilities}
    return Entry(
        module=__name__,
        attribute="SuppliedModel",
        role="rigid" if equations.coordinates.gearing == "rigid" else "supplied",
        promises=abilities,
        order=4,
        call_s=CALL_S,
        made=type("SuppliedEquations", (SuppliedModel,), attributes),
    )
