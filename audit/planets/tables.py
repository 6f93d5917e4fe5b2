"""What the chapter on the planets records and tabulates: one spec for JSON and page."""

from __future__ import annotations

from crosscheck.audit.measures.third import Quantiles
from crosscheck.audit.page.columns import Columns, TableColumn
from crosscheck.audit.phase.page.tables import cell_columns, share_column, third_columns
from crosscheck.audit.planets.features import Feature
from crosscheck.audit.planets.freed import Freed
from crosscheck.audit.planets.growth import Breaking, Foretold, Predictions

FREED: Columns[Freed] = Columns(
    lambda row: f"planets/{row.cell.id}",
    [
        *cell_columns(lambda row: row.cell),
        *third_columns(lambda row: row.lumped, "alike_", "lumped: "),
        *third_columns(lambda row: row.free, "free_", "free: "),
        TableColumn(
            "apart_um",
            "free: planets differ by up to [µm]",
            lambda row: row.free.apart_um,
            ".2g",
        ),
        TableColumn("p_of_shares", "p, shares", lambda row: row.tests.by_share, ".2g"),
        TableColumn("p_of_sizes", "p, sizes", lambda row: row.tests.by_size, ".2g"),
        TableColumn("effect", "freeing makes it", lambda row: row.effect.value),
    ],
)


def _times(row: Breaking) -> Quantiles | None:
    return row.time_s if row.parted.yes else None


BREAKING: Columns[Breaking] = Columns(
    lambda row: f"planets/breaking/{row.cell.id}",
    [
        *cell_columns(lambda row: row.cell),
        share_column("parted", "planets 1 µm apart in", lambda row: row.parted),
        share_column("early", "before 0.3 s in", lambda row: row.early),
        TableColumn("time_s", "when [s], 0.1, 0.5, 0.9 of those", _times, ".3f"),
    ],
)

PREDICTIONS: Columns[Predictions] = Columns(
    lambda row: f"planets/parting/{row.joint}",
    [
        TableColumn("joint", "joint", lambda row: row.joint),
        TableColumn("starts", "starts", lambda row: row.starts),
        TableColumn("parted", "symmetry breaks in", lambda row: row.parted),
        TableColumn("first", "before the other joint's in", lambda row: row.first),
        TableColumn("median_s", "median time [s]", lambda row: row.median_s, ".4f"),
        TableColumn(
            "lumped_right", "foretold along the lumped run in", lambda row: row.lumped_right
        ),
        TableColumn("lumped_error", "largest error", lambda row: row.lumped_largest_error, ".1%"),
        TableColumn("free_right", "foretold along the free run in", lambda row: row.free_right),
        TableColumn("free_error", "largest error", lambda row: row.free_largest_error, ".1%"),
        TableColumn(
            "growth_per_s", "largest growth rate [1/s]", lambda row: row.largest_growth_per_s, ".0f"
        ),
        TableColumn(
            "pressed_m",
            "largest spread without loss of contact [m]",
            lambda row: row.pressed_largest_m,
            ".2g",
        ),
    ],
)

FORETOLD: Columns[Foretold] = Columns(
    lambda row: f"planets/parting/first/{row.along}",
    [
        TableColumn("asked", None, lambda row: row.asked),
        TableColumn("diverged", None, lambda row: row.diverged),
        TableColumn("starts", None, lambda row: row.starts),
        TableColumn("courses_part", None, lambda row: row.courses_part),
        TableColumn("right", None, lambda row: row.right),
        TableColumn("largest_error", None, lambda row: row.largest_error),
        TableColumn("median_error", None, lambda row: row.median_error),
        TableColumn("strayed", None, lambda row: row.strayed),
        TableColumn("right_unless_strayed", None, lambda row: row.right_unless_strayed),
        TableColumn("predicted", None, lambda row: row.all_right),
    ],
)

FEATURE: Columns[Feature] = Columns(
    lambda row: (
        f"planets/claim/{row.claim.id}/{row.place.law.id if row.place.law else ''}"
        f"/{row.place.zeta}/{row.place.choice}"
    ),
    [
        TableColumn("figure", "figure", lambda row: row.claim.figure),
        TableColumn("claim", "statement", lambda row: row.claim.id),
        TableColumn("statement", "in short", lambda row: row.claim.statement),
        TableColumn(
            "law", "law, ring rate", lambda row: row.place.law.id if row.place.law else None
        ),
        TableColumn("zeta", "ζ", lambda row: row.place.zeta, "g"),
        TableColumn("choice", None, lambda row: row.place.choice),
        share_column("alike", "lumped: true in", lambda row: row.lumped.share),
        share_column("free", "free: true in", lambda row: row.free.share),
        TableColumn("survives", "what becomes of it", lambda row: row.survives.value),
        TableColumn("changed", "significantly different", lambda row: row.changed),
    ],
)
