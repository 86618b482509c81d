r"""Tables of waypoints and logs, as people have them: what a column is, and in what unit.

>>> import pathlib, tempfile
>>> with tempfile.TemporaryDirectory() as folder:
...     file = pathlib.Path(folder) / "lap.csv"
...     _ = file.write_text("# x_m;y_m;vx_mps\n0;0;5\n1;0;5\n2;0;5\n")
...     read_waypoints(file).source()
'lap.csv: 3 waypoints of x (x_m), y (y_m), speed (vx_mps)'
"""

from popsteer.tables.waypoints import Waypoints, make_path, read_waypoints

__all__ = ["Waypoints", "make_path", "read_waypoints"]
