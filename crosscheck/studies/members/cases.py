"""A member of a study: a mechanism in an experiment, and its part in the study."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck import registry
from crosscheck.mechanisms import supply
from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.mesh import Mesh
from crosscheck.models.arm.meshes import change_meshes
from crosscheck.models.arm.planets import require_alike
from crosscheck.models.arm.stiffness import SineStiffness
from crosscheck.models.errors import InputError
from crosscheck.models.experiment.scenario import (
    PdDrive,
    Scenario,
    Switches,
    expand_to_joints,
    planet_offsets,
)
from crosscheck.models.loading import require_fit, validate_record, validate_switches
from crosscheck.models.robot.file import RobotFile, RobotSource
from crosscheck.models.robot.robot import MESH_LAWS, RIGID, Level, Robot
from crosscheck.models.trajectory import build_trajectory
from crosscheck.studies.definition.quantities import (
    ARM_SIGNALS,
    JOINT_SIGNALS,
    MESH_SIGNALS,
    ROTOR_SIGNALS,
    SIGNALS,
)

if TYPE_CHECKING:
    import xarray as xr

    from crosscheck.studies.definition.definition import Definition

Raw = dict[str, Any]  # content of the mechanism's and scenario's files, by section

RigidModel = tuple[object, Callable[[], Any]]  # equal keys for equal models; what makes one
# Mesh that fills the place of a rigid arm's missing ones.
ANY_MESH = Mesh(
    stiffness=SineStiffness(law="sine", mean_N_per_m=1.0, amplitude_N_per_m=0.0),
    backlash_m=0.0,
    tooth_error_m=0.0,
    damping_ratio=0.0,
)


@dataclass(frozen=True)
class MemberCase:
    """A mechanism in an experiment, with laws of its teeth or at a level, as a study asks it.

    signals: names of those that its runs can have; rigid_levels: of models that its runs can be
    compared with; second_model: name of the one that runs spot checks; planet_counts: planets of
    each joint that moves, 0 without a stage; free_planets: of each joint that the scenario lists
    how many move by themselves; mesh_count: work of a step, in meshes.
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
        """The arguments of ``registry.build`` for a model of the case."""
        return self.mechanism, self.scenario, self.switches

    def list_signals(self, joint: int | None) -> list[str]:
        """Names of the signals that runs have of a joint, numbered from 1, or of any joint."""
        places = range(len(self.planet_counts)) if joint is None else [joint - 1]
        signals, is_geared = [*JOINT_SIGNALS], self.level == "geared"
        if (is_geared or self.level is None) and any(self.planet_counts[each] for each in places):
            signals += MESH_SIGNALS
        if is_geared and {rotor.joint for rotor, _ in self.mechanism.meshes} & {*places}:
            signals += ROTOR_SIGNALS
        return signals

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
        """The Dataset of a run of these signals over time [s]."""
        name = f"ensemble:{self.level}" if self.level else "ensemble"
        laws = self.switches or MESH_LAWS
        return build_trajectory(name, self.mechanism, self.scenario, laws, time, **signals)


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
    require_fit(scenario, case.mechanism, definition.scenario)
    if case.switches is not None:
        require_alike(*case.experiment, definition.mechanism, definition.scenario)
    return case


def read_arm(data: Raw, definition: Definition, scenario: Scenario, arm: Arm | None) -> MemberCase:
    """The case of a study's data; arm: where it is read already. Raises InputError."""
    arm = arm or validate_record(Arm, data["arm"], definition.mechanism)
    laws = validate_switches(data["switches"], arm)
    planets, is_free = arm.planet_counts, laws.planets == "free"
    return MemberCase(
        arm,
        scenario,
        laws,
        None,
        signals=ARM_SIGNALS,
        rigid_levels=registry.RIGID_LEVELS,
        second_model=registry.second_engine(),
        planet_counts=planets,
        free_planets=[count if is_free else 0 for count in planets],
        mesh_count=2 * sum(count if is_free else min(count, 1) for count in planets),
    )


def make_arm_model(case: MemberCase) -> Any:
    """The reference model of a member. Raises InputError."""
    return registry.build(registry.reference_model(), *case.experiment)


def find_rigid_arm(case: MemberCase, level: str, smooth: Scenario) -> RigidModel:
    """Key of the rigid model in a smooth experiment, and the function that builds it."""
    name = next(
        name
        for name in registry.find_level_models(level)
        if registry.MODELS[name].order is not None
    )
    stripped = change_meshes(case.mechanism, lambda mesh: ANY_MESH)
    return (stripped, smooth), partial(registry.build, name, stripped, smooth)


def read_robot(
    data: Raw, definition: Definition, scenario: Scenario, robot: Robot | None
) -> MemberCase:
    """The case of a study's data; robot: where it is read already. Raises InputError."""
    name, level = definition.mechanism, definition.level
    if robot is None:
        file = validate_record(RobotFile, data["robot"], name)
        robot = RobotSource(file=file, urdf_text=data["urdf"]).build(name)
    if level is not None and robot.find_level(level) is None:
        raise InputError(name, "level", level, f"{robot.name} has {', '.join(robot.levels)}")
    return make_robot_case(robot, level or robot.levels[-1], scenario)


def make_robot_case(robot: Robot, level: Level, scenario: Scenario) -> MemberCase:
    """The case of a robot at a level; joints are as long in work as meshes."""
    planets = {stage.joint: stage.gears.planet_count for stage in robot.stages}
    meshes = len(robot.meshes) + sum(2 * len(each.groups) for each in robot.stages)
    return MemberCase(
        robot,
        scenario,
        None,
        level,
        signals=SIGNALS,
        rigid_levels=RIGID,
        second_model=f"{registry.find_level_engines(level)[1]}:{level}",
        planet_counts=[planets.get(joint, 0) for joint in range(len(robot.joints))],
        free_planets=robot.planet_counts,
        mesh_count=2 * len(robot.joints) + (meshes if level == "geared" else 0),
    )


def make_robot_model(case: MemberCase) -> Any:
    """The robot at its level in its experiment, as its kernel takes it."""
    from crosscheck.analytic.robot.runs import RobotMember

    assert case.level is not None  # as it was read
    return RobotMember(case.mechanism, case.level, case.scenario)


def find_rigid_robot(case: MemberCase, level: Level, smooth: Scenario) -> RigidModel:
    """Key of the rigid model in a smooth experiment, by its numbers, and what gives it."""
    from crosscheck.analytic.robot.runs import RobotMember

    model = RobotMember(case.mechanism, level, smooth)
    numbers = frozenset(model.equations.numbers.items())
    return (numbers, model.equations.structure, smooth), lambda: model


def perturb_scenario(
    scenario: Scenario, planets: Sequence[int], seed: int, size_m: float
) -> Scenario:
    """The scenario whose start's offsets of both meshes, and planets, differ by up to ``size_m``.

    planets: of each joint that move by themselves.
    """
    joints, start, generator = len(planets), scenario.start, np.random.default_rng(seed)
    sun, ring = size_m * generator.uniform(-1, 1, (2, joints))
    changed: dict[str, object] = {
        "sun_planet_offset_m": _add(expand_to_joints(start.sun_planet_offset_m, joints), sun),
        "planet_ring_offset_m": _add(expand_to_joints(start.planet_ring_offset_m, joints), ring),
    }
    if any(planets):
        displacements = [size_m * generator.uniform(-1, 1, count) for count in planets]
        changed["planet_offset_m"] = tuple(
            _add(planet_offsets(start, joint, planets[joint]), displacements[joint])
            for joint in range(joints)
        )
    return scenario.model_copy(update={"start": start.model_copy(update=changed)})


def _add(given: Sequence[float], more: np.ndarray) -> tuple[float, ...]:
    return tuple(float(a + b) for a, b in zip(given, more, strict=True))
