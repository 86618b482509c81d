"""The reference path: where the vehicle is, and where it aims.

`view` holds the waypoints, `locate` finds the vehicle beside them, `resample` makes the fine
grid of the near neighbourhood and `lookahead` searches it. `owned` is what a user makes.
"""
