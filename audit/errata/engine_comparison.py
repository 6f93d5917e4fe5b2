"""The first answer of a cross-check, for the paper's arm: the printed equations and an engine."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from crosscheck.analytic.paper.printed import build_printed_form
from crosscheck.audit.errata.erratum import PaperModelFactory, run_model
from crosscheck.audit.experiments.study import Question, Records
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.checks.states import LOOSEST
from crosscheck.checks.trajectories import largest_difference
from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning.comparison import Results, collect_tasks
from crosscheck.planning.state_suite import COUNT, plan_geared_comparisons

PRINTED, ENGINE = "analytic:printed", "pinocchio:gears"
SEED = 0  # of the states, as of a cross-check
EXPERIMENTS = ("constant-torque", "pd")


@dataclass(frozen=True)
class RunDifferences:
    """The largest differences of two runs: joint angle [rad], sun-planet mesh force [N]."""

    duration_s: float
    theta_rad: float
    F_sp_N: float


@dataclass(frozen=True)
class EngineComparison:
    """The largest relative differences of M and of the acceleration over random states.

    runs: of the same experiments, beside the derivation that agrees with the engines to rounding.
    """

    mass_matrix: float | None
    acceleration: float | None
    states: int
    runs: dict[str, RunDifferences]

    @property
    def agrees(self) -> bool | None:
        """Whether both differences are no more than rounding; None if one is undefined."""
        if self.mass_matrix is None or self.acceleration is None:
            return None
        return max(self.mass_matrix, self.acceleration) <= LOOSEST

    def to_dict(self) -> JsonObject:
        """The comparison as a JSON object."""
        return {"id": "finding/printed", **asdict(self)}


@dataclass(frozen=True)
class PrintedEquationsQuestion(Question[EngineComparison]):
    """A question: Eqs. 21-22 as printed beside Pinocchio, and through both experiments.

    longest_s: no run is longer.
    """

    cost = 5.0

    arm: str
    longest_s: float

    def records(self) -> Records:
        return load_arm(self.arm), *map(load_scenario, EXPERIMENTS)

    def answer(self) -> EngineComparison:
        arm, runs = load_arm(self.arm), {}
        mass, acceleration = (
            self._relative_difference(arm, name) for name in ("mass_matrix", "acceleration")
        )
        for name in EXPERIMENTS:  # as a cross-check runs and records them
            full_scenario = load_scenario(name)
            duration_s = min(full_scenario.duration_s, self.longest_s)
            scenario = full_scenario.model_copy(update={"duration_s": duration_s})
            sides = PaperModelFactory(arm, build_printed_form()), PaperModelFactory(arm)
            printed, derived = (run_model(side, scenario) for side in sides)
            sizes = (largest_difference(printed, derived, each) for each in ("theta", "F_sp"))
            runs[name] = RunDifferences(duration_s, *sizes)
        return EngineComparison(mass, acceleration, COUNT, runs)

    def _relative_difference(self, arm: Arm, quantity: str) -> float | None:
        """Largest relative difference as a cross-check measures it; None without a usable one."""
        (comparison,) = (
            candidate
            for candidate in plan_geared_comparisons(arm, COUNT, SEED, arm.model_dump())
            if (candidate.about.key.left, candidate.about.key.right) == (PRINTED, ENGINE)
            and candidate.about.key.quantity == quantity
        )
        outcomes = {task.key: task.perform() for task in collect_tasks([comparison])}
        return comparison.finding(Results(outcomes)).measured
