"""The page's beginning: six findings, what they mean, and how to repair the model."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import product

import numpy as np

from crosscheck.audit.claims.chapter import COLUMNS
from crosscheck.audit.claims.rule import State
from crosscheck.audit.errata.engine import PrintedBeside
from crosscheck.audit.experiments.cells import INTEGRAL, LABELLED, LAWS, PRINTED, Cell, Law
from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.experiments.variant import Planets
from crosscheck.audit.figures.shelf import LOW_ZETA
from crosscheck.audit.figures.views import LAW_COLOURS, same_scale
from crosscheck.audit.hypotheses.accumulation import largest, shaken, verdict
from crosscheck.audit.hypotheses.damping_fit import reversals
from crosscheck.audit.hypotheses.evidence.linear_limits import cured_at_the_sun, survey
from crosscheck.audit.hypotheses.evidence.rungs import LadderVerdict, RigidResidual
from crosscheck.audit.hypotheses.evidence.shaking import DRIVES
from crosscheck.audit.hypotheses.ladder import Climbed, climbed
from crosscheck.audit.hypotheses.ladder import baselines as rigid_baselines
from crosscheck.audit.hypotheses.words import LEVELS
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third import Third
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.measures.undefined import JsonObject, defined
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.audit.page.words import LAW_MEANINGS, LAW_NAMES
from crosscheck.audit.phase.clock import RUN_WINDOW_S, RUN_ZETA, Clocks, clocks
from crosscheck.audit.phase.page.views import within
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import legend, log_y, new_figure, to_svg

MODELS: tuple[Planets, ...] = ("lumped", "free")  # the paper's own first
PAPER_THIRD = 300.0  # rad/s^2, Section 3.2
FAINTEST = 0.1  # rad/s^2: smaller fluctuations are drawn there
PLANET_NAMES = {"free": "planets free", "lumped": "planets lumped"}
ID, TITLE = "findings", "What came out"


def chapter(material: Material) -> AuditChapter:
    """The chapter of findings, which comes first on the page."""
    study, scale = material.study, material.scale
    (printed,) = study.answers([PrintedBeside(LABELLED, scale.longest_s)], "printed equations")
    clock, third = clocks(study, scale), third_finding(material)
    ladder = climbed(material)
    baselines = baseline_finding(ladder, material)
    accumulated = shaken(material)
    by_drive = {drive: [one for one in accumulated if one.drive == drive] for drive in DRIVES}
    limits = survey(scale.quick)
    zetas = [one.zeta for one in limits if one.is_papers]
    said = {
        "printed": printed,
        "clocks": clock,
        "by_law": {one.law: one for one in clock.laws},
        "third": third,
        "baselines": baselines,
        "level": LEVELS[baselines.nearest.level] if baselines.nearest else "",
        "accumulation": {drive: verdict(found) for drive, found in by_drive.items()},
        "largest_rad": {drive: largest(found[0]) for drive, found in by_drive.items()},
        "unstable_below": (min(zetas), max(zetas)),
        "cured": cured_at_the_sun(limits),
        "PRINTED": PRINTED,
        "INTEGRAL": INTEGRAL,
    }
    asked = [one for one in material.judged.values() if not one.claim.static]
    verdicts = {
        name: Counter(str(one.by_model[model].kind) for one in asked)
        for model, name in COLUMNS.items()
    }
    page = text(
        "front/findings",
        **said,
        clock_svg=html(clock_svg(clock)),
        window_s=RUN_WINDOW_S,
        run_zeta=RUN_ZETA,
        third_svg=html(third_svg(third)),
        baselines_svg=html(rigid_baselines(ladder.left)),
        names=LAW_NAMES,
        meanings=LAW_MEANINGS,
        laws=LAWS,
        models=MODELS,
        verdicts=verdicts,
    )
    records = [printed.to_dict(), *(strip.to_dict() for strip in third.strips)]
    outcome = text("front/outcome", **said)
    return AuditChapter(ID, TITLE, page, records, outcome)


@dataclass(frozen=True)
class StartsStrip:
    """The third fluctuation of every start in one setting, as one strip of the drawing."""

    cell: Cell
    third: Third

    def to_dict(self) -> JsonObject:
        """The strip as a JSON object."""
        return {
            "id": f"finding/third/{self.cell.id}",
            "starts": self.third.size.size,
            "run": self.third.run,
            "undefined": self.third.size.size - self.third.sizes.size,
            "severe": int(self.third.of_branch(severe=True).sum()),
            "quantiles": list(map(defined, self.third.quantiles)),
        }


@dataclass(frozen=True)
class Thirds:
    """The third fluctuations at one damping ratio, by law and by planets lumped or free."""

    zeta: float
    strips: tuple[StartsStrip, ...]

    def share(self, law: Law, planets: Planets) -> Share | None:
        """The share of severe starts under a law and with planets lumped or free."""
        places = {(one.cell.law, one.cell.planets): one.third for one in self.strips}
        return places[law, planets].share

    @property
    def as_modelled(self) -> Share | None:
        """The share of severe starts as modelled in the paper: lumped, its law and ring rate."""
        return self.share(PRINTED, "lumped")

    @property
    def as_gears(self) -> Share | None:
        """The share of severe starts as the gears are: planets free, teeth counted."""
        return self.share(INTEGRAL, "free")

    @property
    def needs_clock(self) -> bool:
        """Whether some starts are severe with the clock, and in no setting without it."""
        severe = (State.YES, State.BISTABLE)
        return {s.cell.law.phase for s in self.strips if s.third.state in severe} == {"omega_t"}


def third_finding(material: Material, zeta: float = LOW_ZETA) -> Thirds:
    """The finding on the third fluctuation, from all starts of each law and kind of planets."""
    cells = [Cell(law, zeta, planets=planets) for planets, law in product(MODELS, LAWS)]
    found = material.samples([(cell, PD) for cell in cells], "the third fluctuation")
    return Thirds(zeta, tuple(StartsStrip(cell, Third.of(found[cell, PD])) for cell in cells))


@dataclass(frozen=True)
class Baselines:
    """What every rigid arm leaves under constant torque (H2's), and when its teeth return.

    left: of the labelled reading; return_s: of the rigid arm with all inertia of its gears, under
    PD control.
    """

    left: tuple[RigidResidual, ...]
    verdict: LadderVerdict
    return_s: float | None

    @property
    def nearest(self) -> RigidResidual | None:
        """The first baseline that leaves the paper's theta_2, if one does."""
        return next((one for one in self.left if one.fits["theta_2"]), None)

    @property
    def gives_all(self) -> bool:
        """Whether one baseline leaves all of the paper's numbers."""
        return any(all(one.fits.values()) for one in self.left)


def baseline_finding(climbed: Climbed, material: Material) -> Baselines:
    """The finding on the rigid baselines, from the ladder of H2."""
    left = tuple(one for one in climbed.left if one.arm == LABELLED)
    rigid = {one.level: one for one in reversals(material.study, material.scale)}
    return Baselines(left, climbed.verdict, rigid["coupled"].return_s)


def clock_svg(found: Clocks) -> str:
    """Acceleration from rest, one start for every clock, and what every start reaches; svg."""
    figure, grid = new_figure(2, len(found.laws), 2.2)
    for (above, below), one in zip(grid.T, found.laws, strict=True):
        for place, (delayed, colour) in enumerate(zip(one.delays, COLOURS, strict=False)):
            band = within(delayed.shoulder, *RUN_WINDOW_S)
            label = f"clock starts at {delayed.clock_s:g} s"
            above.fill_between(band.time_s, band.low, band.high, color=colour, label=label, lw=0.6)
            above.collections[-1].set_zorder(3 - place / 10)  # the wildest behind
            sizes = [size for size in delayed.vibration_rad_per_s2 if size is not None]
            below.plot(np.full(len(sizes), place), sizes, "o", ms=4, color=colour, mfc="none")
        above.set(title=LAW_NAMES[one.law], xlabel="time since the start [s]")
        below.set_xticks(range(len(one.delays)), [f"{one.clock_s:g}" for one in one.delays])
        below.set(xlabel="clock at the start [s]", xlim=(-0.5, len(one.delays) - 0.5))
        below.margins(y=0.1)  # no ring cut in half
        log_y(below)
    grid[0, 0].set_ylabel("acceleration [rad/s²]")
    grid[1, 0].set_ylabel("vibration [rad/s²]")
    same_scale(grid)
    legend(figure, grid[0, 0])
    return to_svg(figure)


def third_svg(found: Thirds) -> str:
    """A dot for every start, a row for every law and way to count planets, as svg."""
    figure, grid = new_figure(1, 1, 3.2)
    axes = grid[0, 0]
    names = []
    for row, strip in enumerate(found.strips):
        sizes, share = np.sort(strip.third.sizes), strip.third.share
        apart = row + 0.28 * np.sin(2.4 * np.arange(sizes.size))  # so that dots show one by one
        colour = LAW_COLOURS[strip.cell.law]
        fill = colour if strip.cell.planets == "free" else "white"
        axes.plot(np.maximum(sizes, FAINTEST), apart, "o", ms=4.5, mec=colour, mfc=fill)
        if share is not None:
            said = f" {share} severe"
            axes.text(1.0, row, said, va="center", transform=axes.get_yaxis_transform())
        names.append(f"{LAW_NAMES[strip.cell.law]}, {PLANET_NAMES[strip.cell.planets]}")
    axes.axvline(SEVERE, color="k", lw=0.7, ls="--", label=f"counted as severe ({SEVERE:g})")
    axes.axvline(PAPER_THIRD, color="k", lw=0.7, ls=":", label=f"the paper's ({PAPER_THIRD:g})")
    axes.set_yticks(range(len(names)), names)
    axes.set(xscale="log", xlabel="third fluctuation [rad/s²]", ylim=(len(names) - 0.5, -0.5))
    legend(figure, axes)
    return to_svg(figure)
