/* Steps a speed tracker for the vehicle in a file, and prints what it answers, to the bit.
 *
 *     paced CAR.toml SCRIPT
 *
 * The script is numbers: how many waypoints, and x, y, speed, grade, yaw, curvature of each; then a
 * step a line: x, y, yaw, speed, dt. A step whose dt is 0 is refused, and the path is replaced by itself. */

#include "checks.h"

static bool numbers(FILE *script, double *into, int count) {
    for (int k = 0; k < count; ++k) {
        if (fscanf(script, "%lf", &into[k]) != 1) {
            return false;
        }
    }
    return true;
}

int main(int argc, char **argv) {
    CHECK(argc == 3);
    popsteer_vehicle car;
    if (popsteer_vehicle_load(argv[1], &car)) {
        char message[512];
        popsteer_last_error_message(message, sizeof message);
        puts(message);
        return 0;
    }
    FILE *script = fopen(argv[2], "r");
    double x[WAYPOINTS], y[WAYPOINTS], speed[WAYPOINTS], grade[WAYPOINTS], row[6];
    double yaw[WAYPOINTS], curvature[WAYPOINTS];
    CHECK(script != NULL && numbers(script, row, 1) && row[0] <= WAYPOINTS);
    size_t count = (size_t)row[0], planned;
    for (size_t k = 0; k < count; ++k) {
        CHECK(numbers(script, row, 6));
        x[k] = row[0], y[k] = row[1], speed[k] = row[2], grade[k] = row[3];
        yaw[k] = row[4], curvature[k] = row[5];
    }
    popsteer_path *level = NULL, *sloped = NULL, *path = NULL;
    CHECK(!popsteer_path_new(x, y, speed, NULL, count, false, &level));
    CHECK(popsteer_path_with_grade(level, grade, count - 1, &path) == POPSTEER_ERROR_PATH);
    CHECK(path == NULL && !popsteer_path_with_grade(level, grade, count, &sloped));
    CHECK(popsteer_path_with_yaw(sloped, yaw, NULL, count - 1, &path) == POPSTEER_ERROR_PATH);
    CHECK(popsteer_path_with_yaw(sloped, x, NULL, count, &path) == POPSTEER_ERROR_PATH);
    CHECK(path == NULL && !popsteer_path_with_yaw(sloped, yaw, curvature, count, &path));
    popsteer_speed_tracker *tracker = NULL;
    CHECK(!popsteer_speed_tracker_new(path, &car, NULL, &tracker));
    CHECK(!popsteer_speed_tracker_plan(tracker, speed, 2, &planned) && planned == count);
    CHECK(!popsteer_speed_tracker_plan(tracker, speed, WAYPOINTS, NULL));
    for (size_t k = 0; k < count; ++k) {
        printf("%a\n", speed[k]);
    }
    while (numbers(script, row, 5)) {
        popsteer_vehicle_state vehicle = {row[0], row[1], row[2], row[3]};
        popsteer_speed_command pace;
        if (row[4] <= 0.0) {
            popsteer_error refused = popsteer_speed_tracker_step(tracker, vehicle, NAN, 0.0, &pace);
            CHECK(refused == POPSTEER_ERROR_INPUT);
            CHECK(!popsteer_speed_tracker_set_path(tracker, path));
            continue;
        }
        CHECK(!popsteer_speed_tracker_step(tracker, vehicle, row[4], 0.0, &pace));
        printf("%a %a %a %d %d %d\n", pace.acceleration, pace.reference_speed,
               pace.distance_to_stop, pace.reverse, pace.standing, pace.cannot_stop);
    }
    fclose(script);
    CHECK(!popsteer_speed_tracker_reset(tracker));
    popsteer_path_free(level);
    popsteer_path_free(sloped);
    popsteer_path_free(path);
    popsteer_speed_tracker_free(tracker);
    return 0;
}
