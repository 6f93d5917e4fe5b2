"""A planar arm of any number of links by absolute angles of a class of links."""

import numpy as np


class Segment:
    """A link with what it carries at its end."""

    def __init__(self, link, tip_mass):
        self.length = link.length_m
        self.lever = link.com_m
        self.mass = link.mass
        self.inertia = link.inertia
        self.tip_mass = tip_mass

    @property
    def total(self):
        return self.mass + self.tip_mass

    @property
    def first_moment(self):
        return self.mass * self.lever + self.tip_mass * self.length

    @property
    def second_moment(self):
        return self.inertia + self.mass * self.lever**2 + self.tip_mass * self.length**2


class PlanarChain:
    """Equations by angles relative to the previous link."""

    def __init__(self, arm):
        last = len(arm.links) - 1
        self.arm = arm
        self.segments = [
            Segment(link, arm.payload_mass_kg if i == last else 0.0)
            for i, link in enumerate(arm.links)
        ]
        self.count = last + 1
        self.sums = np.tril(np.ones((self.count, self.count)))

    def lever_of(self, i, j):
        """Mass times levers of the absolute angles i and j, i at most j."""
        a, b = self.segments[i], self.segments[j]
        if i == j:
            outer = sum(s.total for s in self.segments[i + 1 :])
            return a.second_moment + outer * a.length**2
        outer = sum(s.total for s in self.segments[j + 1 :])
        return a.length * (b.first_moment + outer * b.length)

    def mass_matrix(self, q):
        phi = self.sums @ q
        M = np.zeros((self.count, self.count))
        for i in range(self.count):
            for j in range(i, self.count):
                M[i, j] = self.lever_of(i, j) * np.cos(phi[i] - phi[j])
                M[j, i] = M[i, j]
        return self.sums.T @ M @ self.sums

    def bias(self, q, v):
        phi, omega = self.sums @ q, self.sums @ v
        h = np.zeros(self.count)
        for i in range(self.count):
            for j in range(self.count):
                if i != j:
                    c = self.lever_of(min(i, j), max(i, j))
                    h[i] += c * np.sin(phi[i] - phi[j]) * omega[j] ** 2
        return self.sums.T @ h

    def force(self, q, v, torque):
        phi = self.sums @ q
        gx, gy = self.arm.gravity_m_per_s2
        weight = np.zeros(self.count)
        for i, s in enumerate(self.segments):
            outer = sum(each.total for each in self.segments[i + 1 :])
            moment = s.first_moment + outer * s.length
            weight[i] = moment * (gy * np.cos(phi[i]) - gx * np.sin(phi[i]))
        friction = np.array([joint.friction_N_m_s_per_rad for joint in self.arm.joints])
        return torque + self.sums.T @ weight - friction * v
