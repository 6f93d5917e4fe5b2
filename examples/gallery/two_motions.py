# %% [markdown]
# # One arm, two motions
#
# The arm starts many times, each start 1e-12 m from the others: no experiment could tell them
# apart. Late in the run some of them vibrate far more than the rest. So one run says little, and
# a study is of many starts.

# %%
import matplotlib.pyplot as plt

import crosscheck

study = crosscheck.sweep(
    "paper-labelled",
    {"arm.joints.*.*_mesh.damping_ratio": [0.003, 0.005, 0.008, 0.012, 0.02]},
    scenario="pd",
    measures=[{"kind": "peak", "signal": "theta_ddot", "joint": 1, "window_s": [1.2, 2.2]}],
    switches={"phase": "omega_t", "planets": "free"},
    settings={"scenario.record_every": 10},
    starts={"count": 24, "seed": 1},
)

# %%
peak = study["theta_ddot_peak_joint1"]
damping = study[peak.dims[0]]
figure, axes = plt.subplots(figsize=(8, 3.6))
for start in range(peak.sizes["start"]):
    axes.plot(damping, peak.isel(start=start), "o", color="tab:blue", alpha=0.4)
axes.set_xscale("log")
axes.set_yscale("log")
axes.set_xlabel("damping ratio of the meshes")
axes.set_ylabel("largest acceleration of joint 1, 1.2 to 2.2 s [rad/s$^2$]")
spread = float((peak.max("start") / peak.min("start")).max())
print(f"starts 1e-12 m apart, peaks that differ by up to {spread:.0f} times")
