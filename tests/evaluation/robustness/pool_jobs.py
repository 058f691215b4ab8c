"""Jobs for worker processes, importable by them: each takes what it shall do."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path


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


@dataclass(frozen=True)
class FakeJob:
    """A job of a campaign: `what` as for `behave`; it notes that it ran in `log`."""

    key: str
    what: str
    log: Path

    def run(self):
        """The row of a job that ends."""
        with self.log.open("a", encoding="utf-8") as file:
            file.write(f"{self.key}\n")
        return {"key": self.key, "value": behave((self.what, 1))}

    def crashed(self, error):
        """The row of one that does not."""
        return {"key": self.key, "error": error}
