"""One LeafSystem a file: ports, state and events; the mathematics is called, never written here.

- `canonical_system`, `forcing_term`, `transformation_system`: the movement primitives of the six points.
- `distance_bands`, `blf_coupler`, `distance_reshaper`: the default coupling. `point_coupler`: every other law.
- `retargeting`, `swivel_differential_ik`: from the person's points to the arms' joints.
- `palm_forces`: what the palms press with. `timed_push`: what disturbs them.
- `contact_wrenches`, `arm_swivels`, `link_lengths`, `skill_clock`, `planned_pose`, `passed_times`: for recordings.
"""
