"""Many vehicles in one call: the answers of single steps, and what is refused."""

from __future__ import annotations

import copy
import math
import os
import pickle
import subprocess
import sys
import textwrap
import threading
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import ConfigError, InputError, Status
from tests.helpers import looped
from tests.parity.laws import LATERAL, Law

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

DT = 0.05
CAR = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.2, dead_time=0.12, max_steer_rate=0.5)
# Parameters of one's own for every other vehicle; every third has a car of its own too.
OWN: dict[str, dict[str, Any]] = {
    "Pop": {"candidate_count": 11, "min_lookahead": 8.0},
    "PreviewPop": {"horizon": 2.0, "heading_cost": 1.5},
    "Pid": {"kp": 0.4, "buffer_length": 7},
    "PurePursuit": {"min_lookahead": 7.0, "alpha_by_arccos": True},
    "Stanley": {"cross_track_gain": 0.7, "softening": 0.1},
}
FIELDS = ("x", "y", "yaw", "speed")
NUMBERS = (
    "steer",
    "cross_track_error",
    "heading_error",
    "predicted_cross_track_error",
    "predicted_heading_error",
    "target",
    "distance_to_stop",
)

each_law = looped("law", LATERAL)


def _paths() -> list[popsteer.Path]:
    x = np.arange(120.0)
    bends = [np.column_stack([x, 4.0 * np.sin(x / length)]) for length in (9.0, 20.0)]
    backwards = popsteer.Path(bends[0][::-1], reverse=[True] * 120)
    closed = popsteer.Path(bends[0], closed=True)
    return [*(popsteer.Path(xy) for xy in bends), closed, backwards]


def _controllers(law: Law, count: int) -> list[Any]:
    paths, controller = _paths(), getattr(popsteer, law.name)
    own = getattr(popsteer, law.params_name)(**OWN[law.name])
    return [
        controller(paths[k % 4], None if k % 3 else CAR, own if k % 2 else None)
        for k in range(count)
    ]


def _drives(count: int, steps: int) -> Iterator[tuple[Floats, Floats, Floats, Floats]]:
    random = np.random.default_rng(5)
    x, y = random.uniform(0.0, 60.0, count), random.uniform(-6.0, 6.0, count)
    yaw, speed = random.uniform(-1.0, 1.0, count), random.uniform(-1.0, 20.0, count)
    for _ in range(steps):
        yield x, y, yaw, speed
        x, y = x + DT * speed * np.cos(yaw), y + DT * speed * np.sin(yaw)
        yaw = yaw + random.uniform(-0.05, 0.05, count)


def _bits(array: Any) -> bytes:
    return np.asarray(array, dtype=np.float64).tobytes()


@each_law
@looped("count", [7, 600])
def test_batch_of_each_law_gives_the_bits_of_single_steps(law: Law, count: int) -> None:
    controllers = _controllers(law, count)
    controllers[3].step(30.0, 1.0, 0.2, 6.0, DT)  # the present state goes along
    batch = popsteer.Batch(controllers)
    angles = popsteer.Batch(iter(controllers))
    for poses in _drives(count, 50):
        commands = batch.step(*poses, DT)
        singles = [
            controller.step(*pose, DT)
            for controller, *pose in zip(controllers, *(a.tolist() for a in poses), strict=True)
        ]
        for field in (*NUMBERS, "reverse", "status"):
            wanted = [getattr(single, field) for single in singles]
            assert _bits(getattr(commands, field)) == _bits(wanted), field
        assert (commands.status.dtype.name, commands.reverse.dtype.name) == ("uint32", "bool")
        assert _bits(angles.steer(*poses, DT)) == _bits(commands.steer)
    assert batch.states == angles.states == [controller.state for controller in controllers]


@each_law
def test_batch_leaves_its_controllers_alone(law: Law) -> None:
    controllers = _controllers(law, 5)
    before = [controller.state for controller in controllers]
    batch = popsteer.Batch(controllers)
    batch.steer(*next(_drives(5, 1)), DT)
    assert [controller.state for controller in controllers] == before != batch.states


@each_law
def test_batch_reset_forgets_every_step(law: Law) -> None:
    controllers = _controllers(law, 4)
    fresh = [controller.state for controller in controllers]
    controllers[0].step(30.0, 1.0, 0.2, 6.0, DT)
    batch = popsteer.Batch(controllers)
    assert batch.states != fresh
    batch.reset()
    assert batch.states == fresh


def test_batch_of_copies_is_that_of_a_list() -> None:
    pop = popsteer.Pop(_paths()[0])
    pop.step(30.0, 1.0, 0.2, 6.0, DT)
    copies, listed = popsteer.Batch(pop, 300), popsteer.Batch([pop] * 300)
    poses = next(_drives(300, 1))
    assert len(copies) == 300
    assert copies.states == listed.states == [pop.state] * 300
    assert _bits(copies.steer(*poses, DT)) == _bits(listed.steer(*poses, DT))
    assert len(popsteer.Batch(pop)) == 1
    assert repr(copies) == "<Batch of 300 vehicles>"


@looped("vehicles", [[], (popsteer.Pop(_paths()[0]), 0)])
def test_batch_of_none_answers_with_empty_arrays(vehicles: Any) -> None:
    batch = popsteer.Batch(*vehicles) if vehicles else popsteer.Batch([])
    assert len(batch) == 0
    assert batch.states == []
    assert batch.steer([], [], [], [], DT).shape == (0,)
    commands = batch.step([], [], [], [], DT)
    assert (len(commands), commands.target.shape, commands.status.shape) == (0, (0, 2), (0,))
    with pytest.raises(InputError, match="dt must be"):
        batch.steer([], [], [], [], math.nan)


def _three() -> tuple[popsteer.Batch, dict[str, Any]]:
    batch = popsteer.Batch(popsteer.Pop(_paths()[0]), 3)
    arrays = dict(zip(FIELDS, next(_drives(3, 1)), strict=True))
    return batch, arrays


@looped("field", FIELDS)
def test_batch_array_of_another_kind_is_read_where_nothing_is_lost(field: str) -> None:
    batch, arrays = _three()
    arrays = {name: np.round(array) for name, array in arrays.items()}
    wanted = batch.steer(**arrays, dt=DT)
    whole = arrays[field]
    wide = np.zeros((3, 4))
    wide[:, 1] = whole
    for same in (
        whole.astype(np.float32),
        whole.astype(np.float16),
        whole.astype(np.int64),
        whole.astype(">f8"),
        wide[:, 1],
        whole[::-1].copy()[::-1],
        whole.tolist(),
    ):
        batch.reset()
        assert _bits(batch.steer(**{**arrays, field: same}, dt=DT)) == _bits(wanted)


@looped("field", FIELDS)
@looped(
    ("value", "requirement", "shown"),
    [
        (np.zeros(2), "of shape (3,)", (2,)),
        (np.zeros(4, dtype=np.float32), "of shape (3,)", (4,)),
        (np.zeros((3, 1)), "of shape (3,)", (3, 1)),
        (np.float64(0.0), "of shape (3,)", ()),
        ([], "of shape (3,)", (0,)),
        (np.zeros(3, dtype=object), "of a dtype that becomes", np.dtype(object)),
        (np.array(["0", "1", "2"]), "of a dtype that becomes", np.dtype("U1")),
        (np.zeros(3, dtype=complex), "of a dtype that becomes", np.dtype(complex)),
        ([0.0, None, 0.0], "of a dtype that becomes", np.dtype(object)),
        (None, "of a dtype that becomes", np.dtype(object)),
        ([[0.0], [0.0, 1.0], []], "an array of numbers", list),
    ],
)
def test_batch_array_of_wrong_shape_or_dtype_is_refused_by_name(
    field: str, value: Any, requirement: str, shown: Any
) -> None:
    batch, arrays = _three()
    before = batch.states
    for call in (batch.steer, batch.step):
        with pytest.raises(InputError) as caught:
            call(**{**arrays, field: value}, dt=DT, on_error="nan")
        assert (caught.value.field, caught.value.value) == (field, shown)
        assert caught.value.requirement.startswith(requirement)
    assert batch.states == before


@each_law
@looped("count", [7, 600])
def test_batch_with_one_bad_vehicle_refuses_all_and_names_it(law: Law, count: int) -> None:
    batch = popsteer.Batch(_controllers(law, count))
    poses: dict[str, Any] = dict(zip(FIELDS, next(_drives(count, 1)), strict=True))
    batch.steer(**poses, dt=DT)
    before = batch.states
    for field, bad in (("x", np.inf), ("y", 1.1e9), ("yaw", -np.inf), ("speed", np.nan)):
        spoilt = poses[field].copy()
        spoilt[3] = bad
        for call in (batch.steer, batch.step):
            with pytest.raises(InputError) as caught:
                call(**{**poses, field: spoilt}, dt=DT)
            assert caught.value.field == f"{field}[3]"
            assert caught.value.value == bad or np.isnan(bad)
    assert batch.states == before


def _without_time(state: popsteer.State) -> popsteer.State:
    return state.replace(held=0, held_time=0.0)


@each_law
def test_batch_with_bad_vehicles_marked_steps_the_others(law: Law) -> None:
    batch, other = (popsteer.Batch(_controllers(law, 300)) for _ in range(2))
    x, y, yaw, speed = next(_drives(300, 1))
    batch.steer(x, y, yaw, speed, DT)
    other.steer(x, y, yaw, speed, DT)
    before = batch.states
    spoilt = speed.copy()
    spoilt[[3, 299]] = np.nan, 1e5
    marked = batch.step(x, y, yaw, spoilt, DT, on_error="nan")
    whole = other.step(x, y, yaw, speed, DT)
    bad = np.isin(np.arange(300), [3, 299])
    assert ((marked.status == Status.INPUT_HELD) == bad).all()
    # These two back up, and are said to still.
    assert marked.reverse[bad].all()
    assert (marked.reverse == whole.reverse).all()
    for field in NUMBERS:
        column = getattr(marked, field)
        assert np.isnan(column[bad]).all()
        assert _bits(column[~bad]) == _bits(getattr(whole, field)[~bad])
    kept = [before[k] if bad[k] else state for k, state in enumerate(other.states)]
    # Their next steps count the time.
    assert all((batch.states[k].held, batch.states[k].held_time) == (1, DT) for k in (3, 299))
    assert list(map(_without_time, batch.states)) == list(map(_without_time, kept))
    angles = batch.steer(x, y, yaw, spoilt, DT, on_error="nan")
    assert (np.isnan(angles) == bad).all()


@each_law
def test_batch_that_holds_answers_as_each_controller_that_holds(law: Law) -> None:
    controllers = _controllers(law, 300)
    batch, angles = popsteer.Batch(controllers), popsteer.Batch(controllers)
    random = np.random.default_rng(3)
    lost = 0
    for poses in _drives(300, 8):
        x, y, yaw, speed = spoilt = tuple(pose.copy() for pose in poses)
        for pose in spoilt:
            pose[random.random(300) < 0.2] = random.choice([np.nan, np.inf, 1e10])
        dt = DT if random.random() < 0.8 else random.choice([np.nan, 0.0, -60.0, 2000.0])
        commands = batch.step(x, y, yaw, speed, dt, on_error="hold", hold_limit=2)
        singles = [
            controller.step_or_hold(*pose, dt, 2)
            for controller, *pose in zip(controllers, *(a.tolist() for a in spoilt), strict=True)
        ]
        for field in (*NUMBERS, "reverse", "status"):
            wanted = [getattr(single, field) for single in singles]
            assert _bits(getattr(commands, field)) == _bits(wanted), field
        held = angles.steer(x, y, yaw, speed, dt, on_error="hold", hold_limit=2)
        assert _bits(held) == _bits(commands.steer)
        lost += int(np.count_nonzero(commands.status == Status.INPUT_LOST))
    assert lost > 10
    assert batch.states == angles.states == [controller.state for controller in controllers]


@each_law
@looped("duplicate", [copy.deepcopy, lambda b: pickle.loads(pickle.dumps(b))])
def test_batch_copied_or_pickled_goes_on_alike(law: Law, duplicate: Any) -> None:
    controllers = _controllers(law, 7)
    first, second = _drives(7, 2)
    for batch in (popsteer.Batch(controllers), popsteer.Batch(controllers[3], 7)):
        batch.step(*first, DT)
        twin = duplicate(batch)
        assert twin.states == batch.states
        one, other = (each.step(*second, DT) for each in (batch, twin))
        assert _bits(one.steer) == _bits(other.steer)
        assert twin.states == batch.states
        twin.reset()
        batch.reset()
        assert twin.states == batch.states
        for name in ("steer", "target", "reverse", "status"):
            assert _bits(getattr(duplicate(one), name)) == _bits(getattr(one, name))


@each_law
def test_batch_on_other_paths_answers_as_each_controller_on_them(law: Law) -> None:
    controllers = _controllers(law, 7)
    batch = popsteer.Batch(controllers)
    paths = [popsteer.Path(np.column_stack((path.x + 0.1, path.y + 0.6))) for path in _paths()[:2]]
    drives = list(_drives(7, 4))

    def step() -> None:
        x, y, yaw, speed = drives.pop()
        poses = zip(*(a.tolist() for a in (x, y, yaw, speed)), strict=True)
        singles = [c.steer(*pose, DT) for c, pose in zip(controllers, poses, strict=True)]
        assert _bits(batch.steer(x, y, yaw, speed, DT)) == _bits(singles)
        assert batch.states == [controller.state for controller in controllers]

    step()
    for controller in controllers:
        controller.set_path(paths[0])
    batch.set_path(paths[0])
    step()
    for k, path in ((1, paths[0]), (4, paths[1])):
        controllers[k].set_path(path)
    batch.set_path(paths, vehicles=[1, 4])
    step()
    batch = pickle.loads(pickle.dumps(batch))
    step()
    before = batch.states
    for given, vehicles in ((paths, None), (paths[:1], [1, 2]), (paths[0], [7]), (paths[0], [-1])):
        with pytest.raises(InputError, match=r"path|vehicles"):
            batch.set_path(given, vehicles=vehicles)
    assert batch.states == before


def test_batch_of_none_copied_is_one_of_none() -> None:
    for batch in (popsteer.Batch([]), popsteer.Batch(popsteer.Pop(_paths()[0]), 0)):
        assert len(copy.deepcopy(batch)) == 0


def test_batch_is_given_as_many_states_as_vehicles() -> None:
    batch, _ = _three()
    before = batch.states
    with pytest.raises(ValueError, match="3 vehicles has 3 states, got 2"):
        batch.__setstate__((before[:2], []))
    wrong = [*before[:2], before[2].replace(steer=9.0)]
    with pytest.raises(InputError, match="steer must be"):
        batch.__setstate__((wrong, []))
    assert batch.states == before


def test_command_batch_of_unequal_columns_is_refused() -> None:
    batch, arrays = _three()
    columns = batch.step(**arrays, dt=DT).__getnewargs_ex__()[1]
    for name, column in columns.items():
        with pytest.raises(ValueError, match="equally long"):
            popsteer.CommandBatch(**{**columns, name: column[:2]})


@looped("dt", [math.nan, -math.inf, 10**400])
@looped("on_error", ["raise", "nan"])
def test_batch_with_bad_dt_is_refused_in_any_case(dt: float, on_error: Any) -> None:
    batch, arrays = _three()
    before = batch.states
    with pytest.raises(InputError) as caught:
        batch.steer(**arrays, dt=dt, on_error=on_error)
    assert caught.value.field == "dt"
    assert batch.states == before


@each_law
@looped("on_error", ["raise", "nan"])
def test_batch_in_no_time_answers_as_each_controller(law: Law, on_error: Any) -> None:
    controllers = _controllers(law, 300)
    batch, angles = popsteer.Batch(controllers), popsteer.Batch(controllers)
    for poses, dt in zip(_drives(300, 14), [DT, -60.0, DT, *[0.0] * 11], strict=True):
        commands = batch.step(*poses, dt, on_error=on_error)
        each = zip(controllers, *(pose.tolist() for pose in poses), strict=True)
        singles = [controller.step(*pose, dt) for controller, *pose in each]
        for field in (*NUMBERS, "reverse", "status"):
            wanted = [getattr(single, field) for single in singles]
            assert _bits(getattr(commands, field)) == _bits(wanted), field
        assert _bits(angles.steer(*poses, dt, on_error=on_error)) == _bits(commands.steer)
    assert (commands.status == Status.INPUT_LOST).all()
    assert batch.states == angles.states == [controller.state for controller in controllers]


def test_batch_with_unknown_on_error_lists_the_known() -> None:
    batch, arrays = _three()
    with pytest.raises(ConfigError, match="unknown on_error 'skip'; known: raise, nan, hold"):
        batch.steer(**arrays, dt=DT, on_error="skip")  # type: ignore[arg-type]


def test_batch_of_mixed_or_foreign_controllers_names_the_first() -> None:
    path = _paths()[0]
    pop, pid = popsteer.Pop(path), popsteer.Pid(path)
    of_first = r"controllers\[2\] must be of the first's class Pop, got .*Pid"
    for vehicles, said in (
        ([pop, pop, pid], of_first),
        ([pid, "pop"], r"controllers\[1\] must be of the first's class Pid, got .*str"),
        ([None], r"controllers\[0\] must be a controller of popsteer, got .*NoneType"),
        (3, r"controllers\[0\] must be a controller of popsteer, got .*int"),
    ):
        with pytest.raises(TypeError, match=said):
            popsteer.Batch(vehicles)  # type: ignore[arg-type]


@looped("count", [-1, 10_000_001, 10**30])
def test_batch_with_bad_count_is_refused(count: int) -> None:
    pop = popsteer.Pop(_paths()[0])
    with pytest.raises(ConfigError, match=r"count must be a count in \[0, 10000000\]"):
        popsteer.Batch(pop, count)
    with pytest.raises(TypeError, match="count goes with a single controller"):
        popsteer.Batch([pop], 1)


def test_batch_releases_the_lock_of_the_interpreter() -> None:
    count = 50_000
    # The controller whose steps take longest: a machine of many cores shares them.
    batch = popsteer.Batch(popsteer.PreviewPop(_paths()[0]), count)
    poses = next(_drives(count, 1))
    ticks, stop = 0, threading.Event()

    def tick() -> None:
        nonlocal ticks
        while not stop.is_set():
            ticks += 1
            time.sleep(1e-4)

    other = threading.Thread(target=tick)
    interval = sys.getswitchinterval()
    # Nobody is made to hand the lock over: the other thread gets it where it is given up alone.
    sys.setswitchinterval(100.0)
    try:
        other.start()
        # numpy gives it up as well, a moment for each array it makes: one tick says nothing yet.
        most = 0
        for _ in range(1000):
            before = ticks
            batch.steer(*poses, DT)
            most = max(most, ticks - before)
            if most >= 5:
                break
        assert most >= 5
    finally:
        stop.set()
        sys.setswitchinterval(interval)
        other.join()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_batch_in_a_forked_process_goes_on() -> None:
    script = """
        import os, signal, warnings
        import numpy as np
        import popsteer

        warnings.simplefilter("ignore")  # forking beside threads is what is tried here
        path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
        zeros = np.zeros(5000)
        pop = popsteer.Pop(path)
        step = lambda: popsteer.Batch(pop, 5000).steer(zeros, zeros, zeros, zeros, 0.1)
        before = step()
        child = os.fork()
        if child == 0:
            signal.alarm(30)  # lest it wait for ever
            os._exit(0 if np.array_equal(step(), before) else 1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    """
    subprocess.run([sys.executable, "-c", textwrap.dedent(script)], check=True, timeout=60)
