"""The paper that is examined, and how much of it was read."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PublishedPaper:
    """A paper's bibliographic data; None for what is not known here."""

    title: str
    authors: tuple[str, ...]
    journal: str
    published: str
    volume: str | None = None
    pages: str | None = None
    doi: str | None = None

    def format_citation(self) -> str:
        """The paper in one sentence, with what is not known of it."""
        *others, last = self.authors
        known = {"volume": self.volume, "pages": self.pages, "DOI": self.doi}
        parts = [f"{', '.join(others)} and {last}: {self.title}", self.journal, self.published]
        parts += [f"{name} {value}" for name, value in known.items() if value]
        unknown = [name for name, value in known.items() if not value]
        missing = f" ({', '.join(unknown)}: not known here)" if unknown else ""
        return f"{', '.join(parts)}{missing}."


PAPER = PublishedPaper(
    title="Joint dynamic analysis of space manipulator with planetary gear train transmission",
    authors=("T. Yang", "S. Yan", "W. Ma", "Z. Han"),
    journal="Robotica",
    published="online 30 July 2014",
)
EXTENT_READ = (
    "What was read is the paper's text with its equations, Table I and the captions. Its figures"
    " were not seen: what a plot, a legend or an axis says is unknown here, and 'not given' means"
    " not given in the text. A figure that is drawn again is the experiment that text and caption"
    " describe, compared with what they say of it. The copy that was read names no more than the"
    " title: authors, journal and date are those of this project's bibliography."
)
