"""Benchmarks: what a control step costs when it is called from Python.

`latency` measures, `states` holds the situations the laws are put in, `laws` the calls that are
timed, `yardsticks` those from outside, `timing` the clockwork, `percentiles` sums up, `report` is
what comes of it, `layout` its table, `machine` names what it ran on. Measuring needs numpy alone,
the table rich, the yardsticks an extra of their own.
"""
