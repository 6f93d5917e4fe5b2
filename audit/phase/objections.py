"""What a referee would object to H1, each objection turned into runs with free planets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from crosscheck import signals
from crosscheck.audit.claims.rule import State
from crosscheck.audit.experiments.ensembles import EnsembleQuestion
from crosscheck.audit.experiments.paper_conditions import Condition
from crosscheck.audit.experiments.question import Question, Records
from crosscheck.audit.experiments.samples import Sample
from crosscheck.audit.experiments.scale import Scale
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.events import THIRD_S
from crosscheck.audit.measures.third_fluctuation import ThirdFluctuation
from crosscheck.audit.measures.twosamples import ToothErrorComparison
from crosscheck.audit.measures.undefined import float_or_none
from crosscheck.audit.phase import linear, runs
from crosscheck.models.experiment.drive import CONSTANT

DURATION_S = THIRD_S[1]
THIRD_EVERY = 10  # steps of the motion that is linearised along
FULL_STEP = "scenario.step_s=4e-6"  # Eq. 11 in full lets a vibration grow by 4e5 1/s
QUARTERS = (0.5, 1.0)  # of pi: ring mesh against sun mesh; even z_p suggests pi


D_UNKNOWN, FLUTTER, PLANETS, FULL = "D is unknown", "PD flutter", "teeth out of phase", "Eq. 11"
BY_OBJECTION = {
    "none": [runs.Change("as it stands")],
    D_UNKNOWN: [
        runs.Change("sun mesh 2 times, ring mesh 0.2 times", damping=(2.0, 0.2)),
        runs.Change("sun mesh 0.2 times, ring mesh 2 times", damping=(0.2, 2.0)),
        runs.Change("dampers in contact alone", settings=(runs.CONTACT,)),
    ],
    FLUTTER: [runs.Change("the rigid arm's torque played back, no feedback", recorded=True)],
    PLANETS: [
        runs.Change(
            f"ring meshes shifted by {x:g} π", (f"arm.joints.*.ring_mesh.phase_rad={x * np.pi!r}",)
        )
        for x in QUARTERS
    ],
}
IN_FULL = runs.Change("phases from Eq. 11 in full, planets alike")


# What Eq. 11 in full leaves of it: severe as before; there, but nowhere severe; nothing.
FullEquationOutcome = Literal["severe", "weaker", "gone", "unsettled"]


@dataclass(frozen=True)
class FullEquationQuestion(EnsembleQuestion[list[float | None]]):
    """A question: size of the third fluctuation [rad/s^2] of every start with Eq. 11 in full.

    Planets alike, for which alone Eq. 11 is written out there. None for a start that diverges.
    """

    @property
    def cost(self) -> float:
        return 0.2 * len(self.seeds)

    def answer(self) -> list[float | None]:
        case, models = self.variant.case(), runs.build_models(self.variant, self.seeds)
        full = [runs.build_plant(model, full_rate=True).equations for model in models]
        starts = [model.start() for model in models]
        run = runs.simulate_motion(
            [runs.ContinuedModel(case, *x, item) for x, item in zip(starts, full, strict=True)]
        )
        excess = runs.shoulder_excess(replace(self.variant, settings=()), run.time, run.shoulder)
        part = signals.window(run.time, *THIRD_S)
        return [
            float_or_none(signals.amplitude(item[part])) if np.isfinite(item).all() else None
            for item in excess.T
        ]


@dataclass(frozen=True)
class ObjectionResult(ToothErrorComparison):
    """The third fluctuation in a setting with something changed that a referee would change."""

    objection: str
    change: runs.Change
    cell: Condition


@dataclass(frozen=True)
class GrowthRates:
    """Largest growth rates [1/s] in 0.5 to 1.2 s under `omega_t`; None in a run that ends before.

    Of the arm as it stands, and with one thing changed.
    """

    as_it_stands_per_s: float | None
    without_feedback_per_s: float | None
    eq11_in_full_per_s: float | None
    without_tooth_error_per_s: float | None
    constant_stiffness_per_s: float | None


@dataclass(frozen=True)
class GrowthRateQuestion(Question[GrowthRates]):
    """A question: the ``GrowthRates`` of a setting, as far as the duration [s] shows them."""

    cost = 2.0

    cell: Condition
    duration_s: float

    def variant(self, *meshes: str) -> Variant:
        """The PD run with planets alike: differences between them obey another equation."""
        return replace(runs.build_pd_variant(self.cell, self.duration_s, *meshes), planets="lumped")

    def records(self) -> Records:
        return self.variant().case()

    def answer(self) -> GrowthRates:
        (model,) = runs.build_models(self.variant(), (0,))
        (bare,) = runs.build_models(self.variant(runs.NO_ERROR), (0,))
        plain, full, no_error = (
            runs.build_plant(model),
            runs.build_plant(model, full_rate=True),
            runs.build_plant(bare),
        )
        free = plain.replace_parts(drive=plain.drive._replace(code=CONSTANT))
        still = plain.replace_parts(gears=plain.gears._replace(k_a=np.zeros_like(plain.gears.k_a)))
        growth_rates = []
        for plant in (plain, free, full, no_error, still):
            base = linear.compute_base_motion(self.variant().case(), plant, THIRD_EVERY)
            growth = linear.compute_mesh_modes(plant, base).largest_growth[base.time >= THIRD_S[0]]
            growth_rates.append(float(growth.max()) if growth.size else None)
        return GrowthRates(*growth_rates)


@dataclass(frozen=True)
class Objections:
    """Every change in both settings under both laws, and the growth rates by setting."""

    results: Sequence[ObjectionResult]
    rates: dict[Condition, GrowthRates]

    @property
    def full_equation(self) -> FullEquationOutcome | None:
        """What the printed laws' fluctuation does with Eq. 11 in full; None where it is unknown."""
        in_full = [
            result
            for result in self.results
            if result.objection == FULL and result.cell.law.phase == "omega_t"
        ]
        severe = {result.made.state for result in in_full}
        visible = {result.made_visible.state for result in in_full}
        if not in_full or State.UNDEFINED in severe | visible:
            return None
        if severe == {State.YES}:
            return "severe"
        if visible == {State.YES} and severe == {State.NO}:
            return "weaker"
        return "gone" if visible == {State.NO} else "unsettled"

    @property
    def supports(self) -> bool | None:
        """Whether with every change the tooth error makes no fluctuation under `angle`.

        Settings that vibrate without it say nothing of that.
        """
        under_angle = [result for result in self.results if result.cell.law.phase == "angle"]
        states = {result.made_visible.state for result in under_angle}
        if states & {State.YES, State.BISTABLE}:
            return False
        return True if State.NO in states else None


def run_objections(study: Study, scale: Scale) -> Objections:
    """Results of runs for every objection, with and without tooth error, under both laws."""
    cells = [cell for item in runs.DECISIVE for cell in (item, runs.use_integral_phase(item))]
    meshes = ((), (runs.NO_ERROR,))  # with tooth error and without
    changes = [(name, change) for name, some in BY_OBJECTION.items() for change in some]
    questions = {
        (change, cell, more): change.question(cell, scale, *more)
        for _, change in changes
        for cell in cells
        for more in meshes
    }
    answers = study.answer_by_key(questions, "phase: objections")
    third = {
        key: ThirdFluctuation.from_samples(Sample.from_numbers(item))
        for key, item in answers.items()
    }
    seeds, seconds = scale.seeds[: scale.most_starts], scale.limit_duration(DURATION_S)
    in_full = {
        (IN_FULL, cell, more): FullEquationQuestion(
            replace(
                runs.build_pd_variant(cell, seconds, *more), planets="lumped", settings=(FULL_STEP,)
            ),
            seeds,
        )
        for cell in cells
        for more in meshes
    }
    nothing = np.full(len(seeds), np.nan)  # but sizes is known
    for key, sizes in study.answer_by_key(in_full, "phase: Eq. 11 in full").items():
        size = np.array(sizes, dtype=float)
        third[key] = ThirdFluctuation(size, nothing, nothing, nothing, int(np.isnan(size).sum()))
    results = [
        ObjectionResult(
            name,
            change,
            cell,
            third=third[change, cell, ()],
            without=third[change, cell, (runs.NO_ERROR,)],
        )
        for name, change in (*changes, (FULL, IN_FULL))
        for cell in cells
    ]
    growth = {cell: GrowthRateQuestion(cell, seconds) for cell in runs.DECISIVE}
    return Objections(results, study.answer_by_key(growth, "phase: growth rates"))
