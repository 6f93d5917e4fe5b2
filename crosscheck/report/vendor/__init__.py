"""Scripts of others that pages hold whole, so that they need no network; see README.md."""

from importlib.resources import files


def read_vendored(name: str) -> str:
    """The text of one of the vendored files, by name."""
    return (files(__name__) / name).read_text(encoding="utf-8")
