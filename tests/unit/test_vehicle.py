"""The vehicle as a user meets it: one value, its file, and vehicles by name."""

from __future__ import annotations

import copy
import inspect
import math
import pickle
import re
import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import popsteer
from popsteer import ConfigError, InputError, Vehicle, controllers, sim, vehicle_file, vehicles
from tests.helpers import looped, named

# Of each field the range, the default, and whether it may be None.
FIELDS: dict[str, tuple[tuple[float, float], float | None, bool]] = {
    "wheelbase": ((1e-3, 1e3), 3.0, False),
    "width": ((1e-3, 1e2), None, True),
    "rear_axle": ((-1e3, 1e3), 0.0, False),
    "antenna_left": ((-1e2, 1e2), 0.0, False),
    "antenna_height": ((0.0, 1e2), 0.0, False),
    "no_slip_point": ((-1e3, 1e3), None, True),
    "turning_wheelbase": ((1e-3, 1e3), None, True),
    "understeer": ((0.0, 1e3), 0.0, False),
    "steer_offset": ((-0.5, 0.5), 0.0, False),
    "steer_lag": ((0.0, 10.0), 0.1, False),
    "dead_time": ((0.0, 10.0), 0.0, False),
    "max_steer": ((1e-3, 1.57), 1.22, False),
    "max_steer_rate": ((1e-3, 1e6), None, True),
    "steer_play": ((0.0, 0.5), 0.0, False),
    "max_lateral_acceleration": ((1e-3, 1e6), 4.0, True),
    "max_speed": ((1e-3, 1e4), None, True),
    "max_acceleration": ((1e-3, 1e3), None, True),
    "max_deceleration": ((1e-3, 1e3), None, True),
    "brake_deceleration": ((1e-3, 1e3), None, True),
    "drive_delay": ((0.0, 10.0), 0.1, False),
    "drive_lag": ((0.0, 10.0), 0.0, False),
    "stop_point": ((-1e3, 1e3), None, True),
}
DEFAULTS = {name: default for name, (_, default, _) in FIELDS.items()} | {"steers_at_rest": False}
# A value for every field that is not its default.
OTHERS = {name: min(0.7, 0.99 * high) for name, ((_, high), _, _) in FIELDS.items()}


def _vehicle(fields: dict[str, Any]) -> Vehicle:
    return Vehicle(**fields)


VEHICLES = st.fixed_dictionaries(
    {},
    optional={
        name: st.floats(low, high) | st.just(low) | (st.none() if optional else st.nothing())
        for name, ((low, high), _, optional) in FIELDS.items()
    }
    | {"steers_at_rest": st.booleans()},
).map(_vehicle)

each_field = looped("field", FIELDS)


def test_vehicle_of_no_arguments_is_the_papers_car_with_a_limit() -> None:
    assert Vehicle().as_dict() == DEFAULTS
    assert list(Vehicle().as_dict()) == list(DEFAULTS)
    parameters = inspect.signature(Vehicle).parameters
    assert {name: parameter.default for name, parameter in parameters.items()} == DEFAULTS


@each_field
def test_vehicle_field_given_is_kept(field: str) -> None:
    car = _vehicle({field: OTHERS[field]})
    assert getattr(car, field) == OTHERS[field]
    assert car.as_dict() == {**DEFAULTS, field: OTHERS[field]}
    assert car == Vehicle().replace(**{field: OTHERS[field]}) != Vehicle()
    with pytest.raises(AttributeError):
        setattr(car, field, 1.0)


@each_field
def test_vehicle_number_out_of_range_is_refused_by_name(field: str) -> None:
    low, high = FIELDS[field][0]
    beyond = (math.nextafter(low, -math.inf), math.nextafter(high, math.inf), -1e9)
    for value in (math.nan, math.inf, -math.inf, *beyond):
        given: dict[str, Any] = {field: value}
        for make in (Vehicle, Vehicle().replace):
            with pytest.raises(ConfigError) as caught:
                make(**given)
            assert str(caught.value) == f"{field} must be in [{low:g}, {high:g}], got {value!r}"
    with pytest.raises(ConfigError, match=f"^{field} must be .* got -inf$"):
        _vehicle({field: -(10**400)})
    assert _vehicle({field: low}) != _vehicle({field: high})


@each_field
@looped("value", ["1.0", [1.0], 1j, object()])
def test_vehicle_no_number_is_a_type_error(field: str, value: Any) -> None:
    with pytest.raises(TypeError, match=named(field)):
        Vehicle(**{field: value})


@each_field
def test_vehicle_none_is_taken_where_it_means_something(field: str) -> None:
    none: dict[str, Any] = {field: None}
    if FIELDS[field][2]:
        assert getattr(Vehicle(**none), field) is None
    else:
        with pytest.raises(TypeError, match=named(field)):
            Vehicle(**none)


def test_vehicle_of_unknown_or_positional_arguments_is_a_type_error() -> None:
    with pytest.raises(TypeError, match="wheel_base"):
        Vehicle(wheel_base=2.7)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="positional"):
        Vehicle(2.7)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="wheel_base"):
        Vehicle().replace(wheel_base=2.7)


@given(VEHICLES)
def test_vehicle_repr_copy_and_pickle_are_the_same_vehicle(car: Vehicle) -> None:
    pickled = (pickle.loads(pickle.dumps(car, protocol)) for protocol in range(2, 6))
    for twin in (eval(repr(car), vars(popsteer)), copy.copy(car), copy.deepcopy(car), *pickled):
        assert type(twin) is Vehicle
        assert twin == car
        assert hash(twin) == hash(car)
        assert repr(twin) == repr(car)


@given(VEHICLES, VEHICLES)
def test_vehicles_are_equal_where_all_fields_are(one: Vehicle, other: Vehicle) -> None:
    assert (one == other) == (one.as_dict() == other.as_dict())
    assert len({one, other, one.replace()}) == (1 if one == other else 2)
    assert one != one.as_dict()


def test_vehicle_of_minus_zero_is_that_of_zero() -> None:
    assert Vehicle(rear_axle=-0.0) == Vehicle()
    assert hash(Vehicle(rear_axle=-0.0, no_slip_point=-0.0)) == hash(Vehicle(no_slip_point=0.0))


def test_vehicle_tells_front_axle_and_turning_length() -> None:
    car = Vehicle(wheelbase=2.7, rear_axle=-1.35, turning_wheelbase=3.0, understeer=0.01)
    assert car.front_axle == pytest.approx(1.35)
    assert car.turning_length(-10.0) == pytest.approx(4.0)
    assert Vehicle(wheelbase=2.7).turning_length(20) == 2.7
    for speed in (math.nan, 1.1e4, -math.inf, 10**400):
        with pytest.raises(InputError, match="speed must be"):
            car.turning_length(speed)


@given(VEHICLES)
def test_vehicle_saved_and_loaded_is_the_same(car: Vehicle) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "new" / "car.toml"
        car.save(file)
        loaded = Vehicle.load(str(file))
        assert [each.name for each in file.parent.iterdir()] == ["car.toml"]
    assert loaded == car
    assert repr(loaded) == repr(car)


@given(
    st.dictionaries(st.sampled_from(list(FIELDS)), st.floats(1e-3, 0.5) | st.just(0.5), max_size=16)
)
def test_vehicle_file_with_some_keys_has_the_defaults_for_the_others(fields: Any) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "car.toml"
        file.write_text("".join(f"{key} = {value!r}\n" for key, value in fields.items()))
        assert Vehicle.load(file).as_dict() == {**DEFAULTS, **fields}


def test_vehicle_file_says_what_each_field_is_and_its_unit() -> None:
    lines = vehicle_file.as_toml(Vehicle()).splitlines()
    keys = [line for line in lines if re.match(r"(# )?\w+ =", line)]
    text = "\n".join(lines[lines.index("") :])
    for key in keys:
        meaning, _, text = text.partition(f"\n{key}")
        assert re.fullmatch(r"\n# ([A-Z].*\[.+\]|Whether ).*\.", meaning, re.DOTALL)
    assert [key.removeprefix("# ").split(" =")[0] for key in keys] == list(DEFAULTS)
    commented = [key.split()[1] for key in keys if key.startswith("#")]
    assert commented == [name for name, default in DEFAULTS.items() if default is None]


def test_vehicle_file_of_no_limit_says_inf(tmp_path: Path) -> None:
    file = tmp_path / "car.toml"
    file.write_text("max_lateral_acceleration = inf\nmax_steer_rate = inf\nmax_speed = +inf\n")
    car = Vehicle.load(file)
    assert (car.max_lateral_acceleration, car.max_steer_rate, car.max_speed) == (None, None, None)
    Vehicle(max_lateral_acceleration=None).save(file)
    assert "max_lateral_acceleration = inf\n" in file.read_text()


def test_vehicle_file_takes_whole_numbers(tmp_path: Path) -> None:
    file = tmp_path / "car.toml"
    file.write_text("wheelbase = 3\nmax_lateral_acceleration = 4\n")
    assert Vehicle.load(file) == Vehicle()
    assert type(Vehicle.load(file).wheelbase) is float


_REFUSED = [
    ("wheel_base = 2.7", "wheel_base", "unknown key 'wheel_base', did you mean wheelbase? Known: "),
    ("[car]\nwheelbase = 2.7", "car", "unknown key 'car'; known: wheelbase, "),
    ("wheelbase = '2.7'", "wheelbase", "wheelbase must be a number, got '2.7'"),
    ("wheelbase = true", "wheelbase", "wheelbase must be a number, got True"),
    ("steers_at_rest = 1", "steers_at_rest", "steers_at_rest must be true or false, got 1"),
    ("wheelbase = [2.7]", "wheelbase", r"wheelbase must be a number, got [2.7]"),
    ("wheelbase = {a = 1}", "wheelbase", "wheelbase must be a number, got {'a': 1}"),
    ("dead_time = 1979-05-27", "dead_time", "dead_time must be a number, got datetime.date("),
    ("wheelbase = -2.7", "wheelbase", "wheelbase must be in [0.001, 1000], got -2.7"),
    ("max_steer = nan", "max_steer", "max_steer must be in [0.001, 1.57], got nan"),
    ("max_steer = inf", "max_steer", "max_steer must be in [0.001, 1.57], got inf"),
    ("max_speed = -inf", "max_speed", "max_speed must be in [0.001, 10000], got -inf"),
    (f"understeer = 1{'0' * 400}", "understeer", "understeer must be in [0, 1000], got inf"),
    ("wheelbase = ", "vehicle file", "not TOML: Invalid value (at end of document)"),
    ("wheelbase = 2\nwheelbase = 3", "vehicle file", "not TOML: Cannot overwrite a value (at "),
    ("wheelbase: 2.7", "vehicle file", "not TOML: Expected '=' after a key in a key/value pair"),
    ("a = " + "[" * 5000, "vehicle file", "not TOML: "),
    ("a = 1" + "0" * 5000, "vehicle file", "not TOML: "),
]


@pytest.mark.parametrize(("text", "field", "said"), _REFUSED)
def test_vehicle_file_that_is_wrong_is_refused_with_file_key_and_value(
    tmp_path: Path, text: str, field: str, said: str
) -> None:
    file = tmp_path / "car.toml"
    file.write_text(text, encoding="utf-8")
    for load in (Vehicle.load, vehicle_file.load):
        with pytest.raises(ConfigError) as caught:
            load(file)
        assert str(caught.value).startswith(f"{file}: {said}")
        assert (caught.value.field == field) or field in str(caught.value)
        assert "\n" not in str(caught.value)


def test_vehicle_file_that_cannot_be_read_is_refused_with_its_name(tmp_path: Path) -> None:
    missing, folder, binary = tmp_path / "none.toml", tmp_path, tmp_path / "binary.toml"
    binary.write_bytes(b"wheelbase = \xff")
    for file, said in (
        (missing, "No such file or directory"),
        (folder, "Is a directory"),
        (binary, "not UTF-8 at byte 12"),
    ):
        with pytest.raises(ConfigError) as caught:
            Vehicle.load(file)
        assert str(caught.value) == f"{file}: {said}"
        assert (caught.value.field, caught.value.value) == ("vehicle file", str(file))
    for wrong in (None, 3, 2.7):
        with pytest.raises(TypeError):
            Vehicle.load(wrong)  # type: ignore[arg-type]


def test_vehicle_that_cannot_be_saved_leaves_the_old_file(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="Is a directory"):
        Vehicle().save(tmp_path)
    (tmp_path / "file").write_text("old")
    with pytest.raises(OSError, match=r"car\.toml|file"):
        Vehicle().save(tmp_path / "file" / "car.toml")
    assert (tmp_path / "file").read_text() == "old"


def test_vehicles_by_name_are_the_papers_and_those_of_the_plants() -> None:
    assert vehicles.names() == ("paper", "carla-identified", "kinematic-bicycle")
    assert vehicles.get("paper") == Vehicle(max_lateral_acceleration=None)
    assert vehicles.get("carla-identified") == sim.CarlaIdentified().vehicle
    assert vehicles.get("carla-identified") == Vehicle(
        rear_axle=-1.94,
        no_slip_point=0.0,
        turning_wheelbase=3.553,
        understeer=2.9e-4,
        drive_lag=0.25,
        max_lateral_acceleration=None,
    )
    assert vehicles.get("kinematic-bicycle") == sim.KinematicBicycle().vehicle
    assert vehicles.get("kinematic-bicycle").steer_lag == 0.0
    with pytest.raises(ConfigError, match="unknown vehicle 'bus'; known: paper, carla-identified"):
        vehicles.get("bus")


@looped("name", controllers.names())
@looped("reverse", [False, True])
def test_vehicle_measured_at_any_point_is_steered_alike(name: str, reverse: bool) -> None:
    count, sign = 200, -1.0 if reverse else 1.0
    path = popsteer.Path(
        [(0.5 * k, 3.0 * math.sin(0.05 * k)) for k in range(count)], reverse=[reverse] * count
    )
    base = Vehicle(dead_time=0.1, steer_offset=0.01, max_steer_rate=0.8)
    points = (0.0, -1.35, -3.0, 0.8)
    cars = [base.replace(rear_axle=point) for point in points]
    drivers = [controllers.get(name).controller(path, car) for car in cars]
    for k in range(60):
        x, y = 5.0 + 0.25 * k, 3.0 * math.sin(0.5 + 0.025 * k) + 0.3
        yaw = 0.2 * math.cos(0.1 * k) + (math.pi if reverse else 0.0)
        angles, errors = [], []
        for point, driver in zip(points, drivers, strict=True):
            pose = (x - point * math.cos(yaw), y - point * math.sin(yaw), yaw, 5.0 * sign)
            command = driver.step(*pose, 0.05)
            angles.append(command.steer)
            errors.append(command.cross_track_error)
        assert angles == pytest.approx([angles[0]] * 4, abs=1e-12)
        assert errors == pytest.approx([errors[0]] * 4, abs=1e-9)
