"""What is on the site, in the order of a reader."""

from __future__ import annotations

import importlib

# Chapters, each with its pages in the checkout. A page's title is its first heading.
CHAPTERS: list[tuple[str, list[str]]] = [
    ("What it is", ["docs/index.md"]),
    (
        "Describe your vehicle and drive it",
        ["docs/vehicle.md", "docs/parameters.md", "docs/loop.md"],
    ),
    (
        "From a log to a tuned car",
        ["docs/planning.md", "docs/identify.md", "docs/tune.md", "docs/sweep.md", "docs/report.md"],
    ),
    (
        "Plug it in",
        ["docs/carla.md", "docs/ros2.md", "docs/gymnasium.md", "docs/c.md", "docs/examples.md"],
    ),
    ("Edges and statuses", ["docs/edges.md"]),
    (
        "Choose a controller",
        [
            "docs/choose.md",
            "docs/preview_pop.md",
            "docs/compare_your_controller.md",
            "docs/results.md",
        ],
    ),
    ("Theory", ["docs/theory.md"]),
    ("Benchmarks", ["benches/README.md", "docs/fuzzing.md", "docs/mutation_testing.md"]),
    ("The paper", ["docs/paper.md"]),
    (
        "Development",
        ["CONTRIBUTING.md", "ARCHITECTURE.md", "docs/licences.md", "CHANGELOG.md"],
    ),
]
# Pages whose names on the site differ from those in the checkout.
NAMES = {"benches/README.md": "benchmarks.md"}
# Read on a forge, where the site's first page takes its place.
ELSEWHERE = {"README.md": "index.md"}

MODULES = [
    "popsteer",
    "popsteer.vehicles",
    "popsteer.controllers",
    "popsteer.presets",
    "popsteer.tracks",
    "popsteer.sim",
    "popsteer.plants",
    "popsteer.planning",
    "popsteer.logs",
    "popsteer.identification",
    "popsteer.adapters.carla",
    "popsteer.adapters.ros2",
    "popsteer.adapters.gymnasium",
    "popsteer.paper",
    "popsteer.lab.compare",
    "popsteer.lab.matrix",
    "popsteer.lab.opponents",
    "popsteer.lab.suite",
    "popsteer.lab.stability",
    "popsteer.lab.sweep",
    "popsteer.lab.tune",
    "popsteer.lab.report",
]


def name_of(source: str) -> str:
    """Name a page as it is on the site."""
    return NAMES.get(source, source.rpartition("/")[2].lower())


def api_page(module: str) -> str:
    """Write the page of a module: its docstring, then what it exports, in its own order."""
    try:
        exported = importlib.import_module(module).__all__
    except ImportError as missing:  # an adapter whose extra is not installed
        return f"# {module}\n\nNot made where the site was built: `{missing}`.\n"
    lines = [f"# {module}", "", f"::: {module}"]
    lines += ["    options:", "      show_root_heading: false", "      show_root_toc_entry: false"]
    lines += ["      members: false"]
    modules = {each.removeprefix(f"{module}.") for each in MODULES}
    for name in exported:
        if name not in modules and name != "__version__":
            lines += ["", f"::: {module}.{name}"]
    return "\n".join(lines) + "\n"
