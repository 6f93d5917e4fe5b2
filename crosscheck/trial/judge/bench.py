"""What is on trial, as the plan and the views of a trial see it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import Case
from crosscheck.planning.sizing import unequal_gains
from crosscheck.registry import MODELS, RIGID_LEVELS, lead, names, of_level, promising
from crosscheck.trial.coordinates.frame import Frame, frame_of
from crosscheck.trial.coordinates.states import UserState, states_of
from crosscheck.trial.input.equations import Equations, Gearing
from crosscheck.trial.judge.questions import StateQuestion

# Enough to tell all the waves and signals apart that an entry may hold.
STATES, QUICK_STATES = 300, 150
LEAST_STATES = 20
MOST_BYTES = 300_000_000  # of the terms of a bias at all states, of which a trial holds several


@dataclass(frozen=True)
class Bench:
    """Equations under a name, and the case and states at which they are asked.

    has: the parts that they have, or that follow from those.
    """

    name: str
    equations: Equations
    has: frozenset[str]
    case: Case
    count: int = STATES
    seed: int = 0

    @property
    def gearing(self) -> Gearing:
        """Of the coordinates."""
        return self.equations.coordinates.gearing

    @cached_property
    def frame(self) -> Frame:
        """Of the arm on trial. Raises InputError."""
        return frame_of(self.equations.coordinates, self.case.arm)

    @cached_property
    def states(self) -> tuple[UserState, ...]:
        """At which everything is asked."""
        return states_of(self.frame, self.case.arm, self.case.scenario, self.count, self.seed)

    @property
    def levels(self) -> tuple[str, ...]:
        """The rigid levels that the model may be, the richest last; '' of a geared one."""
        if self.gearing != "rigid":
            return ("",)
        return (self.equations.level,) if self.equations.level else RIGID_LEVELS

    def engines(self, level: str = "") -> tuple[str, ...]:
        """The models that it is held against: geared, or of a rigid level, the lead first."""
        if level:
            return tuple(sorted(of_level(level), key=lambda name: MODELS[name].order is None))
        return tuple(dict.fromkeys((lead(), *promising("mass_matrix", names("geared")))))

    def reference(self, level: str) -> str:
        """The model that entries are held against one by one."""
        return self.engines(level)[0]

    def on(self, arm: Arm) -> Bench:
        """The same equations with the numbers of another arm. Raises InputError."""
        case = Case(arm, unequal_gains(arm), self.case.switches)
        return replace(self, equations=self.equations.on(arm, case.scenario), case=case)

    def yours(self, quantity: str) -> StateQuestion:
        """The question of a part of it."""
        return self.ask(self.name, quantity)

    def ask(self, model: str, quantity: str) -> StateQuestion:
        """The same question to another model, in these coordinates."""
        return StateQuestion(self.name, model, self.case, quantity, self.count, self.seed)
