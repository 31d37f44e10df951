"""Judging times of a ground station on a machine that may have other things to do."""

import time

BUSY = 0.05
"""Seconds of processor time that the look at the machine takes."""
QUIET = 1.3
"""Wall time per processor time up to which a machine counts as quiet."""


def contention():
    """Wall time per processor time of a busy loop now: 1 with a processor to itself."""
    wall, used = time.monotonic(), time.process_time()
    while time.process_time() - used < BUSY:
        pass
    return (time.monotonic() - wall) / BUSY


class Stopwatch:
    """Takes a time and judges it, as long as the machine was quiet before and after."""

    def __init__(self):
        self.before = contention()
        self.started = time.monotonic()

    def within(self, limit, what):
        """Seconds so far; more than `limit` on a quiet machine is a failure."""
        took = time.monotonic() - self.started
        busy = max(self.before, contention())
        if busy > QUIET:
            print(f"{what} took {took:.2f} s; not judged: the machine gave {1 / busy:.0%} of a processor")
        else:
            assert took <= limit, f"{what} took {took:.2f} s, more than {limit} s"
        return took
