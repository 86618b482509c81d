"""The reference path: where the vehicle is, and where it aims.

`view` holds the waypoints, which `measure` has checked; `owned` is what a user makes. `projection`
is the closest point of a segment; `locate` finds it along the arc around the last one, and
`relocalise` on the whole path. `follow` takes a vehicle along the path in both directions.
`preview` gives the path's turns ahead. `resample` makes the fine grid of the near neighbourhood and
`lookahead` searches it.
"""
