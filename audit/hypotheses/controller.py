"""Hypothesis H6: the controller pushes the sun and looks at the link, so the teeth can flutter."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from matplotlib.ticker import NullFormatter

from crosscheck.audit.claims.rule import State
from crosscheck.audit.experiments.paper_conditions import READINGS
from crosscheck.audit.hypotheses.evidence import flutter, linear_limits
from crosscheck.audit.hypotheses.evidence.flutter import (
    VIBRATES,
    Flutter,
    FlutterSetting,
    VibrationAfterHandover,
)
from crosscheck.audit.hypotheses.evidence.linear_limits import GrowthCheck, Threshold
from crosscheck.audit.measures.shares import Share, share_of
from crosscheck.audit.measures.undefined import JsonObject, format_answer, to_json
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.context import AuditContext
from crosscheck.audit.page.text import render_template, to_markup
from crosscheck.models.errors import Diverged
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import draw_legend, make_figure, to_svg

ID, TITLE = "controller", "The controller's own flutter (H6)"
ZETAS = (0.003, 0.004, 0.005, 0.006, 0.008, 0.01, 0.015, 0.02)
ERRORS_UM = (0.0, 5.0)
DAMPINGS: tuple[flutter.Damping, ...] = ("always", "contact")
# Above the linear limit, dampers in contact alone; with lumped planets it vibrates further up.
HANDED = (FlutterSetting("contact", 0.006), FlutterSetting("contact", 0.01, planets="lumped"))
HANDED_STARTS = 16
RESOLVED = 1e-3  # rad/s^2: ten times what is left of a torque that is played back from 1 ms rows
ROUNDING_PER_S = 1e-6
PLAIN = {"varying": True, "played_back": False, "planets": "free"}


def build_chapter(context: AuditContext) -> AuditChapter:
    """The chapter on thresholds and growth; full: also runs over zeta and what they live on."""
    limits = linear_limits.find_thresholds(context.scale.quick)
    smooth = context.scale.cut(linear_limits.smooth_variant())
    try:
        run = context.study.run_variants([smooth], "H6, growth without play")[smooth]
        check = linear_limits.check_growth(linear_limits.growth_rate(run))
    except Diverged:
        check = linear_limits.check_growth({})
    evidence = FlutterEvidence() if context.scale.quick else run_flutter_settings(context)
    verdict = build_h6_record(limits, check, evidence)
    page = render_template(
        "hypotheses/controller",
        verdict=verdict,
        check=check,
        found=evidence,
        flutter=flutter,
        resolved=RESOLVED,
        single=find_single_flutter_limit(evidence, "always"),
        continued=compute_lasting_shares(evidence),
        cured=linear_limits.is_cured_at_sun(limits),
        starts=len(context.scale.seeds),
        drawing=to_markup(draw_flutter_limits(limits, evidence.cells)) if evidence.cells else None,
        poses=LIMITS.html(limit for limit in limits if limit.has_paper_gains),
        others=LIMITS.html(limit for limit in limits if not limit.has_paper_gains),
        cells=CELLS.html(evidence.cells),
        handed=HANDOVERS.html(evidence.handed),
    )
    agrees = format_answer(check.agrees, "agree", "differ")
    records = [
        verdict,
        to_json({"id": "controller/growth", **vars(check), "verdict": agrees}),
        *LIMITS.json(limits),
        *CELLS.json(evidence.cells),
        *HANDOVERS.json(evidence.handed),
    ]
    outcome = render_template("hypotheses/controller_outcome", verdict=verdict)
    return AuditChapter(ID, TITLE, page, records, outcome)


@dataclass(frozen=True)
class FlutterEvidence:
    """The simulated settings, none in the quick report.

    What becomes of each after a switch of its law.
    """

    cells: tuple[Flutter, ...] = ()
    handed: tuple[tuple[FlutterSetting, VibrationAfterHandover], ...] = ()

    def select(self, **fields: object) -> dict[tuple[flutter.Damping, float], Flutter]:
        """The cells whose settings have these fields, by damping and zeta."""
        return {
            (result.setting.damping, result.setting.zeta): result
            for result in self.cells
            if all(getattr(result.setting, name) == value for name, value in fields.items())
        }


def run_flutter_settings(context: AuditContext) -> FlutterEvidence:
    """The vibration in all settings that are run, and what becomes of one whose law is switched.

    Settings are with and without tooth error, with dampers always and in contact alone; with the
    latter also without feedback, with steady stiffness and with lumped planets.
    """
    scale = context.scale
    settings = [
        FlutterSetting(d, zeta, error) for d, zeta, error in product(DAMPINGS, ZETAS, ERRORS_UM)
    ]
    for zeta in ZETAS:
        settings += [
            FlutterSetting("contact", zeta, played_back=True),
            FlutterSetting("contact", zeta, varying=False),
            FlutterSetting("contact", zeta, planets="lumped"),
        ]
    cells = tuple(flutter.measure_flutter(context.study, settings, scale))
    if scale.longest_s < flutter.HANDED_S + flutter.AFTER_S:
        return FlutterEvidence(cells)
    seeds = scale.seeds[: scale.limit_starts(HANDED_STARTS)]
    questions = {setting: flutter.DriveHandover(setting.variant(), seeds) for setting in HANDED}
    handed = context.study.answer_by_key(questions, "H6, vibration handed over")
    return FlutterEvidence(cells, tuple(handed.items()))


def is_independent_of_error(evidence: FlutterEvidence) -> bool | None:
    """Whether the same settings vibrate with and without tooth error, and some do; or None."""
    without, with_error = (evidence.select(tooth_error_um=error, **PLAIN) for error in ERRORS_UM)
    states = [(without[place].state, with_error[place].state) for place in without]
    if not states or any(State.UNDEFINED in pair for pair in states):
        return None
    return any(state == State.YES for state, _ in states) and all(a == b for a, b in states)


def is_driven_by_feedback(evidence: FlutterEvidence) -> bool | None:
    """Whether no start vibrates without feedback, from the beginning or after a switch."""
    bare = [result for result in evidence.cells if result.setting.played_back]
    if not bare or any(result.share is None for result in bare):
        return None
    left = [size for _, result in evidence.handed for size in (*result.torque, *result.sun)]
    goes_on = [size for _, result in evidence.handed for size in result.link]
    if max(goes_on, default=0.0) <= VIBRATES:
        return None  # there was nothing to hand over
    return all(result.share and not result.share.yes for result in bare) and max(left) <= VIBRATES


def find_flutter_limit(evidence: FlutterEvidence, **fields: object) -> float | None:
    """The largest zeta at which more than few starts vibrate without tooth error; None for none."""
    cells = evidence.select(tooth_error_um=0.0, **{**PLAIN, **fields}).values()
    some = (State.YES, State.BISTABLE)
    return max((result.setting.zeta for result in cells if result.state in some), default=None)


def find_single_flutter_limit(evidence: FlutterEvidence, damping: flutter.Damping) -> float | None:
    """The largest zeta at which any start vibrates without tooth error; None for none."""
    cells = evidence.select(tooth_error_um=0.0, damping=damping, **PLAIN).values()
    return max(
        (result.setting.zeta for result in cells if result.share and result.share.yes), default=None
    )


def compute_lasting_shares(evidence: FlutterEvidence) -> dict[str, Share]:
    """The share of starts that vibrate on after ``AFTER_S``, by what drives the arm, if any."""
    shares = {
        name: share_of(
            size > VIBRATES for _, vibration in evidence.handed for size in getattr(vibration, name)
        )
        for name in VibrationAfterHandover._fields
    }
    return {name: share for name, share in shares.items() if share is not None}


def build_h6_record(
    limits: Sequence[Threshold], check: GrowthCheck, evidence: FlutterEvidence
) -> JsonObject:
    """The record of H6: what its verdict rests on, thresholds with the paper's gains, vibrations.

    Thresholds are the lowest and the highest of all poses; vibrations are without tooth error.
    """
    parts = {
        "sensing at the sun removes it": linear_limits.is_cured_at_sun(limits),
        "growth as predicted": check.agrees,
    }
    if evidence.cells:
        parts["independent of E"] = is_independent_of_error(evidence)
        parts["gone without feedback"] = is_driven_by_feedback(evidence)
    paper = [limit.zeta for limit in limits if limit.is_papers]
    return {
        "id": "H6",
        "verdict": _describe_verdict(parts.values()),
        "parts": dict(parts),
        "lowest_threshold_zeta": min(paper),
        "highest_threshold_zeta": max(paper),
        "vibrates_up_to_zeta": {
            "always": find_flutter_limit(evidence, damping="always"),
            "contact": find_flutter_limit(evidence, damping="contact"),
            "contact_lumped": find_flutter_limit(evidence, damping="contact", planets="lumped"),
            "contact_steady": find_flutter_limit(evidence, damping="contact", varying=False),
        },
    }


def _describe_verdict(parts: Collection[bool | None]) -> str:
    """The verdict in words: holds, in part, or not at all; undefined if that depends on what is."""
    if True in parts and False in parts:
        return "holds in part"
    return format_answer(None if None in parts else all(parts), "holds", "does not hold")


def _drop_unresolved(sizes: Sequence[float]) -> tuple[float | None, ...]:
    """The sizes [rad/s^2], None for those that cannot be told from nothing."""
    return tuple(size if size > RESOLVED else None for size in sizes)


def _ends_and_median(
    name: str,
) -> Callable[[tuple[FlutterSetting, VibrationAfterHandover]], tuple[float | None, ...]]:
    """A function to the least, median and largest size of the starts, by what drives the arm."""

    def parts(pair: tuple[FlutterSetting, VibrationAfterHandover]) -> tuple[float | None, ...]:
        ordered = sorted(getattr(pair[1], name))
        return _drop_unresolved((ordered[0], ordered[len(ordered) // 2], ordered[-1]))

    return parts


def _growth_rate(limit: Threshold) -> float | None:
    """The growth rate [1/s] without damping; None for rounding."""
    rate = limit.undamped_growth_per_s
    return rate if abs(rate) > ROUNDING_PER_S else None


LIMITS = Columns[Threshold](
    "controller/threshold/{0.point.arm}/elbow {0.elbow_deg:g}"
    "/P {0.point.gains[0]:g} D {0.point.gains[1]:g}/k {0.point.stiffness:g}/{0.point.sensed}",
    [
        TableColumn("arm", "reading", lambda row: READINGS[row.point.arm]),
        TableColumn("elbow_deg", "elbow [°]", form=".0f"),
        TableColumn("P_N_m_per_rad", "P [N m/rad]", "point.gains.0", "g"),
        TableColumn("D_N_m_s_per_rad", "D [N m s/rad]", "point.gains.1", "g"),
        TableColumn("stiffness_over_k_m", "k / k_m", "point.stiffness", "g"),
        TableColumn("sensed", "looks at the", "point.sensed"),
        TableColumn("zeta", "unstable below ζ (0: nowhere)", form=".5f"),
        TableColumn("frequency_Hz", "mode there [Hz]", form=".0f"),
        TableColumn("undamped_growth_per_s", "growth at ζ = 0 [1/s]", _growth_rate),
        TableColumn("growth_at_threshold_per_s", None, "growth_per_s"),
    ],
)
CELLS = Columns[Flutter](
    "controller/flutter/{0.setting.id}",
    [
        TableColumn("damping", "dampers act", "setting.damping"),
        TableColumn("zeta", "ζ", "setting.zeta", "g"),
        TableColumn("tooth_error_um", "E [µm]", "setting.tooth_error_um", "g"),
        TableColumn("varying", "stiffness varies", "setting.varying"),
        TableColumn("feedback", "feedback", lambda row: not row.setting.played_back),
        TableColumn("planets", "planets", "setting.planets"),
        TableColumn("vibrating", "starts that vibrate", "share.yes"),
        TableColumn("starts", "of", lambda row: len(row.sizes)),
        TableColumn(
            "quantiles_rad_per_s2",
            "vibration [rad/s²]",
            lambda row: _drop_unresolved(row.quantiles),
        ),
        TableColumn("frequency_Hz", "[Hz]", form=".0f"),
        TableColumn("state", None, "state.value"),
    ],
)
HANDOVERS = Columns[tuple[FlutterSetting, VibrationAfterHandover]](
    "controller/handed/{0[0].id}",
    [
        TableColumn("zeta", "ζ", "0.zeta", "g"),
        TableColumn("planets", "planets", "0.planets"),
        TableColumn("starts", "starts", lambda pair: len(pair[1].link)),
        TableColumn("link_rad_per_s2", "goes on as it was [rad/s²]", _ends_and_median("link")),
        TableColumn("torque_rad_per_s2", "torque alone", _ends_and_median("torque"), ".1g"),
        TableColumn("sun_rad_per_s2", "looking at the sun", _ends_and_median("sun"), ".1g"),
    ],
)


def draw_flutter_limits(limits: Sequence[Threshold], cells: Sequence[Flutter]) -> str:
    """Threshold over pose and derivative gain, share of starts that vibrate over zeta, as svg."""
    picture, grid = make_figure(1, 3, 2.9)
    link = [r for r in limits if r.point.sensed != linear_limits.SUN and r.point.stiffness == 1]
    proportional, _ = linear_limits.PAPER_GAINS
    panels = (
        (
            [(r.point.arm, r.elbow_deg, r.zeta) for r in link if r.has_paper_gains],
            "elbow angle [°]",
        ),
        (
            [
                (r.point.arm, r.point.gains[1], r.zeta)
                for r in link
                if not r.elbow_deg and r.point.gains[0] == proportional
            ],
            "D [N m s/rad]",
        ),
    )
    for axes, (points, label) in zip(grid[0], panels, strict=False):
        for arm, colour in zip(dict.fromkeys(arm for arm, _, _ in points), COLOURS, strict=False):
            curve = sorted((x, zeta) for of, x, zeta in points if of == arm)
            axes.plot(*np.array(curve).T, "o-", color=colour, label=READINGS[arm], ms=3)
        axes.set(xlabel=label, ylabel="unstable below ζ [1]", ylim=(0, None))
    axes = grid[0, 2]
    plain = [result for result in cells if not result.setting.tooth_error_um]
    labels = dict.fromkeys(_describe_setting(result.setting) for result in plain)
    for kind, colour in zip(labels, COLOURS[2:], strict=False):
        results = [result for result in plain if _describe_setting(result.setting) == kind]
        values = [result.share.value if result.share else np.nan for result in results]
        axes.plot([r.setting.zeta for r in results], values, "o-", color=colour, label=kind, ms=3)
    axes.set(xscale="log", xlabel="ζ", ylabel="share that vibrates [1]", ylim=(-0.05, 1.05))
    axes.xaxis.set_minor_formatter(NullFormatter())
    draw_legend(picture, grid[0, 0], grid[0, 2])
    return to_svg(picture)


def _describe_setting(setting: FlutterSetting) -> str:
    """The words for a setting, without its zeta."""
    words = [f"dampers act {'always' if setting.damping == 'always' else 'in contact'}"]
    if setting.played_back:
        words.append("no feedback")
    if not setting.varying:
        words.append("steady stiffness")
    if setting.planets == "lumped":
        words.append("planets lumped")
    return ", ".join(words)
