"""A number of the arm or the experiment that a model has wrong is seen in that model alone.

So it is seen whichever other models have it wrong as well: no check that is asked here holds one
model against another.
"""

from collections.abc import Callable
from functools import cache, lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
import pytest

from crosscheck.checks.answers import EQUATIONS
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.planets import usual_switches
from crosscheck.models.errors import InputError
from crosscheck.models.files import read_raw_arm
from crosscheck.models.interface import Model
from crosscheck.models.loading import Case, load_arm
from crosscheck.planning.arms import QUICK_COUNT
from crosscheck.planning.comparison import Comparison, Results, collect_tasks, judge_comparisons
from crosscheck.planning.sizing import make_unequal_gains_scenario
from crosscheck.registry import MODELS, build, find_covering_models, model_names
from crosscheck.runner.tasks import Evaluation, make_setting
from tests.judged import plan_states

OFF, UNLIKE, DIRECT, APART = 1.001, "three-unlike", "direct-between", "planets-apart"
JUDGES = ("arm-data", "invariants", "form-symbols")
STATES = 4  # a wrong number shows in each
QUANTITIES = ("mass_matrix", "generalized_force")


class Wrong(NamedTuple):
    """A field, by its path, that models of an arm have off by OFF; or by ``more``, if not 0."""

    path: str
    arm: str = UNLIKE
    more: float = 0.0


SCALED = "backlash_m", "tooth_error_m", "stiffness.mean_N_per_m", "stiffness.amplitude_N_per_m"
SHIFTED = {"phase_rad": 1e-3, "static_error_m": 1e-8, "tooth_error_phase_rad": 1e-3}
IN_MESHES = dict.fromkeys((*SCALED, "damping_ratio"), 0.0) | SHIFTED
WRONG = [
    *(Wrong("arm.payload_mass_kg", arm) for arm in ("paper-labelled", "paper-swapped", UNLIKE)),
    Wrong("arm.gravity_m_per_s2.0", more=1e-3),
    Wrong("arm.gravity_m_per_s2.1", more=1e-3),
    *(Wrong(f"arm.links.*.{n}") for n in ("length_m", "com_m", "mass_kg", "inertia_kg_m2")),
    *(Wrong(f"arm.links.*.{name}", "probe") for name in ("cross_section_m2", "density_kg_per_m3")),
    *(Wrong(f"arm.joints.*.{name}") for name in ("module_m", "pressure_angle_deg")),
    *(Wrong(f"arm.joints.*.{gear}_teeth", more=1) for gear in ("sun", "planet", "ring")),
    *(Wrong(f"arm.joints.*.{gear}_mass_kg") for gear in ("sun", "planet", "carrier", "ring")),
    *(Wrong(f"arm.joints.*.{g}_equivalent_mass_kg", "probe") for g in ("sun", "planet", "carrier")),
    *(Wrong(f"arm.joints.*.{g}_inertia_kg_m2") for g in ("sun", "planet", "carrier")),
    Wrong("arm.joints.*.ring_inertia_kg_m2", more=1e-3),
    Wrong("arm.joints.*.friction_N_m_s_per_rad"),
    Wrong("arm.joints.1.motor_mass_kg", DIRECT),
    Wrong("arm.joints.1.rotor_inertia_kg_m2", DIRECT),
    Wrong("arm.joints.*.ring_mesh.damping_N_s_per_m", DIRECT),
    *(
        Wrong(f"arm.joints.*.{side}_mesh.{name}", "probe", more)
        for side in ("sun", "ring")
        for name, more in IN_MESHES.items()
    ),
    *(Wrong(f"arm.joints.*.sun_mesh.{name}", APART) for name in ("backlash_m", "tooth_error_m")),
    *(
        Wrong(f"scenario.drive.{name}")
        for name in ("target_rad", "proportional_N_m_per_rad", "derivative_N_m_s_per_rad")
    ),
]


def moved(value: Any, path: list[str], fault: Wrong) -> Any:
    """The record, list or number with what stands at a path off; what has no such field as is."""
    first, *rest = path or ["*"]
    if isinstance(value, tuple):
        among = first == "*" or first.isdigit()
        chosen = {int(first)} if first.isdigit() else range(len(value))
        below = rest if among else path
        return tuple(moved(v, below, fault) if k in chosen else v for k, v in enumerate(value))
    if path and hasattr(value, first):
        return value.model_copy(update={first: moved(getattr(value, first), rest, fault)})
    if path or value is None or (isinstance(value, int) and not fault.more):
        return value
    return value + type(value)(fault.more) if fault.more else value * OFF


def harmed(case: Case, fault: Wrong) -> Case:
    """The case that models with the fault are made of."""
    section, *path = fault.path.split(".")
    return case._replace(**{section: moved(getattr(case, section), path, fault)})


@lru_cache
def plan_of(name: str) -> list[Comparison]:
    """All comparisons that look at one model alone, of the arm as its file has it."""
    arm = load_arm(name)
    found = plan_states(arm, STATES, 0, read_raw_arm(name))
    where = f"{arm.name}/geared", *(f"{arm.name}/{e.level}" for e in MODELS.values() if e.level)
    return [
        c
        for c in found
        if c.about.key.family in JUDGES
        and c.about.key.case in where
        and c.about.key.quantity in (*QUANTITIES, "power", "bias")
        and not c.about.key.right
        and all(isinstance(task, Evaluation) and task.model == c.about.key.left for task in c.needs)
    ]


def answered(name: str, case: Case, model: Model, quantity: str) -> np.ndarray:
    """A model's answers at the states of a case, of which it may be made or not."""
    (question,) = (each for each in EQUATIONS if each.method == quantity)
    return question(model, make_setting(name, case, STATES, 0))


@lru_cache
def right(name: str, case: Case, quantity: str) -> np.ndarray:
    """The answers of a model that is made of the case."""
    return answered(name, case, build(name, *case), quantity)


@pytest.mark.parametrize("fault", WRONG, ids=lambda fault: f"{fault.arm} {fault.path}")
def test_a_wrong_number_is_seen_in_every_model_that_has_it(fault):
    arm = load_arm(fault.arm)
    case = Case(arm, make_unequal_gains_scenario(arm), usual_switches(arm))
    wrong, has_it, unseen = harmed(case, fault), [], []
    for name in (*find_covering_models("geared", arm, case.switches), *model_names("rigid")):
        try:
            model = build(name, *wrong)
        except InputError:  # of teeth that do not fit: the arm's robot is validated
            has_it.append(name)
            continue
        answer = cache(partial(answered, name, case, model))
        if not any(_differs(answer(each), right(name, case, each)) for each in QUANTITIES):
            continue
        has_it.append(name)
        if not _is_seen(name, arm, answer):
            unseen.append(name)
    assert unseen == []
    assert len(has_it) > 3


def _differs(one: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.abs(one - other).max() > 1e-9 * np.abs(other).max())


def _is_seen(name: str, arm: Arm, answer: Callable[[str], np.ndarray]) -> bool:
    """By any comparison that looks at the model alone."""
    for comparison in plan_of(arm.name):
        if comparison.about.key.left != name:
            continue
        outcomes = {task.key: answer(task.quantity) for task in comparison.needs}
        if comparison.finding(Results(outcomes)).verdict == "differ":
            return True
    return False


@pytest.mark.parametrize("name", ["paper-labelled", UNLIKE])
def test_an_arm_that_is_not_what_its_file_says_is_seen(name):
    """Whatever went wrong between the file and the arm, every model has it."""
    arm = load_arm(name)
    heavier = arm.model_copy(update={"payload_mass_kg": OFF * arm.payload_mass_kg})
    judged = [
        c
        for c in plan_states(heavier, QUICK_COUNT, 0, read_raw_arm(name))
        if c.about.key.family == "arm-data" and c.about.key.quantity == "mass_matrix"
    ]
    outcomes = {t.key: t.perform() for t in collect_tasks(judged)}
    verdicts = {f.left: f.verdict for f in judge_comparisons(judged, Results(outcomes))}
    assert set(verdicts.values()) == {"differ"}
    assert {*model_names("geared"), *model_names("rigid")} == set(verdicts)
