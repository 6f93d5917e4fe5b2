"""Hypothesis H6: the controller pushes the sun and looks at the link, so the teeth can flutter."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from matplotlib.ticker import NullFormatter

from crosscheck.audit.claims.rule import State
from crosscheck.audit.experiments.cells import READINGS
from crosscheck.audit.hypotheses.evidence import flutter, linear_limits
from crosscheck.audit.hypotheses.evidence.flutter import VIBRATES, Flutter, FlutterSetting, Handed
from crosscheck.audit.hypotheses.evidence.linear_limits import GrowthCheck, Threshold
from crosscheck.audit.measures.shares import Share, share_of
from crosscheck.audit.measures.undefined import JsonObject, recorded, word
from crosscheck.audit.page.chapter import AuditChapter
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.text import html, text
from crosscheck.models.errors import Diverged
from crosscheck.report.fragments import COLOURS
from crosscheck.report.plots.figures import legend, new_figure, to_svg

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


def chapter(material: Material) -> AuditChapter:
    """The chapter on thresholds and growth; full: also runs over zeta and what they live on."""
    limits = linear_limits.survey(material.scale.quick)
    smooth = material.scale.cut(linear_limits.smooth_variant())
    try:
        run = material.study.runs([smooth], "H6, growth without play")[smooth]
        check = linear_limits.growth_check(linear_limits.growth_rate(run))
    except Diverged:
        check = linear_limits.growth_check({})
    found = Vibrating() if material.scale.quick else vibrating(material)
    verdict = h6(limits, check, found)
    page = text(
        "hypotheses/controller",
        verdict=verdict,
        check=check,
        found=found,
        flutter=flutter,
        resolved=RESOLVED,
        single=largest_with_any(found, "always"),
        continued=continued(found),
        cured=linear_limits.cured_at_the_sun(limits),
        starts=len(material.scale.seeds),
        drawing=html(drawing(limits, found.cells)) if found.cells else None,
        poses=LIMITS.html(one for one in limits if one.by_pose),
        others=LIMITS.html(one for one in limits if not one.by_pose),
        cells=CELLS.html(found.cells),
        handed=HANDOVERS.html(found.handed),
    )
    agrees = word(check.agrees, "agree", "differ")
    records = [
        verdict,
        recorded({"id": "controller/growth", **vars(check), "verdict": agrees}),
        *LIMITS.json(limits),
        *CELLS.json(found.cells),
        *HANDOVERS.json(found.handed),
    ]
    outcome = text("hypotheses/controller_outcome", verdict=verdict)
    return AuditChapter(ID, TITLE, page, records, outcome)


@dataclass(frozen=True)
class Vibrating:
    """The simulated settings, none in the quick report. handed: what becomes of each of HANDED."""

    cells: tuple[Flutter, ...] = ()
    handed: tuple[tuple[FlutterSetting, Handed], ...] = ()

    def of(self, **fields: object) -> dict[tuple[flutter.Damping, float], Flutter]:
        """The cells whose settings have these fields, by damping and zeta."""
        return {
            (one.setting.damping, one.setting.zeta): one
            for one in self.cells
            if all(getattr(one.setting, name) == value for name, value in fields.items())
        }


def vibrating(material: Material) -> Vibrating:
    """The vibration in all settings that are run, and what becomes of one that is handed over.

    Settings are with and without tooth error, with dampers always and in contact alone; with the
    latter also without feedback, with steady stiffness and with lumped planets.
    """
    scale = material.scale
    settings = [
        FlutterSetting(d, zeta, error) for d, zeta, error in product(DAMPINGS, ZETAS, ERRORS_UM)
    ]
    for zeta in ZETAS:
        settings += [
            FlutterSetting("contact", zeta, played_back=True),
            FlutterSetting("contact", zeta, varying=False),
            FlutterSetting("contact", zeta, planets="lumped"),
        ]
    cells = tuple(flutter.flutters(material.study, settings, scale))
    if scale.longest_s < flutter.HANDED_S + flutter.AFTER_S:
        return Vibrating(cells)
    seeds = scale.seeds[: scale.starts(HANDED_STARTS)]
    asked = {one: flutter.DriveHandover(one.variant(), seeds) for one in HANDED}
    handed = material.study.answered(asked, "H6, vibration handed over")
    return Vibrating(cells, tuple(handed.items()))


def independent_of_error(found: Vibrating) -> bool | None:
    """Whether the same settings vibrate with and without tooth error, and some do; or None."""
    without, with_error = (found.of(tooth_error_um=error, **PLAIN) for error in ERRORS_UM)
    states = [(without[place].state, with_error[place].state) for place in without]
    if not states or any(State.UNDEFINED in pair for pair in states):
        return None
    return any(one == State.YES for one, _ in states) and all(a == b for a, b in states)


def lives_on_feedback(found: Vibrating) -> bool | None:
    """Whether no start vibrates without feedback, from the beginning or after a handover."""
    bare = [one for one in found.cells if one.setting.played_back]
    if not bare or any(one.share is None for one in bare):
        return None
    left = [size for _, one in found.handed for size in (*one.torque, *one.sun)]
    goes_on = [size for _, one in found.handed for size in one.link]
    if max(goes_on, default=0.0) <= VIBRATES:
        return None  # there was nothing to hand over
    return all(one.share and not one.share.yes for one in bare) and max(left) <= VIBRATES


def highest_vibrating(found: Vibrating, **fields: object) -> float | None:
    """The largest zeta at which more than few starts vibrate without tooth error; None for none."""
    cells = found.of(tooth_error_um=0.0, **{**PLAIN, **fields}).values()
    some = (State.YES, State.BISTABLE)
    return max((one.setting.zeta for one in cells if one.state in some), default=None)


def largest_with_any(found: Vibrating, damping: flutter.Damping) -> float | None:
    """The largest zeta at which any start vibrates without tooth error; None for none."""
    cells = found.of(tooth_error_um=0.0, damping=damping, **PLAIN).values()
    return max((one.setting.zeta for one in cells if one.share and one.share.yes), default=None)


def continued(found: Vibrating) -> dict[str, Share]:
    """The share of starts that vibrate on after ``AFTER_S``, by what drives the arm, if any."""
    shares = {
        name: share_of(size > VIBRATES for _, one in found.handed for size in getattr(one, name))
        for name in Handed._fields
    }
    return {name: share for name, share in shares.items() if share is not None}


def h6(limits: Sequence[Threshold], check: GrowthCheck, found: Vibrating) -> JsonObject:
    """The record of H6: what its verdict rests on, thresholds with the paper's gains, vibrations.

    Thresholds are the lowest and the highest of all poses; vibrations are without tooth error.
    """
    parts = {
        "sensing at the sun removes it": linear_limits.cured_at_the_sun(limits),
        "growth as predicted": check.agrees,
    }
    if found.cells:
        parts["independent of E"] = independent_of_error(found)
        parts["gone without feedback"] = lives_on_feedback(found)
    paper = [one.zeta for one in limits if one.is_papers]
    return {
        "id": "H6",
        "verdict": _in_words(parts.values()),
        "parts": dict(parts),
        "lowest_threshold_zeta": min(paper),
        "highest_threshold_zeta": max(paper),
        "vibrates_up_to_zeta": {
            "always": highest_vibrating(found, damping="always"),
            "contact": highest_vibrating(found, damping="contact"),
            "contact_lumped": highest_vibrating(found, damping="contact", planets="lumped"),
            "contact_steady": highest_vibrating(found, damping="contact", varying=False),
        },
    }


def _in_words(parts: Collection[bool | None]) -> str:
    """The verdict in words: holds, in part, or not at all; undefined if that hangs on what is."""
    if True in parts and False in parts:
        return "holds in part"
    return word(None if None in parts else all(parts), "holds", "does not hold")


def _resolved(sizes: Sequence[float]) -> tuple[float | None, ...]:
    """The sizes [rad/s^2], None for those that cannot be told from nothing."""
    return tuple(size if size > RESOLVED else None for size in sizes)


def _ends_and_median(
    name: str,
) -> Callable[[tuple[FlutterSetting, Handed]], tuple[float | None, ...]]:
    """A function to the least, median and largest size of the starts, by what drives the arm."""

    def parts(pair: tuple[FlutterSetting, Handed]) -> tuple[float | None, ...]:
        ordered = sorted(getattr(pair[1], name))
        return _resolved((ordered[0], ordered[len(ordered) // 2], ordered[-1]))

    return parts


def _growing(limit: Threshold) -> float | None:
    """The growth rate [1/s] without damping; None for rounding."""
    rate = limit.undamped_growth_per_s
    return rate if abs(rate) > ROUNDING_PER_S else None


LIMITS = Columns[Threshold](
    "controller/threshold/{0.point.arm}/elbow {0.elbow_deg:g}"
    "/P {0.point.gains[0]:g} D {0.point.gains[1]:g}/k {0.point.stiffness:g}/{0.point.sensed}",
    [
        TableColumn("arm", "reading", lambda one: READINGS[one.point.arm]),
        TableColumn("elbow_deg", "elbow [°]", form=".0f"),
        TableColumn("P_N_m_per_rad", "P [N m/rad]", "point.gains.0", "g"),
        TableColumn("D_N_m_s_per_rad", "D [N m s/rad]", "point.gains.1", "g"),
        TableColumn("stiffness_over_k_m", "k / k_m", "point.stiffness", "g"),
        TableColumn("sensed", "looks at the", "point.sensed"),
        TableColumn("zeta", "unstable below ζ (0: nowhere)", form=".5f"),
        TableColumn("frequency_Hz", "mode there [Hz]", form=".0f"),
        TableColumn("undamped_growth_per_s", "growth at ζ = 0 [1/s]", _growing),
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
        TableColumn("feedback", "feedback", lambda one: not one.setting.played_back),
        TableColumn("planets", "planets", "setting.planets"),
        TableColumn("vibrating", "starts that vibrate", "share.yes"),
        TableColumn("starts", "of", lambda one: len(one.sizes)),
        TableColumn(
            "quantiles_rad_per_s2", "vibration [rad/s²]", lambda one: _resolved(one.quantiles)
        ),
        TableColumn("frequency_Hz", "[Hz]", form=".0f"),
        TableColumn("state", None, "state.value"),
    ],
)
HANDOVERS = Columns[tuple[FlutterSetting, Handed]](
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


def drawing(limits: Sequence[Threshold], cells: Sequence[Flutter]) -> str:
    """Threshold over pose and derivative gain, share of starts that vibrate over zeta, as svg."""
    picture, grid = new_figure(1, 3, 2.9)
    link = [r for r in limits if r.point.sensed != linear_limits.SUN and r.point.stiffness == 1]
    proportional, _ = linear_limits.PAPER_GAINS
    panels = (
        ([(r.point.arm, r.elbow_deg, r.zeta) for r in link if r.by_pose], "elbow angle [°]"),
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
            own = sorted((x, zeta) for of, x, zeta in points if of == arm)
            axes.plot(*np.array(own).T, "o-", color=colour, label=READINGS[arm], ms=3)
        axes.set(xlabel=label, ylabel="unstable below ζ [1]", ylim=(0, None))
    axes = grid[0, 2]
    plain = [one for one in cells if not one.setting.tooth_error_um]
    kinds = dict.fromkeys(_kind(one.setting) for one in plain)
    for kind, colour in zip(kinds, COLOURS[2:], strict=False):
        mine = [one for one in plain if _kind(one.setting) == kind]
        values = [one.share.value if one.share else np.nan for one in mine]
        axes.plot([r.setting.zeta for r in mine], values, "o-", color=colour, label=kind, ms=3)
    axes.set(xscale="log", xlabel="ζ", ylabel="share that vibrates [1]", ylim=(-0.05, 1.05))
    axes.xaxis.set_minor_formatter(NullFormatter())
    legend(picture, grid[0, 0], grid[0, 2])
    return to_svg(picture)


def _kind(setting: FlutterSetting) -> str:
    """The words for a setting, without its zeta."""
    words = [f"dampers act {'always' if setting.damping == 'always' else 'in contact'}"]
    if setting.played_back:
        words.append("no feedback")
    if not setting.varying:
        words.append("steady stiffness")
    if setting.planets == "lumped":
        words.append("planets lumped")
    return ", ".join(words)
