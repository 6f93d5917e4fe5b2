"""The picture of README: a mesh force of an engine, and how far two derivations are from it.

``python tools/readme_picture.py`` writes docs/printed-against-engine.svg.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np

import crosscheck

OUT = Path(__file__).parents[1] / "docs" / "printed-against-engine.svg"
ENGINE = "exudyn:tree"
DERIVED = {"analytic:printed": "#b3261e", "analytic:physical": "#1d7a46"}
LABELS = {"analytic:printed": "as printed", "analytic:physical": "corrected"}
DURATION_S = 0.5  # the teeth change sides at about 0.35 s
LEAST_N = 1e-10  # the axis ends here


def draw_picture() -> None:
    """Run the models in the PD experiment and draw the force of the shoulder's sun mesh."""
    arm, scenario = crosscheck.load_arm("paper-labelled"), crosscheck.load_scenario("pd")
    scenario = scenario.model_copy(update={"duration_s": DURATION_S})
    runs = {
        name: crosscheck.simulate(crosscheck.build(name, arm, scenario))
        for name in (ENGINE, *DERIVED)
    }
    forces = {name: run["F_sp"].values[:, 0, 0] for name, run in runs.items()}
    time = runs[ENGINE]["time"].values
    plt.rcParams.update({"svg.hashsalt": "readme", "font.size": 9, "path.simplify_threshold": 0.5})
    figure, (above, below) = plt.subplots(
        2, 1, sharex=True, figsize=(7.2, 3.8), layout="constrained"
    )
    above.plot(time, forces[ENGINE], color="#1c2733", linewidth=0.8)
    above.set_ylabel("mesh force\nin Exudyn [N]")
    for name, colour in DERIVED.items():
        difference = np.abs(forces[name] - forces[ENGINE])
        below.semilogy(
            time, np.maximum(difference, LEAST_N), color=colour, linewidth=0.7, label=LABELS[name]
        )
    below.set_ylabel("distance of the paper's\nequations from it [N]")
    below.set_xlabel("time [s]")
    below.legend(frameon=False, loc="center right")
    figure.savefig(OUT, metadata={"Date": None})
    print(f"wrote {OUT}")


if __name__ == "__main__":
    draw_picture()
