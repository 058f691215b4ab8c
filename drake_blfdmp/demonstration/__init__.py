"""A recording in, a clean demonstration of both arms out.

`formats.read_recording` -> Recording; `cleaning.clean` -> Demonstration, z up on a uniform clock;
`torso_frame.to_torso_frame` takes the walk out; `bones.estimate_bone_lengths` and `holding.find_holding`
measure the person and the box.
"""
