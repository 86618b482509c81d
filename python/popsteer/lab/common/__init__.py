"""What the experiments share.

`names` are those of all that can be compared, `layout` is how tables and JSON documents look,
`theme` the colours of figures, `draw` makes files of them, `machine` names what they ran on.
"""

from popsteer.lab.common import layout, machine, names

__all__ = ["layout", "machine", "names"]
