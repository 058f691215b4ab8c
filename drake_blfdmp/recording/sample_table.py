"""Samples of several topics in one table, evenly thinned where there are more than fit. Without pydrake."""

import numpy as np

MOST_SAMPLES = 10_000
"""So many rows are kept at most; an even number."""


class SampleTable:
    """Rows of numbers, a time each, in bounded memory.

    All messages of one time are one row. When the table is full, every second row is dropped and from then on every
    second time left out, again and again, so that the rows always lie evenly over what has been read. ::

        if table.wants(t_ns):
            table.put("points", numbers)
    """

    def __init__(self, most: int = MOST_SAMPLES):
        """Of `most` rows, an even number."""
        self._most, self._stride, self._samples = most, 1, 0
        self._now: int | None = None
        self._row: int | None = None
        self._t_ns = np.zeros(most, dtype=np.int64)
        self._columns: dict[str, np.ndarray] = {}
        self._filled: dict[str, np.ndarray] = {}

    def wants(self, t_ns: int) -> bool:
        """Whether the row of time `t_ns` (ns) is kept; begins it where the time is new.

        Raises:
            ValueError: the time is before that of the row before.
        """
        if t_ns != self._now:
            if self._now is not None and t_ns < self._now:
                raise ValueError(f"time goes back from {self._now * 1e-9:.6g} s to {t_ns * 1e-9:.6g} s between topics")
            self._now = t_ns
            self._begin(t_ns)
        return self._row is not None

    def put(self, name: str, numbers: np.ndarray) -> None:
        """The numbers (n,) of a topic in the present row.

        Raises:
            ValueError: there are more or fewer than in the rows before.
        """
        if self._row is None:
            return
        column = self._columns.get(name)
        if column is None:
            column = self._columns[name] = np.zeros((self._most, len(numbers)))
            self._filled[name] = np.zeros(self._most, dtype=bool)
        if len(numbers) != column.shape[1]:
            raise ValueError(f"{len(numbers)} numbers after {column.shape[1]}")
        column[self._row] = numbers
        self._filled[name][self._row] = True

    def rows(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Times (N,), s, and numbers (N, n) of each topic, of the rows in which every topic has some."""
        whole = np.arange(self._most) < -(-self._samples // self._stride)
        for filled in self._filled.values():
            whole &= filled
        return self._t_ns[whole] * 1e-9, {name: column[whole] for name, column in self._columns.items()}

    def _begin(self, t_ns: int) -> None:
        index, self._samples = self._samples, self._samples + 1
        if index % self._stride:
            self._row = None
            return
        if index // self._stride == self._most:
            self._halve()
        self._row = None if index % self._stride else index // self._stride
        if self._row is not None:
            self._t_ns[self._row] = t_ns

    def _halve(self) -> None:
        half = self._most // 2
        for column in (self._t_ns, *self._columns.values(), *self._filled.values()):
            column[:half] = column[::2].copy()
        for filled in self._filled.values():
            filled[half:] = False
        self._stride *= 2
