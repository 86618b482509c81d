from __future__ import annotations

from typing import Any

import pytest

import popsteer
from popsteer import controllers, lab, presets, sim, vehicles
from popsteer.errors import ConfigError
from tests.closed_loop.paths import track

PAPER = vehicles.get("paper")
NAMES = ("default", "paper", "published-code", "reproduction")


@pytest.mark.parametrize("law", controllers.names())
def test_presets_of_each_law_are_of_its_class(law: str) -> None:
    assert presets.names(law) == NAMES
    for name in NAMES:
        assert type(presets.get(law, name)) is controllers.get(law).params


def test_presets_where_paper_and_code_differ_hold_both() -> None:
    def held(law: str, name: str, params: Any) -> bool:
        given: dict[str, Any] = presets.get(law, name).as_dict()
        return given == pytest.approx(params.resolved(PAPER).as_dict(), rel=1e-15)

    assert held("pid", "paper", popsteer.PidParams(integral_with_dt=False, smoothing_length=0.0))
    assert held(
        "pid", "published-code", popsteer.PidParams(kp=0.12, ki=0.01, kd=0.48, smoothing_length=0.0)
    )
    assert held("pop", "paper", popsteer.PopParams(exact_lookahead=False))
    assert presets.get("pop", "default") == popsteer.PopParams(exact_lookahead=True)
    paper = popsteer.PurePursuitParams(min_lookahead=0.0, exact_lookahead=False)
    assert held("pure-pursuit", "paper", paper)
    code = popsteer.PurePursuitParams(alpha_by_arccos=True, exact_lookahead=False)
    assert held("pure-pursuit", "published-code", code)
    assert held(
        "stanley",
        "published-code",
        popsteer.StanleyParams(heading_behind=True, smoothing_length=0.0),
    )


def test_preset_or_law_unknown_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="unknown preset 'mine'; known: default, paper"):
        presets.get("pop", "mine")
    with pytest.raises(ConfigError, match="unknown controller 'mpc'; known: pid"):
        presets.get("mpc", "paper")


@pytest.mark.parametrize("law", ["pid", "pure-pursuit", "stanley", "pop"])
def test_presets_of_the_paper_are_absolute_numbers(law: str) -> None:
    small = popsteer.Vehicle(wheelbase=0.3)
    for name in NAMES[1:]:
        params = presets.get(law, name)
        assert params.resolved(small) == params
    default = presets.get(law, "default")
    assert default.resolved(small) != default.resolved(PAPER)


def test_vehicle_of_each_plant_is_the_one_that_is_named_so() -> None:
    for name in sim.plant_names():
        assert sim.vehicle_of(name) == vehicles.get(name)
    assert sim.vehicle_of(sim.KinematicBicycle(popsteer.Vehicle())) == popsteer.Vehicle()


def test_comparison_by_mapping_drives_the_params_given() -> None:
    slow = popsteer.PopParams(lookahead_gain=0.8)
    path = track("slalom")
    given = lab.compare.run(path, {"pop": slow}).runs["pop"]
    assert given.params["lookahead_gain"] == 0.8
    assert given.metrics != lab.compare.run(path, ["pop"]).runs["pop"].metrics


@pytest.mark.parametrize("name", ["no-such-law", "pop,pid"])
def test_comparison_with_unknown_law_drives_nothing(name: str) -> None:
    driven: list[str] = []
    with pytest.raises(ConfigError, match="unknown controller"):
        lab.compare.run(
            track("slalom"), ["pop", name], progress=lambda law, share: driven.append(law)
        )
    assert not driven
