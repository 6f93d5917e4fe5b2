"""Kane's method of sympy.physics.mechanics: two links and a payload, in symbols.

    crosscheck trial examples/sympy_mechanics.py:model paper-labelled

The symbols have the names of the arm's quantities and need no values; ``values`` gives the name
for ``m_P``.
"""

import sympy as sp
import sympy.physics.mechanics as me

from crosscheck import from_sympy

q1, q2, u1, u2, T1, T2 = me.dynamicsymbols("q1 q2 u1 u2 T1 T2")
m1, I_l1, d1, L1, m2, I_l2, d2, L2, m_P = sp.symbols("m1 I_l1 d1 L1 m2 I_l2 d2 L2 m_P")

base = me.ReferenceFrame("base")
upper = base.orientnew("upper", "Axis", [q1, base.z])
lower = upper.orientnew("lower", "Axis", [q2, base.z])
upper.set_ang_vel(base, u1 * base.z)
lower.set_ang_vel(upper, u2 * base.z)

shoulder = me.Point("shoulder")
shoulder.set_vel(base, 0)
centre_1 = shoulder.locatenew("centre 1", d1 * upper.x)
elbow = shoulder.locatenew("elbow", L1 * upper.x)
centre_2 = elbow.locatenew("centre 2", d2 * lower.x)
tip = elbow.locatenew("tip", L2 * lower.x)
for point, start, frame in (
    (centre_1, shoulder, upper),
    (elbow, shoulder, upper),
    (centre_2, elbow, lower),
    (tip, elbow, lower),
):
    point.v2pt_theory(start, base, frame)

bodies = [
    me.RigidBody("link 1", centre_1, upper, m1, (me.inertia(upper, 0, 0, I_l1), centre_1)),
    me.RigidBody("link 2", centre_2, lower, m2, (me.inertia(lower, 0, 0, I_l2), centre_2)),
    me.Particle("payload", tip, m_P),
]
loads = [(upper, (T1 - T2) * base.z), (lower, T2 * base.z)]
kane = me.KanesMethod(base, [q1, q2], [u1, u2], [q1.diff() - u1, q2.diff() - u2])
kane.kanes_equations(bodies, loads)

model = from_sympy(
    [q1, q2],
    [u1, u2],
    mass_matrix=kane.mass_matrix,
    forcing=kane.forcing,
    torque=[T1, T2],
    values={m_P: "m_payload"},
    level="links",
)
