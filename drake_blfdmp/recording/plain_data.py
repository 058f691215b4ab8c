"""Plain data as a JSON structure and arrays beside it, which together give the same data again.

Plain are None, truth values, whole and real numbers, text, NumPy arrays of numbers, truth values or text, frozen
dataclasses that someone vouches for, and lists, tuples and mappings of all these. Nothing else is taken, and nothing is
executed when it comes back. NumPy's own scalars come back as Python's numbers, named tuples as tuples, every mapping as
a dict.
"""

import io
import json
import math
import re
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from drake_blfdmp.errors import BlfDmpError

Arrays = dict[str, np.ndarray]
"""Name to array, as an .npz file holds them."""

_KINDS = "biufU"
_TAGS = ("array", "float", "map", "record", "tuple")


class PlainDataError(BlfDmpError):
    """Something is not plain data, or does not come back from what is meant to be."""


def pack(value: Any, name_of: Callable[[type], str]) -> tuple[Any, Arrays]:
    """The structure, which `json.dumps` takes as it is, and the arrays it names, each by its place in `value`.

    Args:
        value: plain data.
        name_of: the name by which a dataclass is found again; raises PlainDataError for one that will not be.

    Raises:
        PlainDataError: something is not plain; says where.
    """
    packer = _Packer(name_of)
    return packer.pack(value, ()), packer.arrays


def unpack(structure: Any, arrays: Mapping[str, np.ndarray], type_of: Callable[[str], type]) -> Any:
    """What `pack` was given.

    Args:
        structure, arrays: as `pack` returned them.
        type_of: the dataclass of a name; raises PlainDataError for a name it does not know.

    Raises:
        PlainDataError: the structure is none that `pack` makes, names no array, or a dataclass has other fields.
    """
    if structure is None or isinstance(structure, bool | int | float | str):
        return structure
    if isinstance(structure, list):
        return [unpack(part, arrays, type_of) for part in structure]
    if not isinstance(structure, dict) or len(structure) != 1 or next(iter(structure)) not in _TAGS:
        raise PlainDataError(f"plain data: {_short(structure)} has no meaning; it was written by a newer version")
    ((tag, held),) = structure.items()
    try:
        if tag == "array":
            return arrays[held]
        if tag == "float":
            return float(held)
        if tag == "tuple":
            return tuple(unpack(part, arrays, type_of) for part in held)
        if tag == "map":
            return {unpack(key, arrays, type_of): unpack(part, arrays, type_of) for key, part in held}
        name, parts = held
        return type_of(name)(**{key: unpack(part, arrays, type_of) for key, part in parts.items()})
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise PlainDataError(f"plain data: {_short(structure)} does not come back ({error})") from None


def npz_bytes(arrays: Mapping[str, np.ndarray]) -> bytes:
    """An .npz file, compressed; the same arrays give the same bytes, which `numpy.savez` does not promise."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, array in arrays.items():
            member = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            member.compress_type, member.create_system = zipfile.ZIP_DEFLATED, 3
            with archive.open(member, "w") as file:
                np.lib.format.write_array(file, array, allow_pickle=False)
    return stream.getvalue()


def npz_arrays(data: bytes) -> Arrays:
    """The arrays of an .npz file; no Python objects are made of what stands in it.

    Raises:
        PlainDataError: it is none, or damaged.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except Exception as error:  # Arbitrary bytes make NumPy and zipfile raise almost anything.
        raise PlainDataError(f"arrays cannot be read ({type(error).__name__}: {_short(error)})") from None


def json_bytes(structure: Any) -> bytes:
    """A structure as text with one line for all; `json_structure` reads it."""
    return json.dumps(structure, allow_nan=False).encode("ascii")


def json_structure(data: bytes) -> Any:
    """The structure of `json_bytes`.

    Raises:
        PlainDataError: it is no JSON.
    """
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise PlainDataError(f"structure cannot be read ({_short(error)})") from None


class _Packer:
    def __init__(self, name_of: Callable[[type], str]):
        self.arrays: Arrays = {}
        self._name_of = name_of

    def pack(self, value: Any, place: tuple[str, ...]) -> Any:
        if type(value) is np.ndarray:
            return {"array": self._keep(value, place)}
        if isinstance(value, np.generic):
            value = value.item()
        if value is None or isinstance(value, bool):
            return value
        if isinstance(value, str):
            return str(value)
        if isinstance(value, int):
            return int(value)
        if isinstance(value, float):
            return float(value) if math.isfinite(value) else {"float": repr(float(value))}
        if isinstance(value, Mapping):
            return {"map": [[self.pack(key, (*place, "key")), self.pack(part, (*place, _text(key)))]
                            for key, part in value.items()]}  # fmt: skip
        if isinstance(value, list | tuple):
            parts = [self.pack(part, (*place, str(i))) for i, part in enumerate(value)]
            return parts if isinstance(value, list) else {"tuple": parts}
        if is_dataclass(value) and not isinstance(value, type):
            held = {one.name: getattr(value, one.name) for one in fields(value) if one.init}
            parts = {name: self.pack(part, (*place, name)) for name, part in held.items()}
            return {"record": [self._name_of(type(value)), parts]}
        raise self._refused(value, place)

    def _keep(self, array: np.ndarray, place: tuple[str, ...]) -> str:
        if array.dtype.kind not in _KINDS or (array.dtype.kind == "f" and array.dtype.itemsize > 8):
            raise self._refused(array, place)
        wanted = "/".join(re.sub(r"[^\w.+=-]+", "_", part) for part in place) or "value"
        name, count = wanted, 1
        while name in self.arrays:
            count += 1
            name = f"{wanted}~{count}"
        # Order in memory and of bytes are this machine's own, and must not show in the file.
        self.arrays[name] = np.array(array, dtype=array.dtype.newbyteorder("<"), order="C")
        return name

    def _refused(self, value: Any, place: tuple[str, ...]) -> PlainDataError:
        kind = f"array of {value.dtype}" if type(value) is np.ndarray else type(value).__name__
        where = " > ".join(place) or "the value itself"
        return PlainDataError(
            f"plain data: {where} is of the kind '{kind}'; use numbers, text, None, arrays of these, lists, tuples, "
            "mappings or dataclasses that are known"
        )


def _text(key: Any) -> str:
    return " ".join(map(str, key)) if isinstance(key, tuple) else str(key)


def _short(what: Any) -> str:
    text = " ".join(str(what).split())
    return text if len(text) <= 80 else text[:79] + "…"
