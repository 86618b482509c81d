"""What is my car? A vehicle identified from the log of a drive.

`identify` simulates the chain of `popsteer.Vehicle` along the log's commands and speeds, and fits
it to the measured headings by scipy's least squares (extra ``lab``), and to the positions. See
``docs/identify.md``.
"""

from popsteer.identification.procedure import identify
from popsteer.identification.result import Identification
from popsteer.logs import Log, LogError

__all__ = ["Identification", "Log", "LogError", "identify"]
