"""Work on one model, for another process: a run, or one of its functions at many states.

Whatever the model does comes back as an outcome: an array, a trajectory, or the Failure that says
why there is none. One function of one model is one task, so that a failure stays where it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from crosscheck.checks.answers import BadAnswer, Setting
from crosscheck.checks.records import require_complete, require_consistent
from crosscheck.checks.sampled import ModelQuestion, RobotLevel
from crosscheck.models.interface import Model
from crosscheck.models.loading import Case
from crosscheck.models.robot.interface import RobotModel
from crosscheck.registry import MODELS, RIGID_LEVELS, Entry, build, build_robot_model, engine_of
from crosscheck.runner.outcomes import SelfKeyedTask, return_failures

if TYPE_CHECKING:
    import xarray as xr


FORMS = "analytic:energies", "analytic:printed"  # forms whose symbols are available
PRECISE = "precise"  # how the names of such runs begin


@dataclass(frozen=True)
class RunKey:
    """The name of a run: experiment, model, and which of the model's runs there."""

    experiment: str
    model: str
    variant: str = ""

    def __str__(self) -> str:
        return "/".join(filter(None, (self.experiment, self.model, self.variant)))


@dataclass(frozen=True)
class Simulation:
    """A task: one run of one model.

    ``rtol`` asks for the model's adaptive reference instead of fixed steps, or, of a variant that
    is called so, for its precise run.
    """

    key: RunKey
    case: Case
    rtol: float | None = None

    @property
    def model(self) -> str:
        """Name of the model that runs."""
        return self.key.model

    @property
    def cost(self) -> float:
        """Estimated cost [s], to start the longest first."""
        steps = self.case.scenario.steps
        return steps * MODELS[self.model].call_s * (4 if self.rtol else 1)

    @return_failures
    def perform(self) -> xr.Dataset:
        """The whole trajectory, or the Failure that says why there is none."""
        entry, model = MODELS[self.model], build_model(self.model, self.case)
        if self.rtol is None:
            run = model.simulate()
        else:
            run = (model.precise if self.is_precise else model.reference)(self.rtol)
        has_tooth_signals = entry.role != "supplied"
        meshing = bool(entry.layout(self.case.arm, self.case.switches).mesh_joints)
        require_complete(run, self.model, self.case, meshing=meshing and has_tooth_signals)
        if has_tooth_signals:
            require_consistent(run, model, constrained="constraint_residual" in entry.promises)
        return run

    def ask(self, question: ModelQuestion) -> Evaluation:
        """Make the task that asks the run's model a question."""
        return ask_model(self.model, self.case, question)

    @property
    def is_precise(self) -> bool:
        """Whether the run is a precise one, whose steps end where contacts change."""
        return self.key.variant.startswith(PRECISE)


@dataclass(frozen=True)
class Evaluation(SelfKeyedTask):
    """A task: one question to a model, at the states of a setting; see checks.answers."""

    model: str
    setting: Setting | RobotLevel
    question: ModelQuestion

    @property
    def quantity(self) -> str:
        """The question's name."""
        return self.question.__name__

    @property
    def cost(self) -> float:
        """Estimated cost [s]: building the model, then a few calls for every state."""
        if isinstance(self.setting, RobotLevel):
            return 0.05 + 5e-4 * self.setting.states.q.size
        return 0.01 + 10 * self.setting.count * MODELS[self.model].call_s

    @return_failures
    def perform(self) -> np.ndarray:
        """The answers, the states along the first axis, or a Failure where there are none."""
        return self.question(self._build(), self.setting)

    def _build(self) -> Model | RobotModel:
        """The model. Raises BadAnswer if an arm's has other coordinates than it must have."""
        if isinstance(self.setting, RobotLevel):
            at = self.setting.robot, self.setting.level
            return build_robot_model(engine_of(self.model), *at)
        model, expected = build_model(self.model, self.setting.case), self.setting.layout
        if model.layout != expected:
            raise BadAnswer(f"coordinates are {model.layout.names}, must be {expected.names}")
        return model


def ask_model(
    name: str, case: Case, question: ModelQuestion, count: int = 1, seed: int = 0
) -> Evaluation:
    """Make the task of a question to a model of an arm in a case, at a seed's random states."""
    return Evaluation(name, make_setting(name, case, count, seed), question)


def make_setting(name: str, case: Case, count: int = 1, seed: int = 0) -> Setting:
    """Random states of a model of an arm in a case; a rigid one of no level has rigid gears."""
    entry = MODELS[name]
    level = entry.level or RIGID_LEVELS[-1] if entry.is_rigid else ""
    return Setting(case, level, count, seed)


@dataclass(frozen=True)
class SymbolicEvaluation(SelfKeyedTask):
    """A task: work out a form of the paper in symbols, at the states that its model answers."""

    form: str
    setting: Setting
    question: ModelQuestion
    cost = 1.0  # rough seconds

    @property
    def model(self) -> str:
        """Name of what answers: the model's symbols."""
        return f"{self.form} in symbols"

    @property
    def quantity(self) -> str:
        """The question's name."""
        return self.question.__name__

    @return_failures
    def perform(self) -> np.ndarray:
        """M (count, n, n) or the bias (count, n), or why there is none."""
        import sympy as sp  # half a second, for this alone

        from crosscheck.analytic.derivation.symbols import parameter_values
        from crosscheck.analytic.paper.energies import build_energies_form
        from crosscheck.analytic.paper.printed import build_printed_form

        forms = dict(zip(FORMS, (build_energies_form, build_printed_form), strict=True))
        form, states = forms[self.form](), self.setting.states
        numbers = {s: sp.Float(float(x), 17) for s, x in parameter_values(self.setting.arm).items()}
        entries = getattr(form, self.quantity).xreplace(numbers)
        evaluate = sp.lambdify((form.q, form.v), entries, "numpy")
        values = [np.array(evaluate(q, v), dtype=float) for _, q, v in zip(*states, strict=True)]
        return np.array([v[:, 0] if v.shape[1] == 1 else v for v in values])


def build_model(name: str, case: Case) -> Model:
    """The named model of a case; every process remembers the last few."""
    return _build_model(name, MODELS[name], case)


@lru_cache(maxsize=8)
def _build_model(name: str, entry: Entry, case: Case) -> Model:
    """The model of a case, kept by its entry too: supplied models may follow under one name."""
    return build(name, *case)
