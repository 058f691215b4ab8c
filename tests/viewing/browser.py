"""A page in a headless browser: its pixels at one time of its recording, and the errors it reports."""

import base64
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np
import pytest
from matplotlib.image import imread

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
BROWSER = next((found for found in map(shutil.which, BROWSERS) if found), None)
needs_browser = pytest.mark.skipif(BROWSER is None, reason=f"no browser on the path, tried {', '.join(BROWSERS)}")

# The page's own errors, whatever their kind, become lines of the browser's log.
_REPORTER = """<script>
const report = (what) => console.log("PAGE-ERROR " + what);
window.addEventListener("error", (event) => report(event.message));
window.addEventListener("unhandledrejection", (event) => report(event.reason));
console.error = (...what) => report(what.join(" "));
</script>"""


def open_at(page, time, directory, *, script="", size=(640, 480)):
    """Opens a copy of `page` at `time` (s) of its recording in a window of `size`.

    Returns: pixels (H, W, 3) and the errors it reported.
    """
    seek = f"viewer.animator.pause(); viewer.animator.seek({time}); viewer.set_dirty(); {script}"
    text = page.read_text(encoding="utf-8").replace("<head>", "<head>" + _REPORTER, 1)
    before, end, after = text.rpartition("</body>")
    copy, picture = directory / "copy.html", directory / "picture.png"
    # The page fills its scene from fetches that it does not wait for.
    copy.write_text(f"{before}<script>setTimeout(() => {{{seek}}}, 2000)</script>{end}{after}", encoding="utf-8")
    switches = "headless no-sandbox use-angle=swiftshader enable-unsafe-swiftshader no-first-run disable-quic "
    switches += "disable-background-networking disable-component-update disable-sync hide-scrollbars "
    switches += "enable-logging=stderr virtual-time-budget=4000 "
    switches += f"window-size={size[0]},{size[1]}"
    command = [BROWSER, *(f"--{switch}" for switch in switches.split())]
    command += [f"--screenshot={picture}", copy.as_uri()]
    done = patiently(lambda: _run([*command, f"--user-data-dir={tempfile.mkdtemp(dir=directory)}"]))
    return imread(picture)[..., :3], [row for row in done.stderr.splitlines() if "PAGE-ERROR" in row]


class BrowserStalled(Exception):
    """The browser, and not the page in it, has stopped to answer."""


def patiently(use):
    """What `use()` comes to; once more in a new browser if the first stalls, as a headless one at times does."""
    try:
        return use()
    except BrowserStalled:
        return use()


def _run(command):
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    except subprocess.TimeoutExpired as error:
        raise BrowserStalled(str(error)) from None


def coloured(pixels, red, green, blue):
    """Number of pixels in which, of the three channels, those asked for stand out (1), or do not (0)."""
    high = np.where([red, green, blue], pixels, 1.0).min(axis=-1)
    low = np.where([red, green, blue], 0.0, pixels).max(axis=-1)
    return int(np.sum(high - low > 0.25))


# The slowest answer on a busy machine takes some seconds.
_ANSWER_S = 60.0

# Chromium listens at file descriptor 3 and answers at 4.
_JOINED = """import fcntl, os, sys
to_browser, from_browser = (fcntl.fcntl(int(fd), fcntl.F_DUPFD, 10) for fd in sys.argv[1:3])
os.dup2(to_browser, 3), os.dup2(from_browser, 4)
os.execv(sys.argv[3], sys.argv[3:])"""


class LivePage:
    """A page of a server in a headless browser that stays open, driven through the browser's debugging pipe.

    Use it as a context manager; `evaluate` runs JavaScript in the page and hands back what it gives, as JSON allows.
    What the browser does not answer in a minute raises BrowserStalled.
    """

    def __init__(self, url, directory, *, size=(900, 600)):
        self._url, self._directory, self._size, self._count = url, directory, size, 0

    def __enter__(self):
        to_browser, from_here = os.pipe()
        to_here, from_browser = os.pipe()
        switches = "headless no-sandbox use-angle=swiftshader enable-unsafe-swiftshader no-first-run disable-quic "
        switches += "disable-background-networking disable-component-update disable-sync hide-scrollbars "
        switches += f"remote-debugging-pipe window-size={self._size[0]},{self._size[1]}"
        command = [BROWSER, *(f"--{switch}" for switch in switches.split())]
        command += [f"--user-data-dir={tempfile.mkdtemp(dir=self._directory)}", "about:blank"]
        joined = [sys.executable, "-c", _JOINED, str(to_browser), str(from_browser), *command]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen(joined, pass_fds=(to_browser, from_browser), **quiet)
        os.close(to_browser), os.close(from_browser)
        self._to, self._from = os.fdopen(from_here, "wb", 0), os.fdopen(to_here, "rb", 0)
        self._rest, self._session = b"", {}
        try:
            target = self._ask("Target.createTarget", url=self._url)["targetId"]
            attached = self._ask("Target.attachToTarget", targetId=target, flatten=True)
        except BaseException:
            self._end()
            raise
        self._session = {"sessionId": attached["sessionId"]}
        return self

    def __exit__(self, kind, *_):
        self._session = {}
        try:
            if kind is None:
                self._ask("Browser.close")
                self._process.wait(timeout=_ANSWER_S)
        except subprocess.TimeoutExpired:
            pass  # It has said that it closes: nothing more is asked of it.
        finally:
            self._end()

    def _end(self):
        self._process.kill()
        self._process.wait()
        self._to.close(), self._from.close()

    def _ask(self, method, **parameters):
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters, **self._session}
        try:
            self._to.write(json.dumps(message).encode() + b"\0")
        except BrokenPipeError:
            raise BrowserStalled(f"{method}: the browser has gone") from None
        end = time.monotonic() + _ANSWER_S
        while True:
            while b"\0" not in self._rest:
                ready, _, _ = select.select([self._from], [], [], max(0.0, end - time.monotonic()))
                read = self._from.read(1 << 20) if ready else b""
                if not read:
                    raise BrowserStalled(f"{method}: {'the browser has gone' if ready else 'no answer'}")
                self._rest += read
            line, self._rest = self._rest.split(b"\0", 1)
            answer = json.loads(line)
            if answer.get("id") == self._count:
                assert "error" not in answer, answer
                return answer["result"]

    def evaluate(self, script):
        """What the script, an expression or a promise, comes to."""
        answer = self._ask("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def wait_for(self, script, seconds=20.0):
        """Wait until an expression is true in the page; returns what it comes to."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if found := self.evaluate(script):
                return found
            time.sleep(0.05)
        raise AssertionError(f"never true in the page: {script}")

    def screenshot(self, path):
        """Write a PNG of the page and return its pixels (H, W, 3)."""
        data = self._ask("Page.captureScreenshot", format="png")["data"]
        path.write_bytes(base64.b64decode(data))
        return imread(path)[..., :3]
