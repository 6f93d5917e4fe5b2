"""The first call of every function that was handed over, before anything is asked of it.

What can be no equation of this arm (a wrong shape, a complex number) is bad input and ends the
trial here. A function that never returns or takes its process down costs one call, not many.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from crosscheck.checks.answers import BadAnswer
from crosscheck.models.errors import InputError
from crosscheck.models.loading import Case
from crosscheck.planning.comparison import ModelTask
from crosscheck.run import performed
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.tasks import Evaluation, Simulation, built
from crosscheck.runner.underway import Told
from crosscheck.runner.workers import Workers
from crosscheck.trial.coordinates.frame import counted
from crosscheck.trial.coordinates.states import UserState, states_of
from crosscheck.trial.input.calls import SuppliedEquations, handed
from crosscheck.trial.judge.questions import AGAIN, Bench, StateQuestion
from crosscheck.trial.model import HandedModel


@dataclass(frozen=True)
class FirstCall:
    """One of a handed model's own functions, at one state."""

    model: str
    part: str
    case: Case
    seed: int
    cost = 0.01

    @property
    def key(self) -> FirstCall:
        """Itself."""
        return self

    @property
    def quantity(self) -> str:
        """What is asked, for the progress."""
        return self.part

    def perform(self) -> InputError | None:
        """What makes its answer unusable; None also where it raises, which is told later."""
        asker = built(self.model, self.case)
        assert isinstance(asker, HandedModel)  # as it was registered
        try:
            (state,) = states_of(asker.frame, self.case.arm, self.case.scenario, 1, self.seed)
            _call(asker.handed, self.part, state)
        except BadAnswer as error:
            count = counted(asker.equations.coordinates, len(asker.frame.names), self.case.arm)
            return InputError(self.model, "", None, f"{error}; x are {count}")
        except BaseException:  # also SystemExit and KeyboardInterrupt out of a model
            return None
        return None


def _call(own: SuppliedEquations, part: str, state: UserState) -> None:
    if part == "inverse_dynamics":
        own.inverse_dynamics(state.x, state.u, state.u)
    elif part == "mass_matrix":
        own.mass_matrix(state.x)
    elif part in ("bias", "coriolis"):
        own.bias(state.x, state.u)
    else:
        ask = own.force if part == "force" else own.acceleration
        ask(state.t, state.x, state.u, state.torque)


def first_calls(bench: Bench, workers: Workers, told: Told) -> dict[str, Failure]:
    """The parts whose function did not come back, with why; none of a table. Raises InputError."""
    if bench.equations.table is not None:
        return {}
    tasks = [FirstCall(bench.name, part, bench.case, bench.seed) for part in _given(bench)]
    outcomes = performed(workers, tasks, told).outcomes
    lost = {}
    for task in tasks:
        outcome: object = outcomes[task]
        if isinstance(outcome, InputError):
            raise outcome
        if isinstance(outcome, Failure):
            lost[task.part] = replace(outcome, message=f"{task.part}: {outcome.message}")
    return lost


def spared(
    bench: Bench, tasks: Iterable[ModelTask], lost: dict[str, Failure]
) -> dict[ModelTask, Failure]:
    """The tasks that would call a function that does not come back."""
    found = {}
    for task in tasks:
        parts = _behind(bench, task) if task.model == bench.name else ()
        reasons = [lost[part] for part in parts if part in lost]
        if reasons:
            found[task] = reasons[0]
    return found


def _given(bench: Bench) -> list[str]:
    return sorted(handed(bench.equations, bench.case.arm, bench.frame).given)


def _behind(bench: Bench, task: ModelTask) -> tuple[str, ...]:
    """The user's own functions that a task on the model calls."""
    given = _given(bench)
    mass = tuple(part for part in ("mass_matrix", "inverse_dynamics") if part in given)[:1]
    bias = tuple(part for part in ("bias", "coriolis", "inverse_dynamics") if part in given)[:1]
    whole = ("acceleration",) if "acceleration" in given else (*mass, *bias, "force")
    if isinstance(task, Simulation):
        return (*whole, *mass)
    assert isinstance(task, StateQuestion | Evaluation)  # nothing else is asked of it
    about = task.quantity.removesuffix(AGAIN)
    return {
        "mass_matrix": mass,
        "christoffel": mass,
        "bias": bias,
        "rate_terms": bias,
        "other_speeds": bias,
        "acceleration": whole,
        "inverse_dynamics": ("inverse_dynamics", *mass, *bias),
    }.get(about, ("force",))
