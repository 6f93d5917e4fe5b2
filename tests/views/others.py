"""Views of studies, of what changed since a record, and of errata."""

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
from tests.views.agreements import derive_numbers, make_agreement, print_with
from tests.views.shown_numbers import View, mark

MEMBERS, UNDEFINED = 9, 2


def make_result() -> xr.Dataset:
    """A study's result, of which some members diverged; means are no medians."""
    peaks = np.transpose([np.arange(-1.0, MEMBERS - 1) ** 2, np.arange(-5.0, MEMBERS - 5) ** 3])
    peaks[:UNDEFINED] = np.nan
    diverged = np.where(np.arange(MEMBERS) < UNDEFINED, 0.5, np.nan)
    sizes = np.array([[1.0, 4.0], [2.0, 3.0]])
    return xr.Dataset(
        {
            "diverged_s": ("payload", diverged),
            "theta_peak": (("payload", "joint"), peaks),
            "theta_peak_difference": (("checked", "joint"), 1e-9 * sizes),
            "theta_peak_difference_over_spread": (("checked", "joint"), 0.1 * sizes),
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


def make_change() -> Agreement:
    """What has changed since a record that accepts two differences."""
    made = make_agreement("arm", False, 1)
    agreeing = [f.about.key for f in made.checks if f.verdict == "agree"][:2]
    return replace(made, accepted_keys=agreeing)


def make_errata() -> list[Erratum]:
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
    return mark(made)


def print_errata(errata: list[Erratum]) -> str:
    """What `errata --all` prints, one line for each text."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(errata_texts, "WIDTH", 10_000)
        sections = errata_texts.list_sections("probe", errata)
        return "\n".join(errata_texts.format_sections(sections, True))


def format_errata(errata: list[Erratum]) -> str:
    """The JSON file's records."""
    sections = errata_texts.list_sections("probe", errata)
    return format_json({"errata": [row for section in sections for row in section.records]})


def render_errata(errata: list[Erratum]) -> str:
    """The sheet."""
    return sheet.build_sheet(errata_texts.list_sections("probe", errata), 0.3).html


VIEWS = {
    "terminal of a study": View(make_result, print_result),
    "terminal of changes": View(
        make_change, lambda made: print_with(terminal.print_changed, made), derive_numbers
    ),
    "terminal of errata": View(make_errata, print_errata),
    "JSON of errata": View(make_errata, format_errata),
    "page of errata": View(make_errata, render_errata),
}
