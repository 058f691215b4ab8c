"""Drake's own log on the terminal."""

import logging


def quieten() -> None:
    """Warnings and errors only. Importing pydrake sets the level anew, so this comes after it."""
    import pydrake.common  # noqa: F401

    logging.getLogger("drake").setLevel(logging.WARNING)
