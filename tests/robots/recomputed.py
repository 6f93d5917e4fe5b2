"""A robot's costs worked out a second time: by Pinocchio, and by definitions written here.

`cost` asks the project's own derivation, and nothing of Pinocchio. Names, gears and teeth follow
from the files, rates and accelerations of a motion from its angles, which are sums of five sines.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from crosscheck.models.robot.interface import RobotModel
from crosscheck.models.robot.robot import Level, Robot, Rotor
from crosscheck.registry import build_robot_model
from tests.robots import chains

HARMONICS = 5
LIMIT_RADIANS = 0.4  # of the fastest swing in a step
LEVELS: tuple[Level, ...] = ("links", "armature", "coupled")
State = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class RobotFiles:
    """A URDF's text, what the file beside it holds, and the end effector of a file that has none.

    That is the link behind the most moving joints; the last one in the file of those alike.
    """

    urdf: str
    joints: Mapping[str, Mapping[str, Any]]
    gravity: tuple[float, float, float]
    tip: str

    @property
    def kinds(self) -> dict[str, str]:
        """Kinds of the joints that move on their own."""
        joints = ElementTree.fromstring(self.urdf).findall("joint")
        free = [j for j in joints if j.get("type") != "fixed" and j.find("mimic") is None]
        return {str(joint.get("name")): str(joint.get("type")) for joint in free}

    def read(self) -> Robot:
        """As the program reads it; the tip is not stated."""
        return chains.robot(self.urdf, self.joints, gravity_m_per_s2=list(self.gravity))

    def list_spins(self) -> Iterator[Rotor]:
        """Every rotor, sun, and all planets together, each as a rotor of its joint.

        Against the link that carries it a sun turns by 1 + z_r / z_s of the joint, and planets by
        1 - z_r / z_p.
        """
        for name, given in self.joints.items():
            if given["kind"] == "geared":
                transmissions = [dict(given)]
            else:
                of_sun, of_planet = (
                    given["ring_teeth"] / given[f"{gear}_teeth"] for gear in ("sun", "planet")
                )
                planets = given["planet_count"] * given["planet_inertia_kg_m2"]
                transmissions = [
                    chains.geared(1 + of_sun, given["sun_inertia_kg_m2"]),
                    chains.geared(1 - of_planet, planets),
                ]
            for transmission in transmissions:
                yield from chains.robot(self.urdf, {name: transmission}).rotors

    def stretched(self) -> float:
        """Length of the chain from joint to joint, and on to the tip [m], slides at zero."""
        tree = pin.buildModelFromXML(self.urdf)
        data = tree.createData()
        pin.framesForwardKinematics(tree, data, pin.neutral(tree))
        ends = [*data.oMi, data.oMf[tree.getFrameId(self.tip, pin.BODY)]]
        return sum(float(np.linalg.norm(b.translation - a.translation)) for a, b in pairwise(ends))


class Tooth(NamedTuple):
    """A mesh: x is lever times the joint's coordinate while all else is held."""

    name: str
    joint: str
    lever: float
    stiffness: float
    stiffest: float
    damping: float
    play: float


def list_teeth(files: RobotFiles) -> Iterator[Tooth]:
    """Meshes of rotors and of stages, whose stiffness has a sine law, joint by joint."""
    for joint, given in files.joints.items():
        if given["kind"] == "geared":
            mesh = given.get("mesh")
            if mesh:
                lever, k = given["ratio"] * mesh["pinion_base_radius_m"], mesh["stiffness_N_per_m"]
                rest = k, k, mesh["damping_N_s_per_m"], mesh["backlash_m"]
                yield Tooth(f"mesh of {joint}", joint, lever, *rest)
            continue
        radius = given["module_m"] / 2 * np.cos(np.radians(given["pressure_angle_deg"]))
        for side in ("sun", "ring"):
            own, law = given[f"{side}_mesh"], given[f"{side}_mesh"]["stiffness"]
            mean, wave = (
                given["planet_count"] * law[f"{k}_N_per_m"] for k in ("mean", "amplitude")
            )
            lever = radius * (given["sun_teeth"] + given["ring_teeth"])
            rest = mean, mean + wave, own["damping_N_s_per_m"], own["backlash_m"]
            yield Tooth(f"{side} mesh of {joint}", joint, lever, *rest)


class FourierMotion:
    """A motion of five harmonics from its angles at even times over a period."""

    def __init__(self, time: np.ndarray, angles: np.ndarray) -> None:
        self.period = (time[1] - time[0]) * len(time)
        self.parts = (np.fft.rfft(angles, axis=0) / len(time))[: HARMONICS + 1]
        self.parts[1:] *= 2

    def at(self, time: np.ndarray) -> State:
        """Coordinates, rates, accelerations."""
        rates = 2j * np.pi * np.arange(HARMONICS + 1) / self.period
        waves = np.exp(rates * np.asarray(time)[:, None])
        q, v, a = ((waves * rates**order @ self.parts).real for order in range(3))
        return q, v, a


class SecondCost:
    """What `cost` has to tell of a robot along a motion."""

    def __init__(
        self, files: RobotFiles, time: np.ndarray, angles: np.ndarray, runs: int, steps: int
    ) -> None:
        self.files, self.robot = files, files.read()
        self.free, self.spins = list(files.kinds), list(files.list_spins())
        self.teeth, self.motion = list(list_teeth(files)), FourierMotion(time, angles)
        self.time, self.runs, self.steps = time, runs, steps
        self.state = self.motion.at(time)
        self.models = {level: self.build(self.robot, level) for level in (*LEVELS, "geared")}
        self.torques = {level: self.models[level].inverse_dynamics(*self.state) for level in LEVELS}
        self.largest = np.abs(self.torques["coupled"]).max(axis=0)
        self.starts = self.motion.period * np.arange(runs) / runs

    @staticmethod
    def build(robot: Robot, level: Level) -> RobotModel:
        """Pinocchio's model."""
        return build_robot_model("pinocchio", robot, level)

    def error(self, level: str) -> np.ndarray:
        """Torques of a level less those of coupled."""
        return self.torques[level] - self.torques["coupled"]

    @cached_property
    def coupling(self) -> np.ndarray:
        """What coupling adds to M (states, n, n)."""
        with_it, without = (
            self.models[level].mass_matrix(self.state[0]) for level in ("coupled", "armature")
        )
        return with_it - without

    @cached_property
    def by_rates(self) -> np.ndarray:
        """Root of the mean square of what it asks by rates alone."""
        with_it, without = (
            self.models[level].bias(*self.state[:2]) for level in ("coupled", "armature")
        )
        return np.sqrt(((with_it - without) ** 2).mean(axis=0))

    def _feed(self, level: str, steps: int) -> np.ndarray:
        """Torques at each half step after each start (2 steps + 1, runs, n)."""
        times = self.starts + np.linspace(0, 1, 2 * steps + 1)[:, None]
        fed = self.models[level].inverse_dynamics(*self.motion.at(times.ravel()))
        return fed.reshape(*times.shape, fed.shape[1])

    def _run(self, level: str, fed: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Distance of the tip from the plan after a second of torques, at every half step."""
        model, count = self.models[level], len(q) // self.runs
        ends, _ = chains.stepped(
            lambda stage, q, v: model.forward_dynamics(q, v, fed[round(2 * stage)]),
            *(q, v, (len(fed) - 1) // 2),
        )
        planned = self.models["coupled"].tip(self.motion.at(self.starts + 1)[0])
        return np.linalg.norm(model.tip(ends) - np.tile(planned, (count, 1)), axis=1)

    @cached_property
    def distances(self) -> dict[str, np.ndarray]:
        """Of the tip from the plan, by level and run."""
        fed = np.concatenate([self._feed(level, self.steps) for level in LEVELS], axis=1)
        q, v, _ = self.motion.at(np.tile(self.starts, len(LEVELS)))
        away = self._run("coupled", fed, q, v)
        return dict(zip(LEVELS, away.reshape(len(LEVELS), self.runs), strict=True))

    def gear_coupling(self, gears: list[str], factor: float) -> np.ndarray:
        """What gears' coupling asks, of the largest torque, their ratios times a factor.

        At the same reflected inertia, which armature has alone.
        """
        turned = tuple(
            replace(spin, ratio=factor * spin.ratio, inertia=spin.inertia / factor**2)
            for spin in self.spins
            if self.robot.joints[spin.joint].name in gears
        )
        alone = replace(self.robot, rotors=turned, stages=())
        coupled, armature = (
            self.build(alone, level).inverse_dynamics(*self.state)
            for level in ("coupled", "armature")
        )
        return np.abs(coupled - armature) / self.largest

    def forces(self) -> np.ndarray:
        """Force on each rigid mesh (instants, meshes), by d'Alembert on its x alone."""
        return self._forces(self.state)

    def _forces(self, state: State) -> np.ndarray:
        """The motor's part of the torque less what the inertia on x takes."""
        still = np.zeros((len(state[0]), len(self.teeth)))
        q, v, a = (np.hstack([each, still]) for each in state)
        model = self.models["geared"]
        taken = np.einsum("sij,sj->si", model.mass_matrix(q), a) + model.bias(q, v)
        torques = self.models["coupled"].inverse_dynamics(*state)
        found = -taken[:, len(self.free) :]
        for number, tooth in enumerate(self.teeth):
            if tooth.joint in self.free:
                found[:, number] += torques[:, self.free.index(tooth.joint)] / tooth.lever
        return found

    @cached_property
    def _inverse(self) -> np.ndarray:
        """M of geared without its joints' rows, inverted: what meshes press against."""
        q = np.hstack([self.state[0], np.zeros((len(self.time), len(self.teeth)))])
        free = len(self.free)
        return np.linalg.inv(self.models["geared"].mass_matrix(q))[:, free:, free:]

    def swings(self) -> np.ndarray:
        """Frequencies [Hz] (instants, meshes) of each joint's meshes by themselves."""
        found = np.zeros((len(self.time), len(self.teeth)))
        for joint in {tooth.joint for tooth in self.teeth}:
            own = [n for n, tooth in enumerate(self.teeth) if tooth.joint == joint]
            sizes = np.array([self.teeth[n].stiffness for n in own])
            values = np.linalg.eigvals(self._inverse[:, own][:, :, own] * sizes).real
            found[:, own] = np.sort(np.sqrt(values) / (2 * np.pi), axis=1)[:, ::-1]
        return found

    def geared_steps(self) -> int:
        """Steps in a second for the fastest swing, or damper, of all meshes together."""
        stiff, damped = (
            np.linalg.eigvals(self._inverse * [getattr(tooth, size) for tooth in self.teeth]).real
            for size in ("stiffest", "damping")
        )
        return int(np.ceil(max(np.sqrt(stiff.max()), damped.max()) / LIMIT_RADIANS))

    def geared_distances(self, steps: int) -> np.ndarray:
        """Of the tip from the plan where teeth of rotors give way, wound up at the start."""
        q, v, a = self.motion.at(self.starts)
        forces = self._forces((q, v, a)).T
        x = np.stack(
            [
                np.sign(force) * tooth.play + force / tooth.stiffness
                for force, tooth in zip(forces, self.teeth, strict=True)
            ],
            axis=1,
        )
        wound = np.hstack([q, x]), np.hstack([v, 0 * x])
        return self._run("geared", self._feed("coupled", steps), *wound)
