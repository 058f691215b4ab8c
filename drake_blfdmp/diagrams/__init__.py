"""Wiring only.

- `skill`: `AddSkill`, the coupled movement primitives of one skill.
- `hold_and_place`: `AddHoldAndPlace`, `MakeHoldAndPlace`: the skill, the arms, the box and the tables of a plan.
- `live`: `AddLive`, what someone who looks on may do to a run.
"""
