"""A figure before it is drawn: the function of `viewing` that draws it, and from what. It can be kept and drawn later.

Two attachments of a recording hold one, `figures/<stem>.json` and `figures/<stem>.npz`. What a file may call is what
this package offers for it, by name: the functions that `style.styled` decorates, and frozen dataclasses, both only in
modules of `viewing`.
"""

import importlib
import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from typing import Any

from matplotlib.figure import Figure

from drake_blfdmp.recording import plain_data
from drake_blfdmp.recording.plain_data import PlainDataError
from drake_blfdmp.viewing import style

FOLDER = "figures/"
_ROOT = __name__.rpartition(".")[0] + "."
_NAME = re.compile(r"[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*\.[A-Za-z][A-Za-z0-9_]*")


class Drawing:
    """`Drawing(make, *args, **kwargs)` is drawn, with the arguments as they are, by `make(*args, **kwargs)`.

    Attributes:
        make: a function of a module of `viewing` that `style.styled` decorates.
        given: parameter's name to argument, plain data (`recording.plain_data`).
    """

    def __init__(self, make: Callable[..., Figure], /, *args: Any, **kwargs: Any):
        """Raises PlainDataError where `make` is none of those functions, and TypeError where it takes others."""
        self.name = _name(make)
        if style.DRAWINGS.get(_ROOT + self.name) is not make:
            raise PlainDataError(
                f"drawing: {make.__module__}.{make.__qualname__} is none that can be found again; use a function of "
                "drake_blfdmp.viewing that style.styled decorates"
            )
        self.make = make
        self.given: Mapping[str, Any] = inspect.signature(make).bind(*args, **kwargs).arguments

    def figure(self) -> Figure:
        """The figure, drawn."""
        return self.make(**self.given)

    def attachments(self, stem: str) -> dict[str, tuple[bytes, str]]:
        """The drawing as attachments of a recording: name to bytes and media type.

        Raises:
            PlainDataError: an argument is not plain data; says which.
        """
        structure, arrays = plain_data.pack(dict(self.given), _name_of_record)
        text = plain_data.json_bytes({"drawn_by": self.name, "from": structure})
        return {
            f"{FOLDER}{stem}.json": (text, "application/json"),
            f"{FOLDER}{stem}.npz": (plain_data.npz_bytes(arrays), "application/zip"),
        }

    @classmethod
    def of(cls, stem: str, attachments: Mapping[str, bytes]) -> "Drawing":
        """The drawing that a recording's attachments hold under this stem.

        Raises:
            PlainDataError: they are missing or damaged, or this version has no such drawing.
        """
        try:
            text, arrays = (attachments[f"{FOLDER}{stem}.{ending}"] for ending in ("json", "npz"))
        except KeyError as error:
            raise PlainDataError(f"attachment {error} is missing") from None
        whole = plain_data.json_structure(text)
        if not isinstance(whole, dict) or not isinstance(whole.get("drawn_by"), str) or "from" not in whole:
            raise PlainDataError(f"attachment '{FOLDER}{stem}.json' says neither what draws it nor from what")
        make = _found(whole["drawn_by"], "drawing")
        if style.DRAWINGS.get(_ROOT + whole["drawn_by"]) is not make:
            raise _unknown(whole["drawn_by"], "drawing")
        given = plain_data.unpack(whole["from"], plain_data.npz_arrays(arrays), _record_of_name)
        try:
            return cls(make, **given)
        except TypeError as error:
            raise PlainDataError(f"'{whole['drawn_by']}' of this version takes other arguments ({error})") from None


def stems(attachments: Mapping[str, bytes]) -> list[str]:
    """The stems of a recording's drawings, in its order."""
    return [name[len(FOLDER) : -len(".json")] for name in attachments if re.fullmatch(f"{FOLDER}[\\w-]+\\.json", name)]


def _name(named: Any) -> str:
    return f"{named.__module__}.{named.__qualname__}".removeprefix(_ROOT)


def _name_of_record(kind: type) -> str:
    if _found(_name(kind), "dataclass") is not kind:
        raise PlainDataError(f"plain data: {kind.__name__} is no dataclass of drake_blfdmp.viewing, where it is found")
    return _name(kind)


def _record_of_name(name: str) -> type:
    found = _found(name, "dataclass")
    if not (isinstance(found, type) and is_dataclass(found) and found.__dataclass_params__.frozen):
        raise _unknown(name, "dataclass")
    return found


def _found(name: str, what: str) -> Any:
    """What a module of `viewing` has of its own by this name."""
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise _unknown(name, what)
    module_name, _, last = (_ROOT + name).rpartition(".")
    try:
        found = getattr(importlib.import_module(module_name), last)
    except (ModuleNotFoundError, AttributeError):
        raise _unknown(name, what) from None
    if getattr(found, "__module__", None) != module_name:
        raise _unknown(name, what)
    return found


def _unknown(name: Any, what: str) -> PlainDataError:
    return PlainDataError(f"this version has no {what} '{name}'; use a newer drake_blfdmp")
