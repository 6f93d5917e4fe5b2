"""All views, and the verdict on those of a kind of record."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from jinja2 import FileSystemBytecodeCache
from syrupy.extensions.amber.serializer import AmberDataSerializer

from crosscheck.report import rendering
from tests.faults.planting import Seen
from tests.views import agreements, comparisons, costs, others, trials
from tests.views.plain import FOLDERS, list_lines
from tests.views.shown_numbers import list_values, name_numbers

VIEWS = agreements.VIEWS | costs.VIEWS | trials.VIEWS | comparisons.VIEWS | others.VIEWS
KEPT = Path(__file__).parent / "__snapshots__" / "test_views.ambr"
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


def tell_numbers(name: str) -> str:
    """A view with the names of its record's numbers."""
    view = VIEWS[name]
    record = view.make()
    values = dict(list_values(record, "")) | dict(view.derive(record))
    return name_numbers(FOLDERS.sub(".../", list_lines(view.render(record))), values)


def judge_views(seen: Seen) -> str:
    """Whether the views of a kind of record are as on file; each in turn, until one is not."""
    kept = AmberDataSerializer.read_file(str(KEPT))
    with fresh_templates():
        for name in VIEWS:
            if name.partition(" of ")[2].startswith(seen.quantity):
                said = kept.get(f"test_a_view_says[{name}]")
                assert said is not None
                if AmberDataSerializer.serialize(tell_numbers(name)) != said.data:
                    return "differ"
    return "agree"
