"""Answers of the third fluctuation, and models that go on from a state."""

import numpy as np

from crosscheck.analytic.model import PhysicalModel
from crosscheck.audit.experiments.samples import judge_third_fluctuation
from crosscheck.audit.judging.quantities import Sample
from crosscheck.audit.judging.rule import Answer
from crosscheck.models.loading import Case


def third(*sizes: float) -> Answer:
    """The third fluctuation of starts of these sizes [rad/s^2]."""
    sample = Sample({"third": np.array(sizes)}, np.zeros(len(sizes), bool))
    return judge_third_fluctuation(sample)


class ContinuedModel(PhysicalModel):
    """A model that starts from any state q, v (n,)."""

    def __init__(self, case: Case, q: np.ndarray, v: np.ndarray) -> None:
        super().__init__(*case)
        self.state = q, v

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        return self.state
