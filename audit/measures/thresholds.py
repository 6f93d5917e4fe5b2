"""What the paper's words for sizes are taken to mean, once for claims, figures and hypotheses."""

from __future__ import annotations

SEVERE = 100.0  # rad/s^2: four times the rigid arm's own largest acceleration; a third of the 300
EVIDENT = 10.0  # rad/s^2: the smallest that Section 3.2 calls a fluctuation
MINOR = 1.0  # rad/s^2: a tenth of it; nothing smaller is seen in a plot of 300
DOUBLED = 2.0  # a change that no scatter between starts or plots explains
