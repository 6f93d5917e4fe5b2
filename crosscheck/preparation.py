"""What must be found out about an arm before its runs can be planned: sizes, stability, steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

from crosscheck.checks.scales import meaningful
from crosscheck.checks.trajectories import size, uncertainty
from crosscheck.outcomes import Failure, failure
from crosscheck.plan import (
    Experiment,
    Wanted,
    finer,
    mechanism,
    outlined,
    probe_experiment,
    resolved,
    shortened,
)
from crosscheck.registry import about, build, lead, same_integrator
from crosscheck.sizing import Sizes, sizes_of
from crosscheck.stability import Growth, growth_of
from crosscheck.tasks import Evaluation
from crosscheck.workers import Workers

# An experiment's step is halved so often at most, until its uncertainty is so much smaller than
# what means something.
MOST_HALVINGS, MARGIN = 4, 2.0
Known = TypeVar("Known")


@dataclass(frozen=True)
class Prepared:
    """Experiments ready to run, largest stable step [s] of their models, remarks to the user."""

    experiments: Sequence[Experiment]
    limit_s: float
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class Query(Generic[Known]):
    """What a function finds out by asking models, in another process; ``cost``: rough seconds."""

    function: Callable[..., Known]
    arguments: tuple[Any, ...]
    cost: float

    @property
    def key(self) -> Query[Known]:
        """Itself."""
        return self

    def perform(self) -> Known | Failure:
        """The answer, or what is wrong with a model that was asked: its checks will say more."""
        try:
            return self.function(*self.arguments)
        except BaseException as error:  # also SystemExit and KeyboardInterrupt out of a model
            return failure(error)


def settled(wanted: Wanted, experiment: Experiment) -> Experiment:
    """The experiment at a step that its comparisons can mean something at, found by trying.

    On the lead, which is a hundred times as fast as the engines that are to follow.
    """
    experiment = shortened(wanted, experiment)
    for _ in range(MOST_HALVINGS):
        if _is_fine(experiment):
            break
        experiment = shortened(wanted, finer(experiment))
    return experiment


def _is_fine(experiment: Experiment) -> bool:
    """Whether twice the step leads apart by less than means something, twice over."""
    fine, coarse = (
        build(task.model, *task.case).simulate()
        for task in (experiment.run(lead()), experiment.run(lead(), "coarse"))
    )
    arm, scenario, _ = experiment.case
    for quantity in (name for name in ("theta", "x_sp", "x_pr") if name in fine):
        widest = meaningful(quantity, arm, scenario, size(fine, quantity))
        if MARGIN * uncertainty(fine, coarse, quantity) > widest.value:
            return False
    return True


def prepared(wanted: Wanted, workers: Workers) -> Prepared:
    """Everything that the plan needs to know. Raises InputError."""
    sizes = _sizes(wanted, workers) if wanted.needs_sizes else None
    outline = outlined(wanted, sizes if isinstance(sizes, Sizes) else None)
    steps = [
        Evaluation(model, each.case._replace(switches=mechanism(wanted.arm)), "largest_stable_step")
        for model in about(same_integrator(), wanted.arm, mechanism(wanted.arm))
        for each in outline
    ]
    limits = workers.perform([*dict.fromkeys(steps)], lambda key: None)
    # Where a model cannot say its limit, its checks will.
    known = [float(limit) for limit in limits.values() if not isinstance(limit, Failure)]
    limit = min(known, default=float("inf"))
    started = resolved(wanted, outline, limit)
    steady = [Query(growth_of, (each.case.arm, each.case.scenario), 0.5) for each in outline]
    settling = [Query(settled, (wanted, each), 5.0) for each in started]
    tasks = [*dict.fromkeys(steady), *(() if wanted.keeps_steps else settling)]
    answers = workers.perform(tasks, lambda key: None)
    found = []
    for growth, finding, own in zip(steady, settling, started, strict=True):
        experiment = answers.get(finding)
        if not isinstance(experiment, Experiment):
            experiment = shortened(wanted, own)
        grows = answers.get(growth)
        found.append(replace(experiment, growth=grows if isinstance(grows, Growth) else None))
    remarks = [f"{each.name}: {each.growth}" for each in found if each.growth is not None]
    return Prepared([*found, probe_experiment()], limit, (*_of_sizes(sizes), *remarks))


def _sizes(wanted: Wanted, workers: Workers) -> Sizes | Failure:
    """Sizes, or why there are none: then the paper's experiments must do."""
    task = Query(sizes_of, (wanted.arm,), 1.0)
    found = workers.perform([task], lambda key: None).get(task)
    return found if isinstance(found, Sizes | Failure) else Failure("Lost", "no sizes came back")


def _of_sizes(sizes: Sizes | Failure | None) -> list[str]:
    """The numbers of experiments that were made for the arm."""
    if sizes is None:
        return []
    if isinstance(sizes, Failure):
        return [f"experiments could not be sized to the arm: {sizes}"]
    mode = "no gears" if sizes.mode_Hz is None else f"lowest mesh mode {sizes.mode_Hz:.4g} Hz"
    return [
        f"experiments sized to the arm: {mode}, controller at {sizes.rate:.3g} rad/s",
        f"torque-step: {_listed(sizes.step)} N m",
        f"pd-motion: to {_listed(sizes.target)} rad, P {_listed(sizes.proportional)} N m/rad,"
        f" D {_listed(sizes.derivative)} N m s/rad",
    ]


def _listed(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
