"""Logs of drives: columns of a CSV file, or the messages of an MCAP file or a ROS 2 bag.

>>> from popsteer import logs
>>> log = logs.Log([0.0, 0.1], [0.0, 0.8], [0.0, 0.0], [0.0, 0.0], [8.0, 8.0], [0.0, 0.1])
>>> log.duration
0.1
"""

from popsteer.logs.bag import read_bag
from popsteer.logs.csv_log import read_csv
from popsteer.logs.formats import read
from popsteer.logs.log import Log, LogError

__all__ = ["Log", "LogError", "read", "read_bag", "read_csv"]
