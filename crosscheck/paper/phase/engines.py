"""Evidence 3: the same vibration in an independent engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from crosscheck.paper.phase.experiments import ENGINE, SETTINGS, Setting
from crosscheck.paper.phase.fluctuations import Fluctuation, measured
from crosscheck.paper.phase.planets import FLUCTUATION_AND_SPREAD
from crosscheck.paper.phase.verdict import Evidence, second_engine_supports
from crosscheck.paper.planets.pairs import ENGINE_STARTS, STARTS, TwoModels, two_models
from crosscheck.paper.planets.samples import Cell, Quantiles, Sample
from crosscheck.paper.planets.verdict import LARGE_RAD_PER_S2, SIGNIFICANT, not_told_apart
from crosscheck.paper.record import JsonObject, Record
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import UNDEFINED, shown
from crosscheck.report.fragments import heading, paragraph, table
from crosscheck.studies.study import Study

MICRO = 1e6


@dataclass(frozen=True)
class UnderAngle(Record):
    """Exudyn's third fluctuation under `angle`, all planets free, from one start."""

    setting: Setting
    found: Fluctuation

    @property
    def id(self) -> str:
        return f"engine-angle/{self.setting.ring_rate}/{self.setting.zeta:g}"

    def to_dict(self) -> JsonObject:
        head = {"id": self.id, **self.setting._asdict()}
        found = self.found
        if found.diverged_s is not None:
            return {**head, "diverged_s": found.diverged_s}
        return {
            **head,
            "onset_s": found.onset_s,
            "frequency_Hz": found.frequency_Hz,
            "amplitude_rad_per_s2": found.amplitude_rad_per_s2,
            "planet_spread_m": found.planet_spread_m,
        }


class Engines(NamedTuple):
    """The evidence, and the settings at which both models were run."""

    evidence: Evidence
    compared: list[TwoModels]


def engines(study: Study, scale: Scale) -> Engines:
    """Many seeded starts of both models with free planets, held against each other by two tests."""
    compared, angle = two_models(study, scale), _under_angle(study, scale)
    text = [
        heading("3. The same in Exudyn"),
        paragraph(_question()),
        table(SAMPLE_HEAD, [row for one in compared for row in sample_rows(one)]),
        *(paragraph(answer(one)) for one in compared),
        paragraph(_angle_text(angle)),
    ]
    supports = second_engine_supports(
        [one.same for one in compared],
        [one.shown for one in compared],
        [one.found.amplitude_rad_per_s2 for one in angle],
    )
    records = [*compared, *angle]
    return Engines(Evidence("\n".join(text), records, supports), compared)


def freed_planets(compared: Sequence[TwoModels]) -> str:
    """A sentence for every setting: what counting three planets as one does to the vibration."""
    return " ".join(_freed(one) for one in compared if one.lumped.share and one.analytic.share)


def _freed(one: TwoModels) -> str:
    return (
        f"At zeta = {one.setting.zeta:g} and ring rate {one.setting.ring_rate} the fluctuation"
        f" under omega_t is large in {_counted(one.lumped)} starts with three planets counted as"
        f" one and in {_counted(one.analytic)} with free planets (H7)."
    )


def _under_angle(study: Study, scale: Scale) -> list[UnderAngle]:
    """One start at every setting."""
    cells = [Cell("angle", setting) for setting in SETTINGS]
    variants = [scale.cut(cell.starts("free", [1], ENGINE)[0]) for cell in cells]
    runs = measured(study, variants, FLUCTUATION_AND_SPREAD, "phase: Exudyn under angle")
    return [UnderAngle(setting, run) for setting, run in zip(SETTINGS, runs, strict=True)]


SAMPLE_HEAD = (
    "zeta",
    "ring rate",
    "model",
    "large in",
    "95 % interval of the share",
    "amplitude [rad/s²]",
    "planets apart by up to [µm]",
    "onset of the large ones [s]",
    "their frequency [Hz]",
)


def sample_rows(one: TwoModels) -> list[tuple[str, ...]]:
    """Of every sample of a setting: medians and the quantiles 0.1 and 0.9."""
    named = (
        ("analytic, planets lumped", one.lumped),
        ("analytic, planets free", one.analytic),
        ("Exudyn, planets free", one.engine),
    )
    zeta, ring = one.setting
    return [(f"{zeta:g}", ring, name, *_sample(sample)) for name, sample in named]


def _sample(sample: Sample) -> tuple[str, ...]:
    share = sample.share
    interval = UNDEFINED if share is None else f"{share.low:.2f} to {share.high:.2f}"
    return (
        _counted(sample),
        interval,
        _quantiles(sample.amplitude),
        _quantiles(sample.spread, MICRO),
        _quantiles(sample.onset),
        _quantiles(sample.frequency),
    )


def _counted(sample: Sample) -> str:
    share = sample.share
    return UNDEFINED if share is None else f"{share.yes} of {share.of}"


def _quantiles(found: Quantiles, unit: float = 1.0) -> str:
    values = (found.median, found.low, found.high)
    median, low, high = (None if value is None else unit * value for value in values)
    return f"{shown(median, '.4g')} ({shown(low, '.4g')} to {shown(high, '.4g')})"


def _question() -> str:
    starts = " and ".join(
        f"{count} at zeta = {setting.zeta:g}" for setting, count in ENGINE_STARTS.items()
    )
    return (
        "Question: is the third fluctuation under omega_t a property of the paper's equations or of"
        " one program? Exudyn's tree has a body for every planet; the analytic model is"
        " given free planets as well. Starts perturbed by up to 1e-12 m, planet by planet:"
        f" {STARTS} of the analytic model, {starts} of Exudyn's, same step (10 µs), because a"
        " growth by many powers of ten turns rounding into another realisation: distributions are"
        " compared, the"
        f" shares of starts above {LARGE_RAD_PER_S2:g} rad/s² by Fisher's exact test, the"
        " amplitudes by Mann and Whitney's. PD run to 1.2 s, labelled reading, E = 5 µm, b = 50 µm,"
        " all recorded at 10 kHz, which cuts peaks a little lower than section 2's 50 kHz. Medians"
        " with the quantiles 0.1 and 0.9."
    )


def answer(one: TwoModels) -> str:
    """Whether the models differ at a setting, in words."""
    zeta, ring = one.setting
    setting = f"zeta = {zeta:g}, ring rate {ring}"
    if one.same is None:
        few = "so few starts could not be told apart"
        missing = "not every start has a third fluctuation"
        return f"At {setting} it is undefined: {missing if one.could_differ else few}."
    p = f"p = {one.tests.by_share:.2g} for the shares, {one.tests.by_size:.2g} for the amplitudes"
    held = f"({p}; limit {SIGNIFICANT:g})"
    if one.same:
        return f"At {setting} no test tells the two models apart {held}.{_power(one)}"
    return f"At {setting} the two models are told apart {held}."


def _power(one: TwoModels) -> str:
    """What the test of the shares could not have seen."""
    analytic, engine = one.analytic.share, one.engine.share
    if analytic is None or engine is None:
        return ""
    fewest, most = not_told_apart(analytic, engine.of)
    return (
        f" That is no proof that they are equal: beside {analytic.yes} of {analytic.of}, anything"
        f" from {fewest} to {most} of {engine.of} would have passed the test of the shares."
    )


def _angle_text(runs: Sequence[UnderAngle]) -> str:
    found = ", ".join(f"{_size(run.found)} at zeta = {run.setting.zeta:g}" for run in runs)
    return f"Under angle, with all planets free, Exudyn's third fluctuation is {found} (one start)."


def _size(found: Fluctuation) -> str:
    if found.diverged_s is not None:
        return "diverged"
    amplitude = found.amplitude_rad_per_s2
    return UNDEFINED if amplitude is None else f"{amplitude:.2g} rad/s²"
