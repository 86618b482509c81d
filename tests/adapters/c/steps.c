/* Drives one controller around the course of benches/src/lib.rs: what a test counts the
 * instructions of.
 *
 *     steps LAW step LAPS
 *
 * prints how many steps it has taken, as the Rust program of the same name does. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "popsteer.h"

#define WAYPOINTS 1274
#define MOST 10000

static const double tau = 6.283185307179586, swing = 3.0, dt = 0.05;

static double radius_at(double bearing, double radius, double waves) {
    return radius + swing * sin(waves * bearing);
}

int main(int argc, char **argv) {
    if (argc != 4) {
        return 2;
    }
    static double x[WAYPOINTS], y[WAYPOINTS];
    static popsteer_vehicle_state lap[MOST];
    const double radius = WAYPOINTS / tau + swing, waves = WAYPOINTS / 60;
    for (int k = 0; k < WAYPOINTS; ++k) {
        double bearing = tau * k / WAYPOINTS, r = radius_at(bearing, radius, waves);
        x[k] = r * cos(bearing);
        y[k] = r * sin(bearing);
    }
    size_t length = 0;
    for (double bearing = 0.0; bearing < tau && length < MOST; ++length) {
        double k = (double)length, r = radius_at(bearing, radius, waves);
        double slope = swing * waves * cos(waves * bearing);
        double heading = bearing + atan2(r, slope), aside = 0.3 * sin(0.11 * k);
        double speed = 11.0 + 5.0 * sin(0.013 * k);
        lap[length].x = r * cos(bearing) - aside * sin(heading);
        lap[length].y = r * sin(bearing) + aside * cos(heading);
        lap[length].yaw = heading + 0.03 * sin(0.17 * k);
        lap[length].speed = speed;
        bearing += speed * dt / radius;
    }

    popsteer_path *path;
    popsteer_controller *controller = NULL;
    if (popsteer_path_new(x, y, NULL, NULL, WAYPOINTS, true, &path)) {
        return 1;
    }
    if (strcmp(argv[1], "pop") == 0) {
        popsteer_pop_new(path, NULL, NULL, NULL, &controller);
    } else if (strcmp(argv[1], "preview-pop") == 0) {
        popsteer_preview_pop_new(path, NULL, NULL, NULL, &controller);
    } else if (strcmp(argv[1], "stanley") == 0) {
        popsteer_stanley_new(path, NULL, NULL, NULL, &controller);
    }
    popsteer_command command = {0};
    for (size_t k = 0; k < length; ++k) {
        if (popsteer_step(controller, lap[k], dt, NULL, &command)) {
            return 1;
        }
    }
    size_t steps = (size_t)atoi(argv[3]) * length;
    volatile double sum = 0.0;
    for (size_t k = 0, next = 0; k < steps; ++k) {
        if (popsteer_step(controller, lap[next], dt, NULL, &command)) {
            return 1;
        }
        sum = command.steer;
        next = next + 1 == length ? 0 : next + 1;
    }
    (void)sum;
    printf("%zu\n", steps);
    popsteer_controller_free(controller);
    popsteer_path_free(path);
    return 0;
}
