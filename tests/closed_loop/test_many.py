"""Many runs in one call: those of single runs, whatever the threads."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import controllers, sim
from popsteer.errors import ConfigError, InputError, PathError
from tests.closed_loop.paths import track

if TYPE_CHECKING:
    from popsteer.sim.geometry import CorePlant

NOISE = sim.Noise(position=0.1, yaw=0.005, speed=0.1)
PLANTS: list[CorePlant] = [
    *sim.plant_names(),
    sim.CarlaIdentified(sim.vehicle_of("carla-identified").replace(steer_lag=0.2)),
    sim.KinematicBicycle(popsteer.Vehicle(wheelbase=2.0, rear_axle=-1.0, dead_time=0.1)),
]
POSE = (0.0, 1.0, 0.1)


def _bits(figures: dict[str, Any]) -> dict[str, bytes]:
    return {name: np.asarray(figure).tobytes() for name, figure in figures.items()}


def _pops(count: int) -> list[popsteer.Pop]:
    return [popsteer.Pop(track("slalom"))] * count


@pytest.mark.parametrize("name", controllers.names())
@pytest.mark.parametrize("longitudinal", [None, popsteer.SpeedPid()], ids=["coupled", "speed"])
def test_many_runs_without_noise_are_single_runs_bit_for_bit(name: str, longitudinal: Any) -> None:
    drivers = [controllers.get(name).controller(track(each)) for each in ("slalom", "figure-eight")]
    settings = sim.Settings(time_limit=30.0, substeps=4)
    pairs = [(law, plant) for law in drivers for plant in PLANTS]
    singles = [
        sim.run(law, plant, longitudinal=longitudinal, settings=settings).metrics
        for law, plant in pairs
    ]
    many = sim.run_many(
        [law for law, _ in pairs],
        [plant for _, plant in pairs],
        longitudinal=longitudinal,
        settings=settings,
    )
    assert many.keys() == vars(singles[0]).keys()
    for figure, column in many.items():
        wanted = np.array([getattr(single, figure) for single in singles], dtype=column.dtype)
        assert column.tobytes() == wanted.tobytes(), figure


def test_many_runs_with_seeds_of_their_own_are_single_runs_bit_for_bit() -> None:
    noises = [NOISE, sim.Noise(yaw=0.01), sim.Noise()]
    many = sim.run_many(_pops(3), noise=noises, seed=[5, 6, 7])
    for k, noise in enumerate(noises):
        single = sim.run(_pops(1)[0], noise=noise, seed=5 + k).metrics
        assert all(many[name][k] == figure for name, figure in vars(single).items())
    with pytest.raises(ConfigError, match="noise, seed must be single or of one length"):
        sim.run_many(_pops(1)[0], noise=noises, seed=[5, 6])


def test_many_runs_from_starts_and_speeds_are_those_of_simulations() -> None:
    path = track("slalom")
    law = popsteer.Stanley(path, sim.vehicle_of("carla-identified"))
    starts, speeds = [(0.0, 0.3 * k, 0.02 * k) for k in range(4)], [0.0, 3.0, 6.0, 9.0]
    many = sim.run_many(law, start=starts, speed=speeds)
    for k, (start, speed) in enumerate(zip(starts, speeds, strict=True)):
        simulation = sim.Simulation(path, start=start, speed=speed)
        simulation.drive(law)
        one = {name: column[k].item() for name, column in many.items()}
        assert _bits(one) == _bits(simulation.metrics())


def test_many_runs_one_thing_stands_for_all() -> None:
    pop = _pops(1)[0]
    listed = sim.run_many([pop] * 3, ["carla-identified"] * 3, start=[POSE] * 3, speed=[2.0] * 3)
    for alike in (
        sim.run_many([pop] * 3, start=POSE, speed=2.0),
        sim.run_many(pop, ["carla-identified"] * 3, start=POSE, speed=2.0),
        sim.run_many(pop, start=np.array([POSE] * 3), speed=2.0),
        sim.run_many(pop, start=POSE, speed=np.full(3, 2.0)),
    ):
        assert _bits(alike) == _bits(listed)
    single = sim.run_many(pop, start=POSE, speed=2.0)
    assert {name: column.shape for name, column in single.items()} == dict.fromkeys(listed, (1,))


def test_many_runs_of_none_are_empty_and_done() -> None:
    shares: list[float] = []
    many = sim.run_many([], progress=shares.append)
    assert {column.shape for column in many.values()} == {(0,)}
    assert shares[-1] == 1.0


def test_many_runs_leave_the_state_of_the_law_alone() -> None:
    pop = _pops(1)[0]
    pop.step(3.0, 1.0, 0.2, 5.0, 0.05)
    before = pop.state
    first = sim.run_many(pop)
    assert pop.state == before
    pop.reset()
    assert _bits(sim.run_many(pop)) == _bits(first)


def test_many_runs_same_seed_gives_the_same_bits_on_any_threads() -> None:
    one, two, five, shared = (
        sim.run_many(_pops(12), noise=NOISE, seed=7, threads=threads) for threads in (1, 2, 5, None)
    )
    assert _bits(one) == _bits(two) == _bits(five) == _bits(shared)
    assert one["finished"].all()


def test_many_runs_of_other_seeds_and_streams_differ() -> None:
    first, second = (sim.run_many(_pops(12), noise=NOISE, seed=seed) for seed in (7, 8))
    errors = np.concatenate([each["rms_cross_track_error"] for each in (first, second)])
    assert len(set(errors.tolist())) == 24


@pytest.mark.parametrize("field", ["position", "yaw", "speed"])
def test_many_runs_with_noise_of_each_kind_differ_from_those_without(field: str) -> None:
    silent = sim.run_many(_pops(1), noise=sim.Noise(), seed=3)
    noisy = sim.run_many(_pops(1), noise=sim.Noise(**{field: 0.01}), seed=3)
    assert _bits(silent) == _bits(sim.run_many(_pops(1)))
    assert _bits(noisy) != _bits(silent)


def test_noise_out_of_range_is_refused_by_name() -> None:
    for field in ("position", "yaw", "speed"):
        for bad in (-0.1, float("nan"), 1e4):
            with pytest.raises(ConfigError, match=f"{field} must be in"):
                sim.Noise(**{field: bad})
    assert sim.Noise().replace(yaw=0.1) == sim.Noise(yaw=0.1)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"controller": _pops(2), "plant": ["carla-identified"] * 3}, "controller, plant"),
        ({"controller": _pops(1), "start": [POSE, POSE]}, "controller, start"),
        ({"start": [POSE] * 2, "speed": [1.0]}, "start, speed"),
        ({"start": (0.0, 0.0)}, "start"),
        ({"start": [[POSE]]}, "start"),
        ({"start": "here"}, "start"),
        ({"speed": [[1.0]]}, "speed"),
        ({"plant": "hovercraft"}, "plant"),
        ({"plant": ["carla-identified", "hovercraft"]}, "plant"),
        ({"seed": -1}, "seed"),
        ({"seed": 2**64}, "seed"),
        ({"threads": 0}, "threads"),
        ({"threads": 1025}, "threads"),
    ],
)
def test_many_runs_with_bad_argument_is_refused_by_name(
    arguments: dict[str, Any], field: str
) -> None:
    with pytest.raises(ConfigError) as caught:
        sim.run_many(**{"controller": _pops(1)[0], **arguments})
    assert caught.value.field == field


def test_many_runs_with_bad_start_name_the_run() -> None:
    nan = float("nan")
    with pytest.raises(InputError) as caught:
        sim.run_many(_pops(1)[0], start=[POSE, (0.0, nan, 0.0)])
    assert caught.value.field == "y[1]"
    with pytest.raises(InputError) as caught:
        sim.run_many(_pops(4), speed=[0.0, 0.0, 1e5, 0.0])
    assert (caught.value.field, caught.value.value) == ("speed[2]", 1e5)


def test_many_runs_of_law_or_path_that_cannot_be_driven_are_refused() -> None:
    class Own:
        path = track("slalom")

    with pytest.raises(TypeError, match="controller 1 must be one of popsteer, got Own"):
        sim.run_many([*_pops(1), Own()])  # type: ignore[list-item]
    without = popsteer.Pop(popsteer.Path([(0.0, 0.0), (50.0, 0.0)]))
    with pytest.raises(PathError, match="path of controller 1 has no reference speeds"):
        sim.run_many([*_pops(1), without], longitudinal=popsteer.SpeedPid())
    with pytest.raises(TypeError, match="longitudinal must be"):
        sim.run_many(_pops(1), longitudinal=3)  # type: ignore[arg-type]


def test_many_runs_progress_grows_to_one() -> None:
    shares: list[float] = []
    sim.run_many(_pops(300), progress=shares.append, threads=1)
    assert shares == sorted(shares)
    assert all(0.0 <= share <= 1.0 for share in shares)
    assert shares[-1] == 1.0


# Hours of driving: a straight line of a million metres, ten thousand times.
ENDLESS = """
    import popsteer
    from popsteer import sim

    pop = popsteer.Pop(popsteer.Path([(0.0, 0.0), (1e6, 0.0)]))
    settings = sim.Settings(time_limit=1e6)
    runs = lambda progress: sim.run_many([pop] * 10_000, settings=settings, progress=progress)
"""


def test_many_runs_with_failing_progress_stop_and_raise_its_error() -> None:
    names: dict[str, Any] = {}
    exec(textwrap.dedent(ENDLESS), names)
    shares: list[float] = []

    def fail(share: float) -> None:
        shares.append(share)
        if len(shares) == 3:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        names["runs"](fail)
    assert len(shares) == 3
    assert shares[-1] < 0.5


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_many_runs_interrupted_stop_long_before_the_end() -> None:
    script = f"""{ENDLESS}
    shares = []
    def progress(share):
        shares.append(share)
        if len(shares) == 1:
            print("started", flush=True)

    try:
        runs(progress)
    except KeyboardInterrupt:
        print("interrupted", shares[-1], flush=True)
    """
    command = [sys.executable, "-c", textwrap.dedent(script)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "started\n"
            process.send_signal(signal.SIGINT)
            said, _ = process.communicate(timeout=60)
        finally:
            process.kill()
    word, share = said.split()
    assert (word, process.returncode) == ("interrupted", 0)
    assert float(share) < 0.5
