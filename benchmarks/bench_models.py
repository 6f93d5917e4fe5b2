"""Cost of a run and of a state, model by model, side by side: `make bench`.

The machine's noise cancels in the ratios of one run; quote those and the medians.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from crosscheck.checks.answers import sample_states
from crosscheck.models.loading import load_case
from crosscheck.registry import build, model_names

RUN = ("scenario.duration_s=0.02",)


@pytest.mark.benchmark(group="2000 steps of the PD run")
@pytest.mark.parametrize("name", ["analytic:physical", "analytic:printed", "exudyn:tree"])
def test_run(benchmark: Any, name: str) -> None:
    model = build(name, *load_case("paper-labelled", "pd", settings=RUN))
    benchmark.pedantic(model.simulate, rounds=5, warmup_rounds=1)


@pytest.mark.benchmark(group="rigid run of 0.02 s")
@pytest.mark.parametrize("level", ["links", "coupled"])
@pytest.mark.parametrize("engine", ["analytic", "pinocchio"])
def test_rigid_run(benchmark: Any, engine: str, level: str) -> None:
    model = build(f"{engine}:{level}", *load_case("paper-labelled", "pd", settings=RUN))
    benchmark.pedantic(model.simulate, rounds=5, warmup_rounds=1)


@pytest.mark.benchmark(group="acceleration at one state")
@pytest.mark.parametrize("name", model_names("geared"))
def test_acceleration(benchmark: Any, name: str) -> None:
    model = build(name, *load_case("paper-labelled", "pd"))
    states = sample_states(model.coordinates, model.arm, 1, 0)
    result = benchmark(model.acceleration, states.t[0], states.q[0], states.v[0])
    assert np.isfinite(result).all()
