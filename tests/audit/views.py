"""Which files only say or draw what others have computed."""

from pathlib import PurePath

ROOMS = ("crosscheck/report", "audit/templates", "audit/figures")
NAMES = ("chapter",)  # in a module's name
FILES = ("text.py", "columns.py", "report.py", "command.py")  # in audit


def is_view(path: PurePath) -> bool:
    """Of a file, its path from the project's folder."""
    folder = path.parent.as_posix()
    if path.suffix not in (".py", ".j2", ".css", ".js"):
        return False
    if any(folder == room or folder.startswith(f"{room}/") for room in ROOMS):
        return True
    if not folder.startswith("audit"):
        return False
    return path.name in FILES or any(name in path.stem for name in NAMES)
