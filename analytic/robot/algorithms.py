"""Rigid-body algorithms on numbers of any kind: floats, exact fractions, symbols that fold.

R. Featherstone, Rigid Body Dynamics Algorithms, Springer, 2008: Newton and Euler's recursion
(5.3), composite bodies (6.2), L D L' (6.5); all in the bodies' own frames. The product of two rates
is one matrix B, with which every point of a body is accelerated by B r more than its origin (W.
Khalil and E. Dombre, Modeling, Identification and Control of Robots, 2002, section 9.6).

A rotor on a rigid gear, of inertia J about z on its stator, spins at s = z w + N q': J z z' belongs
to the stator, and J N couples it to the joint. One on a mesh is free to spin, s = z w + N q' + y':
J s' = g, its own force, is an equation of its own, and the links get -(N e + W' z) g and, because s
is carried about, -J s W' (w x z). So M is that of the links, however many meshes there are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

Number = Any
Vector = tuple[Number, Number, Number]
Matrix = tuple[Vector, Vector, Vector]
NONE: Vector = (0, 0, 0)
BASE = -1  # number of the ground, in place of a body's


class TreeJoint(NamedTuple):
    """A joint and where it stands on the body before it.

    rotation, position [m]: of its frame at coordinate 0; axis: of numbers 0, 1 and -1; coordinate,
    factor, offset: the free coordinate that it follows, and how; friction: held per rate; armature:
    on the diagonal of M.
    """

    parent: int
    slides: bool
    rotation: Matrix
    position: Vector
    axis: Vector
    coordinate: int
    factor: Number
    offset: Number
    friction: Number = 0
    armature: Number = 0


class TreeLink(NamedTuple):
    """A body in its joint's frame: inertia (xx, xy, xz, yy, yz, zz) about its com."""

    mass: Number
    com: Vector
    inertia: tuple[Number, ...]


class TreeRotor(NamedTuple):
    """A balanced rotor on a body, or BASE: its axis there, inertia, joint and ratio.

    Of a rotor on meshes y = sum turns x of the meshes' displacements x, x = sum levers y of the
    rotors', motor: share of its joint's torque that drives it, 1 / ratio or 0. Without turns the
    gear is rigid.
    """

    body: int
    axis: Vector
    inertia: Number
    joint: int
    ratio: Number
    turns: tuple[Number, ...] = ()
    levers: tuple[Number, ...] = ()
    motor: Number = 0


class Mechanism(NamedTuple):
    """A tree of bodies on joints, parents first, with its rotors; gravity in the base's frame.

    has_bodies: whether rotors on rigid gears are bodies, or armature on the diagonal of M.
    """

    joints: tuple[TreeJoint, ...]
    bodies: tuple[TreeLink, ...]
    rotors: tuple[TreeRotor, ...]
    gravity: Vector
    free: int
    has_bodies: bool

    @property
    def rigid_rotors(self) -> list[TreeRotor]:
        """Rotors on rigid gears."""
        return [rotor for rotor in self.rotors if not rotor.turns]

    @property
    def elastic_rotors(self) -> list[TreeRotor]:
        """Rotors that meshes alone turn."""
        return [rotor for rotor in self.rotors if rotor.turns]

    def path(self, body: int) -> Iterator[int]:
        """A body and those before it, down to the base."""
        while body != BASE:
            yield body
            body = self.joints[body].parent


class BodyPose(NamedTuple):
    """Rotation and position [m] of a body's frame in that of the body before it."""

    rotation: Matrix
    position: Vector


class Rates(NamedTuple):
    """Motion of a body in its frame: angular rate, its derivative, the origin's acceleration, B."""

    angular: Vector
    angular_rate: Vector
    acceleration: Vector
    spread: Matrix


class Holding(NamedTuple):
    """Rates of the bodies, forces and moments on them, and what joints hold besides."""

    rates: list[Rates]
    forces: list[Vector]
    moments: list[Vector]
    held: list[Number]


class MassMoments(NamedTuple):
    """Mass m and moments m r and m r r' of a body, or of one and all that it carries."""

    mass: Number
    first: Vector
    second: Matrix


def dot(a: Sequence[Number], b: Sequence[Number]) -> Number:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def plus(a: Vector, b: Vector) -> Vector:
    """Sum of vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def scale(factor: Number, a: Vector) -> Vector:
    """A vector times a number."""
    return factor * a[0], factor * a[1], factor * a[2]


def rotate(matrix: Matrix, a: Vector) -> Vector:
    """A matrix times a vector."""
    return dot(matrix[0], a), dot(matrix[1], a), dot(matrix[2], a)


def _weigh(weights: Sequence[Number], values: Sequence[Number]) -> Number:
    return sum((weight * value for weight, value in zip(weights, values, strict=True)), 0)


def transpose(matrix: Matrix) -> Matrix:
    """The transpose of a matrix."""
    x, y, z = zip(*matrix, strict=True)
    return x, y, z


def compute_moments(body: TreeLink, rotors: Sequence[TreeRotor]) -> MassMoments:
    """Moments of a body's mass, with the rotors that it carries.

    The second moment is half the trace of the inertia less the inertia.
    """
    xx, xy, xz, yy, yz, zz = body.inertia
    inertia = (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)

    def entry(i: int, j: int) -> Number:
        spun = sum((rotor.inertia * (rotor.axis[i] * rotor.axis[j]) for rotor in rotors), 0)
        moved = body.mass * (body.com[i] * body.com[j])
        if i != j:
            return moved - (inertia[i][j] + spun)
        others = sum((inertia[k][k] for k in range(3) if k != i), 0) - inertia[i][i]
        whole = sum((rotor.inertia for rotor in rotors), 0)
        return moved + (others + whole) / 2 - spun

    return MassMoments(body.mass, scale(body.mass, body.com), _symmetric(entry))


def _symmetric(entry: Any) -> Matrix:
    xx, xy, xz, yy, yz, zz = (
        entry(i, j) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    )
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)


def _sum(a: MassMoments, b: MassMoments) -> MassMoments:
    second = _symmetric(lambda i, j: a.second[i][j] + b.second[i][j])
    return MassMoments(a.mass + b.mass, plus(a.first, b.first), second)


def _placed(mass: MassMoments, rotation: Matrix, position: Vector) -> MassMoments:
    """Moments in another frame, in which theirs has this rotation and position."""
    d, h = position, rotate(rotation, mass.first)
    half = [rotate(mass.second, row) for row in rotation]

    def entry(i: int, j: int) -> Number:
        moved = 2 * (d[i] * h[i]) if i == j else d[i] * h[j] + d[j] * h[i]
        return dot(half[i], rotation[j]) + (moved + mass.mass * (d[i] * d[j]))

    return MassMoments(mass.mass, plus(h, scale(mass.mass, d)), _symmetric(entry))


def regroup_masses(joints: Sequence[TreeJoint], bodies: Sequence[MassMoments]) -> list[MassMoments]:
    """The same moving masses in fewer numbers.

    Mass on the axis of a joint that turns moves as if it were on the body before (M. Gautier and
    W. Khalil, IEEE Trans. Robotics and Automation 6 (1990) 368-373): mass, first and second moment
    along the axis stand there. What the base gets does not move.
    """
    result = list(bodies)
    for k in reversed(range(len(joints))):
        joint = joints[k]
        if joint.slides:
            continue
        result[k], on_axis = _split_at_axis(result[k], joint.axis)
        if joint.parent != BASE:
            moved = _placed(on_axis, joint.rotation, joint.position)
            result[joint.parent] = _sum(result[joint.parent], moved)
    return result


def _split_at_axis(mass: MassMoments, axis: Vector) -> tuple[MassMoments, MassMoments]:
    """What of a mass is not on an axis of its frame, and what is as good as on it."""
    away = [1 - a * a for a in axis]
    x, y, z = (moment * factor for moment, factor in zip(mass.first, away, strict=True))
    second = _symmetric(lambda i, j: mass.second[i][j] * (away[i] if i == j else 1))
    along = sum((mass.second[i][i] * (axis[i] * axis[i]) for i in range(3)), 0)
    line = _symmetric(lambda i, j: along * (axis[i] * axis[j]))
    on_axis = MassMoments(mass.mass, scale(dot(axis, mass.first), axis), line)
    return MassMoments(0, (x, y, z), second), on_axis


class MovingTree:
    """A mechanism at a state, whose algorithms all share its poses.

    coordinates: one for each joint, the cosine and sine of those that turn in turned.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        coordinates: Sequence[Number],
        turned: Sequence[tuple[Number, Number]],
    ) -> None:
        self.mechanism = mechanism
        self.poses = [
            _pose(joint, value, *turn)
            for joint, value, turn in zip(mechanism.joints, coordinates, turned, strict=True)
        ]
        carried = mechanism.rigid_rotors if mechanism.has_bodies else []
        bodies = [
            compute_moments(body, [rotor for rotor in carried if rotor.body == place])
            for place, body in enumerate(mechanism.bodies)
        ]
        self.bodies = regroup_masses(mechanism.joints, bodies)

    def rates(self, v: Sequence[Number], a: Sequence[Number]) -> list[Rates]:
        """Rates of every body, joints moving at v and a; the base rises against gravity."""
        result: list[Rates] = []
        lift = scale(-1, self.mechanism.gravity)
        base = Rates(NONE, NONE, lift, (NONE, NONE, NONE))
        for k, (joint, pose) in enumerate(zip(self.mechanism.joints, self.poses, strict=True)):
            under = base if joint.parent == BASE else result[joint.parent]
            back = transpose(pose.rotation)
            lifted = plus(under.acceleration, rotate(under.spread, pose.position))
            angular, growth = rotate(back, under.angular), rotate(back, under.angular_rate)
            origin, relative = rotate(back, lifted), scale(v[k], joint.axis)
            turned, gained = cross(angular, relative), scale(a[k], joint.axis)
            if joint.slides:
                origin = plus(origin, plus(gained, scale(2, turned)))
            else:
                angular, growth = plus(angular, relative), plus(growth, plus(gained, turned))
            result.append(Rates(angular, growth, origin, _spread(angular, growth)))
        return result

    def wrenches(self, rates: Sequence[Rates]) -> tuple[list[Vector], list[Vector]]:
        """Forces and moments about its origin that every body needs for its rates."""
        forces, moments = [], []
        for body, rate in zip(self.bodies, rates, strict=True):
            forces.append(
                plus(scale(body.mass, rate.acceleration), rotate(rate.spread, body.first))
            )
            moments.append(plus(_spun(body.second, rate), cross(body.first, rate.acceleration)))
        return forces, moments

    def project(self, forces: Sequence[Vector], moments: Sequence[Vector]) -> list[Number]:
        """Generalized forces of forces at the bodies' origins and moments on them."""
        forces, moments = list(forces), list(moments)
        held: list[Number] = [0] * len(forces)
        for k in reversed(range(len(forces))):
            joint, pose = self.mechanism.joints[k], self.poses[k]
            held[k] = dot(joint.axis, forces[k] if joint.slides else moments[k])
            if joint.parent != BASE:
                force = rotate(pose.rotation, forces[k])
                moment = plus(rotate(pose.rotation, moments[k]), cross(pose.position, force))
                forces[joint.parent] = plus(forces[joint.parent], force)
                moments[joint.parent] = plus(moments[joint.parent], moment)
        return held

    def turning(self, body: int, axis: Vector) -> dict[int, Number]:
        """W' z: rate of a body about an axis of its frame, per rate of each joint."""
        result = {}
        for k in self.mechanism.path(body):
            joint = self.mechanism.joints[k]
            if not joint.slides:
                result[k] = dot(joint.axis, axis)
            axis = rotate(self.poses[k].rotation, axis)
        return result

    def mass_matrix(self) -> list[list[Number]]:
        """M over all joints, by composite bodies, and what rotors on rigid gears add."""
        mechanism, count = self.mechanism, len(self.poses)
        matrix: list[list[Number]] = [[0] * count for _ in range(count)]
        composites = list(self.bodies)
        for k in reversed(range(count)):
            joint = mechanism.joints[k]
            self._fill_column(matrix, k, composites[k])
            matrix[k][k] = matrix[k][k] + joint.armature
            if joint.parent != BASE:
                moved = _placed(composites[k], *self.poses[k])
                composites[joint.parent] = _sum(composites[joint.parent], moved)
        for rotor in mechanism.rigid_rotors:
            j, spun = rotor.joint, rotor.inertia * rotor.ratio
            matrix[j][j] = matrix[j][j] + spun * rotor.ratio
            coupled = self.turning(rotor.body, rotor.axis) if mechanism.has_bodies else {}
            for k, turned in coupled.items():
                matrix[j][k] = matrix[j][k] + spun * turned
                matrix[k][j] = matrix[k][j] + spun * turned
        return matrix

    def _fill_column(self, matrix: list[list[Number]], k: int, carried: MassMoments) -> None:
        """Column and row of a joint: the forces of its unit rate on it and on those before it."""
        joints, axis = self.mechanism.joints, self.mechanism.joints[k].axis
        if joints[k].slides:
            force, moment = scale(carried.mass, axis), cross(carried.first, axis)
        else:
            force, moment = cross(axis, carried.first), _inertia_of_turn(carried.second, axis)
        for p in self.mechanism.path(k):
            along = dot(joints[p].axis, force if joints[p].slides else moment)
            matrix[p][k] = matrix[k][p] = along
            pose = self.poses[p]
            force = rotate(pose.rotation, force)
            moment = plus(rotate(pose.rotation, moment), cross(pose.position, force))

    def _hold_still(self, v: Sequence[Number]) -> Holding:
        """Forces that keep joints moving at v from accelerating."""
        rates = self.rates(v, [0] * len(v))
        forces, moments = self.wrenches(rates)
        held: list[Number] = [0] * len(v)
        for rotor in self.mechanism.rigid_rotors if self.mechanism.has_bodies else ():
            if rotor.body != BASE:
                spun, rate = rotor.inertia * rotor.ratio, rates[rotor.body]
                held[rotor.joint] = held[rotor.joint] + spun * dot(rotor.axis, rate.angular_rate)
                carried = scale(spun * v[rotor.joint], cross(rate.angular, rotor.axis))
                moments[rotor.body] = plus(moments[rotor.body], carried)
        return Holding(rates, forces, moments, held)

    def forward_dynamics(
        self,
        v: Sequence[Number],
        mesh_rates: Sequence[Number],
        torques: Sequence[Number],
        mesh_forces: Sequence[Number],
        efforts: Sequence[Number],
    ) -> list[Number]:
        """Accelerations of the free coordinates, then of the meshes' displacements.

        v: rates of all joints; torques: of the motors of the free coordinates; mesh_forces:
        generalized forces on the displacements, whose rates are mesh_rates; efforts: what springs
        do to the angles of all joints besides.
        """
        joints, still = self.mechanism.joints, self._hold_still(v)
        rates, held, moments = still.rates, still.held, still.moments
        gained = []
        for rotor in self.mechanism.elastic_rotors:
            effort = _weigh(rotor.levers, mesh_forces)
            effort = effort + rotor.motor * torques[joints[rotor.joint].coordinate]
            gained.append(effort)
            held[rotor.joint] = held[rotor.joint] + rotor.ratio * effort
            if rotor.body != BASE:
                rate = rates[rotor.body]
                spin = _weigh(rotor.turns, mesh_rates) + rotor.ratio * v[rotor.joint]
                spun = rotor.inertia * (spin + dot(rotor.axis, rate.angular))
                carried = scale(spun, cross(rate.angular, rotor.axis))
                reaction = plus(scale(effort, rotor.axis), carried)
                moments[rotor.body] = plus(moments[rotor.body], reaction)
        right, projected = list(torques), self.project(still.forces, moments)
        for joint, rate, effort, *parts in zip(joints, v, efforts, held, projected, strict=True):
            given = joint.factor * (effort - (parts[0] + parts[1] + joint.friction * rate))
            right[joint.coordinate] = right[joint.coordinate] + given
        result = solve(self.collapse(self.mass_matrix()), right)
        return result + self._mesh_accelerations(result, rates, gained, len(mesh_forces))

    def collapse(self, matrix: list[list[Number]]) -> list[list[Number]]:
        """Reduce a matrix over all joints to one over the free coordinates."""
        joints, free = self.mechanism.joints, self.mechanism.free
        result: list[list[Number]] = [[0] * free for _ in range(free)]
        for row, left in zip(matrix, joints, strict=True):
            for entry, right in zip(row, joints, strict=True):
                i, j = left.coordinate, right.coordinate
                result[i][j] = result[i][j] + (left.factor * right.factor) * entry
        return result

    def _mesh_accelerations(
        self, result: Sequence[Number], rates: Sequence[Rates], gained: Sequence[Number], count: int
    ) -> list[Number]:
        """x'' = sum levers (g / J - z w' - N q''), w' with what the joints' accelerations add."""
        joints = self.mechanism.joints
        moved = [joint.factor * result[joint.coordinate] for joint in joints]
        more: list[Vector] = []
        for joint, pose, growth in zip(joints, self.poses, moved, strict=True):
            under = NONE if joint.parent == BASE else more[joint.parent]
            turned = rotate(transpose(pose.rotation), under)
            more.append(turned if joint.slides else plus(turned, scale(growth, joint.axis)))
        accelerations: list[Number] = [0] * count
        for rotor, effort in zip(self.mechanism.elastic_rotors, gained, strict=True):
            ahead = effort * (1 / rotor.inertia) - rotor.ratio * moved[rotor.joint]
            if rotor.body != BASE:
                whole = plus(rates[rotor.body].angular_rate, more[rotor.body])
                ahead = ahead - dot(rotor.axis, whole)
            for mesh, lever in enumerate(rotor.levers):
                accelerations[mesh] = accelerations[mesh] + lever * ahead
        return accelerations


def _pose(joint: TreeJoint, value: Number, cosine: Number, sine: Number) -> BodyPose:
    axis = joint.axis
    if joint.slides:
        along = scale(value, rotate(joint.rotation, axis))
        return BodyPose(joint.rotation, plus(joint.position, along))
    across = (0, -axis[2], axis[1]), (axis[2], 0, -axis[0]), (-axis[1], axis[0], 0)

    def entry(i: int, j: int) -> Number:  # Rodrigues' formula
        along = axis[i] * axis[j]
        return along + cosine * (int(i == j) - along) + sine * across[i][j]

    turn = tuple(tuple(entry(i, j) for i in range(3)) for j in range(3))  # by columns
    columns = [rotate(joint.rotation, column) for column in turn]
    return BodyPose(transpose((columns[0], columns[1], columns[2])), joint.position)


def _spread(w: Vector, growth: Vector) -> Matrix:
    """B with B r = w' x r + w x (w x r)."""
    (x, y, z), (a, b, c) = w, growth
    xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
    return (-(yy + zz), xy - c, xz + b), (xy + c, -(xx + zz), yz - a), (xz - b, yz + a, -(xx + yy))


def _spun(second: Matrix, rate: Rates) -> Vector:
    """Moment of m r x B r over a body."""
    B = rate.spread

    def moment(i: int, j: int) -> Number:
        return dot(B[j], second[i]) - dot(B[i], second[j])

    return moment(1, 2), moment(2, 0), moment(0, 1)


def _inertia_of_turn(second: Matrix, axis: Vector) -> Vector:
    """Angular momentum of a body that turns at 1 rad/s about an axis."""

    def entry(i: int) -> Number:
        j, k = (i + 1) % 3, (i + 2) % 3
        across = second[i][j] * axis[j] + second[i][k] * axis[k]
        return (second[j][j] + second[k][k]) * axis[i] - across

    return entry(0), entry(1), entry(2)


def solve(matrix: Sequence[Sequence[Number]], right: Sequence[Number]) -> list[Number]:
    """x of M x = right, M positive definite, by L D L' from the last row on.

    In that order rows of bodies on other branches stay empty.
    """
    M, r = [list(row) for row in matrix], list(right)
    size = len(r)
    inverses: list[Number] = [0] * size
    lower: list[list[Number]] = [[0] * size for _ in range(size)]
    for k in reversed(range(size)):
        inverses[k] = 1 / M[k][k]
        for i in reversed(range(k)):
            lower[k][i] = M[k][i] * inverses[k]
            for j in range(i + 1):
                M[i][j] = M[i][j] - lower[k][i] * M[k][j]
            r[i] = r[i] - lower[k][i] * r[k]
    result: list[Number] = []
    for k in range(size):
        result.append(r[k] * inverses[k])
        for j in range(k):
            result[k] = result[k] - lower[k][j] * result[j]
    return result
