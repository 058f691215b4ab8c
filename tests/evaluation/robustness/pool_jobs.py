"""Jobs for worker processes, importable by them: each takes what it shall do."""

import os
import signal
import time


def behave(job):
    """Return, raise, die or hang, as asked."""
    what, value = job
    if what == "raise":
        raise ValueError("two\nlines")
    if what == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    if what == "exit":
        os._exit(3)
    if what == "hang":
        time.sleep(600)
    return os.getpid() if what == "pid" else value
