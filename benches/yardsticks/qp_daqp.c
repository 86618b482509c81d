/* A drive's quadratic problems by daqp in C; studies/solvers.py compiles and calls it. */
#include "api.h"
#include "utils.h"
#include <time.h>

static double now(void) {
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return at.tv_sec + 1e-9 * at.tv_nsec;
}

/* Solves `count` problems of n changes and m sums of them, whose matrix is kept where `fresh` is 0:
   gives the first change of each, and the time that updating and solving took [s]. */
int solve_all(int count, int n, int m, double *sums, double *hessian, const int *fresh,
              double *gradient, double *upper, double *lower, double *moves, double *seconds) {
    double x[64], multipliers[128];
    DAQPProblem problem = {n, n + m, n, hessian, gradient, sums, upper, lower};
    DAQPWorkspace work = {0};
    DAQPResult found = {x, multipliers};
    double unused;
    int flag = setup_daqp(&problem, &work, &unused);
    for (int k = 0; flag >= 0 && k < count; k++) {
        int mask = DAQP_UPDATE_v | DAQP_UPDATE_d;
        problem.f = gradient + k * n;
        problem.bupper = upper + k * (n + m);
        problem.blower = lower + k * (n + m);
        if (fresh[k]) {
            mask |= DAQP_UPDATE_Rinv | DAQP_UPDATE_sense;
            problem.sense = work.sense;
            problem.H = hessian + k * n * n;
        }
        double begun = now();
        flag = daqp_update_ldp(mask, &work, &problem);
        if (flag >= 0) {
            daqp_solve(&found, &work);
            flag = found.exitflag;
        }
        seconds[k] = now() - begun;
        moves[k] = x[0];
    }
    free_daqp_workspace(&work);
    free_daqp_ldp(&work);
    return flag;
}
