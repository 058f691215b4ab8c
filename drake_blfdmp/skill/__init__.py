"""What is learned, and the pure mathematics of it: NumPy and SciPy alone.

- `skill`: `Skill`, its file. `learning`, `regression`, `basis`: from a demonstration to its weights.
- `canonical`, `transformation`: the movement primitive, (1) to (4).
- `profiles`, `bands`: the hands' desired distance, and every link's band with its derivatives, (5), (13), (20).
- `geometry`, `barrier`: the links' lengths and the barrier on them. `laws`: the laws a scenario can choose.
- `reshaper`: the least change of the points' accelerations that meets all links.
- `sampled`: gains, and which are safe at a time step. `rollout`: skills in time without Drake, many at once.
"""
