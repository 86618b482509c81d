"""Dead time, and the prediction through it: what `popsteer dead-time` promises."""

from __future__ import annotations

import numpy as np
import pytest

import popsteer
from popsteer import presets, sim
from popsteer.errors import ConfigError
from popsteer.report.dead_time import error_text
from popsteer.report.table import title_of
from popsteer.sim import Settings
from popsteer.study import DEAD_TIME_LAWS, DeadTimeRow, dead_times
from tests.closed_loop.page import line, table
from tests.closed_loop.paths import track
from tests.helpers import authors_data

RUNS = ("late", "predicted", "short", "long", "early", "later")

Rows = dict[str, DeadTimeRow]


@pytest.fixture(scope="module", params=["racetrack", "authors"])
def rows(request: pytest.FixtureRequest) -> tuple[str, Rows]:
    if request.param == "racetrack":
        found = dead_times(track("racetrack"))
    else:
        path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
        found = dead_times(path, start=(-183.8, 78.7, -1.574))
    return request.param, {row.law: row for row in found}


@pytest.mark.parametrize("law", DEAD_TIME_LAWS)
def test_dead_time_predicted_costs_at_most_a_twentieth(rows: tuple[str, Rows], law: str) -> None:
    row = rows[1][law]
    assert row.prompt.finished
    assert row.ratio(row.predicted) <= 1.05


@pytest.mark.parametrize("law", DEAD_TIME_LAWS)
@pytest.mark.parametrize("model", ["short", "long", "early", "later"])
def test_dead_time_predicted_by_a_wrong_model_costs_at_most_a_quarter(
    rows: tuple[str, Rows], law: str, model: str
) -> None:
    row = rows[1][law]
    assert row.ratio(getattr(row, model)) <= 1.25


@pytest.mark.parametrize("law", DEAD_TIME_LAWS)
def test_dead_time_with_nothing_done_costs_more(rows: tuple[str, Rows], law: str) -> None:
    row = rows[1][law]
    assert row.ratio(row.late) > max(1.02, row.ratio(row.predicted))
    assert row.late.finished is (law != "pop")


def test_page_table_of_dead_times_is_what_is_driven(rows: tuple[str, Rows]) -> None:
    name, found = rows
    lines = [
        line(
            title_of(row.law),
            f"{row.prompt.mean_abs_cross_track_error:.3f}",
            *(error_text(row, getattr(row, run)) for run in RUNS),
        )
        for row in found.values()
    ]
    assert table(f"dead time, {name}") == lines


def test_dead_time_without_learning_costs_more_where_the_model_is_wrong() -> None:
    learning = {row.law: row for row in dead_times(track("racetrack"), ["preview-pop"])}
    for row in dead_times(track("racetrack"), learning_time=0.0):
        assert row.ratio(row.predicted) <= 1.1
        if row.law == "preview-pop":
            worst = max(row.ratio(getattr(row, model)) for model in RUNS[2:])
            assert worst > 1.25
            assert row.ratio(row.short) > 1.1 * learning[row.law].ratio(learning[row.law].short)


@pytest.mark.parametrize("preset", ["default", "paper"])
def test_dead_time_with_other_presets_costs_as_little(preset: str) -> None:
    for row in dead_times(track("racetrack"), ["pop", "stanley", "pid"], preset=preset):
        assert row.ratio(row.predicted) <= 1.05
        assert max(row.ratio(getattr(row, model)) for model in RUNS[2:]) <= 1.25


@pytest.mark.parametrize("name", ["pop", "stanley", "preview-pop"])
def test_learning_in_noise_costs_little(name: str) -> None:
    """What is learnt from a noisy pose is no worse than what is not learnt."""

    class Noisy:
        """A law that sees the vehicle 0.1 m, 0.005 rad and 0.05 m/s off."""

        def __init__(self, law: popsteer.laws.Controller) -> None:
            self.path, self.reference_offset = law.path, law.reference_offset
            self._law, self._random = law, np.random.default_rng(7)

        def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
            off = self._random.normal(size=4).tolist()
            x, y = x + 0.1 * off[0], y + 0.1 * off[1]
            return self._law.steer(x, y, yaw + 0.005 * off[2], speed + 0.05 * off[3], dt)

    path = track("racetrack")
    params = sim.fitted(presets.get(name, "default"), "carla-identified")
    errors = []
    for learning_time in (0.0, 10.0):
        known = sim.actuator("carla-identified", 0.2).replace(learning_time=learning_time)
        law = popsteer.laws.get(name).controller(path, params, actuator=known)  # type: ignore[arg-type]
        done = sim.run(
            Noisy(law),
            path=path,
            steering=popsteer.Actuator(dead_time=0.2),
            settings=Settings(keep_records=False),
        )
        errors.append(done.metrics.mean_abs_cross_track_error)
    assert errors[1] <= 1.03 * errors[0]


def test_dead_time_of_nothing_or_too_little_is_refused() -> None:
    path = track("straight")
    with pytest.raises(ConfigError, match="laws must be at least one"):
        dead_times(path, [])
    with pytest.raises(ConfigError, match="dead_time"):
        dead_times(path, dead_time=0.01)
