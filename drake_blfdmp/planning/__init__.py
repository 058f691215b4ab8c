"""From a scenario to a plan: every number a diagram needs.

- `scenario`, `scenario_sections`: the typed description of a run, from and to YAML.
- `sources`: the scenario's recording, cleaned, in the torso frame, with its held interval.
- `task`: the motion on the task's clock, the skill, the bands.
- `supports`: the tables, and the shift that makes room for them.
- `span`: how far apart the palms can be at all.
- `squeeze`: the depth for a force; `held_squeeze`: that of a box for which rules of thumb have too little.
- `carry`: a carry brought to where the box shall stand, and clear of the tables.
- `searches`: how places for the arms are looked for; `led_elbows`: elbows that are led another way than the person's.
- `planned`: what a plan is. `followed`: whether the arms follow it all the way.
- `plan`: all of it in order, `MakePlan`; `free_plan`: the same for a motion without a box.
- `goal_range`: how far, and when, a plan's goal may be moved while it is carried out.
"""
