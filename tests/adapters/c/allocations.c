/* Counts what is allocated and freed while controllers step: nothing. For glibc, whose allocator
 * has a second name. */

#include "checks.h"

void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void *__libc_memalign(size_t, size_t);
void __libc_free(void *);

static size_t calls;

void *malloc(size_t size) {
    ++calls;
    return __libc_malloc(size);
}

void *calloc(size_t count, size_t size) {
    ++calls;
    return __libc_calloc(count, size);
}

void *realloc(void *old, size_t size) {
    ++calls;
    return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size) {
    ++calls;
    return __libc_memalign(alignment, size);
}

int posix_memalign(void **out, size_t alignment, size_t size) {
    ++calls;
    *out = __libc_memalign(alignment, size);
    return *out == NULL;
}

void free(void *old) {
    ++calls;
    __libc_free(old);
}

int main(void) {
    popsteer_path *path = sine(0.0), *other = sine(2.0);
    popsteer_vehicle car = late_car();
    popsteer_controller *each[5] = {NULL};
    CHECK(!popsteer_pop_new(path, &car, NULL, NULL, &each[0]));
    CHECK(!popsteer_preview_pop_new(path, &car, NULL, NULL, &each[1]));
    CHECK(!popsteer_pid_new(path, &car, NULL, NULL, &each[2]));
    CHECK(!popsteer_pure_pursuit_new(path, &car, NULL, NULL, &each[3]));
    CHECK(!popsteer_stanley_new(path, &car, NULL, NULL, &each[4]));
    popsteer_batch *batch = NULL;
    CHECK(!popsteer_batch_new((const popsteer_controller *const *)each, 5, &batch));
    popsteer_speed_tracker *tracker = NULL;
    CHECK(!popsteer_speed_tracker_new(path, &car, NULL, &tracker));
    CHECK(calls > 8);
    size_t before = calls;
    popsteer_reported reported = popsteer_reported_default();
    for (int step = 0; step < 600; ++step) {
        popsteer_vehicle_state vehicles[5];
        popsteer_command commands[5];
        popsteer_predicted instants[10];
        popsteer_speed_command pace;
        popsteer_estimate estimate;
        for (int k = 0; k < 5; ++k) {
            vehicles[k] = (popsteer_vehicle_state){0.4 * step, 0.5 * k, 0.3, 8.0};
            vehicles[k].speed = step % 50 == 7 ? NAN : 8.0;
            reported.pose_age = step % 3 * 0.1;
            CHECK(popsteer_step(each[k], vehicles[k], 0.05, &reported, &commands[k]) ==
                  (step % 50 == 7 ? POPSTEER_ERROR_INPUT : POPSTEER_ERROR_NONE));
            CHECK(!popsteer_step_or_hold(each[k], vehicles[k], 0.05, 1, NULL, &commands[k]));
            CHECK(!popsteer_controller_estimate(each[k], &estimate));
            if (step % 100 == 99) {
                CHECK(!popsteer_predict(each[k], 0.05, instants, 10, NULL));
                CHECK(!popsteer_controller_set_path(each[k], step % 200 == 99 ? other : path));
            }
        }
        vehicles[0].speed = 8.0;
        CHECK(!popsteer_speed_tracker_step(tracker, vehicles[0], 0.05, 0.0, &pace));
        CHECK(!popsteer_batch_step_or_hold(batch, vehicles, 0.05, 1, NULL, commands));
    }
    size_t counted = calls - before;
    popsteer_batch_free(batch);
    popsteer_speed_tracker_free(tracker);
    for (int k = 0; k < 5; ++k) {
        popsteer_controller_free(each[k]);
    }
    popsteer_path_free(path);
    popsteer_path_free(other);
    printf("%zu\n", counted);
    return counted != 0;
}
