# %% [markdown]
# # The elbow's zero is a quarter turn off
#
# The elbow of a robot with six joints reads zero where the links form a right angle; the model
# counts it from the straight arm. Only a mass matrix is given, and a trial judges what there is.

# %%
from types import SimpleNamespace

import numpy as np

import crosscheck

robot = crosscheck.load_robot("six-joint")
elbow = [joint.name for joint in robot.joints].index("elbow")
model = crosscheck.build("analytic:links", robot, crosscheck.load_scenario("pd"))


def straight(q):
    """The mass matrix, with the elbow counted from the straight arm."""
    turned = np.array(q)
    turned[elbow] += np.pi / 2
    return model.mass_matrix(turned)


crosscheck.try_equations(SimpleNamespace(mass_matrix=straight), robot, name="straight")
