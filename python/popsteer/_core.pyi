"""The Rust core. Documentation is on the objects themselves; the names are those of `popsteer`."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from inspect import Signature
from typing import (
    Any,
    ClassVar,
    Final,
    Generic,
    Literal,
    TypeAlias,
    TypeVar,
    final,
    type_check_only,
)

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self, dataclass_transform

from popsteer.plants.protocol import PythonPlant
from popsteer.prediction import Prediction
from popsteer.sim.pedals import PedalMap
from popsteer.state import State
from popsteer.status import Status

_Floats: TypeAlias = NDArray[np.float64]
_Point: TypeAlias = tuple[float, float]
_Flags: TypeAlias = NDArray[np.bool_]
_Looked: TypeAlias = tuple[NDArray[np.float32], _Floats, _Flags, _Flags, _Floats]
_Pose: TypeAlias = tuple[float, float, float]
_Law: TypeAlias = Pop | PreviewPop | Pid | PurePursuit | Stanley
_Tuning: TypeAlias = PreviewPopParams | StanleyParams | PurePursuitParams | PidParams | PopParams
_Longitudinal: TypeAlias = CoupledLongitudinal | SpeedPid | SpeedTracker
_Plant: TypeAlias = str | CarlaIdentified | KinematicBicycle

__version__: str
build_profile: str

def run_many(
    runs: Iterable[
        tuple[_Law, _Plant, list[float], tuple[Noise | None, int, int], _Longitudinal | None]
    ],
    *,
    pedals: PedalMap | None,
    settings: Settings | None,
    threads: int | None,
    progress: Callable[[float], object] | None,
) -> dict[str, NDArray[Any]]: ...

_ParamsT = TypeVar("_ParamsT")

# What several classes have is written once, in private bases that exist for type checkers alone:
# at run time each class has it itself. What has a field a line takes the fields by name.

@type_check_only
class _Pickled:
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@type_check_only
@dataclass_transform(eq_default=False, kw_only_default=True, frozen_default=True)
class _Columns(_Pickled): ...

@type_check_only
class _Value(_Pickled):
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]

@type_check_only
@dataclass_transform(kw_only_default=True, frozen_default=True)
class _Answer(_Value): ...

@type_check_only
class _Parameters(_Value):
    __signature__: ClassVar[Signature]  # with the defaults: popsteer.params_file
    def as_dict(self) -> dict[str, Any]: ...
    def replace(self, **changes: object) -> Self: ...

@type_check_only
@dataclass_transform(kw_only_default=True, frozen_default=True)
class _Params(_Parameters): ...

@type_check_only
class _LawParams(_Params):
    def resolved(self, vehicle: Vehicle) -> Self: ...
    @classmethod
    def load(cls, file: str | os.PathLike[str]) -> Self: ...  # from popsteer.params_file
    def save(self, file: str | os.PathLike[str]) -> None: ...

@type_check_only
class _Stateful(Generic[_ParamsT]):
    @property
    def state(self) -> State: ...
    @state.setter
    def state(self, state: State) -> None: ...
    @property
    def params(self) -> _ParamsT: ...

@type_check_only
class _Steering:
    def steer(
        self,
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
        /,
        *,
        applied_steer: float | None = None,
        measured_steer: float | None = None,
        pose_age: float = 0.0,
        roll: float = 0.0,
    ) -> float: ...

@type_check_only
class _Controller(_Stateful[_ParamsT], _Steering):
    def __new__(
        cls,
        path: Path,
        vehicle: Vehicle | None = None,
        params: _ParamsT | None = None,
        *,
        adapt: AdaptParams | Literal["auto"] | None = "auto",
        monitor: MonitorParams | Literal["auto"] | None = "auto",
    ) -> Self: ...
    def step(
        self,
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
        *,
        applied_steer: float | None = None,
        measured_steer: float | None = None,
        pose_age: float = 0.0,
        roll: float = 0.0,
    ) -> Command: ...
    def step_or_hold(
        self,
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
        hold_limit: int = 10,
        *,
        applied_steer: float | None = None,
        measured_steer: float | None = None,
        pose_age: float = 0.0,
        roll: float = 0.0,
    ) -> Command: ...
    def predict(self, time: float = 1.0, dt: float = 0.05) -> Prediction: ...
    def relocalise(self, x: float, y: float, yaw: float) -> None: ...
    def reset(self, *, steer: float | None = None) -> None: ...
    def set_path(self, path: Path) -> None: ...
    vehicle: Final[Vehicle]
    vehicle_given: Final[bool]
    adapt: Final[AdaptParams | None]
    monitor: Final[MonitorParams | None]
    fault: Final[str | None]
    estimate: Final[Estimate]
    path: Final[Path]
    tracked_point: Final[float]
    def __getnewargs_ex__(self) -> tuple[tuple[Path, Vehicle | None, Any], dict[str, Any]]: ...

@type_check_only
class _CorePlant(_Parameters):
    vehicle: Final[Vehicle]
    def __hash__(self) -> int: ...  # type: ignore[override]

@type_check_only
class _Vehicle(_Params):
    @property
    def front_axle(self) -> float: ...
    def turning_length(self, speed: float) -> float: ...
    @staticmethod
    def load(file: str | os.PathLike[str]) -> Vehicle: ...
    def save(self, file: str | os.PathLike[str]) -> None: ...
    def __hash__(self) -> int: ...  # type: ignore[override]

@final
class Projection(_Answer):
    segment: int
    fraction: float
    point: _Point
    arc_length: float
    cross_track_error: float
    path_yaw: float

@final
class Lookahead(_Answer):
    index: int
    point: _Point
    found: bool

@final
class Command(_Answer):
    steer: float
    cross_track_error: float
    heading_error: float
    predicted_cross_track_error: float
    predicted_heading_error: float
    target: _Point
    reverse: bool
    reference_speed: float | None
    distance_to_stop: float
    status: Status

@final
class Path:
    def __new__(
        cls,
        xy: ArrayLike,
        *,
        speed: ArrayLike | None = None,
        closed: bool = False,
        reverse: ArrayLike | None = None,
        grade: ArrayLike | None = None,
        yaw: ArrayLike | Literal["spline"] | None = None,
        curvature: ArrayLike | None = None,
        mend: bool = True,
        source: str | None = None,
    ) -> Self: ...
    @classmethod
    def from_csv(
        cls,
        file: str | os.PathLike[str],
        *,
        closed: bool = False,
        columns: str | Sequence[str] | Mapping[str, str] | None = None,
        origin: tuple[float, float] | None = None,
    ) -> Self: ...
    mended: Final[tuple[str, ...]]
    x: Final[_Floats]
    y: Final[_Floats]
    s: Final[_Floats]
    speed: Final[_Floats | None]
    reverse: Final[_Flags | None]
    grade: Final[_Floats | None]
    yaw: Final[_Floats | None]
    curvature: Final[_Floats | None]
    source: Final[str | None]
    length: Final[float]
    closed: Final[bool]
    def __len__(self) -> int: ...
    def nearest_waypoint(self, x: float, y: float) -> int: ...
    def locate(
        self,
        x: float,
        y: float,
        yaw: float,
        waypoint: int,
        reach: float,
        *,
        opposite_distance: float = 10.0,
    ) -> Projection: ...
    def get_crossing(
        self, x: float, y: float, lookahead: float, segment: int
    ) -> tuple[_Point, bool]: ...
    def relocalise(
        self, x: float, y: float, yaw: float, *, opposite_distance: float = 10.0
    ) -> int: ...
    def project(self, x: float, y: float, nearest: int | None = None) -> Projection: ...
    def path_yaw_behind(self, nearest: int) -> float: ...
    def reference_speed(self, x: float, y: float, nearest: int | None = None) -> float | None: ...
    def window(self, nearest: int, ahead: float = 20.0) -> tuple[int, int]: ...
    def resample(self, nearest: int, ahead: float = 20.0, spacing: float = 0.01) -> _Floats: ...
    def get_lookahead_point(
        self,
        x: float,
        y: float,
        lookahead: float,
        *,
        nearest: int | None = None,
        tolerance: float = 0.01,
        window_ahead: float = 20.0,
        grid_spacing: float = 0.01,
    ) -> Lookahead: ...
    def get_lookahead_point_index(
        self,
        x: float,
        y: float,
        lookahead: float,
        *,
        nearest: int | None = None,
        tolerance: float = 0.01,
        window_ahead: float = 20.0,
        grid_spacing: float = 0.01,
    ) -> int: ...

@final
class Estimate(_Answer):
    gain: float = 1.0
    steer_offset: float = 0.0
    dead_time: float = 0.0
    steer_lag: float = 0.0
    slip: float = 0.0
    slip_length: float = 0.0
    acceleration: float = 0.0
    speed_scale: float = 1.0
    def as_dict(self) -> dict[str, Any]: ...

@final
class Pop(_Controller[PopParams]): ...

@final
class PreviewPop(_Controller[PreviewPopParams]): ...

@final
class Pid(_Controller[PidParams]): ...

@final
class PurePursuit(_Controller[PurePursuitParams]): ...

@final
class Stanley(_Controller[StanleyParams]): ...

@final
class Drive(_Answer):
    steer: float
    acceleration: float
    speed: float
    reverse: bool
    hold: bool
    phase: str
    fault: str | None
    status: Status
    cross_track_error: float
    heading_error: float
    predicted_cross_track_error: float
    predicted_heading_error: float
    target: tuple[float, float]
    reference_speed: float
    distance_to_stop: float

@final
class Driver:
    def __new__(
        cls,
        path: Path,
        vehicle: Vehicle | None = None,
        controller: _Tuning | None = None,
        *,
        speed: SpeedTrackerParams | None = None,
        params: DriverParams | None = None,
        adapt: AdaptParams | Literal["auto"] | None = "auto",
        monitor: MonitorParams | Literal["auto"] | None = "auto",
    ) -> Self: ...
    def step(
        self,
        x: float | None,
        y: float | None,
        yaw: float | None,
        speed: float | None,
        dt: float | None,
        *,
        applied_steer: float | None = None,
        measured_steer: float | None = None,
        pose_age: float = 0.0,
        roll: float = 0.0,
        gear: bool | None = None,
    ) -> Drive: ...
    def reset(self, *, steer: float | None = None) -> None: ...
    def set_path(self, path: Path) -> None: ...
    def hold(self) -> None: ...
    def go(self) -> None: ...
    def release(self) -> str | None: ...
    def predict(self, time: float = 1.0, dt: float = 0.05) -> Prediction: ...
    path: Final[Path]
    vehicle: Final[Vehicle]
    controller: Final[_Tuning]
    speed: Final[SpeedTrackerParams]
    params: Final[DriverParams]
    plan: Final[_Floats]
    fault: Final[str | None]
    estimate: Final[Estimate]
    tracked_point: Final[float]
    adapt: Final[AdaptParams | None]
    monitor: Final[MonitorParams | None]
    @property
    def state(self) -> State: ...
    @state.setter
    def state(self, state: State) -> None: ...
    def __setstate__(self, state: State) -> None: ...
    def __getnewargs_ex__(self) -> tuple[tuple[Path, Vehicle, _Tuning], dict[str, Any]]: ...

@final
class CommandBatch(_Columns):
    steer: _Floats
    cross_track_error: _Floats
    heading_error: _Floats
    predicted_cross_track_error: _Floats
    predicted_heading_error: _Floats
    target: _Floats
    reverse: _Flags
    reference_speed: _Floats
    distance_to_stop: _Floats
    status: NDArray[np.uint32]
    def __len__(self) -> int: ...

@final
class Batch:
    def __new__(cls, controllers: _Law | Iterable[_Law], count: int | None = None) -> Self: ...
    def steer(
        self,
        x: ArrayLike,
        y: ArrayLike,
        yaw: ArrayLike,
        speed: ArrayLike,
        dt: float,
        *,
        on_error: Literal["raise", "nan", "hold"] = "raise",
        hold_limit: int = 10,
        applied_steer: ArrayLike | None = None,
        measured_steer: ArrayLike | None = None,
        pose_age: ArrayLike = 0.0,
        roll: ArrayLike = 0.0,
    ) -> _Floats: ...
    def step(
        self,
        x: ArrayLike,
        y: ArrayLike,
        yaw: ArrayLike,
        speed: ArrayLike,
        dt: float,
        *,
        on_error: Literal["raise", "nan", "hold"] = "raise",
        hold_limit: int = 10,
        applied_steer: ArrayLike | None = None,
        measured_steer: ArrayLike | None = None,
        pose_age: ArrayLike = 0.0,
        roll: ArrayLike = 0.0,
    ) -> CommandBatch: ...
    def set_path(
        self, path: Path | Sequence[Path], *, vehicles: Sequence[int] | None = None
    ) -> None: ...
    def reset(self) -> None: ...
    states: Final[list[State]]
    def __len__(self) -> int: ...
    def __setstate__(self, kept: tuple[list[State], list[Path | None]]) -> None: ...

@final
class CoupledLongitudinal:
    def __new__(cls, params: CoupledLongitudinalParams | None = None) -> Self: ...
    def step(self, speed: float, steer: float) -> tuple[float, float]: ...
    params: Final[CoupledLongitudinalParams]

@final
class SpeedPid(_Stateful[SpeedPidParams]):
    def __new__(cls, params: SpeedPidParams | None = None) -> Self: ...
    def step(self, speed: float, target_speed: float, dt: float) -> tuple[float, float]: ...
    def reset(self) -> None: ...

@final
class SpeedCommand(_Answer):
    acceleration: float
    speed: float
    reference_speed: float
    distance_to_stop: float
    reverse: bool
    standing: bool
    cannot_stop: bool
    phase: str
    status: Status

@final
class SpeedTracker(_Stateful[SpeedTrackerParams]):
    def __new__(
        cls, path: Path, vehicle: Vehicle | None = None, params: SpeedTrackerParams | None = None
    ) -> Self: ...
    def step(
        self,
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
        *,
        pose_age: float = 0.0,
        reverse_gear: bool | None = None,
        stop: bool = False,
    ) -> SpeedCommand: ...
    def set_path(self, path: Path) -> None: ...
    def reset(self) -> None: ...
    path: Final[Path]
    vehicle: Final[Vehicle]
    plan: Final[_Floats]

@final
class Episodes:
    def __new__(
        cls,
        count: int,
        preview: Sequence[float],
        weights: tuple[float, float, float, float, float],
        *,
        longitudinal: CoupledLongitudinal | SpeedPid | None = None,
        settings: Settings | None = None,
        stall_time: float | None = None,
    ) -> Self: ...
    def __len__(self) -> int: ...
    def begin(
        self, vehicle: int, path: Path, plant: _Plant | PythonPlant, start: _Pose, speed: float, /
    ) -> None: ...
    def step(self, actions: _Floats, rest: _Flags, /) -> _Looked: ...
    def look(self) -> _Looked: ...
    def ending(self, vehicle: int, /) -> str | None: ...
    @staticmethod
    def figures() -> dict[str, float]: ...
    @staticmethod
    def info_names() -> list[str]: ...

@final
class Simulation:
    def __new__(
        cls,
        path: Path,
        plant: _Plant | PythonPlant | None = None,
        *,
        start: _Pose,
        speed: float = 0.0,
        tracked_point: float | None = None,
        settings: Settings | None = None,
    ) -> Self: ...
    @property
    def state(self) -> tuple[float, float, float, float]: ...
    path: Final[Path]
    plant: Final[str]
    vehicle: Final[Vehicle]
    settings: Final[Settings]
    time: Final[float]
    reverse: Final[bool]
    progress: Final[float]
    is_finished: Final[bool]
    is_over: Final[bool]
    ending: Final[str | None]
    reference_speed: Final[float | None]
    def step(
        self, steer: float, throttle: float = 0.0, brake: float = 0.0, reverse: bool = False
    ) -> None: ...
    def drive(
        self,
        controller: object,
        longitudinal: _Longitudinal | None = None,
        progress: Callable[[float], object] | None = None,
        *,
        noise: Noise | None = None,
        seed: int = 0,
        pedals: PedalMap | None = None,
    ) -> None: ...
    def metrics(self) -> dict[str, Any]: ...
    def records(self) -> dict[str, NDArray[Any]]: ...

@final
class _EmptyCall(_Steering):
    def __new__(cls) -> Self: ...
    def reset(self) -> None: ...

@final
class _InFlight:
    def __new__(cls, vehicle: Vehicle) -> Self: ...
    def advance(
        self, last: float, dt: float, x: float, y: float, yaw: float, speed: float
    ) -> tuple[float, float, float, float, float]: ...

_speed_defaults: dict[str, float]

def _path_curvature(path: Path, smoothing_length: float) -> _Floats: ...
def _path_headings(
    path: Path, base: float, segment: int, arc_length: float, distances: _Floats
) -> _Floats: ...
def _with_speed(path: Path, speed: _Floats) -> Path: ...
def _path_cusps(path: Path) -> _Flags: ...
def _plan_speeds(
    curvature: _Floats,
    spacing: _Floats,
    *,
    sharp: _Floats,
    closed: bool,
    cusps: _Flags | None,
    speed_limits: _Floats | None,
    grade: _Floats | None,
    start_speed: float | None,
    end_speed: float | None,
    max_speed: float,
    max_lateral_acceleration: float,
    acceleration: tuple[_Floats, _Floats],
    deceleration: tuple[_Floats, _Floats],
    longitudinal_grip: float | None,
    exponent: float,
    vehicle: Vehicle,
) -> tuple[_Floats, NDArray[np.uint8]]: ...
def _recursion(kept: _Floats, added: _Floats) -> _Floats: ...
def _lagged(given: _Floats, lags: _Floats, cell: float) -> _Floats: ...

@final
class _Wheels:
    def __new__(cls, times: _Floats, commands: _Floats, lag: float, rate: float | None) -> Self: ...
    @property
    def times(self) -> _Floats: ...
    @property
    def commands(self) -> _Floats: ...
    @property
    def lag(self) -> float: ...
    @property
    def rate(self) -> float | None: ...
    @property
    def angle(self) -> _Floats: ...
    @property
    def turning(self) -> _Floats: ...
    def at(self, times: _Floats) -> _Floats: ...
    def integral(self, times: _Floats) -> _Floats: ...
    def behind_play(
        self, edges: _Floats, dead_time: float, scale: float, offset: float, play: float
    ) -> _Floats: ...

# Parameters, as they are declared in Rust: `make declared` writes them.

@final
class Vehicle(_Vehicle):
    wheelbase: float = 3.0
    width: float | None = None
    rear_axle: float = 0.0
    antenna_left: float = 0.0
    antenna_height: float = 0.0
    no_slip_point: float | None = None
    turning_wheelbase: float | None = None
    understeer: float = 0.0
    steer_offset: float = 0.0
    steer_lag: float = 0.1
    dead_time: float = 0.0
    max_steer: float = 1.22
    max_steer_rate: float | None = None
    steer_play: float = 0.0
    max_lateral_acceleration: float | None = 4.0
    max_speed: float | None = None
    max_acceleration: float | None = None
    max_deceleration: float | None = None
    brake_deceleration: float | None = None
    drive_delay: float = 0.1
    drive_lag: float = 0.0
    stop_point: float | None = None
    steers_at_rest: bool = False

@final
class AdaptParams(_Params):
    turn_time: float = 10.0
    slip_time: float = 5.0
    speed_time: float = 20.0

@final
class MonitorParams(_Params):
    deviation_limit: float | None = None
    join_limit: float | None = None
    turn_tolerance: float = 0.01

@final
class PopParams(_LawParams):
    lookahead_gain: float = 0.2
    min_lookahead: float | None = None
    steer_span: float = 0.05235987755982989
    candidate_count: int = 21
    exact_lookahead: bool = True
    lookahead_tolerance: float | None = None
    window_ahead: float | None = None
    grid_spacing: float | None = None
    search_distance: float | None = None
    lost_distance: float | None = None

@final
class PreviewPopParams(_LawParams):
    steer_span_rate: float | None = None
    horizon: float = 1.0
    heading_cost: float | None = None
    steer_rate_cost: float | None = None
    approach_angle: float = 0.25
    min_speed: float | None = None
    smoothing_length: float | None = None
    search_distance: float | None = None
    lost_distance: float | None = None

@final
class PidParams(_LawParams):
    kp: float | None = None
    ki: float | None = None
    kd: float | None = None
    buffer_length: int = 500
    integral_with_dt: bool = True
    smoothing_length: float | None = None
    derivative_filter: float = 0.05
    search_distance: float | None = None
    lost_distance: float | None = None

@final
class PurePursuitParams(_LawParams):
    lookahead_gain: float = 0.9
    min_lookahead: float | None = None
    alpha_by_arccos: bool = False
    exact_lookahead: bool = True
    lookahead_tolerance: float | None = None
    window_ahead: float | None = None
    grid_spacing: float | None = None
    search_distance: float | None = None
    lost_distance: float | None = None

@final
class StanleyParams(_LawParams):
    cross_track_gain: float = 1.5
    speed_gain: float = 1.3
    softening: float | None = None
    heading_behind: bool = False
    smoothing_length: float | None = None
    search_distance: float | None = None
    lost_distance: float | None = None

@final
class CoupledLongitudinalParams(_Params):
    cutoff: float = 0.5
    steer_limit: float = 1.22
    speed_limit: float = 69.44

@final
class SpeedPidParams(_Params):
    kp: float = 0.5
    ki: float = 0.1
    kd: float = 0.0

@final
class SpeedTrackerParams(_Params):
    kp: float = 1.5
    disturbance_time: float = 1.0
    max_jerk: float | None = None
    reserve: float = 0.4
    drive_delay: float | None = None

@final
class DriverParams(_Params):
    hold_time: float = 0.5

@final
class CarlaIdentified(_CorePlant):
    def __new__(
        cls,
        vehicle: Vehicle | None = None,
        *,
        throttle_lag: float = 0.25,
        drive: float = 6.0,
        drag: float = 0.28,
        air_drag: float = 0.001,
        bend_loss: float = 0.11,
        braking: float = 9.0,
    ) -> Self: ...
    throttle_lag: Final[float]
    drive: Final[float]
    drag: Final[float]
    air_drag: Final[float]
    bend_loss: Final[float]
    braking: Final[float]

@final
class KinematicBicycle(_CorePlant):
    def __new__(
        cls,
        vehicle: Vehicle | None = None,
        *,
        drive: float = 6.0,
        drag: float = 0.28,
        braking: float = 9.0,
    ) -> Self: ...
    drive: Final[float]
    drag: Final[float]
    braking: Final[float]

@final
class Noise(_Params):
    position: float = 0.0
    yaw: float = 0.0
    speed: float = 0.0

@final
class Settings(_Params):
    dt: float = 0.05
    substeps: int = 10
    stop_distance: float = 1.0
    time_limit: float = 1000.0
    give_up_distance: float = 50.0
    settling_time: float = 5.0
    keep_records: bool = True

# End of the parameters.
