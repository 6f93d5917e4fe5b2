"""``python -m crosscheck``, and the command ``crosscheck``."""

from __future__ import annotations

import gc
import logging
import signal
import sys
from typing import NoReturn

from crosscheck.runner import interruption
from crosscheck.runner.supervision import run_supervised

FEW_OBJECTS = 10_000  # before cycles are searched for: Python's own 700 cost imports a sixth more


def main() -> NoReturn:
    """Run the command line; exit codes 0, 1 (differs), 2 (bad input), 3 (no verdict), 130, 143."""
    sys.exit(run_supervised(command))


def command() -> NoReturn:
    """Run the command line in its own process; leaves by SystemExit."""
    gc.set_threshold(FEW_OBJECTS)
    try:
        interruption.listen()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, interruption.SIGNALS)
        logging.basicConfig(format="crosscheck: %(message)s")
        from crosscheck.cli.app import main as run

        run()
    except (KeyboardInterrupt, Exception):
        if not interruption.was_stopped():
            raise
        print(f"crosscheck: {interruption.exit_message()}", file=sys.stderr)
        sys.exit(interruption.exit_code())
    finally:
        interruption.ignore_signals()  # all is said and written: nothing is left to interrupt
        gc.freeze()  # what is left is not searched for cycles once more: half a second
        interruption.leave_if_stopped()


if __name__ == "__main__":
    main()
