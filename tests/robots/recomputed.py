"""A robot's costs worked out a second time: Lagrange's equations in NumPy, from its files alone.

Nothing here is imported from the program. Links are not merged, slopes are complex steps, and rates
and accelerations of a motion follow from its angles, which are sums of five sines.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

SLOPE = 1e-30  # of a complex step, which rounds nothing
HARMONICS = 5
LIMIT_RADIANS = 0.4  # of the fastest swing in a step
State = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class RobotFiles:
    """A URDF's text and what the file beside it holds."""

    urdf: str
    joints: Mapping[str, Mapping[str, Any]]
    gravity: tuple[float, float, float]


class UrdfLine(NamedTuple):
    """A joint of the URDF: factor and offset by its leader's coordinate, which is of a column."""

    name: str
    kind: str
    parent: str
    child: str
    rotation: np.ndarray
    position: np.ndarray
    axis: np.ndarray
    column: int
    factor: float
    offset: float
    limits: Mapping[str, float]


class Mass(NamedTuple):
    """A link's mass, centre of mass and inertia about it, in the link's frame."""

    link: str
    mass: float
    com: np.ndarray
    inertia: np.ndarray


class Spin(NamedTuple):
    """A rotor, sun or all planets: its rate along an axis of a link, by joint and by meshes.

    teeth: of each mesh its number and what a unit of its rate adds.
    """

    gear: str
    inertia: float
    link: str
    axis: np.ndarray
    line: UrdfLine
    ratio: float
    teeth: tuple[tuple[int, float], ...]


class Tooth(NamedTuple):
    """A mesh: x is lever times the joint's coordinate while all else is held."""

    name: str
    joint: str
    lever: float
    stiffness: float
    stiffest: float
    damping: float
    play: float


class Frame(NamedTuple):
    """Rotation and position of a link, velocity and rate by each free joint, per state."""

    rotation: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    rate: np.ndarray


def _numbers(element: ElementTree.Element | None, key: str, default: str) -> np.ndarray:
    text = default if element is None else element.get(key, default)
    return np.array([float(word) for word in text.split()])


def _part(element: ElementTree.Element, tag: str) -> ElementTree.Element:
    found = element.find(tag)
    assert found is not None
    return found


def _about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotations (states, 3, 3) about a unit vector, by Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.asarray(angle)[..., None, None]
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _turned(element: ElementTree.Element | None) -> np.ndarray:
    roll, pitch, yaw = _numbers(element, "rpy", "0 0 0")
    x, y, z = np.eye(3)
    return _about(z, yaw) @ _about(y, pitch) @ _about(x, roll)


class Lagrangian:
    """The robot's energies as functions of free coordinates, and what follows from them."""

    def __init__(self, files: RobotFiles) -> None:
        root = ElementTree.fromstring(files.urdf)
        moving = [j for j in root.findall("joint") if j.get("type") != "fixed"]
        free = [str(j.get("name")) for j in moving if j.find("mimic") is None]
        self.free, self.gravity = free, np.array(files.gravity)
        self.lines = [self._line(joint) for joint in root.findall("joint")]
        self.masses = list(self._masses(root))
        (self.root,) = {str(e.get("name")) for e in root.findall("link")} - {
            line.child for line in self.lines
        }
        self.moving = [line for line in self.lines if line.kind != "fixed"]
        self.teeth, self.spins = list[Tooth](), list[Spin]()
        for name, given in files.joints.items():
            line = next(line for line in self.lines if line.name == name)
            (self._add_rotor if given["kind"] == "geared" else self._add_stage)(line, given)
        self.gears = list(dict.fromkeys(spin.gear for spin in self.spins))

    def _line(self, joint: ElementTree.Element) -> UrdfLine:
        name, origin, mimic = str(joint.get("name")), joint.find("origin"), joint.find("mimic")
        axis = _numbers(joint.find("axis"), "xyz", "1 0 0")
        ends = [_part(joint, end).get("link", "") for end in ("parent", "child")]
        leader = name if mimic is None else str(mimic.get("joint"))
        factor, offset = "1", "0"
        if mimic is not None:
            factor, offset = mimic.get("multiplier", factor), mimic.get("offset", offset)
        limit = joint.find("limit")
        limits = {} if limit is None else {key: float(text) for key, text in limit.items()}
        return UrdfLine(
            name,
            str(joint.get("type")),
            *ends,
            _turned(origin),
            _numbers(origin, "xyz", "0 0 0"),
            axis / max(np.linalg.norm(axis), 1e-300),
            self.free.index(leader) if leader in self.free else -1,
            float(factor),
            float(offset),
            limits,
        )

    def _masses(self, root: ElementTree.Element) -> Iterator[Mass]:
        for link in root.findall("link"):
            inertial = link.find("inertial")
            if inertial is not None:
                (mass,) = _numbers(inertial.find("mass"), "value", "")
                xx, xy, xz, yy, yz, zz = (
                    float(_part(inertial, "inertia").get(key, ""))
                    for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
                )
                own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
                origin = inertial.find("origin")
                turn, com = _turned(origin), _numbers(origin, "xyz", "0 0 0")
                yield Mass(str(link.get("name")), float(mass), com, turn @ own @ turn.T)

    def _add_rotor(self, line: UrdfLine, given: Mapping[str, Any]) -> None:
        link, axis = given.get("stator", line.parent), line.rotation @ line.axis
        if "rotor_axis" in given:
            axis = np.array(given["rotor_axis"]) / np.linalg.norm(given["rotor_axis"])
        mesh, teeth = given.get("mesh"), ()
        if mesh:
            radius, k = mesh["pinion_base_radius_m"], mesh["stiffness_N_per_m"]
            teeth = ((len(self.teeth), 1 / radius),)
            own = k, k, mesh["damping_N_s_per_m"], mesh["backlash_m"]
            self.teeth.append(
                Tooth(f"mesh of {line.name}", line.name, given["ratio"] * radius, *own)
            )
        inertia = given["rotor_inertia_kg_m2"]
        self.spins.append(Spin(line.name, inertia, link, axis, line, given["ratio"], teeth))

    def _add_stage(self, line: UrdfLine, given: Mapping[str, Any]) -> None:
        """Sun and planets by their numbers of teeth; meshes of a sine law alone."""
        sun, planet, ring = (given[f"{gear}_teeth"] for gear in ("sun", "planet", "ring"))
        planets = given.get("planet_count", 3)
        pitch = given["module_m"] / 2 * np.cos(np.radians(given["pressure_angle_deg"]))
        axis, number = line.rotation @ line.axis, len(self.teeth)
        at = line.name, line.parent
        for inertia, ratio, teeth in (
            (
                given["sun_inertia_kg_m2"],
                1 + ring / sun,
                ((number, 1 / (pitch * sun)), (number + 1, 1 / (pitch * sun))),
            ),
            (
                planets * given["planet_inertia_kg_m2"],
                1 - ring / planet,
                ((number + 1, -1 / (pitch * planet)),),
            ),
        ):
            self.spins.append(Spin(at[0], inertia, at[1], axis, line, ratio, teeth))
        for side in ("sun", "ring"):
            own, law = given[f"{side}_mesh"], given[f"{side}_mesh"]["stiffness"]
            mean, wave = planets * law["mean_N_per_m"], planets * law["amplitude_N_per_m"]
            name, lever = f"{side} mesh of {line.name}", (1 + ring / sun) * pitch * sun
            rest = mean, mean + wave, own["damping_N_s_per_m"], own["backlash_m"]
            self.teeth.append(Tooth(name, line.name, lever, *rest))

    @property
    def tip(self) -> str:
        """The link behind the most moving joints; the last one in the file of those alike."""
        depth = {self.root: (0, self.root)}
        for line in self.lines:
            steps, body = depth[line.parent]
            moves = line.kind != "fixed"
            depth[line.child] = (steps + moves, line.child if moves else body)
        furthest = max(depth.values(), key=lambda own: own[0])
        return [name for name, own in depth.items() if own == furthest][-1]

    def stretched(self) -> float:
        """Length of the chain from joint to joint, and on to the tip [m], slides at zero."""
        frames = self.frames(np.zeros((1, len(self.free))))
        ends = [self.root, *(line.child for line in self.moving), self.tip]
        places = [frames[end].position[0] for end in ends]
        return sum(float(np.linalg.norm(b - a)) for a, b in pairwise(places))

    def frames(self, q: np.ndarray) -> dict[str, Frame]:
        """Every link's Frame at states (states, free)."""
        count, size = q.shape
        found = {
            self.root: Frame(
                np.tile(np.eye(3, dtype=q.dtype), (count, 1, 1)),
                np.zeros((count, 3), q.dtype),
                np.zeros((count, 3, size), q.dtype),
                np.zeros((count, 3, size), q.dtype),
            )
        }
        for line in self.lines:  # parents come before children in the files of tests
            under = found[line.parent]
            rotation, arm = under.rotation @ line.rotation, under.rotation @ line.position
            axis = rotation @ line.axis
            velocity, rate = under.velocity, under.rate
            if line.kind != "fixed":
                value = line.factor * q[:, line.column] + line.offset
                unit = line.factor * axis[:, :, None] * np.eye(size)[line.column]
                if line.kind == "prismatic":
                    arm = arm + value[:, None] * axis
                    velocity = velocity + unit
                else:
                    rotation, rate = rotation @ _about(line.axis, value), rate + unit
            velocity = velocity + np.cross(under.rate, arm[:, :, None], axis=1)
            found[line.child] = Frame(rotation, under.position + arm, velocity, rate)
        return found

    def spin_rows(self, q: np.ndarray, size: int) -> list[np.ndarray]:
        """c (states, size) of each spin, whose rate in space is c times the rates."""
        frames, rows = self.frames(q), []
        for spin in self.spins:
            frame = frames[spin.link]
            row = np.zeros((len(q), size), q.dtype)
            row[:, : q.shape[1]] = np.einsum("si,sij->sj", frame.rotation @ spin.axis, frame.rate)
            row[:, spin.line.column] += spin.ratio * spin.line.factor
            for number, rate in spin.teeth if size > q.shape[1] else ():
                row[:, q.shape[1] + number] += rate
            rows.append(row)
        return rows

    def energies(self, q: np.ndarray, level: str) -> tuple[np.ndarray, np.ndarray]:
        """Mass matrix (states, n, n), and potential energy (states,)."""
        frames, free = self.frames(q), q.shape[1]
        size = free + (len(self.teeth) if level == "geared" else 0)
        matrix = np.zeros((len(q), size, size), q.dtype)
        height = np.zeros(len(q), q.dtype)
        for own in self.masses:
            frame = frames[own.link]
            arm = frame.rotation @ own.com
            velocity = frame.velocity + np.cross(frame.rate, arm[:, :, None], axis=1)
            rate = frame.rotation.swapaxes(1, 2) @ frame.rate
            matrix[:, :free, :free] += own.mass * velocity.swapaxes(1, 2) @ velocity
            matrix[:, :free, :free] += rate.swapaxes(1, 2) @ own.inertia @ rate
            height -= own.mass * (frame.position + arm) @ self.gravity
        if level in ("coupled", "geared"):
            for spin, row in zip(self.spins, self.spin_rows(q, size), strict=True):
                matrix += spin.inertia * row[:, :, None] * row[:, None, :]
        if level == "armature":
            for spin in self.spins:
                column, turns = spin.line.column, spin.ratio * spin.line.factor
                matrix[:, column, column] += spin.inertia * turns**2
        return matrix, height

    def terms(self, q: np.ndarray, v: np.ndarray, level: str) -> tuple[np.ndarray, ...]:
        """M, the torques of rates, and those of weights, by slopes of the energies."""
        count, free = q.shape
        steps = np.concatenate([np.zeros((1, free)), np.eye(free)])
        places = (q[None] + 1j * SLOPE * steps[:, None]).reshape(-1, free)
        matrices, heights = self.energies(places, level)
        matrices = matrices.reshape(free + 1, count, *matrices.shape[1:])
        slopes = np.zeros((v.shape[1], *matrices.shape[1:]))  # nothing depends on a mesh's x
        slopes[:free] = matrices[1:].imag / SLOPE
        weights = np.zeros_like(v)
        weights[:, :free] = (heights.reshape(free + 1, count)[1:].imag / SLOPE).T
        rates = np.einsum("ksij,sk,sj->si", slopes, v, v)
        rates -= np.einsum("kslm,sl,sm->sk", slopes, v, v) / 2
        return matrices[0].real, rates, weights

    def torques(self, state: State, level: str) -> np.ndarray:
        """What a motion needs (states, n)."""
        q, v, a = state
        matrix, rates, weights = self.terms(q, v, level)
        return (matrix @ a[:, :, None])[:, :, 0] + rates + weights

    def accelerations(
        self, q: np.ndarray, v: np.ndarray, pushes: np.ndarray, level: str
    ) -> np.ndarray:
        """Accelerations (states, n) under generalized forces."""
        matrix, rates, weights = self.terms(q[:, : len(self.free)], v, level)
        return np.linalg.solve(matrix, (pushes - rates - weights)[:, :, None])[:, :, 0]

    def places(self, q: np.ndarray) -> np.ndarray:
        """The tip (states, 3)."""
        return self.frames(q[:, : len(self.free)])[self.tip].position


class FourierMotion:
    """A motion of five harmonics from its angles at even times over a period."""

    def __init__(self, time: np.ndarray, angles: np.ndarray) -> None:
        self.period = (time[1] - time[0]) * len(time)
        self.parts = np.fft.rfft(angles, axis=0) / len(time)
        self.beyond = float(np.abs(self.parts[HARMONICS + 1 :]).max())
        self.parts = self.parts[: HARMONICS + 1]
        self.parts[1:] *= 2

    def at(self, time: np.ndarray) -> State:
        """Coordinates, rates, accelerations."""
        rates = 2j * np.pi * np.arange(HARMONICS + 1) / self.period
        waves = np.exp(rates * np.asarray(time)[:, None])
        q, v, a = ((waves * rates**order @ self.parts).real for order in range(3))
        return q, v, a


def stepped(
    slope: Callable[[float, np.ndarray, np.ndarray], np.ndarray],
    q: np.ndarray,
    v: np.ndarray,
    steps: int,
    seconds: float = 1.0,
) -> np.ndarray:
    """Coordinates after equal steps of the classical Runge-Kutta method; slope: by stage number."""
    h, size = seconds / steps, q.shape[1]
    y = np.hstack([q, v])

    def rate(stage: float, y: np.ndarray) -> np.ndarray:
        return np.hstack([y[:, size:], slope(stage, y[:, :size], y[:, size:])])

    for step in range(steps):
        k1 = rate(step, y)
        k2 = rate(step + 0.5, y + h / 2 * k1)
        k3 = rate(step + 0.5, y + h / 2 * k2)
        k4 = rate(step + 1, y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return y[:, :size]


class SecondCost:
    """What `cost` has to tell of a robot along a motion."""

    def __init__(
        self, files: RobotFiles, time: np.ndarray, angles: np.ndarray, runs: int, steps: int
    ) -> None:
        self.robot, self.motion = Lagrangian(files), FourierMotion(time, angles)
        self.time, self.runs, self.steps = time, runs, steps
        self.state = self.motion.at(time)
        levels = ("links", "armature", "coupled")
        self.torques = {level: self.robot.torques(self.state, level) for level in levels}
        self.largest = np.abs(self.torques["coupled"]).max(axis=0)
        self.terms = {level: self.robot.terms(*self.state[:2], level) for level in levels}
        self.starts = self.motion.period * np.arange(runs) / runs

    def error(self, level: str) -> np.ndarray:
        """Torques of a level less those of coupled."""
        return self.torques[level] - self.torques["coupled"]

    @cached_property
    def coupling(self) -> np.ndarray:
        """What coupling adds to M (states, n, n)."""
        return self.terms["coupled"][0] - self.terms["armature"][0]

    @cached_property
    def by_rates(self) -> np.ndarray:
        """Root of the mean square of what it asks by rates alone."""
        return np.sqrt(((self.terms["coupled"][1] - self.terms["armature"][1]) ** 2).mean(axis=0))

    def _feed(self, level: str, steps: int) -> np.ndarray:
        """Torques at each half step after each start (2 steps + 1, runs, n)."""
        times = self.starts + np.linspace(0, 1, 2 * steps + 1)[:, None]
        fed = self.robot.torques(self.motion.at(times.ravel()), level)
        return fed.reshape(*times.shape, fed.shape[1])

    @cached_property
    def distances(self) -> dict[str, np.ndarray]:
        """Of the tip from the plan, by level and run."""
        levels = ("links", "armature", "coupled")
        fed = np.concatenate([self._feed(level, self.steps) for level in levels], axis=1)
        q, v, _ = self.motion.at(np.tile(self.starts, len(levels)))
        ends = stepped(
            lambda stage, q, v: self.robot.accelerations(q, v, fed[round(2 * stage)], "coupled"),
            *(q, v, self.steps),
        )
        planned = self.robot.places(self.motion.at(np.tile(self.starts, len(levels)) + 1)[0])
        away = np.linalg.norm(self.robot.places(ends) - planned, axis=1)
        return dict(zip(levels, away.reshape(len(levels), self.runs), strict=True))

    def gear_coupling(self, gears: list[str], factor: float) -> np.ndarray:
        """What gears' coupling asks, of the largest torque, their ratios times a factor.

        Of a rotor J s^2 / 2, s = c v: J (s' c + s (c' - grad s)); armature has J N^2 a alone.
        """
        q, v, a = self.state
        count, free = q.shape
        steps = np.concatenate([np.zeros((1, free)), np.eye(free)])
        places = (q[None] + 1j * SLOPE * steps[:, None]).reshape(-1, free)
        total = np.zeros_like(q)
        for spin, rows in zip(self.robot.spins, self.robot.spin_rows(places, free), strict=True):
            if spin.gear not in gears:
                continue
            turns = spin.ratio * spin.line.factor
            rows = rows.reshape(free + 1, count, free)
            c, slopes = rows[0].real, rows[1:].imag / SLOPE
            c[:, spin.line.column] += (factor - 1) * turns
            growth = np.einsum("ksi,sk->si", slopes, v)
            speed = (c * v).sum(axis=1)[:, None]
            own = (c * a).sum(axis=1)[:, None] + (growth * v).sum(axis=1)[:, None]
            asked = own * c + speed * (growth - np.einsum("ksi,si->sk", slopes, v))
            asked[:, spin.line.column] -= (factor * turns) ** 2 * a[:, spin.line.column]
            total += spin.inertia / factor**2 * asked
        return np.abs(total) / self.largest

    @cached_property
    def spin_accelerations(self) -> list[np.ndarray]:
        """Accelerations in space of each spin along its axis."""
        q, v, a = self.state
        ahead = self.robot.spin_rows(q + 1j * SLOPE * v, q.shape[1])
        return [((c.real * a) + (c.imag / SLOPE * v)).sum(axis=1) for c in ahead]

    def forces(self) -> np.ndarray:
        """Force on each rigid mesh (instants, meshes), by d'Alembert on its x alone."""
        return self._forces(self.torques["coupled"], self.spin_accelerations)

    def _forces(self, torques: np.ndarray, accelerations: list[np.ndarray]) -> np.ndarray:
        found = np.zeros((len(torques), len(self.robot.teeth)))
        for number, tooth in enumerate(self.robot.teeth):
            if tooth.joint in self.robot.free:
                found[:, number] = torques[:, self.robot.free.index(tooth.joint)] / tooth.lever
        for spin, own in zip(self.robot.spins, accelerations, strict=True):
            for number, rate in spin.teeth:
                found[:, number] -= spin.inertia * rate * own
        return found

    @cached_property
    def _inverse(self) -> np.ndarray:
        """M of geared without its joints' rows, inverted: what meshes press against."""
        free = len(self.robot.free)
        matrix = self.robot.energies(self.state[0], "geared")[0]
        return np.linalg.inv(matrix)[:, free:, free:]

    def swings(self) -> np.ndarray:
        """Frequencies [Hz] (instants, meshes) of each joint's meshes by themselves."""
        found = np.zeros((len(self.time), len(self.robot.teeth)))
        for joint in {tooth.joint for tooth in self.robot.teeth}:
            own = [n for n, tooth in enumerate(self.robot.teeth) if tooth.joint == joint]
            sizes = np.array([self.robot.teeth[n].stiffness for n in own])
            values = np.linalg.eigvals(self._inverse[:, own][:, :, own] * sizes).real
            found[:, own] = np.sort(np.sqrt(values) / (2 * np.pi), axis=1)[:, ::-1]
        return found

    def geared_steps(self) -> int:
        """Steps in a second for the fastest swing, or damper, of all meshes together."""
        stiff = np.array([tooth.stiffest for tooth in self.robot.teeth])
        damped = np.array([tooth.damping for tooth in self.robot.teeth])
        swing = np.sqrt(np.linalg.eigvals(self._inverse * stiff).real.max())
        return int(
            np.ceil(
                max(swing, np.linalg.eigvals(self._inverse * damped).real.max()) / LIMIT_RADIANS
            )
        )

    def geared_distances(self, steps: int) -> np.ndarray:
        """Of the tip from the plan where teeth of rotors give way, wound up at the start."""
        free, teeth = self.robot.free, self.robot.teeth
        q, v, a = self.motion.at(self.starts)
        torques = self.robot.torques((q, v, a), "coupled")
        ahead = self.robot.spin_rows(q + 1j * SLOPE * v, q.shape[1])
        own = [((c.real * a) + (c.imag / SLOPE * v)).sum(axis=1) for c in ahead]
        force = self._forces(torques, own)
        x = np.stack(
            [
                np.sign(f) * tooth.play + f / tooth.stiffness
                for f, tooth in zip(force.T, teeth, strict=True)
            ],
            axis=1,
        )
        fed = self._feed("coupled", steps)

        def slope(stage: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
            pushes = np.hstack([fed[round(2 * stage)], np.zeros_like(x)])
            for number, tooth in enumerate(teeth, len(free)):
                ahead, rate = q[:, number], v[:, number]
                pressed = tooth.stiffness * (ahead - np.sign(ahead) * tooth.play)
                pressed += tooth.damping * rate
                pushes[:, number] -= np.where(np.abs(ahead) > tooth.play, pressed, 0.0)
                if tooth.joint in free:
                    pushes[:, number] += pushes[:, free.index(tooth.joint)] / tooth.lever
            return self.robot.accelerations(q, v, pushes, "geared")

        ends = stepped(slope, np.hstack([q, x]), np.hstack([v, 0 * x]), steps)
        planned = self.robot.places(self.motion.at(self.starts + 1)[0])
        return np.linalg.norm(self.robot.places(ends) - planned, axis=1)
