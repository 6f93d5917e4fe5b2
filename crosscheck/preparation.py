"""What must be found out about an arm before its runs can be planned: sizes, stability, steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from crosscheck.plan import MECHANISM, Experiment, Wanted, experiments, outlined
from crosscheck.registry import same_integrator, usable_numbers
from crosscheck.sizing import Sizes, sizes_of
from crosscheck.stability import Growth, growth_of
from crosscheck.tasks import Evaluation, Failure, failure
from crosscheck.workers import Workers
from models.arm import Arm
from models.errors import InputError
from models.scenario import Scenario


@dataclass(frozen=True)
class Prepared:
    """Experiments ready to run, largest stable step [s] of their models, remarks to the user."""

    experiments: Sequence[Experiment]
    limit_s: float
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class Sizing:
    """The sizes of an arm, worked out in another process."""

    arm: Arm

    @property
    def key(self) -> Sizing:
        """Itself."""
        return self

    @property
    def cost(self) -> float:
        """Rough seconds."""
        return 1.0

    def perform(self) -> Sizes | InputError | Failure:
        """The sizes, or what is wrong with the arm, or with the model that was asked."""
        try:
            with usable_numbers("sizing", self.arm):
                return sizes_of(self.arm)
        except InputError as error:
            return error
        except BaseException as error:  # also SystemExit and KeyboardInterrupt out of a model
            return failure(error)


@dataclass(frozen=True)
class Steadiness:
    """Whether a scenario's loop is stable, worked out in another process."""

    arm: Arm
    scenario: Scenario

    @property
    def key(self) -> Steadiness:
        """Itself."""
        return self

    @property
    def cost(self) -> float:
        """Rough seconds."""
        return 0.5

    def perform(self) -> Growth | Failure | None:
        """What grows, or why that is not known: the checks of the model will say more."""
        try:
            return growth_of(self.arm, self.scenario)
        except BaseException as error:  # also SystemExit and KeyboardInterrupt out of a model
            return failure(error)


def prepared(wanted: Wanted, workers: Workers) -> Prepared:
    """Everything that the plan needs to know. Raises InputError."""
    sizes = _sizes(wanted, workers) if wanted.needs_sizes else None
    outline = outlined(wanted, sizes if isinstance(sizes, Sizes) else None)
    questions = [Steadiness(each.case.arm, each.case.scenario) for each in outline]
    steps = [
        Evaluation(model, each.case._replace(switches=MECHANISM), "largest_stable_step")
        for model in same_integrator()
        for each in outline
    ]
    answers = workers.perform([*dict.fromkeys(questions), *dict.fromkeys(steps)], lambda key: None)
    growths = [_known(answers.get(question)) for question in questions]
    # Where a model cannot say its limit, its checks will.
    limits = [answers[step] for step in steps if not isinstance(answers.get(step), Failure)]
    limit = min((float(limit) for limit in limits if limit is not None), default=float("inf"))
    chosen = experiments(wanted, outline, growths, limit)
    remarks = [f"{e.name}: {e.growth}" for e in chosen if e.growth is not None]
    return Prepared(chosen, limit, (*_of_sizes(sizes), *remarks))


def _sizes(wanted: Wanted, workers: Workers) -> Sizes | Failure:
    """Sizes, or why there are none: then the paper's experiments must do. Raises InputError."""
    task = Sizing(wanted.arm)
    found = workers.perform([task], lambda key: None).get(task)
    if isinstance(found, InputError):
        raise found
    return found if isinstance(found, Sizes | Failure) else Failure("Lost", "no sizes came back")


def _known(answer: object) -> Growth | None:
    return answer if isinstance(answer, Growth) else None


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
