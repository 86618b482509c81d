"""Controllers on pathological paths: crossings, near misses, cusps, odd spacings, starts."""

from popsteer.lab.edges import table
from popsteer.lab.edges.runs import (
    EdgeRun,
    EdgeTrack,
    edge_controller,
    edge_params,
    edge_tracks,
    run,
)

__all__ = ["EdgeRun", "EdgeTrack", "edge_controller", "edge_params", "edge_tracks", "run", "table"]
