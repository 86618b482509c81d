"""The reference path: where the vehicle is, and where it aims.

`view` holds the waypoints, which `measure` has checked; `owned` is what a user makes. `projection`
is the closest point of a segment; `locate` finds it along the arc around the last one, and
`relocalise` on the whole path after a jump, with the boxes of an index on long paths. `follow`
takes a vehicle along the path in both directions. `preview` tells how the path turns ahead, `stop`
how far and how fast to go on. `resample` makes the fine grid of the near neighbourhood and
`lookahead` searches it.
"""
