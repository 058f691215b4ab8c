"""Carrying a plan out and judging it, and what the studies compute.

One run:

- `run_recorder`: what is recorded of a run, from which its figures are drawn. `planned_signals`: its part of the plan.
- `run_logger`: what is logged while the diagram runs, and the `RunLog` made of it.
- `metrics`: the numbers of `summary.json`, pure functions of a `RunLog` and the skill's rollouts. `summary`: the file.
- `success`: the stated thresholds, and a sentence for each that is missed.
- `live_session`: what is done to a run in the live view.
- `carry_out`: one whole run. `folders`: where results go. `console`: the bar of its progress.

Studies:

- `study`: what a study is given, and the claims, figures and tables that it hands back.
- `study_runner`: finding the studies of a folder, and running them.
- `report`: what came out of them, as a page and as Markdown.
- `studies`: what they compute.
"""
