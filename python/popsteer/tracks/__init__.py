"""The tracks that come with popsteer, each generated from its formula when it is asked for.

The standard manoeuvres are in `popsteer.tracks.manoeuvres`, as functions whose dimensions can be
changed; pathological paths, with crossings, cusps and odd spacings, are in
`popsteer.tracks.edges`.

Examples
--------
>>> from popsteer import tracks
>>> tracks.names()
('racetrack', 'straight', 'circle', 'figure-eight', 'slalom', 'step-steer', \
'double-lane-change', 'obstacle-avoidance')
>>> track = tracks.get("racetrack")
>>> track.xy.shape, track.speed.shape, track.closed
((1274, 2), (1274,), False)
"""

from popsteer.tracks.catalogue import get, names
from popsteer.tracks.track import Track

__all__ = ["Track", "get", "names"]
