/* What the test programs share: a check that says where it failed, and a path with a car. */

#ifndef CHECKS_H
#define CHECKS_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "popsteer.h"

#define CHECK(condition)                                                        \
    do {                                                                        \
        if (!(condition)) {                                                     \
            char message_[256];                                                 \
            popsteer_last_error_message(message_, sizeof message_);             \
            fprintf(stderr, "%s:%d: %s (last error: %s)\n", __FILE__, __LINE__, \
                    #condition, message_);                                      \
            exit(1);                                                            \
        }                                                                       \
    } while (0)

#define WAYPOINTS 300

/* A sine of 8 m, 1 m between waypoints, or the same `aside` [m] to its left. */
static inline popsteer_path *sine(double aside) {
    double x[WAYPOINTS], y[WAYPOINTS];
    for (int k = 0; k < WAYPOINTS; ++k) {
        x[k] = k;
        y[k] = 8.0 * sin(k / 25.0) + aside;
    }
    popsteer_path *path = NULL;
    CHECK(popsteer_path_new(x, y, NULL, NULL, WAYPOINTS, false, &path) == POPSTEER_ERROR_NONE);
    return path;
}

/* A car with all limits, whose commands are late. */
static inline popsteer_vehicle late_car(void) {
    popsteer_vehicle car = popsteer_vehicle_default();
    car.wheelbase = 2.7;
    car.rear_axle = -1.35;
    car.understeer = 0.002;
    car.steer_offset = 0.01;
    car.dead_time = 0.15;
    car.max_steer = 0.6;
    car.max_steer_rate = 0.5;
    return car;
}

#endif
