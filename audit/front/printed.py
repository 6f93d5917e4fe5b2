"""The first answer of a cross-check, for the paper's arm: the printed equations and an engine."""

from __future__ import annotations

from dataclasses import dataclass

from analytic.paper.printed import printed_form
from audit.errata.erratum import Effect, Trial, effect_of
from audit.errata.finder import effect_scenarios
from audit.errata.sides import FormSide, PhysicalSide
from audit.experiments.variant import spelled_out
from audit.page.record import JsonObject
from crosscheck.checks.states import LOOSEST
from crosscheck.planning.comparison import Results, tasks_of
from crosscheck.planning.state_suite import COUNT, geared
from models.experiment.switches import switches
from models.loading import load_arm

PRINTED, ENGINE = "analytic:printed", "pinocchio:gears"
SEED = 0  # of the states, as of a cross-check


@dataclass(frozen=True)
class BesideEngine:
    """Largest relative differences of M and of the acceleration over random states.

    effects: of all errors of M and of its kinetic energies together, by experiment.
    """

    mass_matrix: float | None
    acceleration: float | None
    states: int
    effects: dict[str, Effect]

    @property
    def agrees(self) -> bool | None:
        """Whether both are no more than rounding; None if one is undefined."""
        if self.mass_matrix is None or self.acceleration is None:
            return None
        return max(self.mass_matrix, self.acceleration) <= LOOSEST

    def to_dict(self) -> JsonObject:
        """For JSON."""
        return {
            "id": "finding/printed",
            "mass_matrix": self.mass_matrix,
            "acceleration": self.acceleration,
            "states": self.states,
            **{
                f"{name}_{part}": value
                for name, effect in self.effects.items()
                for part, value in vars(effect).items()
            },
        }


@dataclass(frozen=True)
class PrintedBeside:
    """Question: Eqs. 21-22 as printed beside Pinocchio, and through both experiments."""

    arm: str
    duration_s: float

    @property
    def inputs(self) -> str:
        return spelled_out([load_arm(self.arm)], repr(self))

    @property
    def cost(self) -> float:
        return 3 + 2 * self.duration_s

    def answer(self) -> BesideEngine:
        mass, acceleration = (self._apart(name) for name in ("mass_matrix", "acceleration"))
        arm = load_arm(self.arm)
        trial = Trial(FormSide(arm, printed_form()), PhysicalSide(arm, switches()))
        effects = {one.name: effect_of(trial, one) for one in effect_scenarios(self.duration_s)}
        return BesideEngine(mass, acceleration, COUNT, effects)

    def _apart(self, quantity: str) -> float | None:
        """As a cross-check measures it; None where a model gives no usable answer."""
        arm = load_arm(self.arm)
        (comparison,) = (
            one
            for one in geared(arm, COUNT, SEED, arm.model_dump())
            if (one.about.key.left, one.about.key.right) == (PRINTED, ENGINE)
            and one.about.key.quantity == quantity
        )
        outcomes = {task.key: task.perform() for task in tasks_of([comparison])}
        return comparison.finding(Results(outcomes)).measured
