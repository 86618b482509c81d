/* NULL, wrong handles and bad numbers are refused, with a message, and change nothing. */

#include "checks.h"

static popsteer_path *path;
static popsteer_controller *controller;
static const popsteer_vehicle_state here = {10.0, 3.0, 0.3, 8.0};

static void says(const char *wanted) {
    char message[256];
    size_t length = popsteer_last_error_message(message, sizeof message);
    CHECK(length == strlen(message));
    if (strcmp(message, wanted) != 0) {
        fprintf(stderr, "said: %s\nnot: %s\n", message, wanted);
        exit(1);
    }
}

static void null_is_refused(void) {
    popsteer_command command;
    popsteer_estimate estimate;
    popsteer_predicted instant;
    popsteer_path *none = path;
    double x[2] = {0.0, 1.0}, y[2] = {0.0, 0.0};
    CHECK(popsteer_step(NULL, here, 0.05, NULL, &command) == POPSTEER_ERROR_NULL);
    says("controller is NULL or not aligned");
    CHECK(popsteer_step(controller, here, 0.05, NULL, NULL) == POPSTEER_ERROR_NULL);
    says("out is NULL or not aligned");
    CHECK(popsteer_step_or_hold(NULL, here, 0.05, 1, NULL, &command) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_step_or_hold(controller, here, 0.05, 1, NULL, NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_path_new(NULL, y, NULL, NULL, 2, false, &none) == POPSTEER_ERROR_NULL);
    CHECK(none == NULL);
    CHECK(popsteer_path_new(x, y, NULL, NULL, 2, false, NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_pop_new(path, NULL, NULL, NULL, NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_vehicle_check(NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_predict(NULL, 0.05, &instant, 1, NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_predict(controller, 0.05, NULL, 1, NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_controller_estimate(NULL, &estimate) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_controller_estimate(controller, NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_controller_set_path(controller, NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_controller_set_path(NULL, path) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_controller_reset(NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_controller_reset_to(NULL, 0.0) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_controller_relocalise(NULL, 0.0, 0.0, 0.0) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_batch_new(NULL, 1, &(popsteer_batch *){NULL}) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_batch_step(NULL, &here, 0.05, NULL, &command) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_batch_reset(NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_batch_size(NULL) == 0);
    popsteer_speed_tracker *tracker = NULL;
    popsteer_speed_command pace;
    popsteer_vehicle car;
    CHECK(popsteer_speed_tracker_new(NULL, NULL, NULL, &tracker) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_speed_tracker_new(path, NULL, NULL, NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_speed_tracker_step(NULL, here, 0.05, 0.0, &pace) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_speed_tracker_set_path(NULL, path) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_speed_tracker_plan(NULL, x, 2, NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_speed_tracker_reset(NULL) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_speed_tracker_free(NULL) == POPSTEER_ERROR_NONE);
    CHECK(popsteer_path_with_grade(NULL, x, 2, &none) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_path_with_yaw(NULL, x, x, 2, &none) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_vehicle_load(NULL, &car) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_vehicle_load("car.toml", NULL) == POPSTEER_ERROR_NULL);
    CHECK(isnan(popsteer_path_length(NULL)));
    CHECK(popsteer_path_mended(NULL) == 0);
    CHECK(isnan(popsteer_controller_tracked_point(NULL)));
    CHECK(popsteer_path_free(NULL) == POPSTEER_ERROR_NONE);
    CHECK(popsteer_controller_free(NULL) == POPSTEER_ERROR_NONE);
    CHECK(popsteer_batch_free(NULL) == POPSTEER_ERROR_NONE);
}

static void wrong_handles_are_refused(void) {
    popsteer_command command;
    popsteer_controller *made = NULL;
    CHECK(popsteer_step((popsteer_controller *)path, here, 0.05, NULL, &command) ==
          POPSTEER_ERROR_HANDLE);
    says("controller is no popsteer_controller");
    CHECK(popsteer_pop_new((popsteer_path *)controller, NULL, NULL, NULL, &made) ==
          POPSTEER_ERROR_HANDLE);
    CHECK(popsteer_path_free((popsteer_path *)controller) == POPSTEER_ERROR_HANDLE);
    CHECK(popsteer_controller_free((popsteer_controller *)path) == POPSTEER_ERROR_HANDLE);
    CHECK(popsteer_batch_free((popsteer_batch *)path) == POPSTEER_ERROR_HANDLE);
    CHECK(popsteer_batch_size((popsteer_batch *)path) == 0);
    double numbers[64] = {0.0};
    CHECK(popsteer_step((popsteer_controller *)numbers, here, 0.05, NULL, &command) ==
          POPSTEER_ERROR_HANDLE);
    char *odd = (char *)controller + 1;
    CHECK(popsteer_step((popsteer_controller *)(void *)odd, here, 0.05, NULL, &command) ==
          POPSTEER_ERROR_HANDLE);
    /* All of them are still what they were. */
    CHECK(popsteer_path_length(path) > 299.0);
    CHECK(popsteer_path_mended(path) == 0);
    CHECK(popsteer_step(controller, here, 0.05, NULL, &command) == POPSTEER_ERROR_NONE);
}

static void bad_numbers_are_named(void) {
    popsteer_path *bad = NULL;
    popsteer_controller *made = NULL;
    double x[3] = {0.0, 1.0, NAN}, y[3] = {0.0, 0.0, 0.0};
    CHECK(popsteer_path_new(x, y, NULL, NULL, 3, false, &bad) == POPSTEER_ERROR_PATH);
    says("x of waypoint 2 must be in [-1000000000.0, 1000000000.0], got NaN");
    CHECK(popsteer_path_new(x, y, NULL, NULL, 1, false, &bad) == POPSTEER_ERROR_PATH);
    says("a path needs at least 2 waypoints, got 1");
    CHECK(popsteer_path_new(x, y, NULL, NULL, SIZE_MAX, false, &bad) == POPSTEER_ERROR_INPUT);
    says("count is SIZE_MAX, as is a negative number");

    double swapped[8] = {0, 1, 2, 4, 3, 5, 6, 7}, back[8] = {0, 1, 2, 3, 4, 3, 2, 1}, line[8] = {0};
    CHECK(popsteer_path_new(back, line, NULL, NULL, 8, false, &bad) == POPSTEER_ERROR_PATH);
    CHECK(bad == NULL);
    CHECK(popsteer_path_new(swapped, line, NULL, NULL, 8, false, &bad) == POPSTEER_ERROR_NONE);
    CHECK(popsteer_path_mended(bad) == 1);
    CHECK(popsteer_path_length(bad) == 7.0);
    popsteer_path_free(bad);

    popsteer_vehicle car = popsteer_vehicle_default();
    car.wheelbase = -1.0;
    CHECK(popsteer_vehicle_check(&car) == POPSTEER_ERROR_CONFIG);
    CHECK(popsteer_pop_new(path, &car, NULL, NULL, &made) == POPSTEER_ERROR_CONFIG);
    says("wheelbase must be in [0.001, 1000.0], got -1.0");
    car.wheelbase = NAN; /* not optional */
    CHECK(popsteer_vehicle_check(&car) == POPSTEER_ERROR_CONFIG);
    popsteer_pop_params params = popsteer_pop_params_default();
    params.candidate_count = 4;
    CHECK(popsteer_pop_new(path, NULL, &params, NULL, &made) == POPSTEER_ERROR_CONFIG);
    popsteer_options options = popsteer_options_default();
    options.adapt = 7;
    CHECK(popsteer_pop_new(path, NULL, NULL, &options, &made) == POPSTEER_ERROR_CONFIG);
    says("adapt must be a count in [0, 2], got 7.0");
    popsteer_speed_tracker *tracker = NULL;
    popsteer_speed_tracker_params gains = popsteer_speed_tracker_params_default();
    gains.kp = -1.0;
    CHECK(popsteer_speed_tracker_new(path, NULL, &gains, &tracker) == POPSTEER_ERROR_CONFIG);
    says("kp must be in [0.0, 1000.0], got -1.0");
    CHECK(tracker == NULL);
    CHECK(popsteer_speed_tracker_free((popsteer_speed_tracker *)path) == POPSTEER_ERROR_HANDLE);
    options.adapt = POPSTEER_ON;
    options.turn_time = -1.0;
    CHECK(popsteer_pop_new(path, NULL, NULL, &options, &made) == POPSTEER_ERROR_CONFIG);
    CHECK(made == NULL);

    popsteer_controller *twin = NULL;
    CHECK(popsteer_controller_clone(controller, &twin) == POPSTEER_ERROR_NONE);
    popsteer_command before, command;
    memset(&command, 0x5a, sizeof command);
    memcpy(&before, &command, sizeof command);
    popsteer_vehicle_state lost = here;
    lost.speed = INFINITY;
    CHECK(popsteer_step(controller, lost, 0.05, NULL, &command) == POPSTEER_ERROR_INPUT);
    says("speed must be in [-10000.0, 10000.0], got inf");
    CHECK(popsteer_step(controller, here, NAN, NULL, &command) == POPSTEER_ERROR_INPUT);
    popsteer_reported reported = popsteer_reported_default();
    reported.pose_age = -1.0;
    CHECK(popsteer_step(controller, here, 0.05, &reported, &command) == POPSTEER_ERROR_INPUT);
    CHECK(memcmp(&before, &command, sizeof command) == 0);
    /* Neither has the controller changed: its next answer is that of its twin. */
    popsteer_command other;
    CHECK(popsteer_step(controller, here, 0.05, NULL, &command) == POPSTEER_ERROR_NONE);
    CHECK(popsteer_step(twin, here, 0.05, NULL, &other) == POPSTEER_ERROR_NONE);
    CHECK(command.steer == other.steer && command.status == other.status);

    CHECK(popsteer_controller_reset_to(controller, 9.0) == POPSTEER_ERROR_INPUT);
    CHECK(popsteer_controller_relocalise(controller, NAN, 0.0, 0.0) == POPSTEER_ERROR_INPUT);
    popsteer_predicted instants[4];
    size_t count = 0;
    CHECK(popsteer_predict(controller, 0.0, instants, 4, &count) == POPSTEER_ERROR_INPUT);
    /* A pose that repeats while the vehicle drives is old, and is rolled forward: so drive on. */
    popsteer_vehicle_state there = here;
    there.x += 0.05 * here.speed * cos(here.yaw);
    there.y += 0.05 * here.speed * sin(here.yaw);
    CHECK(popsteer_step(controller, there, 0.05, NULL, &command) == POPSTEER_ERROR_NONE);
    CHECK(popsteer_predict(controller, 0.05, instants, 4, &count) == POPSTEER_ERROR_NONE);
    CHECK(count == 4 && instants[0].vehicle.x == there.x);
    CHECK(popsteer_controller_reset(controller) == POPSTEER_ERROR_NONE);
    CHECK(popsteer_predict(controller, 0.05, instants, 4, &count) == POPSTEER_ERROR_NO_STEP);
    popsteer_controller_free(twin);
}

static void held_inputs_have_their_status(void) {
    popsteer_command command, held;
    popsteer_vehicle_state lost = here;
    lost.x = NAN;
    CHECK(popsteer_step(controller, here, 0.05, NULL, &command) == POPSTEER_ERROR_NONE);
    CHECK(popsteer_step_or_hold(controller, lost, 0.05, 1, NULL, &held) == POPSTEER_ERROR_NONE);
    CHECK(held.status == POPSTEER_STATUS_INPUT_HELD && held.steer == command.steer);
    CHECK(popsteer_step_or_hold(controller, lost, 0.05, 1, NULL, &held) == POPSTEER_ERROR_NONE);
    CHECK(held.status == POPSTEER_STATUS_INPUT_LOST && (held.status & POPSTEER_STATUS_FAULTS));
}

static void no_time_holds_the_last_command(void) {
    popsteer_command command, held;
    popsteer_speed_command pace, kept;
    popsteer_speed_tracker *tracker = NULL;
    popsteer_batch *batch = NULL;
    CHECK(!popsteer_speed_tracker_new(path, NULL, NULL, &tracker));
    CHECK(!popsteer_step(controller, here, 0.05, NULL, &command));
    CHECK(!popsteer_batch_new((const popsteer_controller *const *)&controller, 1, &batch));
    CHECK(!popsteer_speed_tracker_step(tracker, here, 0.05, 0.0, &pace));
    const double none[3] = {0.0, -60.0, 2000.0};
    for (int k = 1; k <= 11; ++k) {
        uint32_t status = k > 10 ? POPSTEER_STATUS_INPUT_LOST : POPSTEER_STATUS_INPUT_HELD;
        CHECK(!popsteer_step(controller, here, none[k % 3], NULL, &held));
        CHECK(held.status == status && held.steer == command.steer);
        CHECK(!popsteer_batch_step(batch, &here, none[k % 3], NULL, &held));
        CHECK(held.status == status && held.steer == command.steer);
        CHECK(!popsteer_speed_tracker_step(tracker, here, none[k % 3], 0.0, &kept));
        CHECK(kept.status == status && kept.acceleration == pace.acceleration);
    }
    CHECK(popsteer_step(controller, here, NAN, NULL, &held) == POPSTEER_ERROR_INPUT);
    says("dt must be in [1e-6, 1000.0], got NaN");
    CHECK(popsteer_batch_step(batch, &here, NAN, NULL, &held) == POPSTEER_ERROR_INPUT);
    CHECK(popsteer_speed_tracker_step(tracker, here, NAN, 0.0, &kept) == POPSTEER_ERROR_INPUT);
    popsteer_batch_free(batch);
    popsteer_speed_tracker_free(tracker);
}

static void texts_are_cut_to_their_room(void) {
    char room[8];
    uint32_t both = POPSTEER_STATUS_SATURATED | POPSTEER_STATUS_END_OF_PATH;
    CHECK(popsteer_status_names(both, NULL, 0) == strlen("saturated|end-of-path"));
    memset(room, 'x', sizeof room);
    CHECK(popsteer_status_names(both, room, 4) == strlen("saturated|end-of-path"));
    CHECK(strcmp(room, "sat") == 0 && room[4] == 'x');
    CHECK(popsteer_status_names(0, room, sizeof room) == 2 && strcmp(room, "ok") == 0);
    char all[256];
    CHECK(popsteer_status_names(UINT32_MAX, all, sizeof all) < sizeof all);
    CHECK(strcmp(popsteer_error_name(POPSTEER_ERROR_NONE), "no error") == 0);
    CHECK(strcmp(popsteer_error_name(-7), "unknown error") == 0);
}

static void batch_answers_as_its_controllers(void) {
    popsteer_vehicle car = late_car();
    popsteer_controller *each[3] = {NULL};
    CHECK(!popsteer_pop_new(path, &car, NULL, NULL, &each[0]));
    CHECK(!popsteer_preview_pop_new(path, &car, NULL, NULL, &each[1]));
    CHECK(!popsteer_stanley_new(path, NULL, NULL, NULL, &each[2]));
    popsteer_batch *batch = NULL;
    CHECK(!popsteer_batch_new((const popsteer_controller *const *)each, 3, &batch));
    CHECK(popsteer_batch_size(batch) == 3);
    CHECK(popsteer_step((popsteer_controller *)batch, here, 0.05, NULL, &(popsteer_command){0}) ==
          POPSTEER_ERROR_HANDLE);
    popsteer_path *other = sine(3.0);
    for (int step = 0; step < 100; ++step) {
        popsteer_vehicle_state vehicles[3];
        popsteer_reported reported[3];
        popsteer_command together[3], alone;
        for (int k = 0; k < 3; ++k) {
            vehicles[k] = (popsteer_vehicle_state){0.4 * step + k, 0.5 * k, 0.3, 8.0};
            reported[k] = popsteer_reported_default();
            reported[k].pose_age = step > 50 ? 0.1 : 0.0;
        }
        if (step == 70) {
            CHECK(!popsteer_batch_set_path(batch, 1, other));
            CHECK(!popsteer_controller_set_path(each[1], other));
            CHECK(popsteer_batch_set_path(batch, 3, other) == POPSTEER_ERROR_INPUT);
            says("there is no vehicle 3 in a batch of 3");
        }
        if (step == 80) {
            /* One bad vehicle refuses all, and none has moved. */
            vehicles[2].yaw = NAN;
            CHECK(popsteer_batch_step(batch, vehicles, 0.05, reported, together) ==
                  POPSTEER_ERROR_INPUT);
            says("vehicle 2: yaw must be in [-1000000.0, 1000000.0], got NaN");
            CHECK(!popsteer_batch_step_or_hold(batch, vehicles, 0.05, 5, reported, together));
        } else {
            CHECK(!popsteer_batch_step(batch, vehicles, 0.05, reported, together));
        }
        for (int k = 0; k < 3; ++k) {
            CHECK(!popsteer_step_or_hold(each[k], vehicles[k], 0.05, 5, &reported[k], &alone));
            CHECK(memcmp(&alone.steer, &together[k].steer, sizeof alone.steer) == 0);
            CHECK(memcmp(&alone.target_x, &together[k].target_x, sizeof alone.steer) == 0);
            CHECK(alone.status == together[k].status && alone.reverse == together[k].reverse);
        }
    }
    CHECK(!popsteer_batch_reset(batch));
    popsteer_batch *empty = NULL;
    CHECK(!popsteer_batch_new(NULL, 0, &empty));
    CHECK(!popsteer_batch_step(empty, NULL, 0.05, NULL, NULL));
    popsteer_batch_free(empty);
    popsteer_batch_free(batch);
    popsteer_path_free(other);
    for (int k = 0; k < 3; ++k) {
        popsteer_controller_free(each[k]);
    }
}

int main(void) {
    char message[8] = "xxxxxxx";
    CHECK(popsteer_last_error_message(message, sizeof message) == 0 && message[0] == '\0');
    CHECK(popsteer_abi_version() == POPSTEER_ABI_VERSION);
    path = sine(0.0);
    CHECK(popsteer_pop_new(path, NULL, NULL, NULL, &controller) == POPSTEER_ERROR_NONE);
    null_is_refused();
    wrong_handles_are_refused();
    bad_numbers_are_named();
    held_inputs_have_their_status();
    no_time_holds_the_last_command();
    texts_are_cut_to_their_room();
    batch_answers_as_its_controllers();
    popsteer_path_free(path); /* the controller still follows it */
    popsteer_command command;
    CHECK(popsteer_step(controller, here, 0.05, NULL, &command) == POPSTEER_ERROR_NONE);
    popsteer_controller_free(controller);
    puts("all refused");
    return 0;
}
