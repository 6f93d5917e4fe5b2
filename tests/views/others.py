"""Views of studies, of what changed since a record, and of errata."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import xarray as xr

from crosscheck.audit.errata import errata_texts, sheet
from crosscheck.audit.errata.erratum import Effect, Erratum
from crosscheck.cli import studies
from crosscheck.findings import Agreement
from crosscheck.report import terminal
from crosscheck.report.records import format_json
from tests.studies.studies import study
from tests.views.agreements import list_findings, make_agreement, print_with
from tests.views.walker import Fact, View, vary

MEMBERS, UNDEFINED = 9, 2
CUES = {
    "constant-torque": ("effect under 100 N m", "constant_torque"),
    "pd": ("effect under PD control",),
}


def make_result(seed: int) -> xr.Dataset:
    """A study's result, of which some members diverged."""
    rng = np.random.default_rng(seed)
    peaks = rng.normal(size=(MEMBERS, 2))
    peaks[:UNDEFINED] = np.nan
    diverged = np.where(np.arange(MEMBERS) < UNDEFINED, 0.5, np.nan)
    return xr.Dataset(
        {
            "diverged_s": ("payload", diverged),
            "theta_peak": (("payload", "joint"), peaks),
            "theta_peak_difference": (("checked", "joint"), 1e-9 * rng.normal(size=(2, 2)) ** 2),
            "theta_peak_difference_over_spread": (("checked", "joint"), rng.uniform(size=(2, 2))),
        },
        {"checked": [0, 2]},
    )


def print_result(result: xr.Dataset) -> str:
    """What a sweep prints."""
    axis = {"path": "arm.payload_mass_kg", "kind": "list", "values": [*map(float, range(MEMBERS))]}
    made = study([axis], [{"kind": "peak", "signal": "theta"}])
    with TemporaryDirectory() as folder:
        result.to_netcdf(Path(folder) / "out.nc", engine="h5netcdf")
        return print_with(studies._print_ranges, made, Path(folder) / "out.nc")


def list_result(result: xr.Dataset) -> Iterator[Fact]:
    """Facts of a study's result."""
    yield from (Fact(count, name) for name, count in (("gone", UNDEFINED), ("members", MEMBERS)))
    yield Fact(10, "stride")  # of the scenario
    for joint in range(2):
        of_joint = result.isel(joint=joint)
        values, own = of_joint.theta_peak.values, (f"theta_peak, joint {joint + 1}",)
        for name, size in (("least", np.nanmin), ("median", np.nanmedian), ("largest", np.nanmax)):
            yield Fact(float(size(values)), name, own)
        yield Fact(int(np.isnan(values).sum()), "undefined", own)
        yield Fact(values.size, "values", own)
        yield Fact(float(of_joint.theta_peak_difference.max()), "off", own)
        spread = float(of_joint.theta_peak_difference_over_spread.max())
        yield Fact(spread, "spread", own, digits=1)


def make_change(seed: int) -> Agreement:
    """What has changed since a record that accepts two differences."""
    made = make_agreement("arm", False, seed)
    agreeing = [f.about.key for f in made.checks if f.verdict == "agree"][: 1 + seed]
    return replace(made, accepted_keys=agreeing)


def list_change(agreement: Agreement) -> Iterator[Fact]:
    """Facts of it."""
    yield from list_findings(agreement)
    yield Fact(len(agreement.accepted_keys), "accepted")


def make_errata(seed: int) -> list[Erratum]:
    """Two errors of equations, with an effect."""
    effects = {"constant-torque": Effect(0.01, 123.0, 0.4), "pd": Effect(0.03, 47.0, 0.07)}
    made = [
        Erratum(
            f"eq{n}",
            where=f"Eq. {n}",
            printed="a",
            derived="b",
            size=0.3 * n,
            unit="kg",
            effects=effects,
        )
        for n in (21, 22)
    ]
    return vary(made, seed)


def list_errata(errata: list[Erratum]) -> Iterator[Fact]:
    """Facts of errata, and how many entries sections have."""
    for each in errata:
        yield Fact(each.size, "size", (), "kg")
        for scenario, effect in each.effects.items():
            for name, value in vars(effect).items():
                yield from (Fact(value, name, (cue,)) for cue in (scenario, *CUES[scenario]))
    for section in errata_texts.list_sections("probe", errata):
        yield Fact(len(section.records), "entries", (section.heading,))


def print_errata(errata: list[Erratum]) -> str:
    """What `errata --all` prints, one line for each text."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(errata_texts, "WIDTH", 10_000)
        return "\n".join(
            errata_texts.format_sections(errata_texts.list_sections("probe", errata), True)
        )


def format_errata(errata: list[Erratum]) -> str:
    """The JSON file's records."""
    sections = errata_texts.list_sections("probe", errata)
    return format_json({"errata": [row for section in sections for row in section.records]})


def render_errata(errata: list[Erratum]) -> str:
    """The sheet."""
    return sheet.build_sheet(errata_texts.list_sections("probe", errata), 0.3).html


EFFECT = {
    "angle {}": "theta_rad",
    "force {}": "mesh_force_N",
    "impulse {}": "impulse_N_s",
    "^{}(?<=kg)$": "size",
    ": {}$": "entries",
    "right minus printed: {}": "size",
}
SWEEP = {
    "{} of {} members": "gone, members",
    "^{} of {}$": "undefined, values",
    "^{} [(]{}[)]": "off, spread",
    "steps, one in {}": "stride",
}
CHANGED = {
    "changed by {}": "measured",
    "{} x the allowed {}": "share, tolerance",
    "{} of {} recorded results? changed": "red, checks",
    "{} known differences? left": "accepted",
}
WORDING = {
    r"^joint \d|Eqs?\. \d+(?:(?:,| and) \d+)?": "names",
    r"run of 0\.3 s|under 100 N m": "the experiments",
}
VIEWS = {
    "terminal of a study": View(
        make_result, print_result, list_result, phrases=SWEEP, wording={r"joint \d": "names"}
    ),
    "terminal of changes": View(
        make_change,
        lambda made: print_with(terminal.print_changed, made),
        list_change,
        phrases=CHANGED,
        sorted=("share", "tolerance", "measured"),
    ),
} | {
    f"{name} of errata": View(
        make_errata,
        render,
        list_errata,
        phrases=EFFECT,
        wording=WORDING,
        given=lambda made: (errata_texts.load_notes(), errata_texts.load_claims()),
    )
    for name, render in (
        ("terminal", print_errata),
        ("JSON", format_errata),
        ("page", render_errata),
    )
}
