"""The numbers that claims are about, by the experiment that gives them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.studies.study import Numbers


class NotSimulatedError(LookupError):
    """A cell lacks the experiment that a claim is about."""


class Source(NamedTuple):
    """An experiment of a cell; of a family, the size [um] that makes this member."""

    kind: str
    size_um: float | None = None

    def __call__(self, name: str) -> Quantity:
        """One of its numbers."""
        return Quantity(self, name)

    def __str__(self) -> str:
        return self.kind if self.size_um is None else f"{self.kind} {self.size_um:g} um"


class Quantity(NamedTuple):
    """A number by the experiment that it is measured in and its measure's name for it."""

    source: Source
    name: str

    def __str__(self) -> str:
        return f"{self.source}: {self.name}"


class Family(NamedTuple):
    """Experiments that differ in one size [um]."""

    kind: str

    def __call__(self, size_um: float) -> Source:
        """Its member of this size."""
        return Source(self.kind, size_um)


PD, CONSTANT = Source("pd"), Source("constant torque")
# One effect of the gears left out, under PD control and under constant torque.
NO_BACKLASH, NO_ERROR = Source("no backlash"), Source("no error")
CONSTANT_STIFFNESS = Source("constant stiffness")
CONSTANT_NO_ERROR = Source("constant torque, no error")
TWO_PLANETS = Source("two planets")
STATIC = Source("static")  # follows from the arm's data alone
BACKLASH, ERROR = Family("backlash"), Family("tooth error")  # Figs. 16-20
BACK = Family("back and forth, backlash")  # Fig. 15
DIVERGED = "diverged_s"  # what a run that diverged has in place of its numbers


class Known(dict[Quantity, float]):
    """Numbers of a cell; nan where a run has no such number or diverged.

    They come as NumPy's, so that a division by zero is not finite and not an exception. Raises
    NotSimulatedError for an experiment that the cell does not have, KeyError for a quantity that no
    experiment measures.
    """

    def __getitem__(self, quantity: Quantity) -> float:
        return np.float64(super().__getitem__(quantity))

    def __missing__(self, quantity: Quantity) -> float:
        if self.diverged(quantity.source):
            return math.nan
        if self.simulated(quantity.source):
            raise KeyError(quantity)
        raise NotSimulatedError(quantity)

    def simulated(self, source: Source) -> bool:
        """Whether the cell has this experiment."""
        return any(known.source == source for known in self)

    def diverged(self, source: Source) -> bool:
        """Whether the experiment's run diverged."""
        return source(DIVERGED) in self

    def add(self, source: Source, numbers: Numbers) -> None:
        """Take over an experiment's numbers."""
        for name, value in numbers.items():
            self[source(name)] = math.nan if value is None else value

    def share(self, source: Source, other: Source) -> None:
        """Let one experiment's numbers be another's as well."""
        self.update({other(q.name): value for q, value in self.items() if q.source == source})

    def members(self, family: Family) -> list[Source]:
        """The experiments of a family, ascending."""
        found = {known.source for known in self if known.source.kind == family.kind}
        return sorted(found, key=lambda source: source.size_um or 0.0)
