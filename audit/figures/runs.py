"""Which runs are drawn in which figure, and every choice that the paper leaves open."""

from __future__ import annotations

from dataclasses import replace

from crosscheck.audit.experiments.cells import Cell
from crosscheck.audit.experiments.experiments import DEFAULTS, PD, Source, question
from crosscheck.audit.experiments.variant import Variant
from crosscheck.audit.measures.rigid import rigid_model

# The paper gives no damping. At the smaller value its third fluctuation shows under its own law.
ZETA, LOW_ZETA = 0.02, 0.005
SMOOTH_RECORD = 20  # 0.2 ms: for angles and speeds, which have nothing at mesh frequencies
FULL_RECORD = 2  # 20 µs: eleven records of a period of the fastest mesh mode


def drawn(source: Source, cell: Cell, seed: int | None, record_every: int = FULL_RECORD) -> Variant:
    """An experiment in a setting as the claims' samples have it, from one of their starts."""
    variant = question(PD if source in DEFAULTS else source, cell, ()).variant
    return replace(variant, seed=seed, record_every=record_every)


def rigid_run(scenario: str, level: str) -> Variant:
    """The rigid arm at a level, recorded on the grid of the smooth runs."""
    return Variant(scenario, model=rigid_model(level), record_every=SMOOTH_RECORD)
