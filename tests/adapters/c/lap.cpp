// The C++ interface: what owns what, what throws, and a lap whose angles are those of C.

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "popsteer.hpp"

#define CHECK(condition)                                                          \
    do {                                                                          \
        if (!(condition)) {                                                       \
            std::fprintf(stderr, "%s:%d: %s (last error: %s)\n", __FILE__, __LINE__, \
                         #condition, popsteer::last_error().c_str());             \
            return false;                                                         \
        }                                                                         \
    } while (false)

using popsteer::Command;
using popsteer::VehicleState;

// Nothing in a control loop throws.
static_assert(noexcept(std::declval<popsteer::Controller&>().step(VehicleState{}, 0.05)));
static_assert(noexcept(std::declval<popsteer::Controller&>().step_or_hold(VehicleState{}, 0.05)));
static_assert(noexcept(std::declval<popsteer::Controller&>().predict({}, 0.05)));
static_assert(noexcept(std::declval<popsteer::Driver&>().step(VehicleState{}, 0.05)));
static_assert(noexcept(std::declval<popsteer::Driver&>().predict({}, 0.05)));
static_assert(noexcept(std::declval<popsteer::Batch&>().step({}, 0.05, {})));
static_assert(std::is_nothrow_move_constructible_v<popsteer::Pop>);
static_assert(std::is_nothrow_move_assignable_v<popsteer::Path>);
static_assert(!std::is_copy_constructible_v<popsteer::Controller>);
static_assert(sizeof(popsteer::Pop) == sizeof(void*));

namespace {

popsteer::Path sine() {
    std::vector<double> x, y, speed;
    for (int k = 0; k < 300; ++k) {
        x.push_back(k);
        y.push_back(8.0 * std::sin(k / 25.0));
        speed.push_back(8.0);
    }
    return popsteer::Path(x, y, speed);
}

bool lap_is_that_of_c() {
    const popsteer::Path path = sine();
    popsteer::Vehicle car = popsteer::default_vehicle();
    car.wheelbase = 2.7;
    car.dead_time = 0.15;
    car.max_steer_rate = popsteer::none;
    popsteer::PreviewPop controller(path, car);
    popsteer_controller* plain = nullptr;
    CHECK(!popsteer_preview_pop_new(path.get(), &car, nullptr, nullptr, &plain));
    VehicleState vehicle{0.0, 0.5, 0.3, 8.0};
    double largest = 0.0;
    for (int step = 0; step < 600; ++step) {
        const popsteer::Result result = controller.step(vehicle, 0.05);
        Command command;
        CHECK(!popsteer_step(plain, vehicle, 0.05, nullptr, &command));
        CHECK(result && std::memcmp(&result.command.steer, &command.steer, sizeof(double)) == 0);
        CHECK(!(result.command.status & popsteer::status::faults));
        largest = std::fmax(largest, std::fabs(command.steer));
        vehicle.x += vehicle.speed * std::cos(vehicle.yaw) * 0.05;
        vehicle.y += vehicle.speed * std::sin(vehicle.yaw) * 0.05;
        vehicle.yaw += vehicle.speed * std::tan(command.steer) / car.wheelbase * 0.05;
    }
    CHECK(largest > 0.02 && largest < 0.6);
    std::array<popsteer::Predicted, 20> room{};
    CHECK(controller.predict(room, 0.05).size() == 20);
    CHECK(controller.estimate().gain > 0.4);
    popsteer_controller_free(plain);
    return true;
}

bool speeds_are_kept() {
    const popsteer::Path path = sine().with_grade(std::vector<double>(300, 0.02)).with_yaw();
    popsteer::SpeedTracker speeds(path);
    CHECK(speeds && speeds.plan().size() == 300 && speeds.plan()[299] == 0.0);
    const popsteer::SpeedResult pace = speeds.step({100.0, -6.0, -0.2, 7.0}, 0.05);
    CHECK(pace && pace.command.acceleration > 0.0 && pace.command.distance_to_stop > 150.0);
    CHECK(!speeds.step({popsteer::none, 0.0, 0.0, 1.0}, 0.05));
    CHECK(!speeds.set_path(sine()) && !speeds.reset());
    return true;
}

bool objects_own_their_handles() {
    popsteer::Path path = sine();
    popsteer::Pop first(path);
    CHECK(path.length() > 299.0);
    path = sine();  // the first one lives on in its controller
    popsteer::Pop second = std::move(first);
    CHECK(!first && second);
    CHECK(!first.step({0.0, 0.0, 0.0, 1.0}, 0.05));
    CHECK(first.step({0.0, 0.0, 0.0, 1.0}, 0.05).error == POPSTEER_ERROR_NULL);
    CHECK(second.step({0.0, 0.0, 0.0, 1.0}, 0.05));
    popsteer::Controller twin = second.clone();
    const VehicleState here{3.0, 0.2, 0.1, 5.0};
    CHECK(twin.step(here, 0.05).command.steer == second.step(here, 0.05).command.steer);
    CHECK(!second.set_path(path) && !second.relocalise(3.0, 0.2, 0.1) && !second.reset_to(0.1));
    const double nan = popsteer::none;
    const popsteer::Result held = second.step_or_hold({nan, 0.0, 0.0, 1.0}, 0.05);
    CHECK(held && held.command.status == popsteer::status::input_held);
    CHECK(popsteer::status_names(held.command.status) == "input-held");
    const popsteer::Result refused = second.step({nan, 0.0, 0.0, 1.0}, 0.05);
    CHECK(!refused && refused.error == POPSTEER_ERROR_INPUT);
    CHECK(popsteer::last_error().find("x must be in") == 0);
    return true;
}

bool batch_is_as_long_as_its_arrays() {
    const popsteer::Path path = sine();
    popsteer::Stanley stanley(path);
    popsteer::Batch batch(stanley, 3);
    CHECK(batch.size() == 3);
    const VehicleState here{3.0, 0.2, 0.1, 5.0};
    const std::vector<VehicleState> vehicles(3, here);
    std::vector<Command> commands(3);
    CHECK(!batch.step(vehicles, 0.05, commands));
    CHECK(commands[2].steer == stanley.step(here, 0.05).command.steer);
    std::vector<Command> two(2);
    CHECK(batch.step(vehicles, 0.05, two) == POPSTEER_ERROR_INPUT);
    CHECK(popsteer::last_error() == "out has 2 entries, the batch 3 vehicles");
    CHECK(batch.step_or_hold({}, 0.05, commands) == POPSTEER_ERROR_INPUT);
    CHECK(popsteer::last_error() == "vehicles has 0 entries, the batch 3 vehicles");
    const std::vector<popsteer::Reported> reported(1);
    CHECK(batch.step(vehicles, 0.05, commands, reported) == POPSTEER_ERROR_INPUT);
    CHECK(!batch.set_path(1, path) && !batch.reset());
    return true;
}

bool driver_is_that_of_c() {
    const popsteer::Path path = sine();
    const popsteer::PreviewPop controller(path);
    popsteer::Driver driver(controller);
    popsteer_driver* plain = nullptr;
    CHECK(!popsteer_driver_new(controller.get(), nullptr, nullptr, &plain));
    std::array<popsteer::Predicted, 5> room{}, plain_room{};
    CHECK(driver.predict(room, 0.05).size() == 0);
    const popsteer::Reported reported = popsteer_reported_default();
    for (int step = 0; step < 60; ++step) {
        const VehicleState vehicle{0.05 * step, 0.5, 0.3, step < 30 ? 1.0 : popsteer::none};
        const popsteer::Drive drive =
            step % 2 ? driver.step(vehicle, 0.05, reported) : driver.step(vehicle, 0.05);
        popsteer_drive other{};
        CHECK(!popsteer_driver_step(plain, vehicle, 0.05, nullptr, -1, &other));
        CHECK(!std::memcmp(&drive.steer, &other.steer, sizeof drive.steer));
        CHECK(drive.fault == other.fault);
    }
    std::size_t count = 0;
    CHECK(!popsteer_driver_predict(plain, 0.05, plain_room.data(), plain_room.size(), &count));
    CHECK(driver.predict(room, 0.05).size() == count);
    CHECK(!std::memcmp(room.data(), plain_room.data(), sizeof room));
    popsteer_estimate estimate{};
    CHECK(!popsteer_driver_estimate(plain, &estimate));
    const popsteer::Estimate same = driver.estimate();
    CHECK(!std::memcmp(&estimate, &same, sizeof same));
    CHECK(!driver.hold() && !driver.hold(false));
    CHECK(std::string(popsteer_fault_name(driver.release())) == "speed" && driver.release() == 0);
    CHECK(!driver.set_path(path) && !driver.reset(0.1));
    CHECK(!popsteer_driver_free(plain));
    return true;
}

bool constructors_say_what_is_wrong() {
    const double x[2] = {0.0, 1.0}, y[3] = {0.0, 0.0, 0.0};
#if defined(__cpp_exceptions)
    try {
        const popsteer::Path bad(x, popsteer::Span<const double>(y, 1));
        CHECK(false);
    } catch (const popsteer::Error& error) {
        CHECK(error.code() == POPSTEER_ERROR_PATH);
        CHECK(std::string(error.what()) == "y has 1 entries for 2 waypoints");
    }
    const popsteer::Path path = sine();
    popsteer::PopParams params = popsteer_pop_params_default();
    params.steer_span = -1.0;
    try {
        const popsteer::Pop bad(path, popsteer::default_vehicle(), params);
        CHECK(false);
    } catch (const popsteer::Error& error) {
        CHECK(error.code() == POPSTEER_ERROR_CONFIG);
        CHECK(std::string(error.what()).find("steer_span must be in") == 0);
    }
#else
    const popsteer::Path bad(x, y);
    CHECK(!bad);
    const popsteer::Pop none(bad);
    CHECK(!none && popsteer::last_error() == "path is NULL or not aligned");
#endif
    return true;
}

}  // namespace

int main() {
    const bool good = popsteer::is_compatible() && lap_is_that_of_c() && speeds_are_kept() &&
                      objects_own_their_handles() && batch_is_as_long_as_its_arrays() &&
                      driver_is_that_of_c() && constructors_say_what_is_wrong();
    if (good) {
        std::puts("all checked");
    }
    return good ? 0 : 1;
}
