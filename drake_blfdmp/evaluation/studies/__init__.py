"""What the studies compute; their scripts say what the paper claims and show it.

- `noise_metrics`, `noise_takes`: what a skeleton sensor gets wrong (Fig. 2). `truth`: motions beside what was really
  done (Fig. 6).
- `law_metrics`, `law_comparison`: the laws on one task (Fig. 10). `gain_search`: their gains. `resting`: where the
  hands rest with the law of Gams et al. `one_axis`, `one_axis_facts`: the published law alone.
- `swivel_metrics`, `redundancy_runs`: swivel angles and elbows of the two arms (Fig. 11).
- `random_problems`, `guarantee_metrics`, `random_gain_search`: whether laws keep their bands on random problems, with
  the best gains for those. `sampling_cells`: the same over rates and gains. `intervals`: how sure a counted share is.
- `squeeze_rig`, `squeeze_cells`, `squeeze_metrics`: how pads yield, and the least squeeze that holds.
- `generalisation_cases`, `generalisation_metrics`: other starts, goals, durations and boxes.
"""
