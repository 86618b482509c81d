"""Tuning in TOML files: what is saved is loaded, and what is wrong is named."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

import popsteer
from popsteer import controllers, presets
from popsteer.errors import ConfigError
from popsteer.params_file import load_all

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize("name", controllers.names())
@pytest.mark.parametrize("preset", ["default", "reproduction"])
def test_saved_params_load_equal(tmp_path: Path, name: str, preset: str) -> None:
    params = presets.get(name, preset)
    file = tmp_path / "new" / "tuned.toml"
    params.save(file)
    assert type(params).load(file) == params
    assert load_all(file) == {name: params}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[pop]\nlookahead_gain = -1", r"\[pop\] lookahead_gain must be in .*, got -1"),
        ("[pop]\nlookahead = 1", r"unknown key of \[pop\] 'lookahead'; known: lookahead_gain"),
        ("[pop]\ncandidate_count = 2.5", r"pop.candidate_count must be a whole number, got 2.5"),
        ("[pop]\nexact_lookahead = 1", r"pop.exact_lookahead must be true or false, got 1"),
        ("[pop]\nlookahead_gain = true", r"pop.lookahead_gain must be a number, got True"),
        ("[mpc]\nhorizon = 1", r"unknown table 'mpc'; known: pid"),
        ("lookahead_gain = 1", r"unknown table 'lookahead_gain'"),
        ("pop = 1", r"pop must be a table of parameters, \[pop\], got 1"),
        ("", r"tables must be at least one of \[pid\]"),
        ("[pop", r"not TOML"),
    ],
)
def test_wrong_file_is_refused_by_file_key_and_value(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "tuned.toml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=said) as raised:
        load_all(file)
    assert str(raised.value).startswith(f"{file}: ")


def test_params_of_another_controller_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "tuned.toml"
    popsteer.PopParams().save(file)
    with pytest.raises(ConfigError, match="controller must be pid, whose parameters these are"):
        popsteer.PidParams.load(file)
    with pytest.raises(ConfigError, match="No such file"):
        popsteer.PidParams.load(tmp_path / "nowhere.toml")
