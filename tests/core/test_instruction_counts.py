"""No step takes more instructions than the recorded baseline and its tolerance."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import pytest

from benches import instruction_counts
from benches.instruction_counts import Unavailable, comparable, compare, count, count_all, total
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture(scope="module")
def baseline() -> dict[str, Any]:
    recorded: dict[str, Any] = json.loads(instruction_counts.BASELINE.read_text(encoding="utf-8"))
    return recorded


@pytest.fixture(scope="module")
def program() -> Path:
    try:
        instruction_counts.toolchain()
        return instruction_counts.build()
    except Unavailable as reason:
        pytest.skip(str(reason))


@pytest.fixture(scope="module")
def counts(program: Path) -> dict[str, float]:
    try:
        return {call: total(parts) for call, parts in count_all(program).items()}
    except Unavailable as reason:
        pytest.skip(str(reason))


def test_instruction_counts_are_within_the_baseline(
    counts: dict[str, float], baseline: dict[str, Any]
) -> None:
    try:
        comparable(baseline)
    except Unavailable as reason:
        pytest.skip(f"the baseline does not hold here: {reason}")
    found = compare(counts, baseline)
    assert not found, "\n".join(found)


def test_instruction_counts_of_two_runs_agree(counts: dict[str, float], program: Path) -> None:
    assert total(count(program, "stanley steer")) == counts["stanley steer"]


def test_by_part_adds_a_function_s_own_instructions_to_the_module_they_were_written_in() -> None:
    text = """fl=(1) /x/rust/core/src/laws/preview_pop/limited.rs
fn=(7) popsteer_core::laws::preview_pop::PreviewPop::choose
+3 100
fi=(2) /x/rust/core/src/path/view.rs
-1 20
fe=(3) /rustc/library/core/src/slice/mod.rs
* 5
cfi=(2)
cfn=(9) sincos
calls=3 40
* 1000
12 1
fl=(4) ./math/s_sin.c
fn=(9)
+1 700
"""
    assert instruction_counts.by_part(text) == {
        "limits": 100, "path": 20, "rest of the law": 6, "sin, exp, ...": 700
    }  # fmt: skip


def test_instruction_counts_of_more_work_are_reported(counts: dict[str, float]) -> None:
    # `step` is `steer` and the errors besides: as a fault planted in `steer` it must be seen.
    recorded = {"tolerance": instruction_counts.TOLERANCE, "counts": counts}
    planted = counts | {"pop steer": counts["pop step"]}
    (line,) = compare(planted, recorded)
    assert line.startswith("pop steer: ")


def test_baseline_holds_every_call_and_what_it_hangs_on(baseline: dict[str, Any]) -> None:
    assert set(baseline["counts"]) == set(instruction_counts.CALLS)
    assert baseline["tolerance"] == instruction_counts.TOLERANCE
    assert baseline["toolchain"]["rustc"].startswith("rustc ")


@looped(
    ("counted", "lines"),
    [(100.0, 0), (103.0, 0), (103.1, 1), (50.0, 0), (math.nan, 1)],
)
def test_compare_tells_what_is_beyond_the_tolerance(counted: float, lines: int) -> None:
    recorded = {"tolerance": 0.03, "counts": {"pop steer": 100.0}}
    assert len(compare({"pop steer": counted}, recorded)) == lines


def test_comparable_another_compiler_is_named(
    baseline: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    other = baseline["toolchain"] | {"rustc": "rustc 1.0.0"}
    monkeypatch.setattr(instruction_counts, "toolchain", lambda: other)
    with pytest.raises(Unavailable, match=r"^rustc is 'rustc 1\.0\.0', the baseline's"):
        comparable(baseline)


def test_count_all_without_valgrind_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(Unavailable, match="valgrind is not on the path"):
        count_all(tmp_path / "steps")
