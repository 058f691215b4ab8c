"""Retargeting of the person's six points to both arms as a Drake system."""

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.robot.retargeting import Retarget, palm_offsets, retarget_motion


class Retargeting(LeafSystem):
    """Palm poses, twists and swivel angles from the skill's six points (`robot.retargeting`).

    .. pydrake_system::

        name: Retargeting
        input_ports:
        - position
        - velocity
        - tempo (optional)
        - orientation (optional)
        - angular_velocity (optional)
        output_ports:
        - palm_poses
        - palm_twists
        - swivel
        - swivel_rate

    No state. `position`, `velocity` (18) in the torso frame. `orientation` (4), a unit quaternion w x y z, and
    `angular_velocity` (3), rad/s, of what is held, in the frame of the line between the hands, both or neither: the
    palms roll together about that line by them, and keep their roll without. `palm_poses` (14): left, then right X_WP
    as qw qx qy qz x y z. `palm_twists` (12): angular (rad/s), then translational velocity (m/s) of each palm in W.
    `swivel` (2), rad, and `swivel_rate` (2), rad/s: what is asked of the robot's arms. `tempo` (1), how fast the
    skill's clock runs, turns rates by that clock, as `velocity` and `angular_velocity` are, into rates in the world; 1
    when not connected.
    """

    def __init__(self, *, retarget: Retarget):
        super().__init__()
        self._retarget = retarget
        self._offsets = palm_offsets(retarget.rolls)
        self._position = self.DeclareVectorInputPort("position", 18)
        self._velocity = self.DeclareVectorInputPort("velocity", 18)
        self._tempo = self.DeclareVectorInputPort("tempo", 1)
        self._orientation = self.DeclareVectorInputPort("orientation", 4)
        self._angular_velocity = self.DeclareVectorInputPort("angular_velocity", 3)
        for index, (name, size) in enumerate(
            (("palm_poses", 14), ("palm_twists", 12), ("swivel", 2), ("swivel_rate", 2))
        ):
            self.DeclareVectorOutputPort(name, size, lambda context, output, i=index: self._calc(context, output, i))
        # All four outputs are views of one computation; the last is kept for the other three.
        self._key: tuple[bytes, ...] | None = None
        self._result: tuple[np.ndarray, ...] = ()

    def _calc(self, context, output, index):
        x, velocity = self._position.Eval(context), self._velocity.Eval(context)
        tempo = np.asarray(self._tempo.Eval(context))[0] if self._tempo.HasValue(context) else 1.0
        velocity = tempo * np.asarray(velocity)
        turn: tuple[np.ndarray, ...] = ()
        if self._orientation.HasValue(context):
            rate = np.asarray(self._angular_velocity.Eval(context))
            turn = np.asarray(self._orientation.Eval(context)), tempo * rate
        key = (x.tobytes(), velocity.tobytes(), *(value.tobytes() for value in turn))
        if key != self._key:
            self._result = retarget_motion(
                x.reshape(6, 3), velocity.reshape(6, 3), self._retarget, self._offsets, *turn
            )
            self._key = key
        output.SetFromVector(self._result[index].reshape(-1))
