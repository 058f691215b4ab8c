"""A page served on this machine alone."""

import errno
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from drake_blfdmp.errors import BlfDmpError

HOST = "127.0.0.1"
PORTS = range(7000, 7100)


class PageServer(ThreadingHTTPServer):
    """Answers `/` with one page, and nothing else."""

    daemon_threads = True
    # Elsewhere than on Windows, reuse keeps a port usable right after the last server; there it would share it.
    allow_reuse_address = False

    def __init__(self, page: str, port: int | None = None, handler: type[BaseHTTPRequestHandler] | None = None):
        """Listens on `port`, 0 for any free one; on the first free one of 7000 to 7099 when None.

        Raises:
            BlfDmpError: the port is taken or out of range.
        """
        self.page = page.encode()
        if port is not None and not 0 <= port <= 65535:
            raise BlfDmpError(f"--port {port} is out of range; give 1024 to 65535, or 0 for any free one")
        taken: OSError | None = None
        for number in PORTS if port is None else (port,):
            try:
                super().__init__((HOST, number), handler or PageHandler)
                return
            except OSError as error:
                taken = error
                if error.errno not in (errno.EADDRINUSE, errno.EACCES):
                    break
        which = "ports 7000 to 7099 are" if port is None else f"port {port} is"
        reason = taken.strerror if taken is not None else "taken"
        raise BlfDmpError(f"playback: {which} not to be had ({reason}); name another with --port") from None

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://{HOST}:{self.server_address[1]}/"


class PageHandler(BaseHTTPRequestHandler):
    """Sends the page."""

    server: PageServer

    def do_GET(self) -> None:
        if self.path.partition("?")[0] != "/":
            self.send_error(404)
            return
        self.send_response(200)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.send_header("Content-Length", str(len(self.server.page)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(self.server.page)

    def log_message(self, format: str, *args) -> None:
        """Says nothing."""
