from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

import pytest

from studies import bench as tables
from studies.layout import replace_block
from tests.helpers import ROOT

if TYPE_CHECKING:
    from pathlib import Path

ROW = {"p50": 200, "p99": 300, "p999": 1500, "max": 4_000_000, "net_p50": 150.0}
STAGE = ROW | {"p50": 60_000, "net_p50": None}
EMPTY = ROW | {"p50": 100, "net_p50": 25.0}
LATENCY: dict[str, Any] = {
    "results": {
        "pop_step_ns": ROW,
        "empty_call_ns": EMPTY,
        "numba_step_ns": None,
        "mpc_step_ns": STAGE | {"net_p50": 70_000.0},
        "mpc_solve_ns": STAGE,
    },
    "ratios": {"step_over_empty_call": 2.0, "numba_over_step": None},
    "net_ratios": {"step_over_empty_call": 6.0, "numba_over_step": None},
    "absent": {"numba_step_ns": "not installed"},
    "states": {"source": "a drive", "count": 12},
    "machine": {"cpu": "A CPU", "cores": "2", "python": "CPython 3.11", "platform": "p"},
    "timing": {"calls": {"pop_step_ns": 1_000_003}, "timer_floor_ns": 40.0},
}
COUNTS = {
    "toolchain": {"rustc": "rustc 1", "libc": "glibc 2", "processor": "x86_64"},
    "counts": {"pop steer": 1151.82},
}


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """What `make bench` leaves: criterion's folder with a bench of this run and an older one."""
    (tmp_path / "latency.json").write_text(json.dumps(LATENCY), encoding="utf-8")
    (tmp_path / "instruction_counts.json").write_text(json.dumps(COUNTS), encoding="utf-8")
    (tmp_path / "started").touch()
    os.utime(tmp_path / "started", (1000, 1000))
    benches = (("pop/steer", 2000), ("pop/removed", 999), ("pop/100", 2000), ("pop/21", 2000))
    for name, written in benches:
        folder = tmp_path / "criterion" / name / "new"
        folder.mkdir(parents=True)
        interval = {"lower_bound": 61.0, "upper_bound": 62.04}
        median = {"point_estimate": 61.26, "confidence_interval": interval}
        (folder / "estimates.json").write_text(json.dumps({"median": median}), encoding="utf-8")
        (folder / "benchmark.json").write_text(json.dumps({"full_id": name}), encoding="utf-8")
        os.utime(folder / "estimates.json", (written, written))
    return tmp_path


def test_figures_hold_the_numbers_of_the_run(run: Path) -> None:
    made = tables.figures(run, run / "criterion", "rustc 1")
    assert set(made) == {"figures", "latency"}
    for text in made.values():
        assert "A CPU, 2 cores; CPython 3.11; rustc 1." in text
        for line in (
            "| POP, angle | 200 ns | 300 ns | 1.50 µs | 4.00 ms | 150 ns | 2.00 | 6.00 | 1.00 |",
            "| POP in numba | not installed |  |  |  |  |  |  |  |",
            "| MPC on osqp | 60.0 µs | 300 ns | 1.50 µs | 4.00 ms | 70.0 µs | 600 | 2,800 | 300 |",
            "| &nbsp;&nbsp;its solve | 60.0 µs | 300 ns | 1.50 µs | 4.00 ms | - | 600 | - | 300 |",
        ):
            assert line in text.splitlines()
    figures = made["figures"].splitlines()
    assert "| `step_over_empty_call` | 2.00 | 6.00 |" in figures
    assert "| `numba_over_step` | - | - |" in figures
    assert "| `pop steer` | 1,152 |" in figures
    assert "POP, angle 1,000,003" in made["figures"]
    assert "Over the length" not in made["figures"]


def test_figures_take_criterions_benches_of_this_run_alone_in_order(run: Path) -> None:
    text = tables.figures(run, run / "criterion", "rustc 1")["figures"]
    names = ["pop/21", "pop/100", "pop/steer"]
    assert [line for line in text.splitlines() if line.startswith("| `pop/")] == [
        f"| `{name}` | 61.3 | 61.0 to 62.0 |" for name in names
    ]


def test_figures_hold_the_bench_over_the_length_where_it_ran(run: Path) -> None:
    rows = [
        {"waypoints": 1000, "step p50 [ns]": 151.24, "path [bytes]": None},
        {"waypoints": 10_000_000, "step p50 [ns]": 160.0, "path [bytes]": 32.0},
    ]
    (run / "path_scale.json").write_text(json.dumps({"rows": rows}), encoding="utf-8")
    lines = tables.figures(run, run / "criterion", "rustc 1")["figures"].splitlines()
    assert "| waypoints | 1,000 | 10,000,000 |" in lines
    assert "| step p50 [ns] | 151.2 | 160 |" in lines
    assert "| path [bytes] | - | 32 |" in lines


def test_figures_without_a_bench_in_rust_are_refused(run: Path) -> None:
    os.utime(run / "started", (3000, 3000))
    with pytest.raises(SystemExit, match="no bench of this run"):
        tables.figures(run, run / "criterion", "rustc 1")


@pytest.mark.parametrize("missing", ["latency.json", "instruction_counts.json"])
def test_figures_of_half_a_run_are_refused(run: Path, missing: str) -> None:
    (run / missing).unlink()
    with pytest.raises(SystemExit, match=f"{missing}: .*run the whole of"):
        tables.figures(run, run / "criterion", "rustc 1")


def test_figures_without_counts_say_why(run: Path) -> None:
    counted = {"counts": None, "reason": "valgrind is not on the path"}
    (run / "instruction_counts.json").write_text(json.dumps(counted), encoding="utf-8")
    text = tables.figures(run, run / "criterion", "rustc 1")["figures"]
    assert "Not counted in this run: valgrind is not on the path." in text


def test_replace_block_keeps_its_marks_and_what_is_around() -> None:
    text = "a\n<!-- figures: begin (generated) -->\nold\n| \\1 |\n<!-- figures: end -->\nz\n"
    new = replace_block(text, "figures", "| \\2 |\n\nnew")
    assert new == (
        "a\n<!-- figures: begin (generated) -->\n| \\2 |\n\nnew\n<!-- figures: end -->\nz\n"
    )
    assert replace_block(new, "figures", "| \\2 |\n\nnew") == new
    assert replace_block(text, "other", "new") == text


def test_replace_block_twice_is_refused() -> None:
    block = "<!-- figures: begin -->\n<!-- figures: end -->\n"
    with pytest.raises(SystemExit, match="more than one"):
        replace_block(2 * block, "figures", "new")


def test_readme_of_the_benches_has_the_block() -> None:
    readme = (ROOT / "benches" / "README.md").read_text(encoding="utf-8")
    assert replace_block(readme, "figures", "") != replace_block(readme, "figures", "new")
