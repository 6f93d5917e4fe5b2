"""What must be found out about an arm before its runs can be planned: sizes, stability, steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from crosscheck.checks.scales import meaningful
from crosscheck.checks.trajectories import size, uncertainty
from crosscheck.findings import About, Key, failed
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import Diverged, Unfinished
from crosscheck.planning import plan
from crosscheck.planning.comparison import Comparison, answered
from crosscheck.planning.sizing import Sizes, growth_of, sizes_of
from crosscheck.registry import about, build, lead, same_integrator
from crosscheck.runner.outcomes import DIED, Failure, failure
from crosscheck.runner.tasks import Evaluation, Simulation
from crosscheck.runner.workers import Workers

if TYPE_CHECKING:
    import xarray as xr

# An experiment's step is halved so often at most, until its uncertainty is so much smaller than
# what means something.
MOST_HALVINGS, MARGIN = 4, 2.0
Known = TypeVar("Known")


@dataclass(frozen=True)
class Lost:
    """What could not be found out: of which experiment or arm, what, by which model, and why."""

    case: str
    quantity: str
    model: str
    why: Failure

    @property
    def comparison(self) -> Comparison:
        """A check that has failed: the plan stands on what it knew without."""
        key = Key("preparation", self.case, self.quantity, self.model)
        what = About(key, "1", "whether it could be found out", "the plan")
        note = f"{self.model}: {self.why}"
        return answered(what, (), partial(failed, note=note))


@dataclass(frozen=True)
class Prepared:
    """Experiments ready to run, largest stable step [s] of their models, remarks to the user.

    lost: what is not known because a model failed; each is a failed check.
    """

    experiments: Sequence[plan.Experiment]
    limit_s: float
    remarks: tuple[str, ...]
    lost: tuple[Lost, ...] = ()


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
        """The answer, or what is wrong with a model that was asked."""
        try:
            return self.function(*self.arguments)
        except BaseException as error:  # also SystemExit and KeyboardInterrupt out of a model
            return failure(error)


def settled(wanted: plan.Wanted, experiment: plan.Experiment) -> plan.Experiment:
    """The experiment at a step that its comparisons can mean something at, found by trying.

    On the lead, which is a hundred times as fast as the engines that are to follow.
    """
    experiment = plan.shortened(wanted, experiment)
    for _ in range(MOST_HALVINGS):
        if _is_fine(experiment):
            break
        experiment = plan.shortened(wanted, plan.finer(experiment))
    return experiment


def _is_fine(experiment: plan.Experiment) -> bool:
    """Whether twice the step leads apart by less than means something, twice over.

    Or whether no step would help: a run that diverges is what its checks are about.
    """
    try:
        fine = _run(experiment.run(lead()))
    except Diverged:
        return True
    try:
        coarse = _run(experiment.run(lead(), "coarse"))
    except Diverged:
        return False
    arm, scenario, _ = experiment.case
    for quantity in (name for name in ("theta", "x_sp", "x_pr") if name in fine):
        widest = meaningful(quantity, arm, scenario, size(fine, quantity))
        if MARGIN * uncertainty(fine, coarse, quantity) > widest.value:
            return False
    return True


def _run(task: Simulation) -> xr.Dataset:
    return build(task.model, *task.case).simulate()


def prepared(wanted: plan.Wanted, workers: Workers) -> Prepared:
    """Everything that the plan needs to know.

    Raises InputError, and Unfinished where a model was stopped or its process died: what is then
    unknown hangs on the machine, and so would the plan.
    """
    lost: list[Lost] = []
    sizes, said = None, list[str]()
    if wanted.needs_sizes:
        asked = _Asked(Query(sizes_of, (wanted.arm,), 1.0), wanted.arm.name, "sizes", lead())
        (sizes,) = _answers([asked], workers, lost)
        said = _of_sizes(sizes, lost)
    outline = plan.outlined(wanted, sizes)
    limits = _answers([*_limits(wanted, outline)], workers, lost)
    limit = min((float(known) for known in limits if known is not None), default=float("inf"))
    started = [plan.resolved(each, limit) for each in outline]
    growths, steps = [], list[_Asked]()
    for each in outline:
        task = Query(growth_of, (each.case.arm, each.case.scenario), 0.5)
        growths.append(_Asked(task, each.name, "growth-rate", lead()))
    for each in [] if wanted.keeps_steps else started:
        steps.append(_Asked(Query(settled, (wanted, each), 5.0), each.name, "step", lead()))
    answers = _answers([*growths, *steps], workers, lost)
    fine = answers[len(growths) :] or [None] * len(started)
    found = [
        replace(settling or plan.shortened(wanted, own), growth=growth)
        for own, growth, settling in zip(started, answers, fine, strict=False)
    ]
    remarks = [f"{each.name}: {each.growth}" for each in found if each.growth is not None]
    return Prepared([*found, plan.probe_experiment()], limit, (*said, *remarks), tuple(lost))


class _Asked(NamedTuple):
    """A task, and what it finds out: of which experiment or arm, what, by which model."""

    task: Query[Any] | Evaluation
    case: str
    quantity: str
    model: str


def _limits(wanted: plan.Wanted, outline: Sequence[plan.Experiment]) -> Iterator[_Asked]:
    laws, what = usual_switches(wanted.arm), "largest_stable_step"
    for model in about(same_integrator(), wanted.arm, laws):
        for each in outline:
            task = Evaluation(model, each.case._replace(switches=laws), what)
            yield _Asked(task, each.name, what, model)


def _answers(asked: Sequence[_Asked], workers: Workers, lost: list[Lost]) -> list[Any]:
    """The answers in their order, None for one that is lost, which is noted.

    Raises Unfinished where a model did not come back.
    """
    outcomes = workers.perform(list(dict.fromkeys(each.task for each in asked)), lambda key: None)
    found = []
    for each in asked:
        outcome: Any = outcomes[each.task.key]
        if isinstance(outcome, Failure):
            if outcome.unfinished or outcome.kind == DIED:
                what = f"preparing {each.case}: {each.quantity} by {each.model}"
                raise Unfinished(f"{what}: {outcome}")
            lost.append(Lost(each.case, each.quantity, each.model, outcome))
            outcome = None
        found.append(outcome)
    return found


def _of_sizes(sizes: Sizes | None, lost: Sequence[Lost]) -> list[str]:
    """The numbers of experiments that were made for the arm, or why there are none."""
    if sizes is None:
        return [f"experiments could not be sized to the arm: {each.why}" for each in lost]
    mode = "no gears" if sizes.mode_Hz is None else f"lowest mesh mode {sizes.mode_Hz:.4g} Hz"
    return [
        f"experiments sized to the arm: {mode}, controller at {sizes.rate:.3g} rad/s",
        f"torque-step: {_listed(sizes.step)} N m",
        f"pd-motion: to {_listed(sizes.target)} rad, P {_listed(sizes.proportional)} N m/rad,"
        f" D {_listed(sizes.derivative)} N m s/rad",
    ]


def _listed(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
