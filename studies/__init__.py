"""What makes the published numbers that no command of popsteer makes: `python -m studies.NAME`.

From the root of a checkout:

    python -m studies.pages [TABLE ...]  # the tables of docs/, all or those named
    python -m studies.figures            # the figures of `popsteer compare` and `stability`
    python -m studies.report             # the pictures of docs/report.md, in headless Chromium
    python -m studies.matrix FOLDER      # what `popsteer matrix --out` wrote, into two pages
    python -m studies.bench FOLDER       # what `make bench` measured, into the READMEs
    python -m studies.limits STUDY       # preview POP behind wheels that turn slowly
    python -m studies.solvers FOLDER     # the MPC's quadratic problem, by solvers in C
    python -m studies.opponents          # the weights of each controller, searched alike
    python -m studies.sizing             # runs a second of a sweep, by number of workers
    python -m studies.alarms             # whether an alarm is ever false
    python -m studies.playground         # how long the playground drives

The other modules drive what these show; tests hold the pages to them.
"""
