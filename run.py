"""From a recording of a person to two simulated Frankas that hold a box, move it and place it.

    python run.py                                   the main job, on a synthetic recording
    python run.py --recording FILE                  the same with your own recording
    python run.py --scenario FILE --set box.mass=2  any scenario, with changes
    python run.py inspect FILE                      what a recording holds, and whether a skill can be learned from it
    python run.py convert IN OUT                    any readable recording as CSV or MCAP
    python run.py recover FILE                      a complete recording of a run from one that was cut off
    python run.py playback RUN.mcap                 a recording of a run, or of another ROS 2 system, in the browser
    python run.py studies                           the paper's figures and claims: what there is; --help tells more
    python run.py figures FILE.mcap                 the figures of a run or study again, from its file alone

Exit status: 0 success, 1 the run ended without success, 2 bad input.
"""

import signal
import sys
from importlib import import_module
from pathlib import Path

from drake_blfdmp import interruption

ROOT = Path(__file__).resolve().parent
COMMANDS = ("inspect", "convert", "recover", "figures", "playback", "studies")


def main(arguments: list[str] | None = None) -> int:
    """Hand over to the command; one line for anything a user can cause."""
    arguments = sys.argv[1:] if arguments is None else arguments
    from drake_blfdmp.errors import BlfDmpError

    try:
        if arguments[:1] and arguments[0] in COMMANDS:
            return import_module(f"drake_blfdmp.commands.{arguments[0]}").main(arguments[1:], ROOT)
        from drake_blfdmp.commands import run

        return run.main(arguments, ROOT, (__doc__ or "").split("\n\n")[0])
    except KeyboardInterrupt:
        return _ended_by(interruption.received() or signal.SIGINT)
    except Exception as error:
        number = interruption.received()
        if number is not None:  # Bindings may have made another exception of it.
            return _ended_by(number)
        if isinstance(error, BlfDmpError):
            print(f"run.py: {error}", file=sys.stderr)
            return error.exit_status
        if isinstance(error, OSError) and not isinstance(error, BrokenPipeError):  # Else the output's reader has gone.
            where = f"{error.filename}: " if error.filename else ""
            print(f"run.py: {where}{error.strerror or error}; free space there or name another place", file=sys.stderr)
            return 2
        raise


def _ended_by(number: int) -> int:
    print(f"run.py: {interruption.told(number)}", file=sys.stderr)
    return 128 + number


if __name__ == "__main__":
    interruption.listen()
    sys.exit(main())
