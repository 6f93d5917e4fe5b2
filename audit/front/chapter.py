"""The page's beginning: six findings, what they mean, and how to repair the model."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import product

import numpy as np

from crosscheck.audit.claims.chapter import COLUMNS
from crosscheck.audit.claims.rule import State
from crosscheck.audit.claims.statements.section3 import RETURN
from crosscheck.audit.errata.engine_comparison import PrintedEquationsQuestion
from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.experiments.paper_conditions import (
    INTEGRAL,
    LABELLED,
    LAWS,
    PRINTED,
    Condition,
    Law,
)
from crosscheck.audit.experiments.variant import Equations, Planets
from crosscheck.audit.figures.figure_data import LOW_ZETA
from crosscheck.audit.figures.plotting import LAW_COLOURS, set_same_scale
from crosscheck.audit.hypotheses.accumulation import judge_drive, largest_error, run_shaking
from crosscheck.audit.hypotheses.damping_fit import find_reversals
from crosscheck.audit.hypotheses.evidence.level_ablation import AblationVerdict, RigidResidual
from crosscheck.audit.hypotheses.evidence.linear_limits import find_thresholds, is_cured_at_sun
from crosscheck.audit.hypotheses.evidence.shaking import DRIVES
from crosscheck.audit.hypotheses.evidence.spin import SpinCost, is_considerable
from crosscheck.audit.hypotheses.h2_ablation import AblationSummary, run_ablations
from crosscheck.audit.hypotheses.h2_ablation import draw_baselines as rigid_baselines
from crosscheck.audit.hypotheses.labels import LEVELS
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third_fluctuation import ThirdFluctuation
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.measures.undefined import JsonObject, float_or_none
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.labels import LAW_MEANINGS, LAW_NAMES
from crosscheck.audit.page.text import render_template, to_markup
from crosscheck.audit.phase.clock import RUN_WINDOW_S, RUN_ZETA, ClockTestResult, run_clock_test
from crosscheck.audit.phase.page.drawings import cut_envelope
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, set_log_scale, to_svg

MODELS: dict[Planets, Equations] = {"lumped": "printed", "free": "corrected"}  # the paper's first
SPIN_S = 0.5  # as H4 asks it
PAPER_THIRD = 300.0  # rad/s^2, Section 3.2
FAINTEST = 0.1  # rad/s^2: smaller fluctuations are drawn there
PLANET_NAMES = {"free": "planets free", "lumped": "printed equations"}
ID, TITLE = "findings", "What came out"


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter of findings, which comes first on the page."""
    study, scale = context.study, context.scale
    (printed,) = study.answer_questions(
        [PrintedEquationsQuestion(LABELLED, scale.longest_s)], "printed equations"
    )
    clock, third = run_clock_test(study, scale), evaluate_third_fluctuation(context)
    ablation = run_ablations(context)
    baselines = compare_baselines(ablation, context)
    spin_cost = SpinCost(LABELLED, "constant-torque", scale.limit_duration(SPIN_S))
    (spin,) = study.answer_questions([spin_cost], "elbow planets' spin")
    accumulated = run_shaking(context)
    by_drive = {drive: [entry for entry in accumulated if entry.drive == drive] for drive in DRIVES}
    limits = find_thresholds(scale.quick)
    zetas = [entry.zeta for entry in limits if entry.is_papers]
    template_values = {
        "printed": printed,
        "spin": spin,
        "spin_matters": is_considerable(spin.tip_m),
        "clocks": clock,
        "by_law": {entry.law: entry for entry in clock.laws},
        "third": third,
        "baselines": baselines,
        "level": LEVELS[baselines.nearest.level] if baselines.nearest else "",
        "accumulation": {
            drive: judge_drive(drive_results) for drive, drive_results in by_drive.items()
        },
        "largest_rad": {
            drive: largest_error(drive_results[0]) for drive, drive_results in by_drive.items()
        },
        "unstable_below": (min(zetas), max(zetas)),
        "cured": is_cured_at_sun(limits),
        "PRINTED": PRINTED,
        "INTEGRAL": INTEGRAL,
    }
    simulated_claims = [entry for entry in context.judged_claims.values() if not entry.claim.static]
    verdicts = {
        name: Counter(str(entry.by_model[model].kind) for entry in simulated_claims)
        for model, name in COLUMNS.items()
    }
    page = render_template(
        "front/findings",
        **template_values,
        clock_svg=to_markup(draw_clocks(clock)),
        window_s=RUN_WINDOW_S,
        run_zeta=RUN_ZETA,
        third_svg=to_markup(draw_third_fluctuations(third)),
        baselines_svg=to_markup(rigid_baselines(ablation.residuals)),
        names=LAW_NAMES,
        meanings=LAW_MEANINGS,
        laws=LAWS,
        models=MODELS,
        verdicts=verdicts,
    )
    records = [printed.to_dict(), *(strip.to_dict() for strip in third.strips)]
    outcome = render_template("front/outcome", **template_values)
    return AuditChapter(ID, TITLE, page, records, outcome)


@dataclass(frozen=True)
class StartsStrip:
    """The third fluctuation of every start in one setting, as one strip of the drawing."""

    condition: Condition
    third: ThirdFluctuation

    def to_dict(self) -> JsonObject:
        """The strip as a JSON object."""
        return {
            "id": f"finding/third/{self.condition.id}",
            "starts": self.third.size.size,
            "undefined": self.third.size.size - self.third.sizes.size,
            "severe": int(self.third.select_branch(severe=True).sum()),
            "quantiles": list(map(float_or_none, self.third.quantiles)),
        }


@dataclass(frozen=True)
class ThirdFluctuationFinding:
    """The third fluctuations at one damping ratio, by law and by planets lumped or free."""

    zeta: float
    strips: tuple[StartsStrip, ...]

    def share(self, law: Law, planets: Planets) -> Share | None:
        """The share of severe starts under a law and with planets lumped or free."""
        places = {
            (strip.condition.law, strip.condition.planets): strip.third for strip in self.strips
        }
        return places[law, planets].share

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
        return {s.condition.law.phase for s in self.strips if s.third.state in severe} == {
            "omega_t"
        }


def evaluate_third_fluctuation(
    context: AuditContext, zeta: float = LOW_ZETA
) -> ThirdFluctuationFinding:
    """The finding on the third fluctuation, from all starts of each law and kind of planets."""
    conditions = [
        Condition(law, zeta, planets=planets, equations=equations)
        for (planets, equations), law in product(MODELS.items(), LAWS)
    ]
    samples = context.samples(
        [(condition, PD) for condition in conditions], "the third fluctuation"
    )
    return ThirdFluctuationFinding(
        zeta,
        tuple(
            StartsStrip(condition, ThirdFluctuation.from_samples(samples[condition, PD]))
            for condition in conditions
        ),
    )


@dataclass(frozen=True)
class BaselineFinding:
    """What every rigid arm leaves under constant torque (H2's), and when its teeth return.

    residuals: of the labelled reading; return_s: of the rigid arm with all inertia of its gears,
    under PD control.
    """

    residuals: tuple[RigidResidual, ...]
    verdict: AblationVerdict
    return_s: float | None

    @property
    def nearest(self) -> RigidResidual | None:
        """The first baseline that leaves the paper's theta_2, if one does."""
        return next((residual for residual in self.residuals if residual.fits["theta_2"]), None)

    @property
    def returns_as_read(self) -> bool | None:
        """Whether the return is the paper's, as well as one reads a plot; None without a return."""
        return None if self.return_s is None else bool(RETURN.contains(np.array(self.return_s)))

    @property
    def gives_all(self) -> bool:
        """Whether one baseline leaves all of the paper's numbers."""
        return any(all(residual.fits.values()) for residual in self.residuals)


def compare_baselines(ablation: AblationSummary, context: AuditContext) -> BaselineFinding:
    """The finding on the rigid baselines, from the ablation of H2."""
    residuals = tuple(entry for entry in ablation.residuals if entry.arm == LABELLED)
    rigid = {entry.level: entry for entry in find_reversals(context.study, context.scale)}
    return BaselineFinding(residuals, ablation.verdict, rigid["coupled"].return_s)


def draw_clocks(clocks: ClockTestResult) -> str:
    """Acceleration from rest, one start for every clock, and what every start reaches; svg."""
    figure, grid = make_figure(2, len(clocks.laws), 2.2)
    for (above, below), entry in zip(grid.T, clocks.laws, strict=True):
        for place, (delayed, colour) in enumerate(zip(entry.delays, COLOURS, strict=False)):
            band = cut_envelope(delayed.shoulder, *RUN_WINDOW_S)
            label = f"clock starts at {delayed.clock_s:g} s"
            above.fill_between(band.time_s, band.low, band.high, color=colour, label=label, lw=0.6)
            above.collections[-1].set_zorder(3 - place / 10)  # the wildest behind
            sizes = [size for size in delayed.vibration_rad_per_s2 if size is not None]
            below.plot(np.full(len(sizes), place), sizes, "o", ms=4, color=colour, mfc="none")
        above.set(title=LAW_NAMES[entry.law], xlabel="time since the start [s]")
        below.set_xticks(range(len(entry.delays)), [f"{entry.clock_s:g}" for entry in entry.delays])
        below.set(xlabel="clock at the start [s]", xlim=(-0.5, len(entry.delays) - 0.5))
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
    for row, strip in enumerate(finding.strips):
        sizes, share = np.sort(strip.third.sizes), strip.third.share
        heights = row + 0.28 * np.sin(2.4 * np.arange(sizes.size))  # so that dots show one by one
        colour = LAW_COLOURS[strip.condition.law]
        fill = colour if strip.condition.planets == "free" else "white"
        axes.plot(np.maximum(sizes, FAINTEST), heights, "o", ms=4.5, mec=colour, mfc=fill)
        if share is not None:
            share_label = f" {share} severe"
            axes.text(1.0, row, share_label, va="center", transform=axes.get_yaxis_transform())
        names.append(f"{LAW_NAMES[strip.condition.law]}, {PLANET_NAMES[strip.condition.planets]}")
    axes.axvline(SEVERE, color="k", lw=0.7, ls="--", label=f"counted as severe ({SEVERE:g})")
    axes.axvline(PAPER_THIRD, color="k", lw=0.7, ls=":", label=f"the paper's ({PAPER_THIRD:g})")
    axes.set_yticks(range(len(names)), names)
    axes.set(xscale="log", xlabel="third fluctuation [rad/s²]", ylim=(len(names) - 0.5, -0.5))
    draw_legend(figure, axes)
    return to_svg(figure)
