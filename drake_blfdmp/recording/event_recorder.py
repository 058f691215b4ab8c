"""Writes an event to a run's recording whenever a number that stands for a name changes."""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import Context, LeafSystem

from drake_blfdmp.recording.mcap_recorder import McapRecorder


class EventRecorder(LeafSystem):
    """Events of a McapRecorder, written at the times they happen.

    .. pydrake_system::

        name: EventRecorder
        input_ports:
        - number

    `number` (1) is an index of the names. The first value is written too; a number whose name is empty is not an
    event. Like a McapRecorder it records one run.
    """

    def __init__(self, *, recorder: McapRecorder, names: Sequence[str], rate: float = 100.0):
        """Listen for `recorder` at `rate`, Hz."""
        super().__init__()
        self._recorder, self._names = recorder, tuple(names)
        self._last: int | None = None
        self._number = self.DeclareVectorInputPort("number", 1)
        self.DeclarePeriodicPublishEvent(1.0 / rate, 0.0, self._publish)

    def _publish(self, context: Context) -> None:
        number = int(np.asarray(self._number.Eval(context))[0])
        if number != self._last:
            self._last = number
            if self._names[number]:
                self._recorder.Event(self._names[number], context.get_time())
