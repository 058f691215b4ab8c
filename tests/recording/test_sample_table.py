"""Rows of several topics, evenly thinned."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.recording.sample_table import SampleTable

PERIOD = 10_000_000  # ns


def fill(samples, most, left_out=()):
    """A table of two topics; the row of sample k holds k and (2 k, 3 k), the second not where left out."""
    table = SampleTable(most)
    for k in range(samples):
        for name, numbers in (("a", [k]), ("b", [2 * k, 3 * k])):
            if table.wants(k * PERIOD) and not (name == "b" and k in left_out):
                table.put(name, np.array(numbers, float))
    return table


@given(st.integers(1, 400), st.integers(2, 20).map(lambda half: 2 * half))
def test_rows_stay_whole_even_and_few_but_not_too_few(samples, most):
    t, columns = fill(samples, most).rows()
    kept = columns["a"][:, 0].astype(int)
    assert len(kept) == samples if samples <= most else most // 2 <= len(kept) <= most
    assert kept[0] == 0 and len(set(np.diff(kept))) <= 1
    np.testing.assert_allclose(t, kept * PERIOD * 1e-9)
    np.testing.assert_array_equal(columns["b"], np.outer(kept, [2, 3]))
    stride = kept[1] - kept[0] if len(kept) > 1 else 1
    assert samples - 1 - kept[-1] < stride


@given(st.integers(9, 60), st.sets(st.integers(0, 60)))
def test_a_row_that_lacks_a_topic_is_left_out(samples, left_out):
    _, columns = fill(samples, 8, left_out | {3}).rows()
    if "b" in columns:
        kept = columns["a"][:, 0].astype(int)
        assert not left_out & set(kept.tolist())
        np.testing.assert_array_equal(columns["b"], np.outer(kept, [2, 3]))


def test_what_cannot_be_a_row_is_refused():
    table = fill(3, 8)
    with pytest.raises(ValueError, match=r"time goes back from 0\.02 s to 0\.01 s"):
        table.wants(PERIOD)
    table.wants(3 * PERIOD)
    with pytest.raises(ValueError, match="2 numbers after 1"):
        table.put("a", np.zeros(2))
