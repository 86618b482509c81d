"""The search for weights gives all controllers the same sets to try, their defaults first."""

from __future__ import annotations

import pytest

from popsteer import controllers
from popsteer.lab import opponents

pytest.importorskip("optuna")

from studies.opponents import SEARCHED, WIDTH, Searched


def test_search_tries_the_defaults_and_sets_about_them_and_keeps_the_least_last(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("studies.opponents.SETS", 4)
    each = Searched("pure-pursuit")
    begin = each.values(each.usual)
    tried = each.search()
    assert len(tried) == 4
    assert begin in [values for _, values in tried]
    assert tried[-1][0] == min(score for score, _ in tried) > 0.0
    for _, values in tried:
        for name, value in values.items():
            assert begin[name] / WIDTH <= value <= WIDTH * begin[name]


def test_search_has_two_weights_of_every_controller() -> None:
    named = {each.rpartition(":")[2] for each in opponents.names()}
    assert set(SEARCHED) == named | set(controllers.names())
    assert {len(fields) for fields in SEARCHED.values()} == {2}
