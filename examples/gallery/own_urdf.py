# %% [markdown]
# # A link that hangs at the wrong point
#
# A pendulum of two links, as a URDF of one's own, and the weights by hand. With a mistake on
# purpose: the second link hangs at the centre of mass of the first, not at its end.

# %%
from pathlib import Path
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np

import crosscheck
from crosscheck.testing import assert_agrees

LINK = """
  <link name="{name}"><inertial><origin xyz="{com} 0 0"/><mass value="{mass}"/>
    <inertia ixx="0.001" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """
  <joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>
    <origin xyz="{at} 0 0"/><axis xyz="0 1 0"/></joint>"""
urdf = '<robot name="pendulum"><link name="base"/>'
urdf += LINK.format(name="upper", com=0.25, mass=2.0)
urdf += LINK.format(name="lower", com=0.2, mass=1.5)
urdf += JOINT.format(name="shoulder", parent="base", child="upper", at=0)
urdf += JOINT.format(name="elbow", parent="upper", child="lower", at=0.5)
with Path("pendulum.urdf").open("w", encoding="utf-8") as file:
    file.write(urdf + "</robot>")

# %% [markdown]
# The links point along x, turn about y and so go down; the weights pull along -z.

# %%
M1, M2, D1, D2, L1, G = 2.0, 1.5, 0.25, 0.2, 0.5, 9.81


def weigh(lever):
    """Equations with this lever of the second link on the first joint."""

    def gravity(q):
        lower = -M2 * G * D2 * np.cos(q[0] + q[1])
        return [lower - (M1 * D1 + M2 * lever) * G * np.cos(q[0]), lower]

    return SimpleNamespace(gravity=gravity)


crosscheck.try_equations(weigh(D1), "pendulum.urdf", name="at the centre")

# %% [markdown]
# At its end:

# %%
right = assert_agrees(weigh(L1), "pendulum.urdf", name="at the end")
print("exit code", right.exit_code)

# %% [markdown]
# What the mistake does to the shoulder's motor, over the angle of the first link:

# %%
angles = np.linspace(-np.pi, np.pi, 200)
figure, axes = plt.subplots(figsize=(8, 3.6))
for lever, colour, label in ((D1, "tab:red", "at its centre"), (L1, "tab:green", "at its end")):
    gravity = weigh(lever).gravity
    axes.plot(angles, [gravity([angle, 0.0])[0] for angle in angles], color=colour, label=label)
axes.set_xlabel("shoulder [rad]")
axes.set_ylabel("torque that holds the weights [N m]")
axes.legend()
