"""Carrying a plan out and judging it.

- `run_logger`: what is logged while the diagram runs, and the `RunLog` made of it.
- `metrics`: the numbers of `summary.json`, pure functions of a `RunLog` and the skill's rollouts.
- `success`: the stated thresholds, and a sentence for each that is missed.
- `carry_out`: one whole run and its output folder.
"""
