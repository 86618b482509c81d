"""What is on the site, in the order of a reader."""

from __future__ import annotations

import importlib
import inspect
import posixpath

# Chapters, each with its pages as docs/ has them. A page's title is its first heading.
_CHAPTERS = {
    "What it is": ["index"],
    "Describe your vehicle and drive it": ["vehicle", "driver", "parameters", "files", "loop"],
    "From a log to a tuned car": ["planning", "identify", "tune", "sweep", "report"],
    "Plug it in": ["carla", "ros2", "gymnasium", "c", "examples"],
    "Edges and statuses": ["edges"],
    "Choose a controller": ["choose", "preview_pop", "compare_your_controller", "results"],
    "Theory": ["theory"],
    "Benchmarks": ["../benches/README", "fuzzing", "mutation_testing"],
    "The paper": ["paper"],
    "Development": ["../CONTRIBUTING", "../ARCHITECTURE", "licences", "../CHANGELOG"],
}
CHAPTERS = {
    title: [posixpath.normpath(f"docs/{name}.md") for name in names]
    for title, names in _CHAPTERS.items()
}
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
    "popsteer.tables",
    "popsteer.identification",
    "popsteer.adapters.carla",
    "popsteer.adapters.ros2",
    "popsteer.adapters.gymnasium",
    "popsteer.paper",
    "popsteer.lab.compare",
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


def api_pages(module: str) -> dict[str, str]:
    """Write the pages of a module by their names: its own, and one for each of its classes.

    Its own has its docstring, and what else it exports in its order.
    """
    try:
        found = importlib.import_module(module)
    except ImportError as missing:  # an adapter whose extra is not installed
        return {module: f"# {module}\n\nNot made where the site was built: `{missing}`.\n"}
    lines = [f"# {module}", "", f"::: {module}"]
    lines += ["    options:", "      show_root_heading: false", "      show_root_toc_entry: false"]
    lines += ["      members: false"]
    modules = {each.removeprefix(f"{module}.") for each in MODULES}
    exported = [each for each in found.__all__ if each not in modules and each != "__version__"]
    classes = [each for each in exported if inspect.isclass(getattr(found, each))]
    if classes:
        lines += ["", "Classes: " + ", ".join(f"[{each}]({module}.{each}.md)" for each in classes)]
    for name in exported:
        if name not in classes:
            lines += ["", f"::: {module}.{name}"]
    pages = {module: "\n".join(lines) + "\n"}
    for name in classes:
        pages[f"{module}.{name}"] = f"# {name}\n\n::: {module}.{name}\n"
    return pages
