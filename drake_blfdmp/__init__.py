"""Two-arm skills from a recording of a person, coupled by barrier Lyapunov functions, carried out in Drake."""

__version__ = "0.1.0"
