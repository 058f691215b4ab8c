"""A recording in, a clean demonstration of both arms out.

`formats.read_recording` -> Recording; `cleaning.clean` -> Demonstration, z up on a uniform clock; `health.examine` says
what a recording is worth; `torso_frame.to_torso_frame` takes the walk out; `bones.estimate_bone_lengths` and
`holding.find_holding` measure the person and the box; `alignment` puts several recordings of one task on one clock;
`virtual_kinect` films a modelled person where nobody was recorded.
"""
