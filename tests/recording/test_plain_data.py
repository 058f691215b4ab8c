"""Plain data comes back as it was, what is not plain is refused, and what was written by others does no harm."""

import io
import json
from collections import OrderedDict, namedtuple
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from drake_blfdmp.recording.plain_data import (
    PlainDataError,
    json_bytes,
    json_structure,
    npz_arrays,
    npz_bytes,
    pack,
    unpack,
)


@dataclass(frozen=True)
class Pair:
    one: Any
    other: Any = None


def name_of(kind):
    if kind is not Pair:
        raise PlainDataError(f"no {kind.__name__}")
    return "Pair"


def type_of(name):
    if name != "Pair":
        raise PlainDataError(f"no {name}")
    return Pair


def there_and_back(value):
    structure, arrays = pack(value, name_of)
    text, data = json_bytes(structure), npz_bytes(arrays)
    again = pack(value, name_of)
    assert (text, data) == (json_bytes(again[0]), npz_bytes(again[1]))
    return unpack(json_structure(text), npz_arrays(data), type_of)


def alike(a, b):
    """Of one type all through, equal, and NaN where the other is."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if is_dataclass(a):
        return all(alike(getattr(a, one.name), getattr(b, one.name)) for one in fields(a))
    if isinstance(a, dict):
        return alike(list(a.items()), list(b.items()))
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(alike, a, b))
    return repr(a) == repr(b)  # NaN is NaN, and 0.0 is not -0.0.


DTYPES = st.one_of(
    hnp.boolean_dtypes(),
    hnp.integer_dtypes(endianness="<"),
    hnp.unsigned_integer_dtypes(endianness="<"),
    hnp.floating_dtypes(endianness="<", sizes=(16, 32, 64)),
    hnp.unicode_string_dtypes(endianness="<", max_len=4),
)
ARRAYS = hnp.arrays(DTYPES, hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4))
KEYS = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=6),
    lambda part: st.tuples(part, part),
    max_leaves=3,
)
VALUES = st.recursive(
    KEYS | ARRAYS,
    lambda part: (
        st.lists(part, max_size=3)
        | st.lists(part, max_size=3).map(tuple)
        | st.dictionaries(KEYS, part, max_size=3)
        | st.builds(Pair, part, part)
    ),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None)
@given(VALUES)
def test_plain_data_comes_back_as_it_was(value):
    assert alike(there_and_back(value), value)


def test_the_order_in_memory_does_not_show():
    rows = np.arange(12.0).reshape(3, 4)
    kinds = [rows, np.asfortranarray(rows), rows.astype(">f8"), np.arange(24.0).reshape(3, 8)[:, ::2] / 2.0]
    written = {npz_bytes(pack(kind, name_of)[1]) for kind in kinds}
    assert len(written) == 1
    np.testing.assert_array_equal(there_and_back(kinds[2]), rows)


def test_numpys_scalars_and_relatives_of_plain_types_come_back_plain():
    point = namedtuple("point", "x y")(np.float32(0.5), np.int64(2))
    found = there_and_back([point, OrderedDict(a=np.bool_(True)), np.str_("s"), np.float64("nan"), -0.0])
    assert alike(found, [(0.5, 2), {"a": True}, "s", float("nan"), -0.0])


def test_arrays_are_named_by_their_places_and_never_twice():
    _, arrays = pack({"a/b": [np.zeros(1)], "a b": (np.ones(2),), "c": Pair({"": np.zeros(3)})}, name_of)
    assert list(arrays) == ["a_b/0", "a_b/0~2", "c/one/"]
    with np.load(io.BytesIO(npz_bytes(arrays))) as file:
        assert sorted(file.files) == sorted(arrays)


@dataclass
class Unknown:
    pass


REFUSED = {
    "a function": (print, "builtin_function_or_method"),
    "a set": ({1}, "set"),
    "bytes": (b"", "bytes"),
    "a complex number": (1j, "complex"),
    "numpy's long double": (np.longdouble(1), "longdouble"),
    "an array of objects": (np.array([None, print]), "array of object"),
    "an array of complex numbers": (np.zeros(1, dtype=complex), "array of complex128"),
    "a masked array": (np.ma.masked_array([1.0], [True]), "MaskedArray"),
    "a date": (np.datetime64("2020-01-01"), "date"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_not_plain_is_refused_and_its_place_named(case):
    value, kind = REFUSED[case]
    with pytest.raises(PlainDataError) as caught:
        pack({"runs": [1.0, Pair(one=value)]}, name_of)
    assert f"runs > 1 > one is of the kind '{kind}'" in str(caught.value)
    with pytest.raises(PlainDataError, match="the value itself"):
        pack(value, name_of)


def test_a_dataclass_needs_somebody_who_knows_it():
    with pytest.raises(PlainDataError, match="no Unknown"):
        pack([Unknown()], name_of)


BROKEN = {
    "an unknown tag": {"pickle": "x"},
    "no tag": {},
    "two tags": {"array": "a", "tuple": []},
    "an array that is not there": {"array": "b"},
    "a name that is no text": {"array": []},
    "no number": {"float": "many"},
    "a tuple of nothing": {"tuple": 1},
    "pairs of three": {"map": [[1, 2, 3]]},
    "a key that no mapping takes": {"map": [[[1], 2]]},
    "an unknown dataclass": {"record": ["os.system", {"command": "ls"}]},
    "fields that are not there": {"record": ["Pair", {"third": 1}]},
    "a field too few": {"record": ["Pair", {}]},
    "no record": {"record": "Pair"},
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_structure_that_nobody_packed_is_refused_in_one_line(case):
    with pytest.raises(PlainDataError) as caught:
        unpack([1, {"tuple": [BROKEN[case]]}], {"a": np.zeros(1)}, type_of)
    assert "\n" not in str(caught.value)


@settings(max_examples=60, deadline=None)
@given(st.binary(max_size=200), st.integers(0, 10_000), st.integers(1, 255))
def test_damaged_bytes_are_refused_or_harmless(noise, place, change):
    whole = npz_bytes({"a": np.arange(20.0), "b": np.array(["x", "yy"])})
    flipped = bytearray(whole)
    flipped[place % len(whole)] ^= change
    for data in (noise, whole[: place % len(whole)], bytes(flipped)):
        try:
            arrays = npz_arrays(data)
        except PlainDataError as error:
            assert "\n" not in str(error)
        else:
            assert all(isinstance(array, np.ndarray) for array in arrays.values())
        try:
            json_structure(data)
        except PlainDataError as error:
            assert "\n" not in str(error)


def test_no_python_object_is_made_of_a_pickle():
    stream = io.BytesIO()
    np.savez(stream, a=np.array([{}], dtype=object))
    with pytest.raises(PlainDataError, match="arrays cannot be read"):
        npz_arrays(stream.getvalue())
    with pytest.raises(PlainDataError, match="structure cannot be read"):
        json_structure(b"[" * 100_000)
    assert json.loads(json_bytes([1.5, None])) == [1.5, None]
