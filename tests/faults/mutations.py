"""Every way in which a method of a model might answer wrongly, and what a cross-check makes of it.

The tasks of a plan are performed once, unharmed. A mutant then answers for one method of one model;
only the tasks that call that method are performed again, through the same code. At states it
answers wrongly of the plan's own arm alone, with its planets lumped or free, and of runs in one
experiment alone: all else would make it easier to see.
"""

from collections import ChainMap
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from crosscheck.findings import Finding
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Switches, switches
from crosscheck.planning import plan
from crosscheck.planning.arms import plan_comparisons
from crosscheck.planning.comparison import Comparison, ModelTask, Results, collect_tasks
from crosscheck.planning.preparation import prepare_experiments
from crosscheck.registry import MODELS, load_model_class
from crosscheck.runner.outcomes import Outcome
from crosscheck.runner.tasks import Simulation
from crosscheck.runner.workers import Workers

BRIEF_S = 0.005
Mutate = Callable[[Any], Any]
ARRAYS = ("mass_matrix", "bias", "generalized_force", "acceleration")
RUNS = ("simulate", "reference", "precise")
VARIABLES = (
    *("theta", "theta_dot", "theta_ddot", "torque", "kinetic_energy"),  # of rigid models too
    *("x_sp", "x_pr", "x_sp_dot", "x_pr_dot", "F_sp", "F_pr"),
)
FACTOR = 1 + 1e-6


@dataclass(frozen=True)
class Mutant:
    """One method of one model with another answer; ``change`` is given the right one.

    laws: the switches under which it answers wrongly at states.
    """

    model: str
    method: str
    name: str
    change: Mutate
    laws: Switches

    def __str__(self) -> str:
        return f"{self.model} {self.method}, planets {self.laws.planets}: {self.name}"


def _interrupt(answer: object) -> object:
    raise KeyboardInterrupt


ANY: dict[str, Mutate] = {
    "raises": lambda answer: 1 / 0,
    "interrupts": _interrupt,
    "None": lambda answer: None,
    "a list": lambda answer: [0.0],
}


def _entry(place: tuple[int, ...], value: float) -> Mutate:
    def change(answer: np.ndarray) -> np.ndarray:
        changed = answer.copy()
        changed[place] = value
        return changed

    return change


def _off(place: tuple[int, ...]) -> Mutate:
    """One entry 1 % off; one that is zero, by 1 % of what its row and column, or its like, are."""

    def change(answer: np.ndarray) -> np.ndarray:
        changed = answer.copy()
        size = abs(answer[place])
        if answer.ndim == 2 and size < 1e-9 * np.sqrt(answer[place[0]] @ answer[place[0]]):
            size = np.sqrt(answer[place[0], place[0]] * answer[place[1], place[1]])
        elif answer.ndim == 1 and size < 1e-9 * abs(answer).max():
            size = abs(answer).max()
        changed[place] += 0.01 * size
        return changed

    return change


ARRAY: dict[str, Mutate] = {
    "one NaN": lambda a: _entry((-1,) * a.ndim, np.nan)(a),
    "one inf": lambda a: _entry((-1,) * a.ndim, np.inf)(a),
    "wrong shape": lambda a: a[..., :-1],
    "no shape": lambda a: a.sum(),
    "another dimension": lambda a: a[None],
    "complex": lambda a: a + 0j,
    "single precision": lambda a: a.astype(np.float32),
}


def _select(**index: Any) -> Mutate:
    return lambda run: run.isel(**{k: v for k, v in index.items() if k in run.dims})


def _with(name: str, change: Mutate) -> Mutate:
    return lambda run: run.assign({name: (run[name].dims, change(run[name].values))})


RUN: dict[str, Mutate] = {
    "half a run": lambda run: run.isel(time=slice(run.sizes["time"] // 2)),
    "a time missing": lambda run: run.isel(time=np.arange(run.sizes["time"]) != 1),
    "all times late": lambda run: run.assign_coords(time=run["time"] + 1e-6),
    "a joint missing": _select(joint=[0]),
    "joints in another order": _select(joint=[1, 0]),
    "a planet missing": lambda run: _select(planet=[0, 1])(run.isel(joint=[0])),
    "planets 2 and 3 without values": lambda run: (
        run.where(run["planet"] == 1) if "planet" in run.dims else run.isel(joint=[0])
    ),
    "no attributes": lambda run: run.drop_attrs(),
    "another's attributes": lambda run: run.assign_attrs(model="somebody"),
    "an array": lambda run: run["theta"],
}
VARIABLE: dict[str, Mutate] = {
    "NaN at one time": lambda v: np.where(
        np.arange(len(v)).reshape(-1, *[1] * (v.ndim - 1)) == 2, np.nan, v
    ),
    "single precision": lambda v: v.astype(np.float32),
    "sign": lambda v: -v,
    "factor 1 + 1e-6": lambda v: v * FACTOR,
    "the other joint's": lambda v: np.roll(v, 1, axis=1) if v.ndim > 1 else v * 2,
}
SCALAR: dict[str, Mutate] = {
    "NaN": lambda step: float("nan"),
    "zero": lambda step: 0.0,
    "sign": lambda step: -step,
    "a thousandth": lambda step: 1e-3 * min(step, 1e-3),
}

MODES: dict[str, Mutate] = {
    "empty": lambda modes: modes[:0],
    "one missing": lambda modes: modes[1:],
    "one twice": lambda modes: np.append(modes, modes[-1]),
    "descending": lambda modes: modes[::-1],
    "one NaN": lambda modes: _entry((0,), np.nan)(modes),
    "sign": lambda modes: -modes,
    "factor 1 + 1e-6": lambda modes: modes * FACTOR,
    "one 1 % off": lambda modes: np.sort(_off((0,))(modes)),
}
POLES: dict[str, Mutate] = {
    "empty": lambda poles: poles[:0],
    "one missing": lambda poles: poles[1:],
    "real parts alone": lambda poles: poles.real,
    "one NaN": lambda poles: _entry((0,), np.nan)(poles),
    "sign": lambda poles: -poles,
    "without damping": lambda poles: 1j * poles.imag,
    "factor 1 + 1e-6": lambda poles: poles * FACTOR,
    "one 1 % off": lambda poles: _off((0,))(poles),
    "one for all": lambda poles: np.full_like(poles, poles[0]),
}


def _residual(at: int, change: Mutate) -> Mutate:
    return lambda parts: tuple(change(p) if k == at else p for k, p in enumerate(parts))


RESIDUAL: dict[str, Mutate] = {
    f"{part} {name}": _residual(at, change)
    for at, part in enumerate(("gaps", "rates", "accelerations"))
    for name, change in (
        ("NaN", lambda p: p * np.nan),
        ("off", lambda p: p + 1e-9 * max(1.0, float(abs(p).max()))),
        ("zero", lambda p: 0 * p),
        ("missing", lambda p: p[:0]),
        ("complex", lambda p: p + 0j),
    )
}


OTHERS = {
    "mesh_modes": MODES,
    "contact_poles": POLES,
    "largest_stable_step": SCALAR,
    "constraint_residual": RESIDUAL,
}


def changes(method: str, role: str, size: int) -> Iterator[tuple[str, Mutate]]:
    """Every mutation that applies to a method's answer, of a model of so many coordinates."""
    yield from ANY.items()
    if method in ARRAYS:
        yield from ARRAY.items()
        yield from _values(method, role, size).items()
    elif method in RUNS:
        yield from RUN.items()
        for name in VARIABLES[:5] if role == "rigid" else VARIABLES:
            yield f"no {name}", lambda run, name=name: run.drop_vars(name)
            yield from ((f"{name}: {what}", _with(name, c)) for what, c in VARIABLE.items())
    else:
        yield from OTHERS[method].items()
        if method == "largest_stable_step" and role in ("geared", "form"):
            yield "tenfold", lambda step: 10 * step if np.isfinite(step) else 1e-12


def _values(method: str, role: str, size: int) -> dict[str, Mutate]:
    """Wrong numbers in an array of the right form."""
    places = np.ndindex(*([size] * (2 if method == "mass_matrix" else 1)))
    return {
        "zero": lambda a: a * 0,
        "sign": lambda a: -a,
        "factor 1 + 1e-6": lambda a: a * FACTOR,
        "the other joint's": lambda a: np.roll(
            a, [1 if role == "rigid" else 3] * a.ndim, axis=tuple(range(a.ndim))
        ),
        **{f"entry {place} 1 % off": _off(place) for place in places},
    }


def list_asked(model: str) -> list[tuple[str, Switches]]:
    """Methods that the model promises, with the laws; of states also with a coordinate a planet."""
    entry, lumped, free = MODELS[model], switches(), switches(planets="free")
    methods = [*sorted(entry.promises), *["largest_stable_step"] * ("simulate" in entry.promises)]
    asked = [(method, lumped) for method in methods]
    if entry.role == "geared":
        asked += [(method, free) for method in methods if method in ARRAYS]
    return asked


def mutants(model: str, arm: Arm) -> list[Mutant]:
    """Of every method that is asked."""
    entry = MODELS[model]
    return [
        Mutant(model, method, name, change, laws)
        for method, laws in list_asked(model)
        for name, change in changes(method, entry.role, len(entry.layout(arm, laws)))
    ]


CALLS = {
    **dict.fromkeys(("christoffel_force", "start_mass"), "mass_matrix"),
    "force_slopes": "generalized_force",
}


def calls(task: ModelTask) -> str:
    """The method of the model that a task calls."""
    if isinstance(task, Simulation):
        if task.rtol is None:
            return "simulate"
        return "precise" if task.is_precise else "reference"
    return CALLS.get(task.quantity, task.quantity)


Asked = tuple[str, str, Switches]  # a model, its method, and the laws at states


def _of_one_experiment(tasks: Sequence[ModelTask]) -> list[ModelTask]:
    """Those that run no experiment, and of the others those of the hardest one that is among them.

    That is the one whose joints are driven unlike each other.
    """
    named = {task.key.experiment for task in tasks if isinstance(task, Simulation)}
    hardest = "pd" if "pd" in named else min(named, default="")
    return [t for t in tasks if not isinstance(t, Simulation) or t.key.experiment == hardest]


class Campaign:
    """What a plan asks of these models, performed unharmed once, against which mutants are held."""

    def __init__(self, arm: Arm, models: Sequence[str]) -> None:
        self.answers: dict[tuple[ModelTask, *tuple[bytes, ...]], Any] = {}
        self.arm = arm
        wanted = plan.CrossCheckRequest(arm, quick=True)
        with Workers(2) as workers:
            planned = plan_comparisons(wanted, prepare_experiments(wanted, workers))
            tasks = collect_tasks(planned)
            self.concerned = {
                (model, *asked): self._find_concerned((model, *asked), tasks, planned)
                for model in models
                for asked in list_asked(model)
            }
            comparisons = [c for _, of_it in self.concerned.values() for c in of_it]
            self.outcomes = workers.perform(collect_tasks(comparisons))
        findings = [each.finding(Results(self.outcomes)) for each in comparisons]
        self.disagreeing = [f for f in findings if f.kind == "check" and f.verdict != "agree"]

    def findings(self, mutant: Mutant, patch: pytest.MonkeyPatch) -> Iterator[Finding]:
        """All that the mutant has a part in, one by one; each task when the first one needs it."""
        touched, asked = self.concerned[mutant.model, mutant.method, mutant.laws]
        changed = dict[Any, Outcome]()
        results = Results(ChainMap(changed, self.outcomes))
        for comparison in asked:
            for task in touched:
                if task in comparison.needs and task.key not in changed:
                    changed[task.key] = self._performed(task, mutant, patch)
            yield comparison.finding(results)

    def _find_concerned(
        self, asked: Asked, tasks: Sequence[ModelTask], planned: Sequence[Comparison]
    ) -> tuple[list[ModelTask], list[Comparison]]:
        """The tasks that call a method of a model, and the comparisons that need them."""
        touched = _of_one_experiment([task for task in tasks if self._is_of(task, asked)])
        keys = set(touched)
        return touched, [c for c in planned if not keys.isdisjoint(c.needs)]

    def _is_of(self, task: ModelTask, asked: Asked) -> bool:
        model, method, laws = asked
        if task.model != model or calls(task) != method:
            return False
        case = task.case if isinstance(task, Simulation) else task.setting.case
        return case.arm == self.arm and (method not in ARRAYS or case.switches == laws)

    def _performed(self, task: ModelTask, mutant: Mutant, patch: pytest.MonkeyPatch) -> Outcome:
        owner = load_model_class(task.model)
        right = getattr(owner, mutant.method)

        def kept(self_: object, *arguments: object) -> object:
            """The right answer, which no mutant works out again."""
            if isinstance(task, Simulation):
                return self.outcomes[task.key]
            key = task, *(np.asarray(argument).tobytes() for argument in arguments)
            if key not in self.answers:
                self.answers[key] = right(self_, *arguments)
            return self.answers[key]

        def wrong(self_: object, *arguments: object) -> object:
            return mutant.change(kept(self_, *arguments))

        with patch.context() as harmed:
            harmed.setattr(owner, mutant.method, wrong)
            harmed.setattr(owner, "takes_many_states", False)  # a mutant changes one answer
            return task.perform()
