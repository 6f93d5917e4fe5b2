"""How long a process may take over a piece of work: by its processor time, whatever else runs.

A machine that is busy with other things makes work last longer, and decides nothing: what counts
is the processor time of the process and of all that it has started. One that uses none for a
minute waits for what will not come.
"""

from __future__ import annotations

import time

from crosscheck.runner.process_tree import ProcessorTimes

# Work may take so much processor time [s], and so many times its rough cost on top.
BASE_LIMIT_S, COST_FACTOR = 60.0, 50.0
# Without so much processor time [s] in so long a time [s] nothing is being done: a process that
# shares its core with two hundred busy ones has more.
IDLE_S, LEAST_S = 60.0, 0.2
LOOK_S = 1.0  # between one look and the next


class CpuTimeLimit:
    """The limit of one piece of work of a child process; cost: estimated [s].

    The first look at it begins to count.
    """

    def __init__(self, process: int, cost: float) -> None:
        self.process, self.cost = process, cost
        self.begun: float | None = None

    def stop_reason(self, times: ProcessorTimes) -> str:
        """Why the work must be stopped; '' while it need not be. times: of the children now.

        Time in which nobody looked does not count: then this process was stopped as well, or had
        no processor.
        """
        now = time.monotonic()
        if self.begun is None:
            self.begun = self.mark = times.get(self.process, 0.0)
            self.looked, self.watched, self.idle = now, 0.0, 0.0
        passed, self.looked = min(now - self.looked, 2 * LOOK_S), now
        self.watched += passed
        used = times.get(self.process, self.begun + self.watched)
        self.idle += passed
        if used - self.mark >= LEAST_S:
            self.mark, self.idle = used, 0.0
        # Threads that wait busily use more than passes.
        spent = min(used - self.begun, self.watched)
        if spent > BASE_LIMIT_S + COST_FACTOR * self.cost:
            about = f"about {self.cost:.2g} s expected"
            return f"stopped after {spent:.0f} s of processor time, {about}"
        if self.idle > IDLE_S:
            return f"stopped after {self.idle:.0f} s without any processor time"
        return ""
