"""A page in a headless browser: its pixels at one time of its recording, and the errors it reports."""

import shutil
import subprocess

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
    command = [BROWSER, *(f"--{switch}" for switch in switches.split()), f"--user-data-dir={directory / 'profile'}"]
    command += [f"--screenshot={picture}", copy.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    return imread(picture)[..., :3], [row for row in done.stderr.splitlines() if "PAGE-ERROR" in row]


def coloured(pixels, red, green, blue):
    """Number of pixels in which, of the three channels, those asked for stand out (1), or do not (0)."""
    high = np.where([red, green, blue], pixels, 1.0).min(axis=-1)
    low = np.where([red, green, blue], 0.0, pixels).max(axis=-1)
    return int(np.sum(high - low > 0.25))
