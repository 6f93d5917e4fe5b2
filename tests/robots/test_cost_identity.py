"""Which joints `cost` says identified links take up: by each engine's torques, on random arms."""

from dataclasses import replace

import numpy as np
import pytest

from crosscheck.models.pinocchio.regressor import LinkRegressor
from crosscheck.models.robot.identity import find_identity_joints
from crosscheck.models.robot.robot import Robot
from crosscheck.registry import build_robot_model
from tests.robots import chains


def draw_arm(seed: int) -> Robot:
    """Three bodies on turned joints, each with one rotor; the last stands elsewhere or askew.

    Not the second: the link before turns about one axis alone, and so hides how a rotor stands.
    """
    rng = np.random.default_rng(seed)
    links, joints, rotors = [chains.link("l0")], [], {}
    for number in (1, 2, 3):
        solid = chains.Solid(rng.uniform(1, 5), rng.uniform(-0.2, 0.2, 3))
        links.append(chains.link(f"l{number}", solid))
        axis = rng.normal(size=3)
        before, after = f"l{number - 1}", f"l{number}"
        at, rpy = rng.uniform(-0.5, 0.5, 3), rng.uniform(-1, 1, 3)
        joints.append(chains.joint(f"j{number}", before, after, axis=axis, at=at, rpy=rpy))
        rotors[f"j{number}"] = chains.geared(float(rng.choice([-1, 1]) * rng.uniform(5, 100)))
    rotors["j3"] |= {"stator": "l1" if seed % 2 else "l2", "rotor_axis": [0.6, 0.0, 0.8]}
    robot = chains.robot(chains.urdf(*links, *joints), rotors)
    if not seed % 2:
        return robot
    along = robot.joints[2].placement.rotation @ robot.joints[2].axis  # in l2, as if it were l1
    return replace(robot, rotors=(*robot.rotors[:2], replace(robot.rotors[2], axis=along)))


@pytest.mark.parametrize("engine", chains.ENGINES)
@pytest.mark.parametrize("seed", range(4))
def test_links_take_up_what_armature_leaves_out_at_just_these_joints(engine, seed):
    """Coupled less armature of a rotor, in parts of J N: links and its acceleration make it up.

    1e-9 is the rounding of links' torques, some 100 N m, against J N of .005 kg m^2 and more.
    """
    robot = draw_arm(seed)
    rng = np.random.default_rng(9)
    motion = [rng.uniform(-2, 2, (60, 3)) for _ in range(3)]
    slopes = LinkRegressor(robot).compute(*motion)
    named = find_identity_joints(robot)
    assert named == ["j1", "j2"]
    for rotor in robot.rotors:
        single = replace(robot, rotors=(rotor,))
        coupled, armature = (
            build_robot_model(engine, single, level).inverse_dynamics(*motion)
            for level in ("coupled", "armature")
        )
        alone = np.zeros((60, 3, 1))
        alone[:, rotor.joint, 0] = motion[2][:, rotor.joint]
        span = np.concatenate([slopes, alone], axis=2).reshape(180, -1)
        apart = (coupled - armature).ravel()
        left = apart - span @ np.linalg.lstsq(span, apart, rcond=1e-10)[0]
        share = np.abs(left).max() / abs(rotor.inertia * rotor.ratio)
        if robot.joints[rotor.joint].name in named:
            assert share < 1e-9
        else:
            assert share > 1e-2


@pytest.mark.parametrize(("sine", "is_along"), [(0.98e-4, True), (1.02e-4, False)])
def test_a_rotor_is_along_its_joint_to_four_digits(sine, is_along):
    robot = draw_arm(0)
    across = np.cross(robot.rotors[0].axis, [0.6, 0.0, 0.8])
    axis = robot.rotors[0].axis + sine * across / np.linalg.norm(across)
    tilted = replace(robot, rotors=(replace(robot.rotors[0], axis=axis),))
    assert (find_identity_joints(tilted) == ["j1"]) == is_along
