"""The laboratory: what people look at, one experiment a folder.

``identify``
    A vehicle identified from a log.
``replay``
    Controllers in shadow mode along a log.
"""
