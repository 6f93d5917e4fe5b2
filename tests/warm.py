"""A process that has imported what commands import, and forks for each that it is asked for.

``python warm.py``: a line of JSON on standard input asks for a command, a line on standard output
says how it ended.
"""

import gc
import importlib
import json
import os
import pkgutil
import resource
import sys
from typing import Any

import crosscheck
from crosscheck.cli.app import build_own_commands
from crosscheck.registry import BUILT_IN, load_model_class


def import_all() -> None:
    """Of the program and its engines; none of it starts anything."""
    for module in pkgutil.walk_packages(crosscheck.__path__, "crosscheck."):
        importlib.import_module(module.name)
    for model in BUILT_IN:
        load_model_class(model)


def become(command: dict[str, Any]) -> None:
    """A process as Python's own for this command: arguments, folder, streams, limits."""
    os.setsid()
    os.chdir(command["folder"])
    os.environ.clear()
    os.environ.update(command["environment"])
    sys.argv, sys.path[0] = ["crosscheck", *command["arguments"]], command["folder"]
    for stream, file in enumerate((os.devnull, command["out"], command["err"])):
        handle = os.open(file, os.O_RDWR | os.O_CREAT, 0o600)
        os.dup2(handle, stream)
        os.close(handle)
    sys.dont_write_bytecode = True  # cut short, a compiled file would fail all later processes
    resource.setrlimit(resource.RLIMIT_FSIZE, (command["largest"], command["largest"]))


if __name__ == "__main__":
    import_all()
    build_own_commands()
    gc.collect()
    gc.freeze()  # what is shared by forks stays so
    for line in sys.stdin:
        child = os.fork()
        if child == 0:
            become(json.loads(line))
            break
        print(json.dumps(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])), flush=True)
    else:
        sys.exit()
    from crosscheck.__main__ import main

    main()
