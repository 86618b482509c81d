from __future__ import annotations

import pytest

import popsteer
from popsteer import laws, presets, sim, study
from popsteer.errors import ConfigError
from tests.closed_loop.paths import track

NAMES = ("default", "paper", "published-code", "reproduction")


@pytest.mark.parametrize("law", laws.names())
def test_presets_of_each_law_are_of_its_class_and_leave_the_vehicle_open(law: str) -> None:
    assert presets.names(law) == NAMES
    for name in NAMES:
        params = presets.get(law, name)
        assert type(params) is laws.get(law).params
        assert params.reference_offset is None


def test_presets_where_paper_and_code_differ_hold_both() -> None:
    assert presets.get("pid", "paper") == popsteer.PidParams(integral_with_dt=False)
    assert presets.get("pid", "published-code") == popsteer.PidParams(kp=0.12, ki=0.01, kd=0.48)
    assert presets.get("pop", "paper") == popsteer.PopParams(exact_lookahead=False)
    assert presets.get("pop", "default") == popsteer.PopParams(exact_lookahead=True)
    assert presets.get("pure-pursuit", "paper") == popsteer.PurePursuitParams(
        min_lookahead=0.0, exact_lookahead=False
    )
    assert presets.get("pure-pursuit", "published-code") == popsteer.PurePursuitParams(
        alpha_by_arccos=True, exact_lookahead=False
    )
    assert presets.get("stanley", "published-code") == popsteer.StanleyParams(heading_behind=True)


def test_preset_or_law_unknown_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="unknown preset 'mine'; known: default, paper"):
        presets.get("pop", "mine")
    with pytest.raises(ConfigError, match="unknown law 'mpc'; known: bang-bang, pid"):
        presets.get("mpc", "paper")


@pytest.mark.parametrize("plant", sim.plant_names())
def test_fitted_params_have_the_plants_axle_and_wheelbase(plant: str) -> None:
    at = sim.geometry(plant)
    front = sim.fitted(popsteer.PopParams(wheelbase=9.0), plant)
    rear = sim.fitted(popsteer.PurePursuitParams(wheelbase=9.0), plant)
    assert (front.reference_offset, front.wheelbase) == (at.front_offset, at.wheelbase)
    assert (rear.reference_offset, rear.wheelbase) == (at.rear_offset, at.wheelbase)


def test_fitted_params_of_a_bicycle_follow_its_own_wheelbase() -> None:
    fitted = sim.fitted(popsteer.PidParams(), sim.KinematicBicycle(wheelbase=2.5))
    assert (fitted.reference_offset, fitted.wheelbase) == (2.5, 2.5)


def test_geometry_of_each_plant_is_what_the_simulation_starts_from() -> None:
    path = track("straight")
    own: list[sim.Plant] = [sim.CarlaIdentified(), sim.KinematicBicycle(wheelbase=2.0)]
    for plant in [*sim.plant_names(), *own]:
        simulation = sim.Simulation(path, plant, start=(10.0, 0.0, 0.0))
        x, *_ = simulation.vehicle
        assert 10.0 - x == pytest.approx(sim.geometry(plant).front_offset, abs=1e-12)


def test_comparison_by_mapping_drives_the_params_given() -> None:
    slow = popsteer.PopParams(lookahead_gain=0.8)
    path = track("slalom")
    given = study.compare(path, {"pop": slow}).runs["pop"]
    assert given.params["lookahead_gain"] == 0.8
    assert given.metrics != study.compare(path, ["pop"]).runs["pop"].metrics


@pytest.mark.parametrize("name", ["no-such-law", "pop,pid"])
def test_comparison_with_unknown_law_drives_nothing(name: str) -> None:
    driven: list[str] = []
    with pytest.raises(ConfigError, match="unknown law"):
        study.compare(
            track("slalom"), ["pop", name], progress=lambda law, share: driven.append(law)
        )
    assert not driven
