"""What the paper's own forms say in symbols, worked out at the states that their models answer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crosscheck.checks.answers import random_states
from crosscheck.models.loading import Case
from crosscheck.registry import MODELS
from crosscheck.runner.outcomes import OwnKey, or_failure

FORMS = "analytic:energies", "analytic:printed"


@dataclass(frozen=True)
class Stated(OwnKey):
    """The closed form of every entry of a matrix of a form, at random states of a seed."""

    form: str
    quantity: str
    case: Case
    count: int
    seed: int
    cost = 1.0  # rough seconds

    @property
    def model(self) -> str:
        """What answers: the symbols."""
        return f"{self.form} in symbols"

    @or_failure
    def perform(self) -> np.ndarray:
        """M (count, n, n) or the bias (count, n), or why there is none."""
        import sympy as sp  # half a second, for this alone

        from crosscheck.analytic.derivation.symbols import parameter_values
        from crosscheck.analytic.paper.energies import energies_form
        from crosscheck.analytic.paper.printed import printed_form

        forms = dict(zip(FORMS, (energies_form, printed_form), strict=True))
        form, arm = forms[self.form](), self.case.arm
        numbers = {s: sp.Float(float(x), 17) for s, x in parameter_values(arm).items()}
        entries = getattr(form, self.quantity).xreplace(numbers)
        evaluate = sp.lambdify((form.q, form.v), entries, "numpy")
        layout = MODELS[self.form].layout(arm, self.case.switches)
        drawn = random_states(layout, arm, self.count, self.seed)
        values = [np.array(evaluate(q, v), dtype=float) for _, q, v in zip(*drawn, strict=True)]
        return np.array([v[:, 0] if v.shape[1] == 1 else v for v in values])
