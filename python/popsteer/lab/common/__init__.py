"""What the experiments share.

`names` are those of all that can be compared, `layout` is how tables and JSON documents look,
`theme` the colours of figures, `draw` makes files of them, `files` writes several files at once,
`vehicle` tells two vehicles apart, `timing` and `percentiles` time calls, `machine` names what they
ran on.
"""

from popsteer.lab.common import files, layout, machine, names, timing, vehicle

__all__ = ["files", "layout", "machine", "names", "timing", "vehicle"]
