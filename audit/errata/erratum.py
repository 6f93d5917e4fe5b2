"""One error of the paper, and how much it matters."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import call
from typing import Any, Literal

import numpy as np
import sympy as sp
import xarray as xr

from crosscheck.analytic.derivation.forms import Form
from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.model import FormModel
from crosscheck.checks.trajectories import largest_difference
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario, Switches, switches

Side = Callable[[Scenario], xr.Dataset]  # equal ones have equal runs
# An error of an equation, with its effect; a statement or a number without support; notation.
ErratumClass = Literal["equation", "statement", "notation"]


@dataclass(frozen=True)
class Effect:
    """Largest change over a run: joint angle [rad], elastic mesh force per planet [N], its impulse.

    impulse_N_s: of a mesh since the start. An impact that comes a little later changes the force by
    its whole height and the impulse by next to nothing.
    """

    theta_rad: float
    mesh_force_N: float
    impulse_N_s: float


@dataclass(frozen=True)
class Erratum:
    """An erratum: where, and how far what is printed is from what should stand there.

    id: names it for good; printed, derived: formulas, or words; remark: what these do not say; size
    [unit]: for this arm, derived minus printed where both are numbers; others: sizes of further
    entries of M, by unit; trial: two models that differ in the erratum alone, as printed and put
    right, None once they have run; effects: what it changes in a run, by scenario; printed_tex,
    derived_tex: the formulas as TeX, if any; denies: ids of the claims that are wrong if the
    erratum is right.
    """

    id: str
    kind: ErratumClass = "equation"
    where: str = ""
    printed: str = ""
    derived: str = ""
    remark: str = ""
    size: float | None = None
    unit: str = ""
    others: Mapping[str, float] = field(default_factory=dict)
    trial: tuple[Side, Side] | None = None
    effects: Mapping[str, Effect] = field(default_factory=dict)
    printed_tex: str = ""
    derived_tex: str = ""
    denies: tuple[str, ...] = ()


def compute_effect(
    trial: tuple[Side, Side],
    scenario: Scenario,
    run: Callable[[Side, Scenario], xr.Dataset] = call,
) -> Effect:
    """The effect of an erratum on the runs of both models in a scenario. Raises Diverged.

    run: may give again what it has given.
    """
    printed, corrected = (run(side, scenario) for side in trial)
    sizes, impulses = list[float](), list[float]()
    for force in ("F_sp", "F_pr"):
        sizes.append(largest_difference(printed, corrected, force))
        impulse = (printed[force] - corrected[force]).cumulative_integrate("time")
        impulses.append(float(np.abs(impulse).max()))
    angle = largest_difference(printed, corrected, "theta")
    return Effect(angle, float(np.max(sizes)), float(np.max(impulses)))


@dataclass(frozen=True)
class PaperSide:
    """One side of an erratum: a model of an arm, of a form of the equations or the physical one."""

    arm: Arm
    form: Form | None = None
    chosen: Switches = field(default_factory=switches)

    def __call__(self, scenario: Scenario) -> xr.Dataset:
        """The run of the side's model. Raises Diverged."""
        if self.form is None:
            return PhysicalModel(self.arm, scenario, self.chosen).simulate()
        return FormModel(self.arm, scenario, None, self.form).simulate()


def write_sides(printed: sp.Expr, derived: sp.Expr) -> dict[str, Any]:
    """Both formulas of an erratum, as text and as TeX, by its fields."""
    return {
        "printed": str(printed),
        "derived": str(derived),
        "printed_tex": tex(printed),
        "derived_tex": tex(derived),
    }


def tex(expression: sp.Expr) -> str:
    """TeX of an expression in the paper's symbols: M_s2 as M_{s2}, dtheta_1 as a dotted theta."""
    names = {}
    for symbol in expression.free_symbols:
        stem, _, index = symbol.name.partition("_")
        number = re.search(r"\d+$", symbol.name)
        if not index and number:  # L2, d1: an index without a line
            stem, index = symbol.name[: number.start()], number.group()
        dotted = len(stem) > 1 and stem.startswith("d")
        base = stem[1:] if dotted else stem
        base = rf"\{base}" if base == "theta" else base
        base = rf"\dot{{{base}}}" if dotted else base
        names[symbol] = f"{base}_{{{index}}}" if index else base
    return str(sp.latex(expression, symbol_names=names))
