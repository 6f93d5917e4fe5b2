"""A member of a study: a mechanism in an experiment, and what a study asks of it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.mechanisms import supply
from crosscheck.models.experiment.scenario import PdDrive, Scenario, Switches, expand_to_joints
from crosscheck.models.loading import validate_record
from crosscheck.models.robot.robot import Level
from crosscheck.registry import build
from crosscheck.studies.members.starts import perturb_scenario

if TYPE_CHECKING:
    import xarray as xr

    from crosscheck.studies.definition.definition import Definition

Raw = dict[str, Any]  # by section, what the files of a mechanism and a scenario hold


@dataclass(frozen=True)
class MemberCase:
    """A mechanism in an experiment, with laws of its teeth or at a level, as a study asks it.

    signals: names of those that its runs can have; rigid_levels: of models that its runs can be
    compared with; second_model: name of the one that runs spot checks; planet_counts: planets of
    each joint that moves, 0 without a stage; free_planets: of each joint that the scenario lists
    how many move by themselves; mesh_count: what is worked out in a step, in meshes.
    """

    mechanism: Any
    scenario: Scenario
    switches: Switches | None
    level: Level | None
    signals: tuple[str, ...]
    rigid_levels: tuple[str, ...]
    second_model: str
    planet_counts: Sequence[int]
    free_planets: Sequence[int]
    mesh_count: int

    @property
    def experiment(self) -> tuple[Any, Scenario, Any]:
        """What a model of the case is built of, see ``registry.build``."""
        return self.mechanism, self.scenario, self.switches

    def perturb(self, seed: int, size_m: float) -> MemberCase:
        """The case from a start whose mesh displacements differ by up to ``size_m``, by a seed."""
        moved = perturb_scenario(self.scenario, self.free_planets, seed, size_m)
        return replace(self, scenario=moved)

    def targets(self) -> np.ndarray:
        """Targets (joints,) of a PD drive [rad], [m], of all joints that move."""
        assert isinstance(self.scenario.drive, PdDrive)  # as was required
        factors, offsets = self.mechanism.joint_map
        listed = expand_to_joints(self.scenario.drive.target_rad, factors.shape[1])
        targets: np.ndarray = factors @ np.array(listed) + offsets
        return targets

    def make_model(self) -> Any:
        """The model that runs beside those of other members. Raises InputError."""
        return supply("make_member_model", self.mechanism.section)(self)

    def make_run(self, time: np.ndarray, signals: Mapping[str, np.ndarray]) -> xr.Dataset:
        """The Dataset of a run with these signals over time [s]."""
        run: xr.Dataset = supply("make_member_run", self.mechanism.section)(self, time, signals)
        return run

    def simulate_second(self) -> xr.Dataset:
        """The run by the second engine. Raises Diverged."""
        return build(self.second_model, *self.experiment).simulate()


def build_case(
    data: Raw,
    definition: Definition,
    previous: MemberCase | None = None,
    changed: Collection[str] = (),
) -> MemberCase:
    """The case of a study's data; only sections that changed are read again. Raises InputError."""
    if previous is None or "scenario" in changed:
        scenario = validate_record(Scenario, data["scenario"], definition.scenario)
    else:
        scenario = previous.scenario
    if previous is not None and not {definition.section, "switches"}.intersection(changed):
        case = replace(previous, scenario=scenario)
    else:
        read = supply("read_member", definition.section)
        mechanism = (
            None if previous is None or definition.section in changed else previous.mechanism
        )
        case = read(data, definition, scenario, mechanism)
    supply("require_fitting", definition.section)(case, definition)
    return case


def group_cases(cases: Sequence[MemberCase], models: Sequence[Any]) -> Sequence[Any]:
    """Groups of the cases' models that run side by side."""
    groups: Sequence[Any] = supply("group_members", cases[0].mechanism.section)(models)
    return groups
