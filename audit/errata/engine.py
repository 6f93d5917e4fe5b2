"""The first answer of a cross-check, for the paper's arm: the printed equations and an engine."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from crosscheck.analytic.paper.printed import printed_form
from crosscheck.audit.errata.erratum import FormSide, PhysicalSide, simulated
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.checks.states import LOOSEST
from crosscheck.checks.trajectories import largest_difference
from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_arm, load_scenario
from crosscheck.planning.comparison import Results, tasks_of
from crosscheck.planning.state_suite import COUNT, geared

PRINTED, ENGINE = "analytic:printed", "pinocchio:gears"
SEED = 0  # of the states, as of a cross-check
EXPERIMENTS = ("constant-torque", "pd")


@dataclass(frozen=True)
class RunsApart:
    """The largest differences of two runs: joint angle [rad], sun-planet mesh force [N]."""

    duration_s: float
    theta_rad: float
    F_sp_N: float


@dataclass(frozen=True)
class BesideEngine:
    """The largest relative differences of M and of the acceleration over random states.

    runs: of the same experiments, beside the derivation that agrees with the engines to rounding.
    """

    mass_matrix: float | None
    acceleration: float | None
    states: int
    runs: dict[str, RunsApart]

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
class PrintedBeside(Question[BesideEngine]):
    """A question: Eqs. 21-22 as printed beside Pinocchio, and through both experiments.

    longest_s: no run is longer.
    """

    cost = 5.0

    arm: str
    longest_s: float

    def records(self) -> Records:
        return load_arm(self.arm), *map(load_scenario, EXPERIMENTS)

    def answer(self) -> BesideEngine:
        arm, runs = load_arm(self.arm), {}
        mass, acceleration = (self._apart(arm, name) for name in ("mass_matrix", "acceleration"))
        for name in EXPERIMENTS:  # as a cross-check runs and records them
            own = load_scenario(name)
            duration_s = min(own.duration_s, self.longest_s)
            scenario = own.model_copy(update={"duration_s": duration_s})
            sides = FormSide(arm, printed_form()), PhysicalSide(arm)
            printed, right = (simulated(side, scenario) for side in sides)
            sizes = (largest_difference(printed, right, each) for each in ("theta", "F_sp"))
            runs[name] = RunsApart(duration_s, *sizes)
        return BesideEngine(mass, acceleration, COUNT, runs)

    def _apart(self, arm: Arm, quantity: str) -> float | None:
        """Largest relative difference as a cross-check measures it; None without a usable one."""
        (comparison,) = (
            one
            for one in geared(arm, COUNT, SEED, arm.model_dump())
            if (one.about.key.left, one.about.key.right) == (PRINTED, ENGINE)
            and one.about.key.quantity == quantity
        )
        outcomes = {task.key: task.perform() for task in tasks_of([comparison])}
        return comparison.finding(Results(outcomes)).measured
