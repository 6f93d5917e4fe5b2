"""The page's beginning: six findings, what they mean, and how to repair the model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from crosscheck.audit.claims.chapter import COLUMNS
from crosscheck.audit.claims.study_plan import AuditContext
from crosscheck.audit.errata.printed_equations import PrintedEquationsQuestion
from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.experiments.paper_conditions import (
    INTEGRAL,
    LABELLED,
    LAW,
    LAWS,
    PRINTED,
    Condition,
    Law,
)
from crosscheck.audit.experiments.samples import judge_third_fluctuation
from crosscheck.audit.experiments.variant import Equations, Planets
from crosscheck.audit.figures.figure_data import LOW_ZETA, ZETA
from crosscheck.audit.figures.plotting import LAW_COLOURS, set_same_scale
from crosscheck.audit.findings import accumulation, baselines, clock, engines, linear_limits
from crosscheck.audit.judging.judgement import ClaimJudgement
from crosscheck.audit.judging.rule import Answer, Share, State
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.measures.undefined import UNDEFINED, JsonObject, format_answer
from crosscheck.audit.page.chapter import (
    LAW_NAMES,
    AuditChapter,
    render_template,
    to_markup,
)
from crosscheck.models.files import read_toml
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, set_log_scale, to_svg

MODELS: dict[Planets, Equations] = {"lumped": "printed", "free": "corrected"}  # the paper's first
SPIN = "eq18-planets-2"  # the erratum that alone causes most of finding 1
PAPER_THIRD = 300.0  # rad/s^2, Section 3.2
# What no start has without the tooth error: the claims that it is there, and that it is severe.
PRESENCE = {"visible": "5-04", "severe": "Abstract-02"}
PHASES = ("omega_t", "angle")
FAINTEST = 0.1  # rad/s^2: smaller fluctuations are drawn there
PLANET_NAMES = {"free": "planets free", "lumped": "printed equations"}
ID, TITLE = "findings", "What came out"
QUESTIONS = read_toml(Path(__file__).with_name("questions.toml"))


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter of findings, which comes first on the page."""
    study, scale = context.study, context.scale
    (printed,) = study.answer_questions(
        [PrintedEquationsQuestion(LABELLED, scale.longest_s)], "printed equations"
    )
    clocks, third = clock.run_clock_test(study, scale), evaluate_third_fluctuation(context)
    rigid = baselines.compare_baselines(context.judged_claims)
    accumulations = accumulation.find_accumulations(context.settings)
    limits = linear_limits.find_thresholds()
    presence = {level: find_laws(context.judged_claims[claim]) for level, claim in PRESENCE.items()}
    compared = engines.compare_engines(study, scale)
    in_engine = engines.is_third_fluctuation_in_engine(compared)
    drives = {drive: accumulation.judge_drive(each) for drive, each in accumulations.items()}
    shown = {
        drive: next(x for x in each if x.condition == Condition(INTEGRAL, ZETA))
        for drive, each in accumulations.items()
    }
    cured = linear_limits.is_cured_at_sun(limits)
    answers: dict[str, bool | str | None] = {
        "printed": printed.agrees,
        "clock": clocks.supports,
        "third": third.needs_clock,
        **{f"presence-{level}": laws for level, laws in presence.items()},
        "engine": in_engine,
        "baseline": rigid.gives_all,
        "inertia": rigid.is_inertia,
        **{
            f"accumulation-{drive}": str(verdict or "depends on the setting")
            for drive, verdict in drives.items()
        },
        "limit": cured,
    }
    records: list[JsonObject] = [
        {
            "id": f"verdict/{name}",
            "question": QUESTIONS[name],
            "verdict": answer if isinstance(answer, str) else format_answer(answer),
        }
        for name, answer in answers.items()
    ]
    records += [printed.to_dict(), *clocks.to_dicts(), *third.to_dicts()]
    records += [comparison.to_dict() for comparison in compared]
    records += [{"id": point.id, "unstable_below_zeta": zeta} for point, zeta in limits.items()]
    simulated_claims = [entry for entry in context.judged_claims.values() if not entry.claim.static]
    link = [zeta for point, zeta in limits.items() if point.sensed == linear_limits.LINK]
    nearest = rigid.nearest
    page = render_template(
        "findings/chapter",
        printed=printed,
        spin_rad=find_spin_rad(context),
        clocks=clocks,
        force_change_N=clock.largest_force_change(),
        third=third,
        presence=presence,
        in_engine=in_engine,
        apart_m=f"{engines.APART_M:g}",
        compared=[each for each in compared if each.cell.law.phase == "omega_t"],
        baselines=rigid,
        level=baselines.LEVELS[nearest.level] if nearest else "",
        left=[nearest.size(claim) for claim in baselines.LABELS] if nearest else [],
        zeta=ZETA,
        own=drives,
        added_rad={drive: each.added_rad[0] for drive, each in shown.items()},
        growth_per_s=shown["sqrt_time"].rigid_growth_per_s[0],
        unstable_below=(min(link), max(link)),
        cured=cured,
        clock_svg=to_markup(draw_clocks(clocks)),
        window_s=clock.RUN_WINDOW_S,
        run_zeta=clock.RUN_ZETA,
        third_svg=to_markup(draw_third_fluctuations(third)),
        baselines_svg=to_markup(baselines.draw_baselines(rigid.residuals)),
        names=LAW_NAMES,
        laws=LAWS,
        models=MODELS,
        verdicts={
            name: Counter(str(entry.by_model[model].kind) for entry in simulated_claims)
            for model, name in COLUMNS.items()
        },
    )
    outcome = render_template("findings/outcome", printed=printed, clocks=clocks)
    return AuditChapter(ID, TITLE, page, records, outcome)


def find_laws(judged: ClaimJudgement) -> str:
    """Under which laws of the mesh phase a claim is true somewhere, in words.

    Where one setting says yes or that the start decides; undefined if a law's settings say nothing.
    """
    states_by_phase = {
        phase: {a.state for a in judged.answers if a.place.value_of(LAW).phase == phase}
        for phase in PHASES
    }
    if any(states <= {State.UNDEFINED} for states in states_by_phase.values()):
        return UNDEFINED
    laws = [phase for phase in PHASES if states_by_phase[phase] & {State.YES, State.BISTABLE}]
    if len(laws) == 1:
        return f"only with {laws[0]}"
    return "with both" if laws else "with neither"


def find_spin_rad(context: AuditContext) -> float | None:
    """The largest joint angle [rad] that the elbow planets' spin makes under constant torque."""
    spin = next(x for x in context.errata if x.id == SPIN)
    effect = spin.effects.get("constant-torque")
    return None if effect is None else effect.theta_rad


@dataclass(frozen=True)
class ThirdFluctuationFinding:
    """Whether starts are severe at one damping ratio, by law and by planets lumped or free."""

    zeta: float
    answers: Mapping[Condition, Answer]

    def share(self, law: Law, planets: Planets) -> Share | None:
        """The share of severe starts under a law and with planets lumped or free."""
        return {(each.law, each.planets): a for each, a in self.answers.items()}[law, planets].share

    @property
    def as_modelled(self) -> Share | None:
        """The share of severe starts as modelled in the paper: its equations, law and ring rate."""
        return self.share(PRINTED, "lumped")

    @property
    def as_gears(self) -> Share | None:
        """The share of severe starts as the gears are: planets free, teeth counted."""
        return self.share(INTEGRAL, "free")

    @property
    def needs_clock(self) -> bool:
        """Whether some starts are severe with the clock, and in no setting without it."""
        severe = (State.YES, State.BISTABLE)
        phases = {each.law.phase for each, a in self.answers.items() if a.state in severe}
        return phases == {"omega_t"}

    def to_dicts(self) -> list[JsonObject]:
        """The starts of each setting as a JSON object."""
        return [
            {
                "id": f"finding/third/{condition.id}",
                "starts": answer.starts,
                "undefined": answer.undefined,
                "severe": answer.yes,
                "quantiles": list(answer.quantiles or (None,) * 3),
            }
            for condition, answer in self.answers.items()
        ]


def evaluate_third_fluctuation(context: AuditContext) -> ThirdFluctuationFinding:
    """The finding on the third fluctuation, from all starts of each law and kind of planets."""
    conditions = [
        Condition(law, LOW_ZETA, planets=planets, equations=equations)
        for (planets, equations), law in product(MODELS.items(), LAWS)
    ]
    samples = context.samples([(each, PD) for each in conditions], "the third fluctuation")
    answers = {each: judge_third_fluctuation(samples[each, PD]) for each in conditions}
    return ThirdFluctuationFinding(LOW_ZETA, answers)


def draw_clocks(clocks: clock.ClockTestResult) -> str:
    """Acceleration from rest, one start for every clock, and what every start reaches; svg."""
    figure, grid = make_figure(2, len(clocks.delays_by_law), 2.2)
    for (above, below), (law, delays) in zip(grid.T, clocks.delays_by_law.items(), strict=True):
        for place, (delayed, colour) in enumerate(zip(delays, COLOURS, strict=False)):
            label = f"clock starts at {delayed.clock_s:g} s"
            above.fill_between(*delayed.shoulder, color=colour, label=label, lw=0.6)
            above.collections[-1].set_zorder(3 - place / 10)  # the wildest behind
            sizes = [size for size in delayed.vibration_rad_per_s2 if size is not None]
            below.plot(np.full(len(sizes), place), sizes, "o", ms=4, color=colour, mfc="none")
        above.set(title=LAW_NAMES[law], xlabel="time since the start [s]")
        below.set_xticks(range(len(delays)), [f"{delayed.clock_s:g}" for delayed in delays])
        below.set(xlabel="clock at the start [s]", xlim=(-0.5, len(delays) - 0.5))
        below.margins(y=0.1)  # no ring cut in half
        set_log_scale(below)
    grid[0, 0].set_ylabel("acceleration [rad/s²]")
    grid[1, 0].set_ylabel("vibration [rad/s²]")
    set_same_scale(grid)
    draw_legend(figure, grid[0, 0])
    return to_svg(figure)


def draw_third_fluctuations(finding: ThirdFluctuationFinding) -> str:
    """A dot for every start, a row for every law and way to count planets, as svg."""
    figure, grid = make_figure(1, 1, 3.2)
    axes = grid[0, 0]
    names = []
    for row, (condition, answer) in enumerate(finding.answers.items()):
        sizes = np.array(answer.values)
        heights = row + 0.28 * np.sin(2.4 * np.arange(sizes.size))  # so that dots show one by one
        colour = LAW_COLOURS[condition.law]
        fill = colour if condition.planets == "free" else "white"
        axes.plot(np.maximum(sizes, FAINTEST), heights, "o", ms=4.5, mec=colour, mfc=fill)
        if answer.share is not None:
            share_label = f" {answer.share} severe"
            axes.text(1.0, row, share_label, va="center", transform=axes.get_yaxis_transform())
        names.append(f"{LAW_NAMES[condition.law]}, {PLANET_NAMES[condition.planets]}")
    axes.axvline(SEVERE, color="k", lw=0.7, ls="--", label=f"counted as severe ({SEVERE:g})")
    axes.axvline(PAPER_THIRD, color="k", lw=0.7, ls=":", label=f"the paper's ({PAPER_THIRD:g})")
    axes.set_yticks(range(len(names)), names)
    axes.set(xscale="log", xlabel="third fluctuation [rad/s²]", ylim=(len(names) - 0.5, -0.5))
    draw_legend(figure, axes)
    return to_svg(figure)
