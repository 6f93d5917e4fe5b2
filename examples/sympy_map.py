"""Coordinates by a function: the elbow turned by elliptic gears, theta_2 = x_2 + e sin(x_2).

    crosscheck trial examples/sympy_map.py:model paper-labelled

Lagrange's method of sympy.physics.mechanics, straight in x; the map is distinguished from it.
"""

import sympy as sp
import sympy.physics.mechanics as me

from crosscheck import Coordinates, from_sympy

ECCENTRICITY = sp.Rational(3, 10)
x1, x2, T1, T2 = me.dynamicsymbols("x1 x2 T1 T2")
m1, I_l1, d1, L1, m2, I_l2, d2, L2 = sp.symbols("m1 I_l1 d1 L1 m2 I_l2 d2 L2")
m_payload = sp.Symbol("m_payload")

theta = sp.Matrix([x1, x2 + ECCENTRICITY * sp.sin(x2)])
time = me.dynamicsymbols._t
phi = [theta[0], theta[0] + theta[1]]
along = [sp.Matrix([sp.cos(angle), sp.sin(angle)]) for angle in phi]


def kinetic(mass, place, inertia=0, angle=0):
    velocity = place.diff(time)
    return (mass * velocity.dot(velocity) + inertia * sp.diff(angle, time) ** 2) / 2


energy = (
    kinetic(m1, d1 * along[0], I_l1, phi[0])
    + kinetic(m2, L1 * along[0] + d2 * along[1], I_l2, phi[1])
    + kinetic(m_payload, L1 * along[0] + L2 * along[1])
)
lagrange = me.LagrangesMethod(energy, [x1, x2])
lagrange.form_lagranges_equations()
power = theta.jacobian([x1, x2]).T * sp.Matrix([T1, T2])  # of the drive's torques, on theta

model = from_sympy(
    [x1, x2],
    [x1.diff(), x2.diff()],
    mass_matrix=lagrange.mass_matrix,
    forcing=lagrange.forcing + power,
    torque=[T1, T2],
    coordinates=Coordinates(function=theta, symbols=(x1, x2)),
    level="links",
)
