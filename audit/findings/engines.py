"""The third fluctuation in an independent engine, whose planets all move by themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from crosscheck.audit.experiments.experiments import PD, build_question
from crosscheck.audit.experiments.paper_conditions import DECISIVE, Condition
from crosscheck.audit.experiments.samples import Scale, build_sample, judge_third_fluctuation
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.judging.rule import Answer, State
from crosscheck.audit.measures.undefined import JsonObject, combine_answers

ENGINE = "exudyn:tree"
STARTS = 16  # of Exudyn's: one costs some four seconds
STARTS_UNDER_ANGLE = 2  # the analytic model's 32 do not differ there
# Both models' meshes start by up to so much elsewhere, far above either's rounding. Planets
# separate only as fast as rounding lets them, and engines round differently: gear angles have
# coarser last digits than displacements. So both have the same to begin with.
APART_M = 1e-9


@dataclass(frozen=True)
class ModelComparison:
    """Whether the third fluctuation is severe, by both models in one setting, planets free."""

    cell: Condition
    analytic: Answer
    engine: Answer

    def to_dict(self) -> JsonObject:
        """The comparison as a JSON object: of each the severe starts, and the median size."""
        models = {"analytic": self.analytic, "engine": self.engine}
        return {
            "id": f"finding/engine/{self.cell.id}",
            **{f"{name}_severe": str(answer.share) for name, answer in models.items()},
            **{f"{name}_rad_per_s2": answer.median for name, answer in models.items()},
        }


def is_third_fluctuation_in_engine(compared: Sequence[ModelComparison]) -> bool | None:
    """Whether the engine by itself has severe starts under `omega_t`, and none under `angle`.

    It is about presence, not about how similar both models are.
    """
    by_phase: dict[str, list[Answer]] = {"omega_t": [], "angle": []}
    for comparison in compared:
        by_phase[comparison.cell.law.phase].append(comparison.engine)
    quiet = [answer.yes == 0 if answer.values else None for answer in by_phase["angle"]]
    states = {answer.state for answer in by_phase["omega_t"]} - {State.UNDEFINED}
    shown = bool(states & {State.YES, State.BISTABLE}) if states else None
    return combine_answers([shown, *quiet])


def compare_engines(study: Study, scale: Scale) -> list[ModelComparison]:
    """The third fluctuations of many starts of both models, the same ones.

    Of the engine a question for every start, so that tasks stay short.
    """
    under_angle = [replace(cell, law=cell.law._replace(phase="angle")) for cell in DECISIVE]
    counts = dict.fromkeys(DECISIVE, STARTS) | dict.fromkeys(under_angle, STARTS_UNDER_ANGLE)
    questions = {
        cell: replace(question, variant=scale.cut(question.variant), apart_m=APART_M)
        for cell, question in ((cell, build_question(PD, cell, scale.seeds)) for cell in counts)
    }
    analytic = study.answer_by_key(
        questions,
        "second engine: analytic starts",
    )
    engine = study.answer_by_key(
        {
            (cell, seed): replace(
                questions[cell],
                variant=replace(questions[cell].variant, model=ENGINE),
                seeds=(seed,),
            )
            for cell, count in counts.items()
            for seed in scale.seeds[:count]
        },
        "second engine: Exudyn",
    )
    return [
        ModelComparison(
            cell,
            judge_third_fluctuation(build_sample(analytic[cell])),
            judge_third_fluctuation(
                *(build_sample(engine[place]) for place in engine if place[0] == cell)
            ),
        )
        for cell in counts
    ]
