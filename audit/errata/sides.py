"""The two sides of a trial: models of any scenario that know what they are made of.

Equal sides make equal models, so a run that several trials need is made once.
"""

from __future__ import annotations

from dataclasses import dataclass

from crosscheck.analytic.derivation.forms import Form
from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.model import FormModel
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import Scenario
from crosscheck.models.experiment.switches import Switches


@dataclass(frozen=True)
class PhysicalSide:
    """The physical model."""

    arm: Arm
    chosen: Switches

    def __call__(self, scenario: Scenario) -> PhysicalModel:
        return PhysicalModel(self.arm, scenario, self.chosen)


@dataclass(frozen=True)
class FormSide:
    """A form of the paper's equations, in symbols."""

    arm: Arm
    form: Form

    def __call__(self, scenario: Scenario) -> FormModel:
        return FormModel(self.arm, scenario, None, self.form)
