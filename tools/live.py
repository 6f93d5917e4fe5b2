"""What the docs show of the running program: the gallery, and pages that commands make."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from html import escape
from multiprocessing import get_context
from pathlib import Path

from crosscheck.output import write_files
from tools.animation import write_animation
from tools.gallery import Entry, read_entries, run_entry, write_example
from tools.samples import SAMPLES, write_sample

WORKERS = 2


def write_live_pages(folder: Path) -> None:
    """Run all examples and sample commands.

    Args:
        folder: Gets ``gallery``, pages of the site; ``files``, copied to its top; ``cards``,
            parts of its front page.

    Raises:
        Exception: Whatever an example or a command raises: the site is not built.
    """
    entries, samples = read_entries(), folder / "files" / "samples"
    with ProcessPoolExecutor(WORKERS, mp_context=get_context("fork")) as pool:
        animation = pool.submit(write_animation)
        pages = [pool.submit(write_sample, sample, samples) for sample in SAMPLES]
        captions = [pool.submit(_write_entry, entry, folder) for entry in entries]
        for page in (animation, *pages):
            page.result()
        examples = [
            (f"generated/gallery/{entry.name}.html", f"gallery/{entry.name}.svg", *words.result())
            for entry, words in zip(entries, captions, strict=True)
        ]
    commands = [(f"samples/{each.name}.html", "", each.title, "") for each in SAMPLES]
    write_files(
        {
            folder / "cards" / "gallery.md": format_cards(examples) + format_contents(entries),
            folder / "cards" / "samples.md": format_cards(commands),
        }
    )


def _write_entry(entry: Entry, folder: Path) -> tuple[str, str]:
    """Run and write an example; the mistake and the finding on its card."""
    example = run_entry(entry)
    write_example(example, folder / "gallery", folder / "files" / "gallery")
    return entry.mistake or example.title, example.finding


def format_cards(cards: list[tuple[str, str, str, str]]) -> str:
    """Cards in HTML, of address, picture or '', title, and finding or '' of each."""
    shown = [
        f'<a class="card" href="{address}">'
        + (f'<img alt="" loading="lazy" src="{picture}">' if picture else "")
        + f"<strong>{escape(title)}</strong>"
        + (f"<span>{escape(finding)}</span>" if finding else "")
        + "</a>"
        for address, picture, title, finding in cards
    ]
    return f'<div class="cards">{"".join(shown)}</div>\n'


def format_contents(entries: list[Entry]) -> str:
    """The gallery's pages in their order, for the site's contents."""
    pages = "\n".join(f"/generated/gallery/{entry.name}" for entry in entries)
    return f"\n```{{toctree}}\n:caption: Examples\n:hidden:\n\n{pages}\n```\n"
