# %% [markdown]
# # A recording weighs the payload
#
# Twelve seconds of angles and torques with noise, here from a simulation with a payload of 10.2 kg,
# on a bench from the drives. The file of the arm says 10 kg. Which model explains the torques?

# %%
import json
import subprocess
import sys

import matplotlib.pyplot as plt
import numpy as np

import crosscheck

arm = crosscheck.load_arm("paper-labelled").model_copy(update={"payload_mass_kg": 10.2})
model = crosscheck.build("analytic:coupled", arm, crosscheck.load_scenario("pd"))
draw, time = np.random.default_rng(0), np.arange(0, 12, 2e-3)
rates = 2 * np.pi * np.outer([1.0, 1.1], [0.2, 0.5, 0.9, 1.3])  # of sines, joint by joint [rad/s]
turned = rates * time[:, None, None] + draw.uniform(0, 2 * np.pi, rates.shape)
angles = 0.15 * np.sin(turned).sum(axis=2)
rate, acceleration = (
    0.15 * (size * wave).sum(axis=2)
    for size, wave in ((rates, np.cos(turned)), (-(rates**2), np.sin(turned)))
)
torques = model.inverse_dynamics(angles, rate, acceleration)
angles += 1e-5 * draw.normal(size=angles.shape)
torques += 0.1 * draw.normal(size=torques.shape)
np.savetxt(
    "recording.csv",
    np.column_stack([time, angles, torques]),
    delimiter=",",
    header="t_s,theta_1_rad,theta_2_rad,torque_1_N_m,torque_2_N_m",
    comments="",
)

# %%
command = "compare recording.csv paper-labelled --json compared.json"
words = [sys.executable, "-m", "crosscheck", *command.split()]
print(subprocess.run(words, capture_output=True, text=True, check=False).stdout)
with open("compared.json", encoding="utf-8") as file:
    compared = json.load(file)

# %% [markdown]
# The residual of each level, over that of links with any numbers: 1 explains the torques.

# %%
judged = compared["sides"][0]["with_the_files_numbers"]
explanations = {each["level"]: each for each in judged["levels"]}
explanations["coupled, other payload"] = judged["single_numbers"][0]
figure, axes = plt.subplots(figsize=(8, 3.6))
for joint, colour in enumerate(("tab:blue", "tab:orange")):
    ratios = [each["rms_over_that_of_any_links"][joint] for each in explanations.values()]
    axes.plot(ratios, list(explanations), "o", color=colour, label=f"joint {joint + 1}")
axes.set_xscale("log")
axes.set_xlabel("residual, times that of any links")
axes.legend()
print(compared["answer"][0])
