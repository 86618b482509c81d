/* popsteer.lab.opponents' MPC whole, without estimates, for a car that drives forward;
   studies/solvers.py compiles and calls it. */
#include "api.h"
#include "utils.h"
#include <math.h>
#include <string.h>
#include <time.h>

enum { N = 20 };
static const double STAGE = 0.05;

typedef struct {
    double wheelbase, turning, understeer, lag, max_steer, rate, lateral; /* of the car */
    double point, dt, error, heading, change; /* its no-slip point; period; weights */
} Car;

typedef struct {
    int segments, closed;
    const double *xy, *arc; /* of the waypoints, the first again where it is closed */
    const double *yaw;      /* of each segment: four coefficients of its share */
    double bend, reach;     /* in which an open path goes on beyond its end, and how far */
} Road;

/* A matrix of the model, kept while speed and gain move little. */
typedef struct {
    double speed, rate;
    double a[4][4], b[4], loss[4], last[4][4], hessian[N * N];
} Model;

static double now(void) {
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return at.tv_sec + 1e-9 * at.tv_nsec;
}

static double within(double value, double low, double high) { return fmin(fmax(value, low), high); }

static double wrap(double angle) { return angle - 2.0 * M_PI * nearbyint(angle / (2.0 * M_PI)); }

/* Squared distance to a segment; where on it, beyond 0 to 1 at the ends of an open path. */
static double distance(const Road *road, int k, double x, double y, double *share) {
    const double *p = road->xy + 2 * k;
    double dx = p[2] - p[0], dy = p[3] - p[1];
    double low = k > 0 || road->closed ? 0.0 : -HUGE_VAL;
    double high = k + 1 < road->segments || road->closed ? 1.0 : HUGE_VAL;
    double t = within(((x - p[0]) * dx + (y - p[1]) * dy) / (dx * dx + dy * dy), low, high);
    double rx = x - (p[0] + t * dx), ry = y - (p[1] + t * dy);
    *share = t;
    return rx * rx + ry * ry;
}

/* Downhill from the last segment, ahead and behind. */
static int locate(const Road *road, int k, double x, double y, double *share) {
    double best = distance(road, k, x, y, share), t;
    for (int way = 1, begun = k; way >= -1 && k == begun; way -= 2) {
        for (int last = k;; last = k) {
            int next = last + way;
            if (road->closed) next = (next + road->segments) % road->segments;
            if (next < 0 || next >= road->segments) break;
            double far = distance(road, next, x, y, &t);
            if (far > best || (way < 0 && far == best)) break;
            k = next, best = far, *share = t;
        }
    }
    return k;
}

static double yaw_on(const Road *road, int k, double t) {
    const double *c = road->yaw + 4 * k;
    return c[0] + t * (c[1] + t * (c[2] + t * c[3]));
}

/* Mean curvatures of the stages ahead. */
static void bends_ahead(const Road *road, int k, double arc, double step, double *bends) {
    double end = road->arc[road->segments], before = 0.0;
    for (int j = 0; j <= N; j++) {
        double at = arc + j * step;
        if (road->closed) at -= end * floor(at / end);
        while (k > 0 && at < road->arc[k]) k = road->closed && at < road->arc[1] ? 0 : k - 1;
        while (k + 1 < road->segments && at >= road->arc[k + 1]) k++;
        double t = within((at - road->arc[k]) / (road->arc[k + 1] - road->arc[k]), 0.0, 1.0);
        double yaw = yaw_on(road, k, t);
        if (!road->closed) yaw += road->bend * within(at - end, 0.0, road->reach);
        if (j) bends[j - 1] = wrap(yaw - before) / step;
        before = yaw;
    }
}

typedef double Four[4][4];

static void times(const Four a, const Four b, Four c) {
    for (int i = 0; i < 4; i++) {
        double row[4] = {0.0};
        for (int k = 0; k < 4; k++)
            for (int j = 0; j < 4; j++) row[j] += a[i][k] * b[k][j];
        memcpy(c[i], row, sizeof row);
    }
}

static void transposed(const Four a, Four b) {
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) b[j][i] = a[i][j];
}

/* Solves m [x y] = [a g]. */
static void solve(Four m, const Four a, const Four g, Four x, Four y) {
    double w[4][12];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) w[i][j] = m[i][j], w[i][4 + j] = a[i][j], w[i][8 + j] = g[i][j];
    for (int c = 0; c < 4; c++) {
        int best = c;
        for (int i = c + 1; i < 4; i++)
            if (fabs(w[i][c]) > fabs(w[best][c])) best = i;
        double scale = 1.0 / w[best][c], row[12];
        for (int j = 0; j < 12; j++) row[j] = w[best][j] * scale;
        if (best != c) memcpy(w[best], w[c], sizeof row);
        memcpy(w[c], row, sizeof row);
        for (int i = 0; i < 4; i++) {
            double factor = i == c ? 0.0 : w[i][c];
            for (int j = 0; j < 12; j++) w[i][j] -= factor * row[j];
        }
    }
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) x[i][j] = w[i][4 + j], y[i][j] = w[i][8 + j];
}

/* The regulator's cost-to-go, by doubling. */
static void cost_to_go(const Car *car, const Model *of, Four p) {
    Four a, g, gp, past, with_g, turned, product, more;
    memcpy(a, of->a, sizeof a);
    memset(p, 0, sizeof(Four));
    p[0][0] = car->error, p[1][1] = car->heading;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) g[i][j] = of->b[i] * of->b[j] / car->change;
    for (int pass = 0; pass < 50; pass++) {
        double moved = 0.0, most = 0.0;
        times(g, p, gp);
        for (int i = 0; i < 4; i++) gp[i][i] += 1.0;
        solve(gp, a, g, past, with_g);
        transposed(a, turned);
        times(turned, p, product);
        times(product, past, more);
        times(with_g, turned, gp);
        times(a, gp, product);
        times(a, past, gp);
        memcpy(a, gp, sizeof a);
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++) {
                g[i][j] += product[i][j], p[i][j] += more[i][j];
                moved = fmax(moved, fabs(more[i][j])), most = fmax(most, fabs(p[i][j]));
            }
        if (moved <= 1e-12 * most) break;
    }
}

static void make_model(const Car *car, double speed, double length, double rate, Model *of) {
    double kept = car->lag > 0.0 ? exp(-STAGE / car->lag) : 0.0;
    double mean = car->lag > 0.0 ? (1.0 - kept) * car->lag / STAGE : 0.0;
    double turn = STAGE * speed * rate / length, half = 0.5 * STAGE * speed * turn;
    const Four a = {{1.0, STAGE * speed, half * mean, half * (1.0 - mean)},
                    {0.0, 1.0, turn * mean, turn * (1.0 - mean)},
                    {0.0, 0.0, kept, 1.0 - kept},
                    {0.0, 0.0, 0.0, 1.0}};
    double moved[N][4], pulled[4];
    memcpy(of->a, a, sizeof a);
    for (int i = 0; i < 4; i++) of->b[i] = moved[0][i] = a[i][3];
    of->loss[0] = half, of->loss[1] = turn, of->loss[2] = of->loss[3] = 0.0;
    of->speed = speed, of->rate = rate;
    cost_to_go(car, of, of->last);
    for (int k = 1; k < N; k++)
        for (int i = 0; i < 4; i++) {
            moved[k][i] = 0.0;
            for (int j = 0; j < 4; j++) moved[k][i] += a[i][j] * moved[k - 1][j];
        }
    /* What two changes do together, summed over what they do alike but for how long. */
    double sums[N] = {0.0};
    for (int m = 0; m < N; m++) {
        int i = N - 1 - m;
        for (int r = 0; r < 4; r++) {
            pulled[r] = 0.0;
            for (int c = 0; c < 4; c++) pulled[r] += of->last[r][c] * moved[m][c];
        }
        for (int d = 0; d <= i; d++) {
            const double *other = moved[m + d];
            double value = sums[d];
            for (int r = 0; r < 4; r++) value += pulled[r] * other[r];
            of->hessian[i * N + i - d] = of->hessian[(i - d) * N + i] = value;
            sums[d] += car->error * moved[m][0] * other[0] + car->heading * moved[m][1] * other[1];
        }
        of->hessian[i * N + i] += car->change;
    }
}

/* Answers `count` poses [m, m, rad, m/s] along a path: gives the commands [rad], and the time that
   each step took [s]. */
int solve_all(int count, const Car *car, int segments, int closed, const double *xy,
              const double *arc, const double *yaw, double bend, double reach, double *sums,
              int first, const double *poses, double *commands, double *seconds) {
    Road road = {segments, closed, xy, arc, yaw, bend, reach};
    Model model;
    make_model(car, 1.0, car->turning, 1.0, &model);
    model.speed = HUGE_VAL, model.rate = 0.0;
    double x[64], multipliers[128], gradient[N] = {0}, upper[2 * N], lower[2 * N];
    for (int j = 0; j < 2 * N; j++) upper[j] = 1.0, lower[j] = -1.0;
    DAQPProblem problem = {N, 2 * N, N, model.hessian, gradient, sums, upper, lower};
    DAQPWorkspace work = {0};
    DAQPResult found = {x, multipliers};
    double unused, steer = 0.0, wheel = 0.0, change = car->rate * car->dt;
    double share = car->lag > 0.0 ? 1.0 - exp(-car->dt / car->lag) : 1.0;
    int flag = setup_daqp(&problem, &work, &unused), segment = first;
    for (int k = 0; flag >= 0 && k < count; k++) {
        const double *pose = poses + 4 * k;
        double begun = now(), t;
        int mask = DAQP_UPDATE_v | DAQP_UPDATE_d;
        wheel += within(share * (steer - wheel), -change, change);
        /* The place on the path. */
        double px = pose[0] + car->point * cos(pose[2]), py = pose[1] + car->point * sin(pose[2]);
        segment = locate(&road, segment, px, py, &t);
        const double *p = xy + 2 * segment, *c = yaw + 4 * segment;
        double dx = p[2] - p[0], dy = p[3] - p[1], s = within(t, 0.0, 1.0);
        double direction = yaw_on(&road, segment, s), cosine = cos(direction), sine = sin(direction);
        double aside = s == t ? -0.5 * (c[1] + c[2] + c[3]) * s * (1.0 - s) : 0.0;
        double ex = px - (p[0] + s * dx - aside * dy), ey = py - (p[1] + s * dy + aside * dx);
        double left = cosine * ey - sine * ex;
        double error = s == t ? copysign(sqrt(ex * ex + ey * ey), left) : left;
        double heading = wrap(pose[2] - direction);
        double here = arc[segment] + t * (arc[segment + 1] - arc[segment]);
        /* The model. */
        double speed = fmax(fabs(pose[3]), car->wheelbase / 3.0);
        double length = car->turning + car->understeer * speed * speed;
        double bends[N], reference[N], rate = 0.0;
        bends_ahead(&road, segment, here, speed * STAGE, bends);
        for (int j = 0; j < N; j++) rate += length * bends[j] * length * bends[j];
        rate = 1.0 + rate / N;
        for (int j = 0; j < N; j++) reference[j] = atan(length * bends[j]);
        if (fabs(speed - model.speed) > 0.005 * model.speed ||
            fabs(rate - model.rate) > 0.02 * rate) {
            make_model(car, speed, length, rate, &model);
            mask |= DAQP_UPDATE_Rinv | DAQP_UPDATE_sense;
            problem.sense = work.sense;
        }
        /* The right-hand side: how far off the stages are, forward; their pull, backward. */
        double off[N][4], by = 0.0;
        double most = fmin(car->max_steer, atan(car->lateral * length / (speed * speed)));
        double at[4] = {within(error, -0.5 * car->wheelbase, 0.5 * car->wheelbase), heading, wheel, steer};
        for (int j = 0; j < N; j++) {
            double to[4];
            for (int r = 0; r < 4; r++) {
                to[r] = -model.loss[r] * reference[j];
                for (int c = 0; c < 4; c++) to[r] += model.a[r][c] * at[c];
            }
            memcpy(at, to, sizeof at);
            off[j][0] = at[0], off[j][1] = at[1];
            off[j][2] = at[2] - reference[j], off[j][3] = at[3] - reference[j];
        }
        double pull[4];
        for (int r = 0; r < 4; r++) {
            pull[r] = 0.0;
            for (int c = 0; c < 4; c++) pull[r] += model.last[r][c] * off[N - 1][c];
        }
        for (int j = N - 1;; j--) {
            gradient[j] = 0.0;
            for (int r = 0; r < 4; r++) gradient[j] += model.b[r] * pull[r];
            if (j == 0) break;
            double to[4] = {car->error * off[j - 1][0], car->heading * off[j - 1][1], 0.0, 0.0};
            for (int r = 0; r < 4; r++)
                for (int c = 0; c < 4; c++) to[r] += model.a[c][r] * pull[c];
            memcpy(pull, to, sizeof pull);
        }
        for (int j = 0; j < N; j++) {
            double turned = fmin(j ? car->rate * STAGE : change, 2.0 * car->max_steer);
            by += turned;
            upper[j] = turned, lower[j] = -turned;
            upper[N + j] = fmax(most - steer, -by), lower[N + j] = fmin(-most - steer, by);
        }
        flag = daqp_update_ldp(mask, &work, &problem);
        if (flag >= 0) {
            daqp_solve(&found, &work);
            flag = found.exitflag;
        }
        double wanted = within(within(steer + x[0], -most, most), steer - change, steer + change);
        steer = within(wanted, -car->max_steer, car->max_steer);
        seconds[k] = now() - begun;
        commands[k] = steer;
    }
    free_daqp_workspace(&work);
    free_daqp_ldp(&work);
    return flag;
}
