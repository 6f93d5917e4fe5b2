"""Every two engines' simulations: the runs that ``simulate`` makes, by each engine's own way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from crosscheck.checks.answers import require_numbers
from crosscheck.checks.engines import STEPS, compare_motions, plan_pair
from crosscheck.checks.sampled import RobotLevel, Subjects, pair_models
from crosscheck.models.errors import Diverged
from crosscheck.models.experiment.scenario import ConstantDrive, Scenario, Start
from crosscheck.models.robot.interface import RobotModel
from crosscheck.planning.comparison import Comparison

# Of teeth in each other at the start [m]: on the edge of contact rounding decides who is.
DEPTH = 1e-6
BRIEF = "brief"  # name of the scenario of a simulation for which a user chose none


@dataclass(frozen=True)
class SimulationQuestion:
    """A simulation, as short as all runs of a case."""

    scenario: Scenario

    @property
    def __name__(self) -> str:
        return "simulation" + f"-{self.scenario.name}" * (self.scenario.name != BRIEF)

    def __call__(self, model: RobotModel, case: RobotLevel) -> np.ndarray:
        """Coordinates (records, 1, n), infinite if it diverged."""
        shape = STEPS + 1, case.states.q.shape[1]
        try:
            q, _ = model.integrate(self.scenario)
        except Diverged:
            return np.full(shape, np.inf)[:, None]
        return require_numbers(q, "integrate", shape)[:, None]


def simulation_start(case: RobotLevel) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Joints' coordinates and rates of a simulation's start, its constant torques; each (free,).

    Torques are so large that joints would have about the state's accelerations alone; those without
    a motor have none.
    """
    q, v, accelerations = (each[0, : case.free] for each in case.states[:3])
    torques = np.zeros(case.free)
    motors = case.robot.motors
    torques[motors] = (np.diagonal(case.sizes.mass_matrix[0])[: case.free] * accelerations)[motors]
    return q, v, torques


def make_scenario(case: RobotLevel) -> Scenario:
    """The scenario of a run with this number of steps, all recorded."""
    q, v, torques = simulation_start(case)
    return Scenario(
        schema_version=1,
        name=BRIEF,
        duration_s=case.run_s,
        step_s=case.run_s / STEPS,
        record_every=1,
        start=Start(
            theta_rad=q.tolist(),
            theta_dot_rad_per_s=v.tolist(),
            sun_planet_offset_m=DEPTH,
            planet_ring_offset_m=DEPTH,
        ),
        drive=ConstantDrive(kind="constant", torque_N_m=torques[case.robot.motors].tolist() or 0.0),
    )


def plan(subjects: Subjects) -> Iterator[Comparison | str]:
    """Comparisons of two models' simulations in equal steps."""
    cases = {each.setting.level: each.setting for each in subjects.robots}
    for level, case in cases.items():
        if not case.has_runs:
            yield f"{level}: no runs, since steps of {case.run_s / STEPS:.2g} s are below rounding"
    for left, right in pair_models(subjects.robots):
        case = left.setting
        scenarios = (case.scenarios or [make_scenario(case)]) if case.has_runs else []
        for question in map(SimulationQuestion, scenarios):
            seconds = question.scenario.duration_s
            metric = f"largest difference, over the motion, of a simulation of {seconds:.3g} s"
            yield plan_pair("same-step", question, left, right, compare_motions, metric)
