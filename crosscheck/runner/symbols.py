"""A form of the paper in symbols, worked out by another process."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.checks.answers import sample_states
from crosscheck.models.loading import Case
from crosscheck.registry import MODELS
from crosscheck.runner.outcomes import SelfKeyedTask, return_failures

FORMS = "analytic:energies", "analytic:printed"  # forms whose symbols are available


@dataclass(frozen=True)
class SymbolicEvaluation(SelfKeyedTask):
    """A task: work out a form of the paper in symbols, at the states that its model answers."""

    form: str
    case: Case
    quantity: str
    count: int
    seed: int
    cost = 1.0  # rough seconds

    @property
    def model(self) -> str:
        """Name of what answers: the model's symbols."""
        return f"{self.form} in symbols"

    @return_failures
    def perform(self) -> np.ndarray:
        """M (count, n, n) or the bias (count, n), or why there is none."""
        import sympy as sp  # half a second, for this alone

        from crosscheck.analytic.derivation.symbols import parameter_values
        from crosscheck.analytic.paper.energies import build_energies_form
        from crosscheck.analytic.paper.printed import build_printed_form

        forms = dict(zip(FORMS, (build_energies_form, build_printed_form), strict=True))
        form, arm = forms[self.form](), self.case.arm
        layout = MODELS[self.form].layout(arm, self.case.switches)
        drawn = sample_states(layout, arm, self.count, self.seed)
        numbers = {s: sp.Float(float(x), 17) for s, x in parameter_values(arm).items()}
        entries = getattr(form, self.quantity).xreplace(numbers)
        evaluate = sp.lambdify((form.q, form.v), entries, "numpy")
        values = [np.array(evaluate(q, v), dtype=float) for _, q, v in zip(*drawn, strict=True)]
        return np.array([v[:, 0] if v.shape[1] == 1 else v for v in values])
