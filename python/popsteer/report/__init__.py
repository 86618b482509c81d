"""Reports: tables, files and figures of what a study found.

`files` and `write` need the extra ``lab`` for the figures, and `tables` for the table; the rest
needs numpy alone.
"""

from popsteer.report.files import files, write
from popsteer.report.metrics_json import metrics_document
from popsteer.report.runs_csv import run_csv
from popsteer.report.table import tables

__all__ = ["files", "metrics_document", "run_csv", "tables", "write"]
