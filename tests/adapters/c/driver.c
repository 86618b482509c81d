/* Steps a driver along a sine, and prints what it answers, to the bit.
 *
 *     driver SCRIPT
 *
 * A row a step: x, y, yaw, speed, dt, pose_age, gear. `nan` is a number that has not come. A gear of 2 holds the
 * vehicle, 3 lets it go, 4 releases it, and 5 sets the path anew, before the step. Each answer ends with the
 * estimates and where the vehicle is predicted to be half a second later. */

#include "checks.h"

int main(int argc, char **argv) {
    CHECK(argc == 2);
    popsteer_vehicle car = late_car();
    popsteer_path *path = sine(0.0), *aside = sine(0.05);
    popsteer_controller *controller = NULL;
    popsteer_driver *driver = NULL;
    CHECK(!popsteer_preview_pop_new(path, &car, NULL, NULL, &controller));
    CHECK(popsteer_driver_new(NULL, NULL, NULL, &driver) != POPSTEER_ERROR_NONE && driver == NULL);
    popsteer_driver_params params = popsteer_driver_params_default();
    params.hold_time = -1.0;
    CHECK(popsteer_driver_new(controller, NULL, &params, &driver) == POPSTEER_ERROR_CONFIG);
    CHECK(!popsteer_driver_new(controller, NULL, NULL, &driver));
    popsteer_estimate estimate;
    popsteer_predicted ahead[11];
    size_t count = 0;
    CHECK(popsteer_driver_estimate(NULL, &estimate) == POPSTEER_ERROR_NULL);
    CHECK(popsteer_driver_predict(driver, 0.05, ahead, 11, &count) == POPSTEER_ERROR_NO_STEP && count == 0);
    popsteer_controller_free(controller);
    popsteer_path_free(path);

    FILE *script = fopen(argv[1], "r");
    CHECK(script != NULL);
    double row[7];
    for (;;) {
        for (int k = 0; k < 7; ++k) {
            if (fscanf(script, "%lf", &row[k]) != 1) {
                CHECK(k == 0);
                fclose(script);
                CHECK(popsteer_driver_reset(driver, 9.0) == POPSTEER_ERROR_INPUT);
                CHECK(!popsteer_driver_reset(driver, 0.1));
                popsteer_driver_free(driver);
                popsteer_path_free(aside);
                return 0;
            }
        }
        int gear = (int)row[6];
        unsigned released = 0;
        if (gear == 2 || gear == 3) {
            CHECK(!popsteer_driver_hold(driver, gear == 2));
        } else if (gear == 4) {
            CHECK(!popsteer_driver_release(driver, &released));
        } else if (gear == 5) {
            CHECK(!popsteer_driver_set_path(driver, aside));
        }
        popsteer_vehicle_state vehicle = {row[0], row[1], row[2], row[3]};
        popsteer_reported reported = popsteer_reported_default();
        reported.pose_age = row[5];
        popsteer_drive drive;
        CHECK(!popsteer_driver_step(driver, vehicle, row[4], &reported, gear > 1 ? -1 : gear, &drive));
        const char *fault = popsteer_fault_name(drive.fault), *was = popsteer_fault_name(released);
        CHECK(!popsteer_driver_estimate(driver, &estimate));
        CHECK(popsteer_driver_predict(driver, -1.0, ahead, 11, NULL) == POPSTEER_ERROR_INPUT);
        CHECK(!popsteer_driver_predict(driver, 0.05, ahead, 11, &count) && count == 11);
        printf("%a %a %a %a %u %d %d %a %a %a %a %s %s\n", drive.steer, drive.acceleration, drive.cross_track_error,
               drive.distance_to_stop, drive.status, drive.reverse, drive.hold, estimate.gain, estimate.dead_time,
               ahead[10].vehicle.x, ahead[10].steer,
               fault == NULL ? "none" : fault, was == NULL ? "none" : was);
    }
}
