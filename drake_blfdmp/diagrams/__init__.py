"""Wiring only.

- `skill`: `AddSkill`, the coupled movement primitives of one skill.
- `hold_and_place`: `AddHoldAndPlace`, `MakeHoldAndPlace`: the skill, the arms, the box and the tables of a plan.
"""
