"""The tracks that come with popsteer, each generated from its formula when it is asked for.

Examples
--------
>>> from popsteer import tracks
>>> tracks.names()
('racetrack', 'straight', 'circle', 'figure-eight', 'slalom')
>>> track = tracks.get("racetrack")
>>> track.xy.shape, track.speed.shape, track.closed
((1274, 2), (1274,), False)
"""

from popsteer.tracks.catalogue import get, names
from popsteer.tracks.track import Track

__all__ = ["Track", "get", "names"]
