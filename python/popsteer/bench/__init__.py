"""Benchmarks: what a control step costs when it is called from Python.

`latency` measures and reports, `states` holds the situations the laws are put in, `laws` the calls
that are timed, `timing` the clockwork, `machine` names what it ran on. Measuring needs numpy alone,
the table rich.
"""
