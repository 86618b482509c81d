"""What the experiments share.

`names` are those of all that can be compared, `layout` is how tables and JSON documents look,
`theme` the colours of figures, `draw` makes files of them.
"""

from popsteer.lab.common import layout, names

__all__ = ["layout", "names"]
