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
from types import FrameType

ROOT = Path(__file__).resolve().parent
COMMANDS = ("inspect", "convert", "recover", "figures", "playback", "studies")


class Terminated(KeyboardInterrupt):
    """SIGTERM or SIGHUP came: everything is closed as after Ctrl-C."""


def _terminate(number: int, frame: FrameType | None) -> None:
    raise Terminated(number)


def main(arguments: list[str] | None = None) -> int:
    """Hand over to the command; one line for anything a user can cause."""
    arguments = sys.argv[1:] if arguments is None else arguments
    from drake_blfdmp.errors import BlfDmpError

    try:
        if arguments[:1] and arguments[0] in COMMANDS:
            return import_module(f"drake_blfdmp.commands.{arguments[0]}").main(arguments[1:], ROOT)
        from drake_blfdmp.commands import run

        return run.main(arguments, ROOT, (__doc__ or "").split("\n\n")[0])
    except BlfDmpError as error:
        print(f"run.py: {error}", file=sys.stderr)
        return error.exit_status
    except BrokenPipeError:
        raise  # Whoever read the output has gone.
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        print(f"run.py: {where}{error.strerror or error}; free space there or name another place", file=sys.stderr)
        return 2
    except Terminated as error:
        print(f"run.py: terminated by {signal.Signals(error.args[0]).name}", file=sys.stderr)
        return 128 + error.args[0]
    except KeyboardInterrupt:
        print("run.py: interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) == signal.SIG_DFL:  # Else somebody ignores it: nohup.
            signal.signal(number, _terminate)
    sys.exit(main())
