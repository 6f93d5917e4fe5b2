"""The paper's own forms of the equations behind the common interface."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import ClassVar

from crosscheck.analytic.derivation.forms import Form
from crosscheck.analytic.derivation.symbolic_terms import build_form_terms
from crosscheck.analytic.derivation.terms import Terms, select_rigid_terms
from crosscheck.analytic.model import AnalyticModel
from crosscheck.analytic.paper.coverage import PAPER_COVERAGE, is_covered_by_paper
from crosscheck.analytic.paper.energies import build_energies_form
from crosscheck.analytic.paper.printed import build_printed_form
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.layout import Layout, lumped_layout, rigid_layout
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import Scenario, Switches


@lru_cache(maxsize=32)
def _build_form_terms(arm: Arm, form: Form) -> Terms:
    return build_form_terms(form, arm)


class FormModel(AnalyticModel):
    """A geared arm in the paper's coordinates, with a form of its equations in symbols.

    Raises InputError for an arm that the paper's equations do not cover.
    """

    name = "analytic:form"
    abilities = AnalyticModel.abilities | {"mesh_modes"}

    build_form: ClassVar[Callable[[], Form]]

    def __init__(
        self,
        arm: Arm,
        scenario: Scenario,
        chosen_switches: Switches | None = None,
        form: Form | None = None,
    ) -> None:
        _require_coverage(arm, self.name)
        super().__init__(arm, scenario, chosen_switches)
        self.terms = _build_form_terms(arm, form or type(self).build_form())

    def find_layout(self) -> Layout:
        """The paper's coordinates."""
        return lumped_layout(self.arm)


def _require_coverage(arm: Arm, model: str) -> None:
    if not is_covered_by_paper(arm):
        raise InputError(arm.name, "joints", None, f"{model} {PAPER_COVERAGE}")


class PrintedModel(FormModel):
    """The model by Eqs. 21-22, entry for entry."""

    name = "analytic:printed"
    build_form = staticmethod(build_printed_form)


class PrintedRigidModel(AnalyticModel):
    """The rigid limit of Eqs. 21-22: no mesh moves, and the rows of theta are left.

    Mesh forces are absent from these rows, so that nothing but x' = x'' = 0 is put in. Raises
    InputError for an arm that the paper's equations do not cover.
    """

    name = "analytic:printed-rigid"

    def __init__(
        self, arm: Arm, scenario: Scenario, chosen_switches: Switches | None = None
    ) -> None:
        _require_coverage(arm, self.name)
        super().__init__(arm, scenario, chosen_switches)
        self.terms = select_rigid_terms(_build_form_terms(arm, build_printed_form()))

    def find_layout(self) -> Layout:
        """The joints' angles alone."""
        return rigid_layout(self.arm)


class EnergiesModel(FormModel):
    """The model by Eqs. 16-19 through Lagrange's equations."""

    name = "analytic:energies"
    build_form = staticmethod(build_energies_form)
