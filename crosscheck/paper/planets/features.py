"""Which features of Figs. 11 to 14 and 16 to 20 survive free planets."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from crosscheck.paper.figures import control, motion, spectra
from crosscheck.paper.figures.runs import (
    BACKLASHES_UM,
    ERRORS_UM,
    LAWS,
    backlash_run,
    control_run,
    error_run,
)
from crosscheck.paper.figures.verdicts import (
    falls,
    fluctuates,
    fluctuation_falls,
    fluctuation_rises,
    in_range,
    near,
    rises,
    visible,
)
from crosscheck.paper.planets.plates import SEEN, Seen
from crosscheck.paper.planets.verdict import SIGNIFICANT, Share, Survival, is_changed, survival
from crosscheck.paper.record import JsonObject, Record
from crosscheck.paper.scale import Scale
from crosscheck.paper.undefined import UNDEFINED, all_of, word
from crosscheck.report.fragments import heading, paragraph, table
from crosscheck.studies.study import Study, Variant
from crosscheck.studies.variant import Planets

ENOUGH = 0.5  # of the starts: for a share
STARTS = {"omega_t": 16, "angle": 4}  # under angle no figure hangs on the start
RECORD_EVERY = 5  # 20 kHz
PLANETS: tuple[Planets, Planets] = ("lumped", "free")


@dataclass(frozen=True)
class Start:
    """All of the figures' runs from one start: the whole PD run, and over b and E [um]."""

    control: Seen
    over_b: Mapping[float, Seen]
    over_E: Mapping[float, Seen]

    @property
    def own(self) -> Seen:
        """At the paper's b and E."""
        return self.over_b[spectra.PAPERS_B_UM]


Decide = Callable[[Start], bool | None]


def _ripples(start: Start) -> bool | None:
    one = start.control
    return all_of(
        (visible(one.ripple_1_N_m, one.largest_1_N_m), visible(one.ripple_2_N_m, one.largest_2_N_m))
    )


def _over_b(
    follows: Callable[[list[float], list[float | None]], bool | None],
    number: Callable[[Seen], float | None],
) -> Decide:
    return lambda start: follows(list(start.over_b), list(map(number, start.over_b.values())))


def _lines(runs: Mapping[float, Seen]) -> spectra.Lines:
    return {size: run.lines for size, run in runs.items()}


def _swings_over_error(start: Start) -> bool | None:
    swings = [run.force_swing_N for run in start.over_E.values()]
    return fluctuation_rises(list(start.over_E), swings)


# Of a figure's number and a statement: whether one start shows it, as the figure itself decides.
FEATURES: tuple[tuple[int, str, Decide], ...] = (
    (11, "both torques ripple in 0.5 to 1.2 s", _ripples),
    (
        12,
        "the side changes near 0.3 s",
        lambda s: near(s.control.side_s, control.SIDE_S, control.SIDE_TOLERANCE),
    ),
    (
        12,
        "the teeth return near 1.5 s",
        lambda s: near(s.control.back_s, control.BACK_S, control.BACK_TOLERANCE),
    ),
    (
        13,
        "the force changes its sign near 0.3 s",
        lambda s: near(s.control.contact_s, control.SIDE_S, control.SIDE_TOLERANCE),
    ),
    (
        14,
        "first fluctuation 10 to 40 rad/s²",
        lambda s: in_range(s.own.first_rad_per_s2, *motion.IMPACTS),
    ),
    (
        14,
        "second fluctuation 10 to 40 rad/s²",
        lambda s: in_range(s.own.second_rad_per_s2, *motion.IMPACTS),
    ),
    (14, "third fluctuation", lambda s: fluctuates(s.own.third_rad_per_s2)),
    (16, "the impact grows with b", _over_b(rises, lambda run: run.peak_N)),
    (16, "it comes later", _over_b(rises, lambda run: run.contact_s)),
    (16, "it lasts shorter", _over_b(falls, lambda run: run.bouncing_s)),
    (
        17,
        "a fluctuation that recedes as b grows",
        _over_b(fluctuation_falls, lambda run: run.force_swing_N),
    ),
    (18, "a line near 1500 Hz at b = 50 µm", lambda s: spectra.near_stated(s.own.lines[0])),
    (
        18,
        "the fluctuation's line drifts down as b grows",
        lambda s: spectra.drifts(_lines(s.over_b)),
    ),
    (
        18,
        "lines below b = 500 µm, a continuous spectrum from there",
        lambda s: spectra.fades(_lines(s.over_b)),
    ),
    (
        18,
        "the elbow's line is larger than the shoulder's",
        lambda s: spectra.elbow_larger(_lines(s.over_b)),
    ),
    (19, "a fluctuation that grows with E", _swings_over_error),
    (20, "a fluctuation that grows with E", lambda s: spectra.grows_with_error(_lines(s.over_E))),
    (20, "minor only below 5 µm", lambda s: spectra.minor_below(_lines(s.over_E))),
    (
        20,
        "the elbow's line is larger than the shoulder's",
        lambda s: spectra.elbow_larger(_lines(s.over_E)),
    ),
)


@dataclass(frozen=True)
class Feature(Record):
    """A figure's feature under a law: shares of starts that show it, None where undefined.

    starts: how many there are, also of those in which it is undefined; family: how many features
    are tested, which share the 5 %.
    """

    figure: int
    statement: str
    law: str
    lumped: Share | None
    free: Share | None
    starts: int
    family: int

    @property
    def id(self) -> str:
        return f"planets/figure-{self.figure}/{self.statement}/{self.law}"

    @property
    def survives(self) -> Survival:
        """What becomes of it."""
        return survival(*(None if s is None else s.value for s in (self.lumped, self.free)))

    @property
    def changed(self) -> bool | None:
        """Whether the shares are told apart; None where they could not be."""
        return is_changed(self.lumped, self.free, self.family)

    def to_dict(self) -> JsonObject:
        return {**super().to_dict(), "survives": self.survives, "changed": self.changed}


@dataclass(frozen=True)
class Features:
    """The features and their text."""

    html: str
    records: Sequence[Feature]


def features(study: Study, scale: Scale) -> Features:
    """Every feature under both laws, with lumped and with free planets."""
    found = _starts(study, scale)
    records = [
        Feature(
            number,
            statement,
            law,
            _share(decide, found[law, "lumped"]),
            _share(decide, found[law, "free"]),
            scale.starts(STARTS[law]),
            len(LAWS) * len(FEATURES),
        )
        for law in LAWS
        for number, statement, decide in FEATURES
    ]
    text = [
        heading("4. Figures 11 to 14 and 16 to 20 with free planets"),
        paragraph(_method()),
        table(_HEAD, map(_row, records)),
        paragraph(_statement(records)),
    ]
    return Features("\n".join(text), records)


def runs_of(law: str, planets: Planets, seed: int) -> list[Variant]:
    """The figures' runs from one start: control, over b, over E."""
    plain = [
        control_run(law),
        *(backlash_run(law, b) for b in BACKLASHES_UM),
        *(error_run(law, e) for e in ERRORS_UM),
    ]
    return [replace(one, planets=planets, seed=seed, record_every=RECORD_EVERY) for one in plain]


def _starts(study: Study, scale: Scale) -> dict[tuple[str, Planets], list[Start]]:
    wanted = {
        (law, planets): [
            runs_of(law, planets, seed) for seed in range(1, scale.starts(STARTS[law]) + 1)
        ]
        for law in LAWS
        for planets in PLANETS
    }
    variants = [scale.cut(one) for starts in wanted.values() for runs in starts for one in runs]
    numbers = iter(study.measures(variants, SEEN, "planets: figures"))
    return {
        key: [_start([Seen.of(next(numbers)) for _ in runs]) for runs in starts]
        for key, starts in wanted.items()
    }


def _start(seen: Sequence[Seen]) -> Start:
    first, last = 1, 1 + len(BACKLASHES_UM)
    over_b = dict(zip(BACKLASHES_UM, seen[first:last], strict=True))
    return Start(seen[0], over_b, dict(zip(ERRORS_UM, seen[last:], strict=True)))


def _share(decide: Decide, starts: Sequence[Start]) -> Share | None:
    """Of the starts in which the feature is defined; None if that is fewer than half."""
    answers = [yes for yes in map(decide, starts) if yes is not None]
    if not answers or len(answers) < ENOUGH * len(starts):
        return None
    return Share.counted(sum(map(bool, answers)), len(answers))


_HEAD = ("figure", "feature", "phase law", "lumped planets", "free planets", "survives", "changed")


def _row(record: Feature) -> tuple[str, ...]:
    shares = (_counted(share, record.starts) for share in (record.lumped, record.free))
    named = (str(record.figure), record.statement, record.law)
    return (*named, *shares, str(record.survives), word(record.changed))


def _counted(share: Share | None, starts: int) -> str:
    if share is None:
        return UNDEFINED
    left_out = f" ({starts - share.of} left out)" if share.of < starts else ""
    return f"{share.yes} of {share.of}{left_out}"


def _method() -> str:
    return (
        "Question: what of the paper's figures of the PD run remains once every planet moves by"
        f" itself? The figures' own runs (zeta = 0.005) and decisions, from {STARTS['omega_t']}"
        f" starts under omega_t and {STARTS['angle']} under angle, recorded at 20 kHz; meshes are"
        " read at the shoulder's first planet. A feature survives if at least nine starts in ten"
        " show it, is bistable if between one and nine do, and is gone below. Starts in which it is"
        " undefined are left out; with fewer than half of them left, so is the share. It counts as"
        f" changed where Fisher's exact test tells the shares apart, at {SIGNIFICANT:g} over all"
        " features and laws together; undefined where so few starts could not be."
    )


def _statement(records: Sequence[Feature]) -> str:
    return " ".join(_told(law, [r for r in records if r.law == law]) for law in LAWS)


def _told(law: str, records: Sequence[Feature]) -> str:
    counts = {kind: sum(r.survives == kind for r in records) for kind in Survival}
    kinds = ", ".join(f"{kind}: {count}" for kind, count in counts.items() if count)
    changed = [r for r in records if r.changed]
    named = "; ".join(f"Fig. {r.figure}, {r.statement} ({r.survives})" for r in changed)
    untold = sum(r.changed is None for r in records)
    return (
        f"Under {law}, whether the {len(records)} features survive: {kinds}. Changed:"
        f" {named or 'none'}; undefined in {untold}. Some start is left out in"
        f" {sum(map(_leaves_out, records))}."
    )


def _leaves_out(record: Feature) -> bool:
    return any(share is None or share.of < record.starts for share in (record.lumped, record.free))
