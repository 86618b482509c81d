"""A vehicle identified from a log: its table, its figure and its files."""

from popsteer.lab.identify.table import caption, identified_csv, identified_json, identified_table

__all__ = ["caption", "identified_csv", "identified_json", "identified_table"]
