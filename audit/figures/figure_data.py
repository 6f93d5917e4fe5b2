"""What figures are made of: runs from one start, samples of all, and the plate with its words.

Every choice that the paper leaves open is made here.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple, TypeVar

from pydantic import JsonValue

from crosscheck.audit.claims import study_plan
from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.claims.study_plan import AuditContext
from crosscheck.audit.experiments.ensembles import simulate_courses
from crosscheck.audit.experiments.experiments import (
    DEFAULTS,
    PD,
    ExperimentSeries,
    PaperExperiment,
    build_question,
)
from crosscheck.audit.experiments.paper_conditions import (
    AS_MODELLED,
    LABELLED,
    LAWS,
    Condition,
    Law,
)
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.judging.quantities import Sample
from crosscheck.audit.measures.run_signals import RunSignals
from crosscheck.audit.measures.undefined import JsonObject
from crosscheck.audit.page.chapter import render_template, to_markup

# The paper gives no damping. At the smaller value its third fluctuation shows under its own law.
ZETA, LOW_ZETA = 0.02, 0.005
FIGURES_FILE = Path(__file__).with_name("figures.toml")
FULL_RECORD = 2  # 20 µs: eleven records of a period of the fastest mesh mode
Name = TypeVar("Name", bound=Hashable)


@dataclass
class FigureData:
    """The page's material as figures need it; each run is read once."""

    context: AuditContext
    course_cache: dict[Variant, RunSignals] = field(default_factory=dict)

    @property
    def seed(self) -> int:
        """The seed of the start that is drawn."""
        return self.context.scale.first_seed

    def load_courses(self, variants: Mapping[Name, Variant], number: int) -> dict[Name, RunSignals]:
        """The variants' runs, cut to the scale, for a figure. Raises Diverged."""
        cut_variants = {name: self.context.scale.cut(variant) for name, variant in variants.items()}
        missing = [cut for cut in cut_variants.values() if cut not in self.course_cache]
        self.course_cache |= simulate_courses(self.context.study, missing, f"figure {number}")
        return {name: self.course_cache[cut] for name, cut in cut_variants.items()}

    def courses_by_law(
        self, number: int, *experiments: PaperExperiment
    ) -> list[dict[Law, RunSignals]]:
        """The courses of each experiment from the drawn start, by law."""
        variants = {
            (experiment, law): make_start_variant(experiment, make_condition(law), self.seed)
            for law in LAWS
            for experiment in experiments
        }
        courses = self.load_courses(variants, number)
        return [{law: courses[experiment, law] for law in LAWS} for experiment in experiments]

    def members(self, series: ExperimentSeries) -> list[PaperExperiment]:
        """A family's experiments that the plan has, by size."""
        planned = (*DEFAULTS, *study_plan.FULL.experiments(make_condition(LAWS[0])))
        members = {item for item in planned if item.kind == series.kind}
        return sorted(members, key=lambda item: item.size or 0.0)

    def samples_by_law(self, experiment: PaperExperiment) -> dict[Law, Sample]:
        """The samples of an experiment, by law."""
        sampled = PD if experiment in DEFAULTS else experiment
        requests = {law: (make_condition(law), sampled) for law in LAWS}
        samples = self.context.samples(requests.values(), str(experiment))
        return {law: samples[request] for law, request in requests.items()}


def make_condition(law: Law) -> Condition:
    """The setting that a law is drawn in: the paper's own in the paper's own model."""
    if law == AS_MODELLED.law:
        return Condition(law, LOW_ZETA, LABELLED, AS_MODELLED.planets, AS_MODELLED.equations)
    return Condition(law, LOW_ZETA)


def make_start_variant(
    experiment: PaperExperiment,
    condition: Condition,
    seed: int | None,
    record_every: int = FULL_RECORD,
) -> Variant:
    """The variant of an experiment as the claims' samples have it, from one of their starts."""
    variant = build_question(PD if experiment in DEFAULTS else experiment, condition, ()).variant
    return replace(variant, seed=seed, record_every=record_every)


class Drawing(NamedTuple):
    """A drawing as an <svg> element, with what it shows in plain text."""

    svg: str
    caption: str


@dataclass(frozen=True)
class PaperFigure:
    """A plate. zeta: None where no damping enters; start: seed of what is drawn.

    numbers: for the figure's words; reason: why there is no drawing.
    """

    number: int
    drawings: Sequence[Drawing]
    zeta: float | None = None
    start: int | None = None
    numbers: Mapping[str, JsonValue] = field(default_factory=dict)
    tables: Mapping[str, str] = field(default_factory=dict)
    reason: str = ""

    @property
    def claims(self) -> list[str]:
        """The ids of the claims about the figure."""
        return [claim.id for claim in CLAIMS if claim.figure == self.number]

    def to_html(self) -> str:
        """The figure's html from <h3> down."""
        return render_template(
            f"figures/figure-{self.number}",
            plate=self,
            svgs=[(to_markup(drawing.svg), drawing.caption) for drawing in self.drawings],
            tables={name: to_markup(table) for name, table in self.tables.items()},
        )

    def to_dict(self) -> JsonObject:
        """The figure as a JSON object; what the claims say stands in their own records."""
        return {
            "id": f"figure-{self.number}",
            "zeta": self.zeta,
            "start": self.start,
            "drawn": not self.reason,
            "claims": list(self.claims),
            "numbers": dict(self.numbers),
        }
