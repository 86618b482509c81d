"""The fastest speeds along a path, and what limits them: a table and figures of a plan."""

from popsteer.lab.plan import table

__all__ = ["table"]
