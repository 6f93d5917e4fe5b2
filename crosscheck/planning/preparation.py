"""What must be found out about an arm before its runs can be planned: sizes, stability, steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from crosscheck.analytic.paper.covered import PAPERS_KIND
from crosscheck.checks.scales import geared, meaningful
from crosscheck.checks.trajectories import size, uncertainty
from crosscheck.findings import About, Key, failed
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import Diverged, Unfinished
from crosscheck.models.experiment.scenario import switches
from crosscheck.planning import plan
from crosscheck.planning.comparison import Comparison, answered
from crosscheck.planning.plan import Experiment, Wanted
from crosscheck.planning.sizing import Sizes, growth_of, sizes_of
from crosscheck.registry import about, build, covering, names, reference_model, same_integrator
from crosscheck.runner.outcomes import DIED, Failure, OwnKey, or_failure
from crosscheck.runner.tasks import Evaluation, Simulation
from crosscheck.runner.workers import Workers

if TYPE_CHECKING:
    import xarray as xr

# An experiment's step is halved so often at most, until its uncertainty is so much smaller than
# what means something.
MOST_HALVINGS = 4
# By how much, judged by each of the runs that a comparison will judge by: where in a step contacts
# are met hangs on the step, so that one of them may be close to the fine run by chance.
MARGINS: dict[plan.Coarse, float] = {"coarse": 2.0, "coarse-2": 1.1, "coarse-3": 1.1}
Known = TypeVar("Known")


class Lost(NamedTuple):
    """A thing that could not be found out, of which experiment or arm, by which model; and why."""

    key: Key
    why: Failure

    @property
    def comparison(self) -> Comparison:
        """The failed check for what is lost: the plan stands on what it knew without."""
        what = About(self.key, "1", "whether it could be found out", "the plan")
        return answered(what, (), partial(failed, note=f"{self.key.left}: {self.why}"))


@dataclass(frozen=True)
class Prepared:
    """Experiments ready to run, largest stable step [s] of their models, remarks to the user.

    lost: what is not known because a model failed; each is a failed check.
    """

    experiments: Sequence[Experiment]
    limit_s: float
    remarks: tuple[str, ...]
    lost: tuple[Lost, ...] = ()


@dataclass(frozen=True)
class Query(OwnKey, Generic[Known]):
    """A task: a function that finds something out by asking models; ``cost``: estimated [s]."""

    function: Callable[..., Known]
    arguments: tuple[Any, ...]
    cost: float

    @or_failure
    def perform(self) -> Known:
        """The function's answer, or what is wrong with a model that was asked."""
        return self.function(*self.arguments)


def settled(wanted: Wanted, experiment: Experiment) -> Experiment:
    """The experiment at a step that its comparisons can mean something at, found by trying.

    It is tried on the reference model, a hundred times as fast as the engines that are to follow.
    """
    experiment = plan.shortened(wanted, experiment)
    for _ in range(MOST_HALVINGS):
        if _is_fine(experiment):
            break
        experiment = plan.shortened(wanted, plan.finer(experiment))
    return experiment


def _is_fine(experiment: Experiment) -> bool:
    """Whether the uncertainty at the experiment's step is well below what means something.

    Also true where no step would help: a run that diverges is what its checks are about.
    """
    try:
        fine = _run(experiment.run(reference_model()))
    except Diverged:
        return True
    arm, scenario, _ = experiment.case
    for variant, margin in MARGINS.items():
        try:
            coarse = _run(experiment.run(reference_model(), variant))
        except Diverged:
            return False
        for quantity in (name for name in ("theta", "x_sp", "x_pr") if name in fine):
            widest = meaningful(quantity, arm, scenario, size(fine, quantity))
            if margin * uncertainty(fine, coarse, quantity) > widest.value:
                return False
    return True


def _run(task: Simulation) -> xr.Dataset:
    return build(task.model, *task.case).simulate()


def prepared(wanted: Wanted, workers: Workers) -> Prepared:
    """What the plan needs to know: experiments, their largest stable step, remarks, what is lost.

    Raises InputError, and Unfinished where a model was stopped or its process died: what is then
    unknown hangs on the machine, and so would the plan.
    """
    lost: list[Lost] = []
    sizes, said = None, list[str]()
    if wanted.needs_sizes:
        query = Query(sizes_of, (wanted.arm,), 1.0)
        (sizes,) = _answers({_key(wanted.arm.name, "sizes"): query}, workers, lost)
        said = _of_sizes(sizes, lost)
    outline = plan.outlined(wanted, sizes)
    laws, what = usual_switches(wanted.arm), "largest_stable_step"
    limits = {
        _key(each.name, what, model): Evaluation(model, each.case._replace(switches=laws), what)
        for model in about(same_integrator(), wanted.arm, laws)
        for each in outline
    }
    known = [float(limit) for limit in _answers(limits, workers, lost) if limit is not None]
    limit = min(known, default=float("inf"))
    started = [plan.resolved(each, limit) for each in outline]
    growths: dict[Key, Query[Any]] = {
        _key(each.name, "growth-rate"): Query(growth_of, (each.case.arm, each.case.scenario), 0.5)
        for each in outline
    }
    steps = {
        _key(each.name, "step"): Query(settled, (wanted, each), 5.0)
        for each in ([] if wanted.keeps_steps else started)
    }
    answers = _answers(growths | steps, workers, lost)
    fine = answers[len(growths) :] or [None] * len(started)
    found = [
        replace(settling or plan.shortened(wanted, own), growth=growth)
        for own, growth, settling in zip(started, answers, fine, strict=False)
    ]
    remarks = [f"{each.name}: {each.growth}" for each in found if each.growth is not None]
    remarks += _of_forms(wanted.arm)
    return Prepared([*found, plan.probe_experiment()], limit, (*said, *remarks), tuple(lost))


def _key(case: str, quantity: str, model: str = "") -> Key:
    """Key of what a task finds out of an experiment or arm, by the reference model unless named."""
    return Key("preparation", case, quantity, model or reference_model())


def _answers(
    asked: Mapping[Key, Query[Any] | Evaluation], workers: Workers, lost: list[Lost]
) -> list[Any]:
    """The answers in their order, None for one that is lost, which ``lost`` is told.

    Raises Unfinished where a model did not come back.
    """
    outcomes = workers.perform(list(dict.fromkeys(asked.values())), lambda key: None)
    found = []
    for key, task in asked.items():
        outcome: Any = outcomes[task.key]
        if isinstance(outcome, Failure):
            if outcome.unfinished or outcome.kind == DIED:
                what = f"preparing {key.case}: {key.quantity} by {key.left}"
                raise Unfinished(f"{what}: {outcome}")
            lost.append(Lost(key, outcome))
            outcome = None
        found.append(outcome)
    return found


def _of_sizes(sizes: Sizes | None, lost: Sequence[Lost]) -> list[str]:
    """Remarks on the experiments that were made for the arm, or why there are none."""
    if sizes is None:
        return [f"experiments could not be sized to the arm: {each.why}" for each in lost]
    mode = "no gears" if sizes.mode_Hz is None else f"lowest mesh mode {sizes.mode_Hz:.4g} Hz"
    return [
        f"experiments sized to the arm: {mode}, controller at {sizes.rate:.3g} rad/s",
        f"torque-step: {_listed(sizes.step)} N m",
        f"pd-motion: to {_listed(sizes.target)} rad, P {_listed(sizes.proportional)} N m/rad,"
        f" D {_listed(sizes.derivative)} N m s/rad",
    ]


def _of_forms(arm: Arm) -> list[str]:
    """A remark on the paper's own forms where they are not about an arm with gears."""
    without = [name for name in names("form") if name not in covering("form", arm, switches())]
    if not (without and geared(arm)):
        return []
    return [f"without {', '.join(without)}: each {PAPERS_KIND}"]


def _listed(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.4g}" for value in values)
