/* Does what a script says with one controller, and prints what it answers, to the bit.
 *
 *     replay LAW SCRIPT
 *
 * The script is numbers, hexadecimal or not: the vehicle's 15 fields; how many paths; for each how
 * many waypoints, whether closed, whether with speeds, and x, y, speed of each waypoint. Then one
 * call a line, by a letter. */

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "popsteer.h"

#define PATHS 4
#define INSTANTS 64

static void fail(const char *what) {
    char message[256];
    popsteer_last_error_message(message, sizeof message);
    fprintf(stderr, "%s: %s\n", what, message);
    exit(1);
}

static double number(FILE *script) {
    double value;
    if (fscanf(script, "%lf", &value) != 1) {
        fail("the script lacks a number");
    }
    return value;
}

static void show(popsteer_error error, const popsteer_command *command) {
    if (error != POPSTEER_ERROR_NONE) {
        char message[256];
        popsteer_last_error_message(message, sizeof message);
        printf("error %" PRId32 " %s\n", (int32_t)error, message);
        return;
    }
    printf("%a %a %a %a %a %a %a %a %a %" PRIu32 " %d\n", command->steer,
           command->cross_track_error, command->heading_error,
           command->predicted_cross_track_error, command->predicted_heading_error,
           command->target_x, command->target_y, command->reference_speed,
           command->distance_to_stop, command->status, command->reverse);
}

static popsteer_path *read_path(FILE *script) {
    size_t count = (size_t)number(script);
    bool closed = number(script) != 0.0, has_speed = number(script) != 0.0;
    double *x = malloc(count * sizeof *x), *y = malloc(count * sizeof *y);
    double *speed = malloc(count * sizeof *speed);
    if (x == NULL || y == NULL || speed == NULL) {
        fail("out of memory");
    }
    for (size_t k = 0; k < count; ++k) {
        x[k] = number(script);
        y[k] = number(script);
        speed[k] = number(script);
    }
    popsteer_path *path;
    if (popsteer_path_new(x, y, has_speed ? speed : NULL, NULL, count, closed, &path)) {
        fail("path");
    }
    free(x);
    free(y);
    free(speed);
    return path;
}

static popsteer_controller *make(const char *law, const popsteer_path *path,
                                 const popsteer_vehicle *car) {
    popsteer_controller *controller = NULL;
    popsteer_error error = POPSTEER_ERROR_NULL;
    if (strcmp(law, "Pop") == 0) {
        error = popsteer_pop_new(path, car, NULL, NULL, &controller);
    } else if (strcmp(law, "PreviewPop") == 0) {
        error = popsteer_preview_pop_new(path, car, NULL, NULL, &controller);
    } else if (strcmp(law, "Pid") == 0) {
        error = popsteer_pid_new(path, car, NULL, NULL, &controller);
    } else if (strcmp(law, "PurePursuit") == 0) {
        error = popsteer_pure_pursuit_new(path, car, NULL, NULL, &controller);
    } else if (strcmp(law, "Stanley") == 0) {
        error = popsteer_stanley_new(path, car, NULL, NULL, &controller);
    }
    if (error != POPSTEER_ERROR_NONE) {
        fail(law);
    }
    return controller;
}

static void call(char letter, FILE *script, popsteer_controller *controller,
                 popsteer_path *const *paths) {
    popsteer_command command;
    switch (letter) {
    case 's': /* x y yaw speed dt: a step */
    case 'r': /* ... applied_steer measured_steer pose_age: one that reports */
    case 'h': /* ... hold_limit: one that holds */ {
        popsteer_vehicle_state vehicle;
        vehicle.x = number(script);
        vehicle.y = number(script);
        vehicle.yaw = number(script);
        vehicle.speed = number(script);
        double dt = number(script);
        if (letter == 's') {
            show(popsteer_step(controller, vehicle, dt, NULL, &command), &command);
        } else if (letter == 'r') {
            popsteer_reported reported = popsteer_reported_default();
            reported.applied_steer = number(script);
            reported.measured_steer = number(script);
            reported.pose_age = number(script);
            show(popsteer_step(controller, vehicle, dt, &reported, &command), &command);
        } else {
            size_t limit = (size_t)number(script);
            show(popsteer_step_or_hold(controller, vehicle, dt, limit, NULL, &command), &command);
        }
        break;
    }
    case 'p': /* index: another path */
        if (popsteer_controller_set_path(controller, paths[(size_t)number(script)])) {
            fail("set_path");
        }
        break;
    case 'l': /* x y yaw: relocalise */ {
        double x = number(script), y = number(script), yaw = number(script);
        if (popsteer_controller_relocalise(controller, x, y, yaw)) {
            fail("relocalise");
        }
        break;
    }
    case 't': /* steer: reset to it */
        if (popsteer_controller_reset_to(controller, number(script))) {
            fail("reset_to");
        }
        break;
    case 'z': /* reset */
        if (popsteer_controller_reset(controller)) {
            fail("reset");
        }
        break;
    case 'e': /* the estimate */ {
        popsteer_estimate estimate;
        if (popsteer_controller_estimate(controller, &estimate)) {
            fail("estimate");
        }
        printf("%a %a %a %a %a %a\n", estimate.gain, estimate.steer_offset,
               estimate.dead_time, estimate.slip, estimate.slip_length,
               estimate.acceleration);
        break;
    }
    case 'f': /* dt size: the prediction */ {
        popsteer_predicted instants[INSTANTS];
        double dt = number(script);
        size_t size = (size_t)number(script), count;
        if (popsteer_predict(controller, dt, instants, size, &count)) {
            fail("predict");
        }
        for (size_t k = 0; k < count; ++k) {
            const popsteer_predicted *at = &instants[k];
            printf("%a %a %a %a %a %a\n", at->time, at->vehicle.x, at->vehicle.y, at->vehicle.yaw,
                   at->vehicle.speed, at->steer);
        }
        break;
    }
    default:
        fail("unknown letter");
    }
}

int main(int argc, char **argv) {
    if (argc != 3 || popsteer_abi_version() != POPSTEER_ABI_VERSION) {
        fail("usage: replay LAW SCRIPT");
    }
    FILE *script = fopen(argv[2], "r");
    if (script == NULL) {
        fail(argv[2]);
    }
    popsteer_vehicle car = popsteer_vehicle_default();
    double *const fields[] = {
        &car.wheelbase,       &car.width,        &car.rear_axle,    &car.antenna_left,
        &car.antenna_height,  &car.no_slip_point,
        &car.turning_wheelbase, &car.understeer, &car.steer_offset,
        &car.steer_lag,       &car.dead_time,    &car.max_steer,
        &car.max_steer_rate,  &car.steer_play, &car.max_lateral_acceleration, &car.max_speed,
        &car.max_acceleration, &car.max_deceleration, &car.brake_deceleration,
        &car.drive_delay,     &car.drive_lag,    &car.stop_point,
    };
    for (size_t k = 0; k < sizeof fields / sizeof *fields; ++k) {
        *fields[k] = number(script);
    }
    car.steers_at_rest = (uint32_t)number(script);
    size_t count = (size_t)number(script);
    popsteer_path *paths[PATHS];
    if (count < 1 || count > PATHS) {
        fail("too many paths");
    }
    for (size_t k = 0; k < count; ++k) {
        paths[k] = read_path(script);
    }
    popsteer_controller *controller = make(argv[1], paths[0], &car);
    printf("%a %a\n", popsteer_path_length(paths[0]),
           popsteer_controller_tracked_point(controller));
    char letter;
    while (fscanf(script, " %c", &letter) == 1) {
        call(letter, script, controller, paths);
    }
    fclose(script);
    for (size_t k = 0; k < count; ++k) {
        popsteer_path_free(paths[k]);
    }
    popsteer_controller_free(controller);
    return 0;
}
