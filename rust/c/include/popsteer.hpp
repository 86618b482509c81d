// popsteer for C++17: header only, over popsteer.h.
//
// Objects own their handles. What makes one throws popsteer::Error; nothing that is called in a
// control loop throws or allocates: it answers with a popsteer_error beside its result. Compiled
// without exceptions, a constructor that fails leaves an object that is false:
// popsteer::last_error() says why.

#ifndef POPSTEER_HPP
#define POPSTEER_HPP

#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "popsteer.h"

namespace popsteer {

using Command = popsteer_command;
using Estimate = popsteer_estimate;
using Options = popsteer_options;
using Predicted = popsteer_predicted;
using Reported = popsteer_reported;
using Vehicle = popsteer_vehicle;
using VehicleState = popsteer_vehicle_state;
using PopParams = popsteer_pop_params;
using PreviewPopParams = popsteer_preview_pop_params;
using PidParams = popsteer_pid_params;
using PurePursuitParams = popsteer_pure_pursuit_params;
using StanleyParams = popsteer_stanley_params;
using SpeedTrackerParams = popsteer_speed_tracker_params;
using DriverParams = popsteer_driver_params;
using Drive = popsteer_drive;
using SpeedCommand = popsteer_speed_command;

/// A field that is not given.
inline constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// The conditions of a step, as bits of Command::status; 0 where none of them holds.
namespace status {
inline constexpr std::uint32_t saturated = POPSTEER_STATUS_SATURATED;
inline constexpr std::uint32_t lookahead_lost = POPSTEER_STATUS_LOOKAHEAD_LOST;
inline constexpr std::uint32_t end_of_path = POPSTEER_STATUS_END_OF_PATH;
inline constexpr std::uint32_t off_path = POPSTEER_STATUS_OFF_PATH;
inline constexpr std::uint32_t input_held = POPSTEER_STATUS_INPUT_HELD;
inline constexpr std::uint32_t input_lost = POPSTEER_STATUS_INPUT_LOST;
inline constexpr std::uint32_t deviating = POPSTEER_STATUS_DEVIATING;
inline constexpr std::uint32_t implausible = POPSTEER_STATUS_IMPLAUSIBLE;
inline constexpr std::uint32_t plan_cut_short = POPSTEER_STATUS_PLAN_CUT_SHORT;
inline constexpr std::uint32_t pose_stale = POPSTEER_STATUS_POSE_STALE;
inline constexpr std::uint32_t outlier = POPSTEER_STATUS_OUTLIER;
inline constexpr std::uint32_t steer_limit = POPSTEER_STATUS_STEER_LIMIT;
inline constexpr std::uint32_t rate_limit = POPSTEER_STATUS_RATE_LIMIT;
inline constexpr std::uint32_t lateral_limit = POPSTEER_STATUS_LATERAL_LIMIT;
inline constexpr std::uint32_t too_fast = POPSTEER_STATUS_TOO_FAST;
/// Stop the vehicle where any of these holds.
inline constexpr std::uint32_t faults = POPSTEER_STATUS_FAULTS;
}  // namespace status

/// The version of the library, such as "0.3.0".
[[nodiscard]] inline const char* version() noexcept { return popsteer_version(); }

/// Whether the library that is linked has the binary interface of this header.
[[nodiscard]] inline bool is_compatible() noexcept {
    return popsteer_abi_version() == POPSTEER_ABI_VERSION;
}

/// Why the last call of this thread that failed did so.
[[nodiscard]] inline std::string last_error() {
    std::string message(popsteer_last_error_message(nullptr, 0), '\0');
    popsteer_last_error_message(message.data(), message.size() + 1);
    return message;
}

/// The names of the conditions of a step, such as "saturated|end-of-path"; "ok" where there is none.
[[nodiscard]] inline std::string status_names(std::uint32_t status) {
    std::string names(popsteer_status_names(status, nullptr, 0), '\0');
    popsteer_status_names(status, names.data(), names.size() + 1);
    return names;
}

/// What a constructor throws; the message names the field and its value.
class Error : public std::runtime_error {
public:
    Error(popsteer_error code, const std::string& message)
        : std::runtime_error(message), code_(code) {}

    [[nodiscard]] popsteer_error code() const noexcept { return code_; }

private:
    popsteer_error code_;
};

/// A view of an array that belongs to somebody else, as std::span of C++20: made of a pointer and a
/// length, an array, or anything with data() and size().
template <typename T>
class Span {
public:
    constexpr Span() noexcept = default;
    constexpr Span(T* data, std::size_t size) noexcept : data_(data), size_(size) {}

    template <std::size_t N>
    constexpr Span(T (&array)[N]) noexcept : data_(array), size_(N) {}

    template <typename C,
              typename = std::enable_if_t<
                  !std::is_array_v<std::remove_reference_t<C>> &&
                  std::is_convertible_v<decltype(std::declval<C&>().data()), T*> &&
                  std::is_convertible_v<decltype(std::declval<C&>().size()), std::size_t>>>
    constexpr Span(C&& container) noexcept : data_(container.data()), size_(container.size()) {}

    [[nodiscard]] constexpr T* data() const noexcept { return data_; }
    [[nodiscard]] constexpr std::size_t size() const noexcept { return size_; }
    [[nodiscard]] constexpr bool empty() const noexcept { return size_ == 0; }
    [[nodiscard]] constexpr T* begin() const noexcept { return data_; }
    [[nodiscard]] constexpr T* end() const noexcept { return data_ + size_; }
    [[nodiscard]] constexpr T& operator[](std::size_t index) const noexcept {
        return data_[index];
    }

private:
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

namespace detail {

/// Throws where something failed; does nothing where there are no exceptions.
inline void require(popsteer_error error) {
#if defined(__cpp_exceptions)
    if (error != POPSTEER_ERROR_NONE) {
        throw Error(error, last_error());
    }
#else
    static_cast<void>(error);
#endif
}

/// Throws for arrays of unlike lengths; false where there are no exceptions.
inline bool require_length(const char* name, std::size_t length, std::size_t wanted) {
    if (length == wanted) {
        return true;
    }
#if defined(__cpp_exceptions)
    throw Error(POPSTEER_ERROR_PATH, std::string(name) + " has " + std::to_string(length) +
                                         " entries for " + std::to_string(wanted) + " waypoints");
#else
    static_cast<void>(name);
    return false;
#endif
}

/// Owns a handle.
template <typename H, popsteer_error (*Free)(H*)>
class Owner {
public:
    Owner() noexcept = default;
    explicit Owner(H* handle) noexcept : handle_(handle) {}
    Owner(Owner&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
    Owner& operator=(Owner&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    Owner(const Owner&) = delete;
    Owner& operator=(const Owner&) = delete;
    ~Owner() { Free(handle_); }

    [[nodiscard]] H* get() const noexcept { return handle_; }
    [[nodiscard]] H** out() noexcept { return &handle_; }

private:
    H* handle_ = nullptr;
};

}  // namespace detail

/// The vehicle of popsteer_vehicle_default(); a field that is not known is popsteer::none.
[[nodiscard]] inline Vehicle default_vehicle() noexcept { return popsteer_vehicle_default(); }

/// The vehicle in a TOML file. See popsteer_vehicle_load; without exceptions, the default where that
/// fails.
[[nodiscard]] inline Vehicle load_vehicle(const char* file) {
    Vehicle vehicle = default_vehicle();
    detail::require(popsteer_vehicle_load(file, &vehicle));
    return vehicle;
}

/// How a controller adapts and watches unless other parameters are given.
[[nodiscard]] inline Options default_options() noexcept { return popsteer_options_default(); }

/// A path; several controllers may share one, and outlive it.
class Path {
public:
    /// Waypoints [m], which are copied, with reference speeds [m/s] or none. A segment whose speed
    /// is negative is driven backwards; so is one whose entry in `reverse` is not 0.
    Path(Span<const double> x, Span<const double> y, Span<const double> speed = {},
         bool closed = false, Span<const std::uint8_t> reverse = {}) {
        const std::size_t count = x.size();
        if (!detail::require_length("y", y.size(), count) ||
            (!speed.empty() && !detail::require_length("speed", speed.size(), count)) ||
            (!reverse.empty() && !detail::require_length("reverse", reverse.size(), count))) {
            return;
        }
        detail::require(popsteer_path_new(x.data(), y.data(), speed.data(), reverse.data(), count,
                                          closed, handle_.out()));
    }

    /// The same path with the slope at each waypoint, positive uphill in their order.
    [[nodiscard]] Path with_grade(Span<const double> grade) const {
        Path path;
        detail::require(
            popsteer_path_with_grade(get(), grade.data(), grade.size(), path.handle_.out()));
        return path;
    }

    /// The same path with the vehicle's heading and curvature at each waypoint, as its planner has
    /// them; one that is not given is that of the spline. See popsteer_path_with_yaw.
    [[nodiscard]] Path with_yaw(Span<const double> yaw = {},
                                Span<const double> curvature = {}) const {
        Path path;
        const std::size_t count = yaw.empty() ? curvature.size() : yaw.size();
        if (curvature.empty() || detail::require_length("curvature", curvature.size(), count)) {
            detail::require(popsteer_path_with_yaw(get(), yaw.data(), curvature.data(), count,
                                                   path.handle_.out()));
        }
        return path;
    }

    /// Whether there is one: always, but after a move, or where there are no exceptions.
    explicit operator bool() const noexcept { return handle_.get() != nullptr; }

    /// Length [m].
    [[nodiscard]] double length() const noexcept { return popsteer_path_length(handle_.get()); }

    [[nodiscard]] const popsteer_path* get() const noexcept { return handle_.get(); }

private:
    Path() noexcept = default;

    detail::Owner<popsteer_path, popsteer_path_free> handle_;
};

/// What a step comes to: true where there is a command, or why there is none.
struct Result {
    popsteer_error error;
    Command command;

    explicit operator bool() const noexcept { return error == POPSTEER_ERROR_NONE; }
};

/// A controller; what steers depends on which of the classes below it is made as.
class Controller {
public:
    /// Whether there is one: always, but after a move, or where there are no exceptions.
    explicit operator bool() const noexcept { return handle_.get() != nullptr; }

    /// One control step, `dt` [s] after the last one that answered. See popsteer_step.
    [[nodiscard]] Result step(const VehicleState& vehicle, double dt) noexcept {
        Result result{};
        result.error = popsteer_step(get(), vehicle, dt, nullptr, &result.command);
        return result;
    }

    /// The same for a vehicle that reports more than pose and speed.
    [[nodiscard]] Result step(const VehicleState& vehicle, double dt,
                              const Reported& reported) noexcept {
        Result result{};
        result.error = popsteer_step(get(), vehicle, dt, &reported, &result.command);
        return result;
    }

    /// A step that answers whatever comes in: it holds the last command for up to `hold_limit`
    /// inputs in a row that `step` would refuse. See popsteer_step_or_hold.
    [[nodiscard]] Result step_or_hold(const VehicleState& vehicle, double dt,
                                      std::size_t hold_limit = 10) noexcept {
        Result result{};
        result.error =
            popsteer_step_or_hold(get(), vehicle, dt, hold_limit, nullptr, &result.command);
        return result;
    }

    /// The same for a vehicle that reports more than pose and speed.
    [[nodiscard]] Result step_or_hold(const VehicleState& vehicle, double dt,
                                      std::size_t hold_limit, const Reported& reported) noexcept {
        Result result{};
        result.error =
            popsteer_step_or_hold(get(), vehicle, dt, hold_limit, &reported, &result.command);
        return result;
    }

    /// Back to before the first step, with straight wheels.
    popsteer_error reset() noexcept { return popsteer_controller_reset(get()); }

    /// Back to before the first step, for a vehicle that is handed over steering at `steer` [rad].
    popsteer_error reset_to(double steer) noexcept {
        return popsteer_controller_reset_to(get(), steer);
    }

    /// Follows another path from the next step on. See popsteer_controller_set_path.
    popsteer_error set_path(const Path& path) noexcept {
        return popsteer_controller_set_path(get(), path.get());
    }

    /// Finds the vehicle's place on the path anew, after a jump.
    popsteer_error relocalise(double x, double y, double yaw) noexcept {
        return popsteer_controller_relocalise(get(), x, y, yaw);
    }

    /// Fills `room` with the trajectory that the controller intends, an instant each `dt` [s]; what
    /// of it is filled: nothing where that failed. See popsteer_predict.
    [[nodiscard]] Span<Predicted> predict(Span<Predicted> room, double dt) const noexcept {
        std::size_t count = 0;
        const popsteer_error error = popsteer_predict(get(), dt, room.data(), room.size(), &count);
        return {room.data(), error == POPSTEER_ERROR_NONE ? count : 0};
    }

    /// What the motion has shown of the vehicle.
    [[nodiscard]] Estimate estimate() const noexcept {
        Estimate estimate{};
        static_cast<void>(popsteer_controller_estimate(get(), &estimate));
        return estimate;
    }

    /// How far ahead of the pose's point the tracked point lies [m].
    [[nodiscard]] double tracked_point() const noexcept {
        return popsteer_controller_tracked_point(get());
    }

    /// A second controller that stands where this one stands.
    [[nodiscard]] Controller clone() const {
        Controller copy;
        detail::require(popsteer_controller_clone(get(), copy.handle_.out()));
        return copy;
    }

    [[nodiscard]] popsteer_controller* get() const noexcept { return handle_.get(); }

protected:
    Controller() noexcept = default;

    template <typename Params>
    Controller(popsteer_error (*make)(const popsteer_path*, const Vehicle*, const Params*,
                                      const Options*, popsteer_controller**),
               const Path& path, const Vehicle& vehicle, const Params& params,
               const Options& options) {
        detail::require(make(path.get(), &vehicle, &params, &options, handle_.out()));
    }

private:
    detail::Owner<popsteer_controller, popsteer_controller_free> handle_;
};

/// The paper's controller: of the angles near the last one that which leads nearest to the
/// lookahead point.
class Pop : public Controller {
public:
    explicit Pop(const Path& path, const Vehicle& vehicle = default_vehicle(),
                 const PopParams& params = popsteer_pop_params_default(),
                 const Options& options = default_options())
        : Controller(popsteer_pop_new, path, vehicle, params, options) {}
};

/// Plans its angles ahead within all limits of the vehicle: the one for real vehicles.
class PreviewPop : public Controller {
public:
    explicit PreviewPop(const Path& path, const Vehicle& vehicle = default_vehicle(),
                        const PreviewPopParams& params = popsteer_preview_pop_params_default(),
                        const Options& options = default_options())
        : Controller(popsteer_preview_pop_new, path, vehicle, params, options) {}
};

/// PID on the cross-track error.
class Pid : public Controller {
public:
    explicit Pid(const Path& path, const Vehicle& vehicle = default_vehicle(),
                 const PidParams& params = popsteer_pid_params_default(),
                 const Options& options = default_options())
        : Controller(popsteer_pid_new, path, vehicle, params, options) {}
};

/// The arc of the rear axle through the lookahead point.
class PurePursuit : public Controller {
public:
    explicit PurePursuit(const Path& path, const Vehicle& vehicle = default_vehicle(),
                         const PurePursuitParams& params = popsteer_pure_pursuit_params_default(),
                         const Options& options = default_options())
        : Controller(popsteer_pure_pursuit_new, path, vehicle, params, options) {}
};

/// Heading and cross-track error of the front axle.
class Stanley : public Controller {
public:
    explicit Stanley(const Path& path, const Vehicle& vehicle = default_vehicle(),
                     const StanleyParams& params = popsteer_stanley_params_default(),
                     const Options& options = default_options())
        : Controller(popsteer_stanley_new, path, vehicle, params, options) {}
};

/// What a step of a SpeedTracker comes to: true where there is a command, or why there is none.
struct SpeedResult {
    popsteer_error error;
    SpeedCommand command;

    explicit operator bool() const noexcept { return error == POPSTEER_ERROR_NONE; }
};

/// Plans the speeds along a path, and keeps them.
class SpeedTracker {
public:
    explicit SpeedTracker(const Path& path, const Vehicle& vehicle = default_vehicle(),
                          const SpeedTrackerParams& params = popsteer_speed_tracker_params_default()) {
        detail::require(popsteer_speed_tracker_new(path.get(), &vehicle, &params, handle_.out()));
    }

    explicit operator bool() const noexcept { return handle_.get() != nullptr; }

    /// One control step, `dt` [s] after the last one that answered, for a pose that was measured
    /// `pose_age` [s] before. See popsteer_speed_tracker_step.
    [[nodiscard]] SpeedResult step(const VehicleState& vehicle, double dt, double pose_age = 0.0) noexcept {
        SpeedResult result{};
        result.error = popsteer_speed_tracker_step(get(), vehicle, dt, pose_age, &result.command);
        return result;
    }

    /// Keeps the speeds of another path from the next step on, planned at once: this allocates.
    popsteer_error set_path(const Path& path) noexcept {
        return popsteer_speed_tracker_set_path(get(), path.get());
    }

    /// The planned speed at each waypoint [m/s].
    [[nodiscard]] std::vector<double> plan() const {
        std::size_t count = 0;
        detail::require(popsteer_speed_tracker_plan(get(), nullptr, 0, &count));
        std::vector<double> speeds(count);
        detail::require(popsteer_speed_tracker_plan(get(), speeds.data(), count, nullptr));
        return speeds;
    }

    popsteer_error reset() noexcept { return popsteer_speed_tracker_reset(get()); }

    [[nodiscard]] popsteer_speed_tracker* get() const noexcept { return handle_.get(); }

private:
    detail::Owner<popsteer_speed_tracker, popsteer_speed_tracker_free> handle_;
};

/// The whole vehicle in one step: steers and drives along a path, and stops where something is wrong.
class Driver {
public:
    /// Steers by a copy of `controller`, along its path.
    explicit Driver(const Controller& controller,
                    const SpeedTrackerParams& speed = popsteer_speed_tracker_params_default(),
                    const DriverParams& params = popsteer_driver_params_default()) {
        detail::require(popsteer_driver_new(controller.get(), &speed, &params, handle_.out()));
    }

    explicit operator bool() const noexcept { return handle_.get() != nullptr; }

    /// One control step, `dt` [s] after the last one; answers whatever comes in. See popsteer_driver_step.
    [[nodiscard]] Drive step(const VehicleState& vehicle, double dt) noexcept {
        Drive drive{};
        popsteer_driver_step(get(), vehicle, dt, nullptr, -1, &drive);
        return drive;
    }

    /// The same for a vehicle that reports more than pose and speed; `gear` is 1 where reverse gear is in, 0
    /// where it is not, and negative where that is not reported.
    [[nodiscard]] Drive step(const VehicleState& vehicle, double dt, const Reported& reported,
                             int gear = -1) noexcept {
        Drive drive{};
        popsteer_driver_step(get(), vehicle, dt, &reported, gear, &drive);
        return drive;
    }

    /// Follows another path from the next step on, its speeds planned at once: this allocates.
    popsteer_error set_path(const Path& path) noexcept { return popsteer_driver_set_path(get(), path.get()); }

    /// The operator's stop, and its end.
    popsteer_error hold(bool held = true) noexcept { return popsteer_driver_hold(get(), held); }

    /// Forgets the fault for which it stopped, and drives again; gives the fault, 0 if there was none.
    std::uint32_t release() noexcept {
        std::uint32_t fault = 0;
        popsteer_driver_release(get(), &fault);
        return fault;
    }

    popsteer_error reset(double steer = 0.0) noexcept { return popsteer_driver_reset(get(), steer); }

    /// Fills `room` with the trajectory that the vehicle is to take, an instant each `dt` [s]; what of it is
    /// filled: nothing where that failed. See popsteer_driver_predict.
    [[nodiscard]] Span<Predicted> predict(Span<Predicted> room, double dt) const noexcept {
        std::size_t count = 0;
        const popsteer_error error =
            popsteer_driver_predict(get(), dt, room.data(), room.size(), &count);
        return {room.data(), error == POPSTEER_ERROR_NONE ? count : 0};
    }

    /// What the motion has shown of the vehicle.
    [[nodiscard]] Estimate estimate() const noexcept {
        Estimate estimate{};
        static_cast<void>(popsteer_driver_estimate(get(), &estimate));
        return estimate;
    }

    [[nodiscard]] popsteer_driver* get() const noexcept { return handle_.get(); }

private:
    detail::Owner<popsteer_driver, popsteer_driver_free> handle_;
};

/// Many vehicles in one call, on the calling thread.
class Batch {
public:
    /// Copies of these controllers, in the state in which they are.
    explicit Batch(Span<const popsteer_controller* const> controllers) {
        detail::require(
            popsteer_batch_new(controllers.data(), controllers.size(), handle_.out()));
    }

    /// `count` copies of one controller.
    Batch(const Controller& controller, std::size_t count)
        : Batch(copies(controller, count)) {}

    explicit operator bool() const noexcept { return handle_.get() != nullptr; }

    [[nodiscard]] std::size_t size() const noexcept { return popsteer_batch_size(get()); }

    /// One control step with every vehicle; all arrays are as long as the batch, `reported` may be
    /// empty. See popsteer_batch_step.
    [[nodiscard]] popsteer_error step(Span<const VehicleState> vehicles, double dt,
                                      Span<Command> out,
                                      Span<const Reported> reported = {}) noexcept {
        const popsteer_error error = check(vehicles, out, reported);
        return error ? error : popsteer_batch_step(get(), vehicles.data(), dt, reported.data(), out.data());
    }

    /// The same, answering whatever comes in. See popsteer_batch_step_or_hold.
    [[nodiscard]] popsteer_error step_or_hold(Span<const VehicleState> vehicles, double dt,
                                              Span<Command> out, std::size_t hold_limit = 10,
                                              Span<const Reported> reported = {}) noexcept {
        const popsteer_error error = check(vehicles, out, reported);
        return error ? error : popsteer_batch_step_or_hold(get(), vehicles.data(), dt, hold_limit,
                                                    reported.data(), out.data());
    }

    popsteer_error set_path(std::size_t vehicle, const Path& path) noexcept {
        return popsteer_batch_set_path(get(), vehicle, path.get());
    }

    popsteer_error reset() noexcept { return popsteer_batch_reset(get()); }

    [[nodiscard]] popsteer_batch* get() const noexcept { return handle_.get(); }

private:
    [[nodiscard]] popsteer_error check(Span<const VehicleState> vehicles, Span<Command> out,
                                       Span<const Reported> reported) const noexcept {
        return popsteer_batch_check_lengths(get(), vehicles.size(), reported.size(), out.size());
    }

    /// A count that no memory holds is for the library to refuse, as its other errors.
    static std::vector<const popsteer_controller*> copies(const Controller& controller,
                                                          std::size_t count) {
        const popsteer_controller* one = controller.get();
        std::vector<const popsteer_controller*> all;
        if (count > all.max_size()) {
            popsteer_batch* refused = nullptr;
            detail::require(popsteer_batch_new(&one, count, &refused));
        }
        all.assign(count, one);
        return all;
    }

    detail::Owner<popsteer_batch, popsteer_batch_free> handle_;
};

}  // namespace popsteer

#endif  // POPSTEER_HPP
