"""All views, and the verdict on those of a kind of record."""

from collections.abc import Iterator
from contextlib import contextmanager

from jinja2 import BytecodeCache
from jinja2.bccache import Bucket

from crosscheck.report import rendering
from tests.faults.planting import Seen
from tests.views import agreements, comparisons, costs, others, trials
from tests.views.walker import walk

VIEWS = agreements.VIEWS | costs.VIEWS | trials.VIEWS | comparisons.VIEWS | others.VIEWS


class CompiledTexts(BytecodeCache):
    """Code of templates by name and text: filters are looked up when it runs."""

    def __init__(self) -> None:
        self.kept: dict[str, bytes] = {}

    def load_bytecode(self, bucket: Bucket) -> None:
        """Fill the bucket with what is kept of its text."""
        if bucket.key + bucket.checksum in self.kept:
            bucket.bytecode_from_string(self.kept[bucket.key + bucket.checksum])

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Keep the bucket's code."""
        self.kept[bucket.key + bucket.checksum] = bucket.bytecode_to_string()


COMPILED_TEXTS = CompiledTexts()


@contextmanager
def fresh_templates() -> Iterator[None]:
    """Templates that have the filters as they are, and leave none behind."""
    forget = getattr(rendering.load_templates, "cache_clear", lambda: None)
    forget()
    rendering.load_templates().bytecode_cache = COMPILED_TEXTS
    yield
    forget()


def judge_views(seen: Seen) -> str:
    """Whether the views of a kind of record show its numbers; each in turn, until one does not."""
    with fresh_templates():
        own = (
            v for name, v in VIEWS.items() if name.partition(" of ")[2].startswith(seen.quantity)
        )
        return "differ" if any(any(walk(view, 1)) for view in own) else "agree"
