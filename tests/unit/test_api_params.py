"""The parameter classes as a user meets them; their bounds are compared with the reference's."""

from __future__ import annotations

import copy
import inspect
import math
import pickle
from typing import Any

import pytest

import popsteer
from popsteer import ConfigError
from tests.helpers import named
from tests.parity.laws import ALL, LATERAL, Law

# The paper's Table 1 and Table 2, with what the published code adds and this project chooses where
# neither says. None scales with the vehicle, see AT_THE_PAPERS.
_PLACE = {"search_distance": None, "lost_distance": None}
_SEARCH = {
    "exact_lookahead": True,
    "lookahead_tolerance": None,
    "window_ahead": None,
    "grid_spacing": None,
}
DEFAULTS: dict[str, dict[str, Any]] = {
    "Pop": {
        "lookahead_gain": 0.2,
        "min_lookahead": None,
        "steer_span": math.radians(3.0),
        "candidate_count": 21,
        **_SEARCH,
        **_PLACE,
    },
    "PreviewPop": {
        "steer_span_rate": None,
        "horizon": 1.0,
        "heading_cost": None,
        "steer_rate_cost": None,
        "approach_angle": 0.25,
        "min_speed": None,
        "smoothing_length": None,
        **_PLACE,
    },
    "Pid": {
        "kp": None,
        "ki": None,
        "kd": None,
        "buffer_length": 500,
        "integral_with_dt": True,
        "smoothing_length": None,
        **_PLACE,
    },
    "PurePursuit": {
        "lookahead_gain": 0.9,
        "min_lookahead": None,
        "alpha_by_arccos": False,
        **_SEARCH,
        **_PLACE,
    },
    "Stanley": {
        "cross_track_gain": 1.5,
        "speed_gain": 1.3,
        "softening": None,
        "heading_behind": False,
        "smoothing_length": None,
        **_PLACE,
    },
    "CoupledLongitudinal": {"cutoff": 0.5, "steer_limit": 1.22, "speed_limit": 69.44},
    "SpeedPid": {"kp": 0.5, "ki": 0.1, "kd": 0.0},
    "SpeedTracker": {
        "kp": 1.5,
        "ki": 0.2,
        "max_jerk": 20.0,
        "reserve": 0.4,
        "drive_delay": 0.0,
    },
}
# What None comes to at a wheelbase of 3 m, and the power of the wheelbase that it grows with.
AT_THE_PAPERS: dict[str, dict[str, tuple[float, int]]] = {
    "Pop": {
        "min_lookahead": (6.0, 1),
        "lookahead_tolerance": (0.01, 1),
        "window_ahead": (20.0, 1),
        "grid_spacing": (0.01, 1),
    },
    "PreviewPop": {
        "steer_span_rate": (math.radians(60.0), 0),
        "heading_cost": (3.0, 1),
        "steer_rate_cost": (0.25, 1),
        "min_speed": (5.0, 1),
        "smoothing_length": (2.0, 1),
    },
    "Pid": {"kp": (0.25, -1), "ki": (0.01, -1), "kd": (0.2, -1), "smoothing_length": (6.0, 1)},
    "PurePursuit": {
        "min_lookahead": (10.0, 1),
        "lookahead_tolerance": (0.01, 1),
        "window_ahead": (20.0, 1),
        "grid_spacing": (0.01, 1),
    },
    "Stanley": {"softening": (1e-5, 1), "smoothing_length": (3.0, 1)},
}

NUMBERS = [
    pytest.param(law, field, id=f"{law.name}-{field}") for law in ALL for field in law.ranges
]
# What drives without a path of its own.
NO_PATH = [law for law in ALL if law.name in ("CoupledLongitudinal", "SpeedPid")]
each_law = pytest.mark.parametrize("law", ALL, ids=lambda law: law.name)


def _class(law: Law) -> Any:
    return getattr(popsteer, law.params_name)


def _changed(law: Law) -> dict[str, Any]:
    """A value for every parameter that is not its default."""
    changes: dict[str, Any] = {}
    for field, default in DEFAULTS[law.name].items():
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
    assert params.as_dict() == DEFAULTS[law.name]
    assert (
        getattr(popsteer, law.name)(
            *([popsteer.Path([(0, 0), (1, 0)])] if law not in NO_PATH else [])
        ).params
        == params
    )


@each_law
def test_params_given_by_name_are_kept(law: Law) -> None:
    changes = _changed(law)
    params = _class(law)(**changes)
    assert params.as_dict() == changes
    for field, value in changes.items():
        assert getattr(params, field) == value
        assert type(getattr(params, field)) is type(value)


@each_law
@pytest.mark.parametrize("changed", [False, True])
def test_params_repr_evaluates_to_the_same(law: Law, changed: bool) -> None:
    params = _class(law)(**(_changed(law) if changed else {}))
    assert eval(repr(params), vars(popsteer)) == params
    assert repr(params).startswith(f"{law.params_name}({next(iter(DEFAULTS[law.name]))}=")


@each_law
def test_params_replace_changes_the_given_ones_alone(law: Law) -> None:
    params = _class(law)()
    for field, value in _changed(law).items():
        replaced = params.replace(**{field: value})
        assert replaced.as_dict() == {**DEFAULTS[law.name], field: value}
        assert replaced != params
    assert params == _class(law)()
    assert params.replace() == params
    with pytest.raises(TypeError):
        params.replace(no_such_parameter=1.0)


@each_law
@pytest.mark.parametrize(
    "duplicate",
    [
        copy.copy,
        copy.deepcopy,
        *(lambda p, n=n: pickle.loads(pickle.dumps(p, n)) for n in range(2, 6)),
    ],
)
def test_params_copied_or_pickled_are_equal(law: Law, duplicate: Any) -> None:
    params = _class(law)(**_changed(law))
    twin = duplicate(params)
    assert type(twin) is type(params)
    assert twin == params
    assert twin != _class(law)()


@each_law
def test_params_are_frozen_keyword_only_and_not_hashable(law: Law) -> None:
    params = _class(law)()
    field = next(iter(DEFAULTS[law.name]))
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


@pytest.mark.parametrize(("law", "field"), NUMBERS)
def test_params_number_out_of_range_is_refused_by_name(law: Law, field: str) -> None:
    (low, high), _ = law.ranges[field]
    beyond = (math.nextafter(low, -math.inf), math.nextafter(high, math.inf), low - 1.0, -1e9)
    for value in (math.nan, math.inf, -math.inf, *beyond):
        for make in (_class(law), _class(law)().replace):
            with pytest.raises(ConfigError) as caught:
                make(**{field: value})
            assert caught.value.field == field
            assert repr(caught.value.value) == repr(value)
            assert str(caught.value) == f"{field} must be in [{low:g}, {high:g}], got {value!r}"


@pytest.mark.parametrize(("law", "field"), NUMBERS)
@pytest.mark.parametrize("sign", [1, -1])
def test_params_whole_number_beyond_all_floats_is_refused_by_name(
    law: Law, field: str, sign: int
) -> None:
    with pytest.raises(ConfigError) as caught:
        _class(law)(**{field: sign * 10**400})
    assert (caught.value.field, caught.value.value) == (field, sign * math.inf)


@pytest.mark.parametrize(("law", "field"), NUMBERS)
@pytest.mark.parametrize("value", ["1.0", b"1", [1.0], (1.0,), 1j, object()])
def test_params_no_number_is_a_type_error(law: Law, field: str, value: object) -> None:
    with pytest.raises(TypeError, match=named(field)):
        _class(law)(**{field: value})


@pytest.mark.parametrize("count", [20, 2, 1, 0, -1, -21, 100_002, 100_003, 10**30, -(10**30)])
def test_pop_candidate_count_even_or_out_of_range_is_refused(count: int) -> None:
    with pytest.raises(ConfigError, match="candidate_count must be odd and in") as caught:
        popsteer.PopParams(candidate_count=count)
    assert caught.value.field == "candidate_count"
    if abs(count) < 2**53:
        assert caught.value.value == count


@pytest.mark.parametrize("length", [0, -1, 501, 10**30])
def test_pid_buffer_length_out_of_range_is_refused(length: int) -> None:
    with pytest.raises(ConfigError, match="buffer_length must be a count in") as caught:
        popsteer.PidParams(buffer_length=length)
    assert caught.value.field == "buffer_length"
    if length < 2**53:
        assert caught.value.value == length


@pytest.mark.parametrize("field", ["candidate_count", "buffer_length"])
@pytest.mark.parametrize("value", [21.0, "21", None])
def test_params_no_whole_number_for_a_count_is_a_type_error(field: str, value: Any) -> None:
    law = popsteer.PopParams if field == "candidate_count" else popsteer.PidParams
    with pytest.raises(TypeError, match=named(field)):
        law(**{field: value})


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
@pytest.mark.parametrize("scale", [1.0, 0.11, 8.0])
def test_params_resolved_scale_with_the_wheelbase(law: Law, scale: float) -> None:
    params = _class(law)()
    wanted = {
        **params.as_dict(),
        **{
            field: pytest.approx(number * scale**power, rel=1e-14)
            for field, (number, power) in AT_THE_PAPERS[law.name].items()
        },
        "search_distance": pytest.approx(6.0 * scale, rel=1e-14),
        "lost_distance": pytest.approx(30.0 * scale, rel=1e-14),
    }
    resolved = params.resolved(popsteer.Vehicle(wheelbase=3.0 * scale))
    assert resolved.as_dict() == wanted
    assert type(resolved) is type(params)


def test_preview_params_resolved_take_the_rate_of_the_wheels() -> None:
    car = popsteer.Vehicle(max_steer_rate=0.4)
    assert popsteer.PreviewPopParams().resolved(car).steer_span_rate == 0.4
    assert popsteer.PreviewPopParams(steer_span_rate=2.0).resolved(car).steer_span_rate == 2.0


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_params_resolved_keep_what_is_given(law: Law) -> None:
    given = _class(law)(**_changed(law))
    assert given.resolved(popsteer.Vehicle(wheelbase=0.3)) == given


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_controller_of_resolved_params_steers_the_same(law: Law) -> None:
    car = popsteer.Vehicle(wheelbase=0.33, max_steer=0.42, rear_axle=-0.1)
    path = popsteer.Path([(0.1 * k, 0.02 * math.sin(0.3 * k)) for k in range(100)])
    make, params = getattr(popsteer, law.name), _class(law)()
    pair = make(path, car, params), make(path, car, params.resolved(car))
    for k in range(50):
        pose = (1.0 + 0.05 * k, 0.03, 0.1, 1.0, 0.05)
        assert pair[0].step(*pose) == pair[1].step(*pose)


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_controller_of_any_vehicle_takes_the_defaults(law: Law) -> None:
    path = popsteer.Path([(0, 0), (1, 0)])
    for wheelbase in (1e-3, 1e3):
        getattr(popsteer, law.name)(path, popsteer.Vehicle(wheelbase=wheelbase))


@each_law
def test_params_signature_shows_the_real_defaults(law: Law) -> None:
    shown = {
        name: parameter.default
        for name, parameter in inspect.signature(_class(law)).parameters.items()
    }
    assert shown == DEFAULTS[law.name]


@each_law
def test_law_of_the_params_of_another_is_a_type_error(law: Law) -> None:
    other = popsteer.SpeedPidParams() if law.name != "SpeedPid" else popsteer.PopParams()
    arguments = [popsteer.Path([(0, 0), (1, 0)])] if law not in NO_PATH else []
    with pytest.raises(TypeError):
        getattr(popsteer, law.name)(*arguments, params=other)
