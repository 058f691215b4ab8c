"""A page as MP4 or GIF: a browser without a window draws frame after frame, ffmpeg makes the file."""

import json
import shutil
import subprocess
import tempfile
import threading
from pathlib import Path
from queue import Empty, Queue

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback.chunks import Progress
from drake_blfdmp.viewing.playback.page import Sheet, render_page
from drake_blfdmp.viewing.playback.server import PageHandler, PageServer

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
_MAC = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
)
SUFFIXES = (".mp4", ".gif")
_SIZE = {".mp4": (960, 540), ".gif": (720, 404)}  # Even, as H.264 wants it.
_RATE = {".mp4": 25.0, ".gif": 12.5}  # GIFs count in hundredths of a second.
_MOST_FRAMES = 6000
_PATIENCE = 120.0  # s for a frame, the first of which waits for the browser's start.

# Draws frame after frame and hands each over; the answer to one asks for the next.
_RECORD = """
playback.pause();
playback.fit(%(width)d, %(height)d);
(async () => {
  for (let k = 0; k < %(count)d; k++) {
    const canvas = playback.picture(Math.min(k * %(step)s, playback.duration), %(width)d, %(height)d);
    const blob = await new Promise((done) => canvas.toBlob(done, "image/jpeg", 0.93));
    await fetch("/frame/" + k, { method: "POST", body: blob });
  }
})();
"""


def find_browser() -> str | None:
    """A browser of Chromium's family; None when there is none."""
    found = next((path for path in map(shutil.which, BROWSERS) if path), None)
    return found or next((path for path in _MAC if Path(path).is_file()), None)


def check_video(path: Path) -> None:
    """Refuses, before any work, what cannot be made.

    Raises:
        BlfDmpError: the name ends otherwise, or ffmpeg or a browser is missing.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise BlfDmpError(f"--video {path}: name it .mp4 or .gif")
    if shutil.which("ffmpeg") is None:
        raise BlfDmpError(f"--video {path}: ffmpeg is not on the path; install it, or write a page with --html")
    if find_browser() is None:
        raise BlfDmpError(
            f"--video {path}: no browser on the path that could draw it (tried {', '.join(BROWSERS)}); "
            "install Chromium, or write a page with --html"
        )


def write_video(sheet: Sheet, path: Path, progress: Progress = lambda what, share: None) -> int:
    """Writes a video of everything the sheet shows, at the sheet's speed; returns the number of frames.

    Raises:
        BlfDmpError: as `check_video`; or it would be too long; or browser or ffmpeg fail.
    """
    check_video(path)
    suffix = path.suffix.lower()
    width, height = _SIZE[suffix]
    rate = _RATE[suffix]
    count = int(sheet.duration / sheet.speed * rate) + 1
    if count > _MOST_FRAMES:
        raise BlfDmpError(
            f"--video {path}: {count} frames, at most {_MOST_FRAMES} are made; shorten it with --from and --to, or "
            "raise --speed"
        )
    step = json.dumps(sheet.speed / rate)
    record = _RECORD % {"width": width, "height": height, "count": count, "step": step}
    frames: Queue[bytes] = Queue(maxsize=4)

    class Frames(PageHandler):
        """Takes frames; the page sends the next when it has the answer, so they come in order."""

        def do_POST(self) -> None:
            frames.put(self.rfile.read(int(self.headers.get("Content-Length", 0))))
            self.send_response(204)
            self.end_headers()

    with (
        tempfile.TemporaryDirectory() as profile,
        PageServer(render_page(sheet, script=record), 0, Frames) as server,
    ):
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser = subprocess.Popen(_browser(server.url, profile), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            _encode(path, frames, browser, count, rate, progress)
        except BaseException:
            path.unlink(missing_ok=True)  # What was begun here is of no use to anyone.
            raise
        finally:
            browser.terminate()
            try:
                browser.wait(10)
            except subprocess.TimeoutExpired:
                browser.kill()
                browser.wait()
            server.shutdown()
    return count


def _browser(url: str, profile: str) -> list[str]:
    switches = (
        "headless no-sandbox enable-unsafe-swiftshader no-first-run disable-quic disable-sync "
        "disable-background-networking disable-component-update disable-gpu-vsync mute-audio remote-debugging-port=0 "
        "disable-background-timer-throttling disable-renderer-backgrounding window-size=800,450"
    )
    return [
        find_browser() or BROWSERS[0],
        *(f"--{switch}" for switch in switches.split()),
        f"--user-data-dir={profile}",
        url,
    ]


def _encode(
    path: Path, frames: "Queue[bytes]", browser: subprocess.Popen, count: int, rate: float, progress: Progress
) -> None:
    """Feeds frames to ffmpeg as they come."""
    command = [
        "ffmpeg",
        "-nostdin",
        "-v",
        "error",
        "-n",
        "-f",
        "image2pipe",
        "-c:v",
        "mjpeg",
        "-framerate",
        f"{rate:g}",
    ]
    command += ["-i", "-"]
    if path.suffix.lower() == ".gif":
        # One palette from what changes, so that the floor does not flicker.
        command += [
            "-vf",
            "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=bayer:diff_mode=rectangle",
        ]
    else:
        command += ["-pix_fmt", "yuv420p", "-movflags", "+faststart"]
    ffmpeg = subprocess.Popen([*command, str(path)], stdin=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        for number in range(count):
            try:
                frame = frames.get(timeout=_PATIENCE)
            except Empty:
                state = "ended" if browser.poll() is not None else "sent no frame"
                raise BlfDmpError(f"--video {path}: the browser {state} at frame {number} of {count}") from None
            if ffmpeg.stdin is not None:
                ffmpeg.stdin.write(frame)
            progress("drawing the video", (number + 1) / count)
    except BrokenPipeError:
        pass  # ffmpeg has ended, and says why.
    except BaseException:
        ffmpeg.kill()
        ffmpeg.wait()
        raise
    said = ffmpeg.communicate()[1].decode(errors="replace").strip().splitlines()
    if ffmpeg.returncode:
        raise BlfDmpError(f"--video {path}: ffmpeg failed: {said[-1] if said else ffmpeg.returncode}")
