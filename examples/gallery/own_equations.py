# %% [markdown]
# # The payload at the wrong place
#
# A mass matrix with a mistake, put right, in other coordinates, and run. A
# trial runs in forked processes, so it works from a notebook as it does from a file.

# %%
import numpy as np

import crosscheck
from crosscheck.testing import Coordinates, Equations, assert_agrees


def two_link(arm, payload_is_at_the_end=True):
    """Two rods and a payload, angles relative to the previous link."""
    one, two = arm.links
    L1, L2, d1, d2 = one.length_m, two.length_m, one.com_m, two.com_m
    m1, m2, J1, J2 = one.mass, two.mass, one.inertia, two.inertia
    m_p = arm.payload_mass_kg
    lever = L2 if payload_is_at_the_end else d2  # d2 is the mistake

    def mass_matrix(q):
        c = np.cos(q[1])
        m22 = J2 + m2 * d2**2 + m_p * L2**2
        m12 = m22 + (m2 * d2 + m_p * lever) * L1 * c
        m11 = J1 + m1 * d1**2 + (m2 + m_p) * L1**2 + m22 + 2 * (m2 * d2 + m_p * L2) * L1 * c
        return [[m11, m12], [m12, m22]]

    def bias(q, v):
        s = (m2 * d2 + m_p * L2) * L1 * np.sin(q[1])
        return [-s * (2 * v[0] * v[1] + v[1] ** 2), s * v[0] ** 2]

    return Equations(mass_matrix=mass_matrix, bias=bias, force=lambda torque: torque)


# %% [markdown]
# ## A mistake
#
# The payload at `d2`, the centre of mass, in the entry beside the diagonal. As the last line of a
# cell, a trial shows itself.


# %%
def mistaken(arm):
    return two_link(arm, payload_is_at_the_end=False)


crosscheck.try_equations(mistaken, "paper-labelled", name="mistaken")

# %% [markdown]
# ## Put right
#
# `assert_agrees` raises unless all agrees, and returns the trial. Its levels say which inertia
# the equations have: none of the gears'.

# %%
trial = assert_agrees(two_link, "paper-labelled", name="two_link")
for each in trial.distances:
    print(f"{each.level:9} {each.entries} entries differ, by up to {each.largest:.1%}")

# %% [markdown]
# ## Other coordinates
#
# The same equations in absolute angles, by hand: M of the relative angles, carried over. A trial
# takes them as they are; the wrong entry would be named in `phi_1` and `phi_2`.


# %%
def absolute(arm):
    relative = two_link(arm)
    turn = np.array([[1.0, 0.0], [-1.0, 1.0]])  # theta = turn @ phi

    def mass_matrix(x):
        return turn.T @ np.array(relative.mass_matrix(turn @ x)) @ turn

    def bias(x, v):
        return turn.T @ np.array(relative.bias(turn @ x, turn @ v))

    return Equations(
        mass_matrix=mass_matrix,
        bias=bias,
        force=lambda torque: turn.T @ torque,
        coordinates=Coordinates(links="absolute"),
    )


trial = assert_agrees(absolute, "paper-labelled", name="absolute")
print(", ".join(trial.problem.frame.names), "level", trial.level)

# %% [markdown]
# ## Runs
#
# With M, bias and force the equations can be simulated, by the same steps as an engine with the
# same integrator.

# %%
short = crosscheck.load_scenario("pd").model_copy(update={"duration_s": 0.1, "step_s": 1e-4})
trial = assert_agrees(two_link, "paper-labelled", scenarios=[short], name="two_link")
for finding in trial.agreement.checks:
    if finding.about.key.family == "trial-run":
        print(finding.verdict, finding.quantity, "beside", finding.right)
