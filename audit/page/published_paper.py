"""The paper that is examined, and how much of it was read."""

from __future__ import annotations

TITLE = "Joint dynamic analysis of space manipulator with planetary gear train transmission"
AUTHORS = "T. Yang, S. Yan, W. Ma and Z. Han"
CITATION = (
    f"{AUTHORS}: {TITLE}, Robotica, online 30 July 2014 (volume, pages, DOI: not known here)."
)
EXTENT_READ = (
    "What was read is the paper's text with its equations, Table I and the captions. Its figures"
    " were not seen: what a plot, a legend or an axis says is unknown here, and 'not given' means"
    " not given in the text. A figure that is drawn again is the experiment that text and caption"
    " describe, compared with what they say of it. The copy that was read names no more than the"
    " title: authors, journal and date are those of this project's bibliography."
)
