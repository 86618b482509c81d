"""The parameter classes as a user meets them; their bounds are compared with the reference's."""

from __future__ import annotations

import copy
import inspect
import math
import pickle
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from popsteer import controllers, presets
from popsteer.errors import ConfigError
from popsteer.params_file import load_all
from tests.helpers import named
from tests.parity.laws import ALL, LATERAL, Law

if TYPE_CHECKING:
    from pathlib import Path

# The paper's Table 1 and Table 2 at its car of 3 m, and what the published code adds; but for the
# softening, whose 1e-5 m/s turns the wheels to the lock at rest.
PAPER: dict[str, dict[str, float]] = {
    "Pop": {"lookahead_gain": 0.2, "steer_span": math.radians(3), "candidate_count": 21},
    "Pid": {"kp": 0.25, "ki": 0.01, "kd": 0.2, "buffer_length": 500},
    "PurePursuit": {"lookahead_gain": 0.9, "min_lookahead": 10.0},
    "Stanley": {"cross_track_gain": 1.5, "speed_gain": 1.3, "softening": 1.0},
    "CoupledLongitudinal": {"cutoff": 0.5, "steer_limit": 1.22, "speed_limit": 69.44},
}
# What drives without a path of its own.
NO_PATH = [law for law in ALL if law.name in ("CoupledLongitudinal", "SpeedPid")]
each_law = pytest.mark.parametrize("law", ALL, ids=lambda law: law.name)
each_lateral = pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)


def _class(law: Law) -> Any:
    return getattr(popsteer, law.params_name)


def _controller(law: Law, **options: Any) -> Any:
    path = [] if law in NO_PATH else [popsteer.Path([(0, 0), (1, 0)])]
    return getattr(popsteer, law.name)(*path, **options)


def _changed(law: Law) -> dict[str, Any]:
    """A value for every parameter that is not its default."""
    changes: dict[str, Any] = {}
    for field, default in _class(law)().as_dict().items():
        if isinstance(default, bool):
            changes[field] = not default
        elif isinstance(default, int):
            changes[field] = default - 2
        else:
            (low, high), _ = law.ranges[field]
            changes[field] = min(max(0.71, low), high)
    return changes


@each_law
def test_params_without_arguments_are_the_papers(law: Law) -> None:
    params = _class(law)()
    assert set(params.as_dict()) == {*law.ranges, *law.counts, *law.flags}
    assert _controller(law).params == params
    resolved = params.resolved(popsteer.Vehicle()) if law in LATERAL else params
    found = {field: getattr(resolved, field) for field in PAPER.get(law.name, {})}
    assert found == PAPER.get(law.name, {})


@each_law
def test_params_given_by_name_are_kept(law: Law) -> None:
    changes = _changed(law)
    params = _class(law)(**changes)
    assert params.as_dict() == changes
    for field, value in changes.items():
        assert getattr(params, field) == value
        assert type(getattr(params, field)) is type(value)


@each_law
def test_params_repr_copies_and_pickles_give_the_same(law: Law) -> None:
    for params in (_class(law)(), _class(law)(**_changed(law))):
        twins = [eval(repr(params), vars(popsteer)), copy.copy(params), copy.deepcopy(params)]
        twins += [pickle.loads(pickle.dumps(params, protocol)) for protocol in range(2, 6)]
        for twin in twins:
            assert type(twin) is type(params)
            assert twin == params
    assert params != _class(law)()
    assert repr(params).startswith(f"{law.params_name}({next(iter(params.as_dict()))}=")


@each_law
def test_params_replace_changes_the_given_ones_alone(law: Law) -> None:
    params = _class(law)()
    for field, value in _changed(law).items():
        replaced = params.replace(**{field: value})
        assert replaced.as_dict() == {**params.as_dict(), field: value}
        assert replaced != params
    assert params == _class(law)()
    assert params.replace() == params
    with pytest.raises(TypeError):
        params.replace(no_such_parameter=1.0)


@each_law
def test_params_are_frozen_keyword_only_and_not_hashable(law: Law) -> None:
    params = _class(law)()
    field = next(iter(params.as_dict()))
    with pytest.raises(AttributeError):
        setattr(params, field, 1.0)
    with pytest.raises(AttributeError):
        params.no_such_parameter = 1.0
    with pytest.raises(TypeError, match="positional"):
        _class(law)(1.0)
    with pytest.raises(TypeError, match="no_such_parameter"):
        _class(law)(no_such_parameter=1.0)
    with pytest.raises(TypeError, match="unhashable"):
        hash(params)
    assert params != object()
    assert (params == params.as_dict()) is False


@each_law
def test_params_number_out_of_range_is_refused_by_name(law: Law) -> None:
    for field, ((low, high), _) in law.ranges.items():
        beyond = (math.nextafter(low, -math.inf), math.nextafter(high, math.inf), low - 1.0, -1e9)
        for value in (math.nan, math.inf, -math.inf, *beyond):
            for make in (_class(law), _class(law)().replace):
                with pytest.raises(ConfigError) as caught:
                    make(**{field: value})
                assert caught.value.field == field
                assert repr(caught.value.value) == repr(value)
                assert str(caught.value) == f"{field} must be in [{low:g}, {high:g}], got {value!r}"
        for infinite in (math.inf, -math.inf):  # a whole number beyond all floats
            with pytest.raises(ConfigError) as caught:
                _class(law)(**{field: int(math.copysign(1, infinite)) * 10**400})
            assert (caught.value.field, caught.value.value) == (field, infinite)


@each_law
def test_params_no_number_is_a_type_error(law: Law) -> None:
    for field in law.ranges:
        for value in ("1.0", b"1", [1.0], (1.0,), 1j, object()):
            with pytest.raises(TypeError, match=named(field)):
                _class(law)(**{field: value})
    for field in law.counts:
        for value in (21.0, "21", None):
            with pytest.raises(TypeError, match=named(field)):
                _class(law)(**{field: value})


def test_params_count_out_of_range_is_refused_by_name() -> None:
    even = (20, 2, 1, 0, -1, -21, 100_002, 100_003, 10**30, -(10**30))
    bad: list[tuple[Any, str, str, tuple[int, ...]]] = [
        (popsteer.PopParams, "candidate_count", "odd and in", even),
        (popsteer.PidParams, "buffer_length", "a count in", (0, -1, 501, 10**30)),
    ]
    for params, field, required, counts in bad:
        for count in counts:
            with pytest.raises(ConfigError, match=f"{field} must be {required}") as caught:
                params(**{field: count})
            assert caught.value.field == field
            if abs(count) < 2**53:
                assert caught.value.value == count


def test_preview_params_resolved_take_the_rate_of_the_wheels() -> None:
    car = popsteer.Vehicle(max_steer_rate=0.4)
    assert popsteer.PreviewPopParams().resolved(car).steer_span_rate == 0.4
    assert popsteer.PreviewPopParams(steer_span_rate=2.0).resolved(car).steer_span_rate == 2.0


@each_lateral
def test_params_resolved_keep_what_is_given(law: Law) -> None:
    given = _class(law)(**_changed(law))
    assert given.resolved(popsteer.Vehicle(wheelbase=0.3)) == given


@each_lateral
def test_controller_of_resolved_params_steers_the_same(law: Law) -> None:
    car = popsteer.Vehicle(wheelbase=0.33, max_steer=0.42, rear_axle=-0.1)
    path = popsteer.Path([(0.1 * k, 0.02 * math.sin(0.3 * k)) for k in range(100)])
    make, params = getattr(popsteer, law.name), _class(law)()
    pair = make(path, car, params), make(path, car, params.resolved(car))
    for k in range(50):
        pose = (1.0 + 0.05 * k, 0.03, 0.1, 1.0, 0.05)
        assert pair[0].step(*pose) == pair[1].step(*pose)


@each_lateral
def test_controller_of_any_vehicle_takes_the_defaults(law: Law) -> None:
    for wheelbase in (1e-3, 1e3):
        _controller(law, vehicle=popsteer.Vehicle(wheelbase=wheelbase))


@each_law
def test_params_signature_shows_the_real_defaults(law: Law) -> None:
    shown = inspect.signature(_class(law)).parameters
    defaults = {name: parameter.default for name, parameter in shown.items()}
    assert defaults == _class(law)().as_dict()


@each_law
def test_law_of_the_params_of_another_is_a_type_error(law: Law) -> None:
    other = popsteer.SpeedPidParams() if law.name != "SpeedPid" else popsteer.PopParams()
    with pytest.raises(TypeError):
        _controller(law, params=other)


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
        (
            "[pop]\nlookahead = 1",
            r"unknown key of \[pop\] 'lookahead', did you mean min_lookahead\? Known: ",
        ),
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
