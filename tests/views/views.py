"""All views, and the verdict on those of a kind of record."""

from collections.abc import Iterator
from contextlib import contextmanager
from tempfile import TemporaryDirectory

from jinja2 import FileSystemBytecodeCache

from crosscheck.report import rendering
from tests.faults.planting import Seen
from tests.views import agreements, comparisons, costs, others, trials
from tests.views.walker import walk

VIEWS = agreements.VIEWS | costs.VIEWS | trials.VIEWS | comparisons.VIEWS | others.VIEWS


FOLDER = TemporaryDirectory()
COMPILED = FileSystemBytecodeCache(FOLDER.name)  # of most templates a fault changes nothing


@contextmanager
def fresh_templates() -> Iterator[None]:
    """Templates that have the filters as they are, and leave none behind."""
    forget = getattr(rendering.load_templates, "cache_clear", lambda: None)
    forget()
    rendering.load_templates().bytecode_cache = COMPILED
    yield
    forget()


def judge_views(seen: Seen) -> str:
    """Whether the views of a kind of record show its numbers; each in turn, until one does not."""
    with fresh_templates():
        own = (
            v for name, v in VIEWS.items() if name.partition(" of ")[2].startswith(seen.quantity)
        )
        return "differ" if any(any(walk(view, 1)) for view in own) else "agree"
