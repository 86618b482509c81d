"""Reports: tables, files and figures of what a study found.

`file_names` and `files` need the extra ``lab`` for the figures, and `tables` for the table; the
rest needs numpy alone.
"""

from popsteer.report.files import file_names, files, write
from popsteer.report.metrics_json import metrics_document
from popsteer.report.runs_csv import run_csv
from popsteer.report.table import tables

__all__ = ["file_names", "files", "metrics_document", "run_csv", "tables", "write"]
