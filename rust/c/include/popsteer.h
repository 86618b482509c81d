/* popsteer: path-tracking steering for cars and car-like robots.
 *
 * SI units and radians; x forward, y left, yaw counter-clockwise; positive steering to the left.
 * Handles are made by ..._new and freed by ..._free; only these two, ..._clone, ..._set_path,
 * popsteer_path_with_grade, popsteer_path_with_yaw and popsteer_vehicle_load allocate or free.
 * docs/c.md shows it in use.
 *
 * Required of the caller of each function: a pointer is NULL or leads to what its type says, for an
 * array to as many entries as its count says; a handle is NULL or one of this library that was not
 * freed. During the call no one else uses a handle that is given without const, and no one changes
 * one that is given with const.
 *
 * Made by cbindgen: do not edit. */

#ifndef POPSTEER_H
#define POPSTEER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * The version of this binary interface: it rises with every change that a program compiled
 * against an older header would not survive. Compare it with `popsteer_abi_version()`.
 */
#define POPSTEER_ABI_VERSION 3

/**
 * Of `popsteer_options.adapt` and `.monitor`: as controllers of this kind do; the default.
 */
#define POPSTEER_AUTO 0

/**
 * Of `popsteer_options.adapt` and `.monitor`: not at all.
 */
#define POPSTEER_OFF 1

/**
 * Of `popsteer_options.adapt` and `.monitor`: with the numbers beside it.
 */
#define POPSTEER_ON 2

/**
 * Keeps its plan.
 */
#define POPSTEER_PHASE_DRIVING 0

/**
 * Brakes for a stop.
 */
#define POPSTEER_PHASE_STOPPING 1

/**
 * Is held at its stop.
 */
#define POPSTEER_PHASE_STANDING 2

/**
 * Stands until its wheels are turned.
 */
#define POPSTEER_PHASE_TURNING 3

/**
 * Stands until its gear is in.
 */
#define POPSTEER_PHASE_SHIFTING 4

/**
 * Brakes or stands as it was told to, for a fault, or as long as nothing is known of it.
 */
#define POPSTEER_PHASE_STOPPED 5

/**
 * Degraded: more angle, lateral acceleration or speed of the wheels is wanted than the vehicle
 * allows. The command is limited.
 */
#define POPSTEER_STATUS_SATURATED 1

/**
 * Degraded: no point ahead lies on the lookahead circle. A stand-in is aimed at.
 */
#define POPSTEER_STATUS_LOOKAHEAD_LOST 2

/**
 * Degraded: past the end of the path. The last segment is followed on as a straight line.
 */
#define POPSTEER_STATUS_END_OF_PATH 4

/**
 * Degraded: the vehicle was farther than `lost_distance` from its place on the path, and was
 * looked for on the whole of it.
 */
#define POPSTEER_STATUS_OFF_PATH 8

/**
 * Degraded: the input was refused, or its `dt` is no control period. The last command is held.
 */
#define POPSTEER_STATUS_INPUT_HELD 16

/**
 * Fault: the same of more inputs in a row than are held. Stop.
 */
#define POPSTEER_STATUS_INPUT_LOST 32

/**
 * Fault: the measured cross-track error is beyond `deviation_limit`, once it was within.
 */
#define POPSTEER_STATUS_DEVIATING 64

/**
 * Fault: the vehicle turns otherwise than the commands explain, or did so within the last 2 s, or
 * its poses and its speed do not belong together.
 */
#define POPSTEER_STATUS_IMPLAUSIBLE 128

/**
 * Degraded: the best plan within the vehicle's limits was not found in the time that a step may
 * take. The command is that of the best plan found.
 */
#define POPSTEER_STATUS_PLAN_CUT_SHORT 256

/**
 * Degraded: the position repeats the last one, though the vehicle drives; it is rolled forward.
 */
#define POPSTEER_STATUS_POSE_STALE 512

/**
 * Degraded: the pose is farther off than speed and wheels explain; the expected one takes its
 * place.
 */
#define POPSTEER_STATUS_OUTLIER 1024

/**
 * Degraded, with `POPSTEER_STATUS_SATURATED`: the largest angle of the wheels limits.
 */
#define POPSTEER_STATUS_STEER_LIMIT 2048

/**
 * Degraded, with `POPSTEER_STATUS_SATURATED`: the rate of the wheels limits.
 */
#define POPSTEER_STATUS_RATE_LIMIT 4096

/**
 * Degraded, with `POPSTEER_STATUS_SATURATED`: the lateral acceleration limits.
 */
#define POPSTEER_STATUS_LATERAL_LIMIT 8192

/**
 * Degraded: the lateral acceleration is beyond the vehicle's limit by the measured turn, or, for
 * preview POP, will be in a bend ahead even if the vehicle brakes in comfort.
 */
#define POPSTEER_STATUS_TOO_FAST 16384

/**
 * All faults: stop the vehicle where any of these bits is set.
 */
#define POPSTEER_STATUS_FAULTS 224

/**
 * What a function came to. Everything but `POPSTEER_ERROR_NONE` left all handles as they were;
 * `popsteer_last_error_message` says more.
 */
enum popsteer_error
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * No error: it is done.
     */
    POPSTEER_ERROR_NONE = 0,
    /**
     * A pointer that is needed is NULL, or not aligned.
     */
    POPSTEER_ERROR_NULL = 1,
    /**
     * A handle of another kind, one that was freed, or no handle at all, as far as that shows.
     */
    POPSTEER_ERROR_HANDLE = 2,
    /**
     * A field of a vehicle, of parameters or of options is out of its range, or a vehicle's file is
     * wrong.
     */
    POPSTEER_ERROR_CONFIG = 3,
    /**
     * The waypoints make no path.
     */
    POPSTEER_ERROR_PATH = 4,
    /**
     * A number given to a step is not finite or beyond its bound.
     */
    POPSTEER_ERROR_INPUT = 5,
    /**
     * There was no step yet that could be gone on from.
     */
    POPSTEER_ERROR_NO_STEP = 6,
    /**
     * There is not enough memory.
     */
    POPSTEER_ERROR_MEMORY = 7,
    /**
     * A fault of popsteer itself.
     */
    POPSTEER_ERROR_INTERNAL = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum popsteer_error popsteer_error;
#else
typedef int32_t popsteer_error;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Many vehicles, each with its controller. One thread at a time may use a batch; for several
 * threads make a batch for each.
 */
typedef struct popsteer_batch popsteer_batch;

/**
 * A controller: who steers along which path, and what is remembered. One thread at a time may use
 * one; different ones on different threads are independent of each other.
 */
typedef struct popsteer_controller popsteer_controller;

/**
 * A driver: who steers and drives along which path, and what is remembered. One thread at a time may
 * use one.
 */
typedef struct popsteer_driver popsteer_driver;

/**
 * A path: waypoints that never change. Many controllers may share one, on any number of threads;
 * the handle may be freed while they do.
 */
typedef struct popsteer_path popsteer_path;

/**
 * A speed tracker: the speeds planned along a path, and what keeps them. One thread at a time may
 * use one.
 */
typedef struct popsteer_speed_tracker popsteer_speed_tracker;

/**
 * The pose of the vehicle's point, and the speed.
 */
typedef struct popsteer_vehicle_state {
    /**
     * Position [m], within 1e9.
     */
    double x;
    /**
     * Position [m], within 1e9.
     */
    double y;
    /**
     * Heading [rad], counter-clockwise from x, within 1e6.
     */
    double yaw;
    /**
     * Speed [m/s], negative while rolling backwards, within 1e4.
     */
    double speed;
} popsteer_vehicle_state;

/**
 * What a vehicle may report beside pose and speed.
 */
typedef struct popsteer_reported {
    /**
     * The command that was applied since the last step in place of the controller's [rad]: a
     * driver's or another controller's. NAN: the controller's.
     */
    double applied_steer;
    /**
     * The angle of the wheels now, as a sensor measured it [rad], on the scale of the commands.
     * NAN: not measured.
     */
    double measured_steer;
    /**
     * How long before the step pose and speed were measured [s], 0 to 1.
     */
    double pose_age;
    /**
     * How far the vehicle is rolled to its right [rad], positive where its right side is lower.
     */
    double roll;
} popsteer_reported;

/**
 * What one step answers.
 */
typedef struct popsteer_command {
    /**
     * Angle of the front wheels to command [rad], positive to the left.
     */
    double steer;
    /**
     * Offset of the tracked point of the measured vehicle from the path [m], positive left of it.
     */
    double cross_track_error;
    /**
     * Yaw of the measured vehicle less direction of the path [rad], in [-pi, pi].
     */
    double heading_error;
    /**
     * Cross-track error of the vehicle as it will be when the command reaches the wheels [m].
     */
    double predicted_cross_track_error;
    /**
     * Heading error of that vehicle [rad].
     */
    double predicted_heading_error;
    /**
     * The point aimed at [m].
     */
    double target_x;
    /**
     * The point aimed at [m].
     */
    double target_y;
    /**
     * The path's speed beside the rear axle [m/s], negative where it is driven backwards; NAN
     * where the path has no speeds.
     */
    double reference_speed;
    /**
     * Distance that the rear axle has to go to the next cusp, or to the end [m]; negative past the
     * end, INFINITY on a closed path without cusps.
     */
    double distance_to_stop;
    /**
     * How the step went: `POPSTEER_STATUS_...` bits; 0 is as the controller wants it.
     */
    uint32_t status;
    /**
     * Whether the path is driven backwards here.
     */
    bool reverse;
} popsteer_command;

/**
 * What the motion has shown of the vehicle.
 */
typedef struct popsteer_estimate {
    /**
     * How many times more the vehicle turns than its figures say.
     */
    double gain;
    /**
     * Angle of the wheels at the command 0 [rad], the vehicle's `steer_offset` included.
     */
    double steer_offset;
    /**
     * Time from a command to its first effect on the wheels [s], the vehicle's `dead_time`
     * included.
     */
    double dead_time;
    /**
     * Time constant of the wheels' response [s]: the vehicle's `steer_lag`, or less.
     */
    double steer_lag;
    /**
     * Angle of the motion of the point that does not slip to the heading, straight on [rad].
     */
    double slip;
    /**
     * How much that angle grows with the curvature [m].
     */
    double slip_length;
    /**
     * Acceleration [m/s^2].
     */
    double acceleration;
    /**
     * Ratio of the vehicle's speed to what its speed signal says.
     */
    double speed_scale;
} popsteer_estimate;

/**
 * Tuning of a driver.
 */
typedef struct popsteer_driver_params {
    /**
     * How long a signal that does not come is replaced by what is expected before that is a
     * fault [s]. Longer: more gaps are bridged. Shorter: a dead sensor is known sooner.
     * Default 0.5, in [0.0, 1000.0].
     */
    double hold_time;
} popsteer_driver_params;

/**
 * Tuning of a speed tracker.
 */
typedef struct popsteer_speed_tracker_params {
    /**
     * Share of an error of the speed that is corrected in a second [1/s]. Default 1.5, in
     * [0.0, 1000.0].
     */
    double kp;
    /**
     * Time constant of the estimate of slope and drag [s]. Shorter: they are known sooner, and
     * a drive that responds later than the vehicle says is taken for one. Default 1, in
     * [0.001, 1000.0].
     */
    double disturbance_time;
    /**
     * Largest change of the acceleration, of plans and of stops, too [m/s^3]. NAN: `60.0 /
     * wheelbase`, in [0.001, 1000000.0].
     */
    double max_jerk;
    /**
     * Acceleration beyond that of the plan that may correct an error [m/s^2]. Default 0.4, in
     * [0.0, 1000.0].
     */
    double reserve;
    /**
     * Delay of the drive in place of the vehicle's, to try another [s]. NAN: `drive_delay`, in
     * [0.0, 10.0].
     */
    double drive_delay;
} popsteer_speed_tracker_params;

/**
 * What a step of a driver answers.
 */
typedef struct popsteer_drive {
    /**
     * Angle to command [rad], positive to the left.
     */
    double steer;
    /**
     * Acceleration in the direction of driving [m/s^2]; negative brakes.
     */
    double acceleration;
    /**
     * Speed to command in the direction of driving [m/s], for a vehicle that takes a speed.
     */
    double speed;
    /**
     * Offset of the tracked point from the path [m], positive left of it.
     */
    double cross_track_error;
    /**
     * Yaw less direction of the path [rad], in [-pi, pi].
     */
    double heading_error;
    /**
     * Cross-track error of the vehicle as it will be when the command reaches the wheels [m].
     */
    double predicted_cross_track_error;
    /**
     * Heading error of that vehicle [rad].
     */
    double predicted_heading_error;
    /**
     * The point aimed at [m].
     */
    double target_x;
    /**
     * The point aimed at [m].
     */
    double target_y;
    /**
     * The planned speed beside the rear axle [m/s], never negative.
     */
    double reference_speed;
    /**
     * Distance that the rear axle has to go to the next stop [m]; negative past it, INFINITY if
     * there is none.
     */
    double distance_to_stop;
    /**
     * How the step went: `POPSTEER_STATUS_...` bits.
     */
    uint32_t status;
    /**
     * What the vehicle does, as of `popsteer_speed_command`.
     */
    uint32_t phase;
    /**
     * Why the vehicle stops, or has stopped; 0: it drives. `popsteer_fault_name` names it.
     */
    uint32_t fault;
    /**
     * Whether the vehicle is to be in reverse gear.
     */
    bool reverse;
    /**
     * Whether the vehicle is to be held where it stands.
     */
    bool hold;
} popsteer_drive;

/**
 * One instant of a predicted trajectory.
 */
typedef struct popsteer_predicted {
    /**
     * Time since the last step [s].
     */
    double time;
    /**
     * Pose of the vehicle's point, and speed.
     */
    struct popsteer_vehicle_state vehicle;
    /**
     * Angle commanded then [rad].
     */
    double steer;
} popsteer_predicted;

/**
 * All parameters of a car-like vehicle, given once. Begin with `popsteer_vehicle_default()` and
 * change what is known; a field marked "NAN: ..." need not be known.
 *
 * A pose is always that of the vehicle's point, wherever it is measured; the axles are given from
 * there. One chain leads from a command to the motion:
 *
 *     wheel' = clip((command(t - dead_time) + steer_offset - wheel) / steer_lag, +-max_steer_rate)
 *     |wheel| <= max_steer
 *     yaw'   = speed tan(wheel) / (turning_wheelbase + understeer speed^2)
 */
typedef struct popsteer_vehicle {
    /**
     * Distance of the axles L [m]; the default lengths of all parameters scale with it.
     * Default 3, in [0.001, 1000.0].
     */
    double wheelbase;
    /**
     * Width over all [m]: how far beside its path is too far scales with it. Absent if it is
     * two thirds of the wheelbase, as of a car. NAN: absent, in [0.001, 100.0].
     */
    double width;
    /**
     * How far ahead of the pose's point the rear axle lies [m]: 0 where the pose is the rear
     * axle's, negative where it is of a point ahead of that. Default 0, in [-1000.0, 1000.0].
     */
    double rear_axle;
    /**
     * How far to the left of the centre line the antenna lies whose position is given as the
     * pose's [m]; negative to the right. The pose's point is on the centre line beside it.
     * Default 0, in [-100.0, 100.0].
     */
    double antenna_left;
    /**
     * How high above ground it lies [m]: what a `roll` moves it aside by. Default 0, in [0.0,
     * 100.0].
     */
    double antenna_height;
    /**
     * How far ahead of the pose's point lies the no-slip point [m], the one that moves along
     * the vehicle's heading; absent if it is the rear axle. NAN: absent, in [-1000.0, 1000.0].
     */
    double no_slip_point;
    /**
     * The wheelbase that the vehicle turns by [m]; absent if it is `wheelbase`. NAN: absent,
     * in [0.001, 1000.0].
     */
    double turning_wheelbase;
    /**
     * Understeer gradient K [s^2/m]. Default 0, in [0.0, 1000.0].
     */
    double understeer;
    /**
     * Angle of the wheels at the command 0 [rad]. Default 0, in [-0.5, 0.5].
     */
    double steer_offset;
    /**
     * Time constant of the wheels' first-order response to a command [s]. Default 0.1, in
     * [0.0, 10.0].
     */
    double steer_lag;
    /**
     * Time from a command to its first effect on the wheels [s]. Default 0, in [0.0, 10.0].
     */
    double dead_time;
    /**
     * Largest angle of the front wheels `delta_max` [rad]. Default 1.22, in [0.001, 1.57].
     */
    double max_steer;
    /**
     * Largest rate of the front wheels' angle [rad/s]; absent if there is no limit. NAN:
     * absent, in [0.001, 1000000.0].
     */
    double max_steer_rate;
    /**
     * Play of the steering: by how much it turns back before the front wheels do [rad]. Plants
     * have it; prediction takes its middle. Default 0, in [0.0, 0.5].
     */
    double steer_play;
    /**
     * Largest lateral acceleration that a command may ask for [m/s^2]; absent if there is no
     * limit. Default 4; NAN: absent, in [0.001, 1000000.0].
     */
    double max_lateral_acceleration;
    /**
     * Top speed [m/s]; absent if there is no limit. NAN: absent, in [0.001, 10000.0].
     */
    double max_speed;
    /**
     * Largest driving acceleration [m/s^2]; absent if it is not known. NAN: absent, in [0.001,
     * 1000.0].
     */
    double max_acceleration;
    /**
     * Largest deceleration of a plan [m/s^2], one of comfort; absent if it is not known. NAN:
     * absent, in [0.001, 1000.0].
     */
    double max_deceleration;
    /**
     * What the brakes can do [m/s^2]: asked of them only where the vehicle would overrun a
     * stop; absent if it is not known. NAN: absent, in [0.001, 1000.0].
     */
    double brake_deceleration;
    /**
     * Time from a command to its first effect on the drive [s]. Default 0.1, in [0.0, 10.0].
     */
    double drive_delay;
    /**
     * Time constant of the drive's first-order response to the pedals [s]. Default 0, in [0.0,
     * 10.0].
     */
    double drive_lag;
    /**
     * How far ahead of the pose's point lies the point that stops at a stop line and at the
     * end of a path that is driven forwards [m]; absent if it is the rear axle. NAN: absent,
     * in [-1000.0, 1000.0].
     */
    double stop_point;
    /**
     * Whether the wheels turn while the vehicle stands: then they do so at a start and at a
     * cusp, and the speed waits for them. 0 is false. Default 0.
     */
    uint32_t steers_at_rest;
} popsteer_vehicle;

/**
 * Tuning of POP, the paper's controller.
 */
typedef struct popsteer_pop_params {
    /**
     * Velocity constant `k_v` [s]: `lookahead = min_lookahead + lookahead_gain * speed`.
     * Default 0.2, in [0.0, 1000.0].
     */
    double lookahead_gain;
    /**
     * Lookahead at rest `ld_min` [m]. NAN: `2.0 * wheelbase`, in [0.0, 10000.0].
     */
    double min_lookahead;
    /**
     * Optimization range `delta_nbd` [rad]: candidates lie at most this far from the last
     * angle. Default 0.05235987755982989, in [1e-6, 3.141592653589793].
     */
    double steer_span;
    /**
     * Optimization resolution: the number of candidates, odd. Default 21, odd and in [3,
     * 100001].
     */
    size_t candidate_count;
    /**
     * Whether the lookahead point is the path's first crossing of the circle ahead of the
     * vehicle, instead of what the paper's search finds. 0 is false. Default 1.
     */
    uint32_t exact_lookahead;
    /**
     * Threshold epsilon of the paper's search [m]. NAN: `wheelbase / 300.0`, in [1e-9,
     * 1000.0].
     */
    double lookahead_tolerance;
    /**
     * Arc ahead of the vehicle that the paper's search looks at [m]. NAN: `20.0 / 3.0 *
     * wheelbase`, in [0.001, 1000000.0].
     */
    double window_ahead;
    /**
     * Greatest distance of neighbours on the path as the paper's search re-discretises it [m].
     * NAN: `wheelbase / 300.0`, in [1e-6, 1000.0].
     */
    double grid_spacing;
    /**
     * Arc of the path that is searched on each side of the last projection [m], in addition to
     * the distance travelled in a step. NAN: `2.0 * wheelbase`, in [0.0, 1000000.0].
     */
    double search_distance;
    /**
     * Distance from the path beyond which the vehicle is lost and is searched for on the whole
     * path [m]. NAN: `10.0 * wheelbase`, in [0.001, 1000000000.0].
     */
    double lost_distance;
} popsteer_pop_params;

/**
 * How a controller adapts to its vehicle, and watches it.
 */
typedef struct popsteer_options {
    /**
     * `POPSTEER_AUTO`: adapts in preview POP, and where the vehicle has a dead time;
     * `POPSTEER_OFF`: never; `POPSTEER_ON`: with `turn_time`, `slip_time` and `speed_time`.
     */
    uint32_t adapt;
    /**
     * `POPSTEER_AUTO`: watches with the default numbers; `POPSTEER_OFF`: never;
     * `POPSTEER_ON`: with `deviation_limit` and `turn_tolerance`.
     */
    uint32_t monitor;
    /**
     * Time constant of the estimates of turning gain, understeer, steering offset and dead
     * time [s]; 0 switches them off. Shorter: a change is learnt sooner, and more noise of the
     * heading is in the estimates. Default 10, in [0.0, 1000000.0].
     */
    double turn_time;
    /**
     * Time constant of the estimated slip [s]; 0 switches it off. Shorter: faster, and more
     * noise of the position in the estimate. Default 5, in [0.0, 1000000.0].
     */
    double slip_time;
    /**
     * Time constant of the estimated scale of the speed signal [s]; 0 switches it off.
     * Shorter: wheels that begin to slip are seen sooner, and a signal that stands still while
     * the vehicle slows is taken for a scale. Default 20, in [0.0, 1000000.0].
     */
    double speed_time;
    /**
     * Cross-track error from which a vehicle that was within it is deviating [m], besides the
     * noise that is seen; 1e9 switches it off. NAN: `0.75 * width`, with `wheelbase / 1.5` for
     * a `width` that is not given, in [0.0, 1000000000.0].
     */
    double deviation_limit;
    /**
     * Cross-track error beyond which a vehicle that was never within `deviation_limit` is
     * deviating too [m]: a path that jumps away. Less than that it may join a path from.
     * Before the start of a path neither limit counts. 1e9 switches it off. NAN: `4.5 *
     * width`, with `wheelbase / 1.5` for a `width` that is not given, in [0.0, 1000000000.0].
     */
    double join_limit;
    /**
     * How far the turns may add up beyond those that the commands explain, besides noise
     * [rad]; 1e9 switches it off. Smaller: faults are found sooner, false alarms are likelier.
     * Default 0.01, in [0.0, 1000000000.0].
     */
    double turn_tolerance;
} popsteer_options;

/**
 * Tuning of preview POP.
 */
typedef struct popsteer_preview_pop_params {
    /**
     * Optimization range `delta_nbd` over the control period [rad/s]: an angle lies at most
     * this times dt from the last one. The paper has 3 degrees in 50 ms, which are the 60
     * degrees a second of the default. NAN: `max_steer_rate`, or 60 degrees a second where
     * that is not given, in [0.001, 1000000.0].
     */
    double steer_span_rate;
    /**
     * How long the prediction looks ahead [s]. Longer: bends are entered earlier and a lag is
     * anticipated. If it is shorter than the lag and the return to the path, the vehicle
     * oscillates. Up to twice as long below a wheelbase in 0.6 s, and if the vehicle has a
     * `max_steer_rate` and its wheels need it. Default 1, in [0.05, 100.0].
     */
    double horizon;
    /**
     * How many metres of cross-track error are as bad as 1 rad of heading error [m/rad]. More:
     * the path is joined more gently, and offsets take longer to vanish. NAN: `wheelbase`, in
     * [0.0, 1000.0].
     */
    double heading_cost;
    /**
     * How many metres of cross-track error are as bad as turning the wheels at 1 rad/s [m
     * s/rad]. More: calmer wheels, less noise passed on, wider bends where the model is wrong.
     * NAN: `wheelbase / 12.0`, in [1e-5, 1000.0].
     */
    double steer_rate_cost;
    /**
     * Heading at which the path is approached from afar [rad]; less if the vehicle's limits
     * would not straighten it in time. More: sooner back on the path, by a sharper manoeuvre.
     * Default 0.25, in [0.001, 1.5707963267948966].
     */
    double approach_angle;
    /**
     * Below this speed [m/s] the wheels turn in proportion to the distance travelled, and the
     * prediction looks as far as at this speed; at rest they keep their angle, unless the
     * vehicle has `steers_at_rest`. Where the vehicle's `max_steer_rate` is given, they turn
     * at all of it down to half this speed. NAN: `wheelbase / 3.0` with `steers_at_rest` or
     * `max_steer_rate`, else `wheelbase / 0.6`, in [0.0001, 10000.0].
     */
    double min_speed;
    /**
     * Length of path over which its direction is taken [m]. More: less of the waypoints' noise
     * is steered, and bends shorter than this are cut. NAN: `wheelbase * 0.2` with
     * `steers_at_rest`, else `wheelbase * 2.0 / 3.0`, in [0.0, 1000.0].
     */
    double smoothing_length;
    /**
     * Arc of the path that is searched on each side of the last projection [m], in addition to
     * the distance travelled in a step. NAN: `2.0 * wheelbase`, in [0.0, 1000000.0].
     */
    double search_distance;
    /**
     * Distance from the path beyond which the vehicle is lost and is searched for on the whole
     * path [m]. NAN: `10.0 * wheelbase`, in [0.001, 1000000000.0].
     */
    double lost_distance;
} popsteer_preview_pop_params;

/**
 * Tuning of PID on the cross-track error of the front axle.
 */
typedef struct popsteer_pid_params {
    /**
     * Proportional gain `k_P` [rad/m]. NAN: `0.25 * (3.0 / wheelbase)`, in [0.0, 1000000.0].
     */
    double kp;
    /**
     * Integral gain `k_I` [rad/(m s)], or [rad/m] without `integral_with_dt`. NAN: `0.01 *
     * (3.0 / wheelbase)`, in [0.0, 1000000.0].
     */
    double ki;
    /**
     * Derivative gain `k_D` [rad s/m]. NAN: `0.2 * (3.0 / wheelbase)`, in [0.0, 1000000.0].
     */
    double kd;
    /**
     * How many of the last errors the integral sums, against wind-up. Default 500, a count in
     * [1, 500].
     */
    size_t buffer_length;
    /**
     * Whether the integral weighs each error with its dt, as the published code does; the
     * paper's equation sums the bare errors. 0 is false. Default 1.
     */
    uint32_t integral_with_dt;
    /**
     * Length of path over which its heading is taken [m]. The derivative is then how fast the
     * front axle moves across that heading, which noise of the waypoints hardly reaches. 0:
     * that of the error, as printed. NAN: `2.0 * wheelbase`, in [0.0, 10000.0].
     */
    double smoothing_length;
    /**
     * Time constant of the first-order filter of the derivative [s]: the common Td/N with N =
     * 16 at the paper's gains. Without it (0, as printed) noise counts as often as inputs
     * come, and wheels without a lag oscillate above 1/`kd` m/s, for the front axle moves
     * across the path as soon as they turn. Default 0.05, in [0.0, 1000.0].
     */
    double derivative_filter;
    /**
     * Arc of the path that is searched on each side of the last projection [m], in addition to
     * the distance travelled in a step. NAN: `2.0 * wheelbase`, in [0.0, 1000000.0].
     */
    double search_distance;
    /**
     * Distance from the path beyond which the vehicle is lost and is searched for on the whole
     * path [m]. NAN: `10.0 * wheelbase`, in [0.001, 1000000000.0].
     */
    double lost_distance;
} popsteer_pid_params;

/**
 * Tuning of pure pursuit of the rear axle.
 */
typedef struct popsteer_pure_pursuit_params {
    /**
     * Velocity constant `k_v` [s]: `lookahead = max(min_lookahead, lookahead_gain * speed)`.
     * Default 0.9, in [0.0, 1000.0].
     */
    double lookahead_gain;
    /**
     * Least lookahead [m]. NAN: `10.0 / 3.0 * wheelbase`, in [0.0, 10000.0].
     */
    double min_lookahead;
    /**
     * Whether alpha is taken as the published code does, `acos(heading . line / lookahead)`,
     * instead of as the angle between heading and line. The grid point lies up to the
     * threshold inside the circle, so that reading never sees less than about `sqrt(2
     * tolerance / lookahead)`: the wheels chatter about straight ahead, and the path is
     * tracked more tightly. 0 is false. Default 0.
     */
    uint32_t alpha_by_arccos;
    /**
     * Whether the lookahead point is the path's first crossing of the circle ahead of the
     * vehicle, instead of what the paper's search finds. 0 is false. Default 1.
     */
    uint32_t exact_lookahead;
    /**
     * Threshold epsilon of the paper's search [m]. NAN: `wheelbase / 300.0`, in [1e-9,
     * 1000.0].
     */
    double lookahead_tolerance;
    /**
     * Arc ahead of the vehicle that the paper's search looks at [m]. NAN: `20.0 / 3.0 *
     * wheelbase`, in [0.001, 1000000.0].
     */
    double window_ahead;
    /**
     * Greatest distance of neighbours on the path as the paper's search re-discretises it [m].
     * NAN: `wheelbase / 300.0`, in [1e-6, 1000.0].
     */
    double grid_spacing;
    /**
     * Arc of the path that is searched on each side of the last projection [m], in addition to
     * the distance travelled in a step. NAN: `2.0 * wheelbase`, in [0.0, 1000000.0].
     */
    double search_distance;
    /**
     * Distance from the path beyond which the vehicle is lost and is searched for on the whole
     * path [m]. NAN: `10.0 * wheelbase`, in [0.001, 1000000000.0].
     */
    double lost_distance;
} popsteer_pure_pursuit_params;

/**
 * Tuning of Stanley, by the front axle.
 */
typedef struct popsteer_stanley_params {
    /**
     * Crosstrack error constant `k_chi` [1/s]. Default 1.5, in [0.0, 1000000.0].
     */
    double cross_track_gain;
    /**
     * Velocity constant `k_v`. Default 1.3, in [0.0, 1000000.0].
     */
    double speed_gain;
    /**
     * Softening constant `k_s` [m/s], which keeps the quotient finite at rest. NAN: `1.0 / 3.0
     * * wheelbase`, in [1e-9, 1000000.0].
     */
    double softening;
    /**
     * Whether the path's heading is that of the segment behind the nearest waypoint, as in the
     * published code, instead of that at the closest point. 0 is false. Default 0.
     */
    uint32_t heading_behind;
    /**
     * Length of path over which its heading is taken [m]. More: less of the waypoints' noise
     * is steered, and bends shorter than this are cut. 0, or `heading_behind`: the heading of
     * one segment, as printed. NAN: `wheelbase`, in [0.0, 10000.0].
     */
    double smoothing_length;
    /**
     * Arc of the path that is searched on each side of the last projection [m], in addition to
     * the distance travelled in a step. NAN: `2.0 * wheelbase`, in [0.0, 1000000.0].
     */
    double search_distance;
    /**
     * Distance from the path beyond which the vehicle is lost and is searched for on the whole
     * path [m]. NAN: `10.0 * wheelbase`, in [0.001, 1000000000.0].
     */
    double lost_distance;
} popsteer_stanley_params;

/**
 * What a step of a speed tracker answers.
 */
typedef struct popsteer_speed_command {
    /**
     * Acceleration in the direction of driving [m/s^2]; negative brakes.
     */
    double acceleration;
    /**
     * Speed to command in the direction of driving [m/s], for a vehicle that takes a speed: never
     * above the top speed; negative only while it still rolls the other way.
     */
    double speed;
    /**
     * Speed that the path allows beside the rear axle [m/s], never negative.
     */
    double reference_speed;
    /**
     * Distance along the path to the next stop [m]: a cusp, the end, or a speed of 0; INFINITY where
     * there is none.
     */
    double distance_to_stop;
    /**
     * Whether the vehicle is to drive backwards.
     */
    bool reverse;
    /**
     * Whether the vehicle is to be held where it stands.
     */
    bool standing;
    /**
     * Whether it overruns its stop, however hard it brakes, or stands beyond it.
     */
    bool cannot_stop;
    /**
     * What the vehicle does: `POPSTEER_PHASE_...`.
     */
    uint32_t phase;
    /**
     * What is known of the inputs: `POPSTEER_STATUS_...`.
     */
    uint32_t status;
} popsteer_speed_command;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The `POPSTEER_ABI_VERSION` of the library that is linked, for comparison with the header's.
 */
uint32_t popsteer_abi_version(void);

/**
 * The version of popsteer, such as "0.3.0".
 */
const char *popsteer_version(void);

/**
 * Makes a batch of copies of `count` controllers, in the state in which they are; they may be of
 * several kinds, and may be freed afterwards.
 */
popsteer_error popsteer_batch_new(const struct popsteer_controller *const *controllers,
                                  size_t count,
                                  struct popsteer_batch **out);

/**
 * How many vehicles a batch has; 0 where `batch` is no batch.
 */
size_t popsteer_batch_size(const struct popsteer_batch *batch);

/**
 * Checks lengths of arrays before a step, for languages whose arrays know theirs: `vehicles` and
 * `out` have to be as long as the batch, and `reported` too, or 0. `POPSTEER_ERROR_INPUT` where
 * one is not; the message names it.
 */
popsteer_error popsteer_batch_check_lengths(const struct popsteer_batch *batch,
                                            size_t vehicles,
                                            size_t reported,
                                            size_t out);

/**
 * Takes one control step with every vehicle: `vehicles` and `out` have an entry for each, and so
 * has `reported`, which may be NULL. Each answer is that of `popsteer_step`, to the bit.
 *
 * Where an input is refused, `POPSTEER_ERROR_INPUT`, no vehicle has moved and `out` is unchanged;
 * the message names the first of them. Nothing is allocated.
 */
popsteer_error popsteer_batch_step(struct popsteer_batch *batch,
                                   const struct popsteer_vehicle_state *vehicles,
                                   double dt,
                                   const struct popsteer_reported *reported,
                                   struct popsteer_command *out);

/**
 * Takes one control step with every vehicle, and answers whatever comes in: each answer is that of
 * `popsteer_step_or_hold`, to the bit.
 */
popsteer_error popsteer_batch_step_or_hold(struct popsteer_batch *batch,
                                           const struct popsteer_vehicle_state *vehicles,
                                           double dt,
                                           size_t hold_limit,
                                           const struct popsteer_reported *reported,
                                           struct popsteer_command *out);

/**
 * Has one vehicle follow another path from its next step on; see `popsteer_controller_set_path`.
 */
popsteer_error popsteer_batch_set_path(struct popsteer_batch *batch,
                                       size_t vehicle,
                                       const struct popsteer_path *path);

/**
 * Takes every vehicle back to before its first step.
 */
popsteer_error popsteer_batch_reset(struct popsteer_batch *batch);

/**
 * Frees a batch; NULL is left alone.
 */
popsteer_error popsteer_batch_free(struct popsteer_batch *batch);

/**
 * No angle but the last command was applied, and the pose is that of now.
 */
struct popsteer_reported popsteer_reported_default(void);

/**
 * Takes a controller back to before its first step, with straight wheels.
 */
popsteer_error popsteer_controller_reset(struct popsteer_controller *controller);

/**
 * Takes a controller back to before its first step, for a vehicle that a driver hands over,
 * steering at the angle `steer` [rad]: it goes on from there without a jump.
 */
popsteer_error popsteer_controller_reset_to(struct popsteer_controller *controller, double steer);

/**
 * Follows another path from the next step on; may be called before every step, as a planner gives
 * its paths. The place on the new path is that of the last step; integral, estimate and commands in
 * flight carry on. The old path is freed here if nobody else holds it: to have no memory freed in
 * the control loop, free its handle elsewhere, later.
 */
popsteer_error popsteer_controller_set_path(struct popsteer_controller *controller,
                                            const struct popsteer_path *path);

/**
 * Finds the vehicle's place on the whole path anew, after a jump of the vehicle or of its
 * localisation. Exact, but on long paths slower than a step.
 */
popsteer_error popsteer_controller_relocalise(struct popsteer_controller *controller,
                                              double x,
                                              double y,
                                              double yaw);

/**
 * Writes to `out` what the motion has shown of the vehicle so far.
 */
popsteer_error popsteer_controller_estimate(const struct popsteer_controller *controller,
                                            struct popsteer_estimate *out);

/**
 * How far ahead of the pose's point the tracked point lies [m], driving forward: the point whose
 * errors a command tells; NAN where `controller` is no controller.
 */
double popsteer_controller_tracked_point(const struct popsteer_controller *controller);

/**
 * Makes a second controller that stands where `controller` stands: to try something, or to go back
 * to it. It follows the same path.
 */
popsteer_error popsteer_controller_clone(const struct popsteer_controller *controller,
                                         struct popsteer_controller **out);

/**
 * Frees a controller; NULL is left alone.
 */
popsteer_error popsteer_controller_free(struct popsteer_controller *controller);

/**
 * The defaults of `popsteer_driver_params`.
 */
struct popsteer_driver_params popsteer_driver_params_default(void);

/**
 * The name of a fault of `popsteer_drive`, such as "position": what it blames. NULL for 0 and for a
 * number of none. "position", "heading", "speed": that signal; "steering": the vehicle turns otherwise
 * than commanded; "input": nothing comes; "deviation": too far off the path; "path": the path is not
 * where the vehicle is; "cannot-stop": it overruns its stop, however hard it brakes.
 */
const char *popsteer_fault_name(uint32_t fault);

/**
 * Makes a driver that steers by a copy of `controller`, along its path, and plans its speeds: as fast as
 * the vehicle's limits allow, and at most the path's own.
 *
 * `speed` and `params` may be NULL for their defaults. `controller` may be freed afterwards. `out` gets
 * the driver, which is freed by `popsteer_driver_free`. `POPSTEER_ERROR_CONFIG` names a field that is
 * out of its range.
 */
popsteer_error popsteer_driver_new(const struct popsteer_controller *controller,
                                   const struct popsteer_speed_tracker_params *speed,
                                   const struct popsteer_driver_params *params,
                                   struct popsteer_driver **out);

/**
 * Takes one control step, and answers whatever comes in.
 *
 * `vehicle`: pose of the vehicle's point, and speed; a number that is not finite or beyond its bound has
 * not come, and what is expected stands in for it, until that is a fault. `dt`: time since the last
 * step [s]; one that is none, as of a stamp that repeats, counts as no time. `reported`: what the
 * vehicle reports besides, or NULL. `gear`: 1 where reverse gear is in, 0 where it is not, negative
 * where that is not reported. `out` gets what to do.
 *
 * Only NULL and wrong handles are errors. Nothing is allocated.
 */
popsteer_error popsteer_driver_step(struct popsteer_driver *driver,
                                    struct popsteer_vehicle_state vehicle,
                                    double dt,
                                    const struct popsteer_reported *reported,
                                    int32_t gear,
                                    struct popsteer_drive *out);

/**
 * Follows another path from the next step on, its speeds planned at once: this allocates. Place, angle
 * and estimates carry on. `POPSTEER_ERROR_CONFIG` where a limit is out of the range of a plan; nothing
 * has changed then.
 */
popsteer_error popsteer_driver_set_path(struct popsteer_driver *driver,
                                        const struct popsteer_path *path);

/**
 * Brakes the vehicle to a stand in comfort, and holds it, for as long as `held` is true: the operator's
 * stop.
 */
popsteer_error popsteer_driver_hold(struct popsteer_driver *driver,
                                    bool held);

/**
 * Forgets the fault for which the vehicle stopped, and drives again: it is looked for about its last
 * place. `fault`, which may be NULL, gets what it was.
 */
popsteer_error popsteer_driver_release(struct popsteer_driver *driver,
                                       uint32_t *fault);

/**
 * Takes a driver back to before its first step, with the wheels at the angle `steer` [rad], from which
 * it goes on without a jump.
 */
popsteer_error popsteer_driver_reset(struct popsteer_driver *driver,
                                     double steer);

/**
 * Writes to `out` what the motion has shown of the vehicle so far.
 */
popsteer_error popsteer_driver_estimate(const struct popsteer_driver *driver,
                                        struct popsteer_estimate *out);

/**
 * Predicts the trajectory that the vehicle is to take, one instant every `dt` [s] from the last step on,
 * into the `size` instants at `out`; `count`, which may be NULL, gets how many were written. Arguments
 * as of `popsteer_predict`.
 *
 * A copy of the driver steers and drives the vehicle as estimated: through cusps, and to its stop, or to
 * rest where it stops for a fault. `POPSTEER_ERROR_NO_STEP` before the first step. Nothing is allocated.
 */
popsteer_error popsteer_driver_predict(const struct popsteer_driver *driver,
                                       double dt,
                                       struct popsteer_predicted *out,
                                       size_t size,
                                       size_t *count);

/**
 * Frees a driver; NULL is left alone.
 */
popsteer_error popsteer_driver_free(struct popsteer_driver *driver);

/**
 * Writes why the last call of this thread that failed did so, with the name of the field and its
 * value: at most `size` bytes into `buffer`, the final NUL included. Returns the length of the whole
 * message without the NUL, as snprintf does; `buffer` may be NULL where `size` is 0. The message
 * is empty before the first failure; calls that succeed leave it.
 */
size_t popsteer_last_error_message(char *buffer,
                                   size_t size);

/**
 * What a code stands for, in a few words.
 */
const char *popsteer_error_name(int32_t error);

/**
 * Makes a POP controller, the paper's: of the angles near the last one that which leads nearest to
 * the lookahead point.
 *
 * `vehicle`, `params` and `options` may be NULL for their defaults; they are copied. `path` may be
 * freed afterwards. `out` gets the controller, which is freed by `popsteer_controller_free`.
 * `POPSTEER_ERROR_CONFIG` names a field that is out of its range.
 */
popsteer_error popsteer_pop_new(const struct popsteer_path *path,
                                const struct popsteer_vehicle *vehicle,
                                const struct popsteer_pop_params *params,
                                const struct popsteer_options *options,
                                struct popsteer_controller **out);

/**
 * Makes a preview POP controller, which plans its angles ahead within all limits of the vehicle:
 * the one for real vehicles. Arguments as of `popsteer_pop_new`.
 */
popsteer_error popsteer_preview_pop_new(const struct popsteer_path *path,
                                        const struct popsteer_vehicle *vehicle,
                                        const struct popsteer_preview_pop_params *params,
                                        const struct popsteer_options *options,
                                        struct popsteer_controller **out);

/**
 * Makes a PID controller on the cross-track error. Arguments as of `popsteer_pop_new`.
 */
popsteer_error popsteer_pid_new(const struct popsteer_path *path,
                                const struct popsteer_vehicle *vehicle,
                                const struct popsteer_pid_params *params,
                                const struct popsteer_options *options,
                                struct popsteer_controller **out);

/**
 * Makes a pure-pursuit controller: the arc of the rear axle through the lookahead point.
 * Arguments as of `popsteer_pop_new`.
 */
popsteer_error popsteer_pure_pursuit_new(const struct popsteer_path *path,
                                         const struct popsteer_vehicle *vehicle,
                                         const struct popsteer_pure_pursuit_params *params,
                                         const struct popsteer_options *options,
                                         struct popsteer_controller **out);

/**
 * Makes a Stanley controller: heading and cross-track error of the front axle. Arguments as of
 * `popsteer_pop_new`.
 */
popsteer_error popsteer_stanley_new(const struct popsteer_path *path,
                                    const struct popsteer_vehicle *vehicle,
                                    const struct popsteer_stanley_params *params,
                                    const struct popsteer_options *options,
                                    struct popsteer_controller **out);

/**
 * The defaults of `popsteer_options`.
 */
struct popsteer_options popsteer_options_default(void);

/**
 * The paper's wheelbase (3 m) and largest angle (1.22 rad), a lag of 0.1 s, 4 m/s^2 of lateral
 * acceleration; the pose is the rear axle's.
 */
struct popsteer_vehicle popsteer_vehicle_default(void);

/**
 * Whether every field is within its range; `POPSTEER_ERROR_CONFIG` and a message that names it
 * where one is not. Controllers check their vehicle by themselves.
 */
popsteer_error popsteer_vehicle_check(const struct popsteer_vehicle *vehicle);

/**
 * The defaults of `popsteer_pop_params`.
 */
struct popsteer_pop_params popsteer_pop_params_default(void);

/**
 * The defaults of `popsteer_preview_pop_params`.
 */
struct popsteer_preview_pop_params popsteer_preview_pop_params_default(void);

/**
 * The defaults of `popsteer_pid_params`.
 */
struct popsteer_pid_params popsteer_pid_params_default(void);

/**
 * The defaults of `popsteer_pure_pursuit_params`.
 */
struct popsteer_pure_pursuit_params popsteer_pure_pursuit_params_default(void);

/**
 * The defaults of `popsteer_stanley_params`.
 */
struct popsteer_stanley_params popsteer_stanley_params_default(void);

/**
 * Makes a path of `count` waypoints, which are copied.
 *
 * `x`, `y`: coordinates [m]. `speed`: reference speeds [m/s], or NULL; a segment whose speed is
 * negative is driven backwards. `reverse`: for each waypoint not 0 where the segment that begins
 * there is driven backwards, whatever the signs of the speeds, or NULL. `closed`: whether the last
 * waypoint leads back to the first.
 *
 * Mended, see `popsteer_path_mended`: waypoints at one place, neighbours swapped, a step back that the
 * path passes again, a standstill in the noise of its position, a short end that points aside. With
 * `reverse` or a negative speed folds are cusps, and only waypoints at one place are mended.
 *
 * Refused as `POPSTEER_ERROR_PATH`: fewer than two waypoints (three in a closed path), a number
 * that is not finite or beyond 1e9 m, a path that turns back on itself though nothing says that it is
 * driven backwards, a gap far longer than the spacing at which it turns, waypoints without an order.
 * `out` gets the path, which is freed by `popsteer_path_free`.
 */
popsteer_error popsteer_path_new(const double *x,
                                 const double *y,
                                 const double *speed,
                                 const uint8_t *reverse,
                                 size_t count,
                                 bool closed,
                                 struct popsteer_path **out);

/**
 * Makes a path that is `path` with the slope at each of its waypoints: rise over run, positive
 * uphill in the direction of the waypoints, and linear between them. `count` is the number of
 * waypoints. Plans and speed trackers use it.
 *
 * Refused as `POPSTEER_ERROR_PATH`: another count, a slope that is not finite or beyond 1. `out` gets
 * the path, which is freed by `popsteer_path_free`.
 */
popsteer_error popsteer_path_with_grade(const struct popsteer_path *path,
                                        const double *grade,
                                        size_t count,
                                        struct popsteer_path **out);

/**
 * Makes a path that is `path` with the vehicle's heading `yaw` [rad] and `curvature` [1/m] at each
 * of its waypoints, as its planner has them: those of the vehicle, whose yaw points against the
 * order of the waypoints where it drives backwards. `count` is the number of waypoints. One that is
 * NULL is that of the natural cubic spline through the waypoints, but there is no curvature beside
 * a `yaw`. Both NULL are for coarse waypoints without noise; `count` is not used then.
 *
 * Refused as `POPSTEER_ERROR_PATH`: another count, a number that is not finite or beyond 1e6 rad or
 * 1e3 1/m, a yaw more than 0.35 rad off the waypoints beside it, a curvature that contradicts the
 * yaw. `out` gets the path, which is freed by `popsteer_path_free`.
 */
popsteer_error popsteer_path_with_yaw(const struct popsteer_path *path,
                                      const double *yaw,
                                      const double *curvature,
                                      size_t count,
                                      struct popsteer_path **out);

/**
 * The length of a path [m], the way from the last waypoint to the first of a closed one included;
 * NAN where `path` is no path.
 */
double popsteer_path_length(const struct popsteer_path *path);

/**
 * How many faults of the waypoints were mended when the path was made; 0 where `path` is no path.
 */
size_t popsteer_path_mended(const struct popsteer_path *path);

/**
 * Frees a path, at the latest when the last controller that follows it is freed; NULL is left
 * alone.
 */
popsteer_error popsteer_path_free(struct popsteer_path *path);

/**
 * The defaults of `popsteer_speed_tracker_params`.
 */
struct popsteer_speed_tracker_params popsteer_speed_tracker_params_default(void);

/**
 * Makes a speed tracker, and plans the speeds: as fast as the vehicle's limits allow, and at most the
 * path's own. What the vehicle does not limit is limited to 25 m/s, 4 m/s^2 to the side, 2 m/s^2
 * driving and 3 m/s^2 braking; bends take 0.9 of the lateral acceleration.
 *
 * `vehicle` and `params` may be NULL for their defaults; they are copied. `path` may be freed
 * afterwards. `out` gets the tracker, which is freed by `popsteer_speed_tracker_free`.
 * `POPSTEER_ERROR_CONFIG` names a field that is out of its range.
 */
popsteer_error popsteer_speed_tracker_new(const struct popsteer_path *path,
                                          const struct popsteer_vehicle *vehicle,
                                          const struct popsteer_speed_tracker_params *params,
                                          struct popsteer_speed_tracker **out);

/**
 * Takes one control step of the speed.
 *
 * `vehicle`: pose of the vehicle's point, and speed, negative backwards. `dt`: time since the last
 * step that answered [s], 1e-6 to 1e3. `pose_age`: how long before the step the pose was measured [s],
 * 0 to 1. `out` gets the acceleration, and why.
 *
 * Any other finite `dt` counts as no time and holds the last command, as in `popsteer_step`; before the
 * first the vehicle is to stand. Another number that is not finite or beyond its bound is refused as
 * `POPSTEER_ERROR_INPUT`: tracker and `out` are then unchanged. Nothing is allocated.
 */
popsteer_error popsteer_speed_tracker_step(struct popsteer_speed_tracker *tracker,
                                           struct popsteer_vehicle_state vehicle,
                                           double dt,
                                           double pose_age,
                                           struct popsteer_speed_command *out);

/**
 * Keeps the speeds of another path from the next step on, planned at once: this allocates. Command,
 * estimate and place carry on. `POPSTEER_ERROR_CONFIG` where a limit is out of the range of a plan;
 * nothing has changed then.
 */
popsteer_error popsteer_speed_tracker_set_path(struct popsteer_speed_tracker *tracker,
                                               const struct popsteer_path *path);

/**
 * Writes the planned speed at each waypoint into `out` [m/s], never negative: the profile. `out` has
 * room for `size` numbers, and `count`, which may be NULL, gets how many waypoints there are; no more
 * than `size` are written.
 */
popsteer_error popsteer_speed_tracker_plan(const struct popsteer_speed_tracker *tracker,
                                           double *out,
                                           size_t size,
                                           size_t *count);

/**
 * Takes a speed tracker back to before its first step.
 */
popsteer_error popsteer_speed_tracker_reset(struct popsteer_speed_tracker *tracker);

/**
 * Frees a speed tracker; NULL is left alone.
 */
popsteer_error popsteer_speed_tracker_free(struct popsteer_speed_tracker *tracker);

/**
 * Writes the names of the conditions that hold, such as "saturated|end-of-path", or "ok": at most
 * `size` bytes into `buffer`, the final NUL included. Returns the length of all of it without the
 * NUL, as snprintf does; 255 bytes are always enough. Bits that stand for no condition have no
 * name.
 */
size_t popsteer_status_names(uint32_t status, char *buffer, size_t size);

/**
 * Takes one control step.
 *
 * `vehicle`: pose of the vehicle's point, and speed. `dt`: time since the last step that answered
 * [s], 1e-6 to 1e3. `reported`: what was applied, and how old the pose is; NULL where there is
 * nothing to report. `out` gets the command.
 *
 * Any other finite `dt`, of a clock that was set or repeats a stamp, counts as no time: `out` gets the
 * last command with `POPSTEER_STATUS_INPUT_HELD`, and beyond 10 in a row
 * `POPSTEER_STATUS_INPUT_LOST`. Another number that is not finite or beyond its bound is refused as
 * `POPSTEER_ERROR_INPUT`: controller and `out` are then unchanged. Nothing is allocated.
 */
popsteer_error popsteer_step(struct popsteer_controller *controller,
                             struct popsteer_vehicle_state vehicle,
                             double dt,
                             const struct popsteer_reported *reported,
                             struct popsteer_command *out);

/**
 * Takes one control step, and answers whatever comes in: where `popsteer_step` would refuse the
 * input, too, `out` gets the last command with `POPSTEER_STATUS_INPUT_HELD`, for up to `hold_limit`
 * inputs in a row, and `POPSTEER_STATUS_INPUT_LOST` beyond. Only NULL and wrong handles are errors.
 *
 * `dt` is the time since the last call [s]; one out of 1e-6 to 1e3 counts as no time. The next
 * step counts the time of those that were held, but for the rate limit: a held angle does not turn.
 */
popsteer_error popsteer_step_or_hold(struct popsteer_controller *controller,
                                     struct popsteer_vehicle_state vehicle,
                                     double dt,
                                     size_t hold_limit,
                                     const struct popsteer_reported *reported,
                                     struct popsteer_command *out);

/**
 * Writes the trajectory that a controller intends from the last step on into `out`, which has room
 * for `size` instants, one each `dt` [s], the last step itself first. `count`, which may be NULL,
 * gets how many were written: fewer than `size` where the trajectory leaves all bounds.
 *
 * A copy of the controller drives the vehicle as it is known by now, at its present acceleration,
 * and to the next stop at most. The controller stays as it is. `POPSTEER_ERROR_NO_STEP` before the
 * first step. Nothing is allocated; the time it takes is that of `size` steps.
 */
popsteer_error popsteer_predict(const struct popsteer_controller *controller,
                                double dt,
                                struct popsteer_predicted *out,
                                size_t size,
                                size_t *count);

/**
 * Reads a vehicle from the TOML file `file`, as Python's `Vehicle.load` does: one key a field, each
 * optional; `inf` is no limit. `out` gets the vehicle.
 *
 * `POPSTEER_ERROR_CONFIG` where the file cannot be read or is no TOML, a key is unknown, or its value
 * is of another type or out of its range: the message names file, key and value, and `out` is
 * unchanged.
 */
popsteer_error popsteer_vehicle_load(const char *file,
                                     struct popsteer_vehicle *out);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* POPSTEER_H */
