// A drive's problems by TinyMPC; studies/solvers.py compiles and calls it.
#include <chrono>
#include <tinympc/tiny_api.hpp>

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using In = Eigen::Map<const Rows>;

// Solves `count` problems of `stages` changes of one command, four states each, whose dynamics are
// kept where `fresh` is 0: gives the first changes, and the time of setting and solving [s].
extern "C" int solve_all(int count, int stages, const double *dynamics, const double *inputs,
                          const double *q, double r, double rho, double tolerance, int most_passes,
                          const int *fresh, const double *starts, const double *wanted,
                          const double *change, const double *low, const double *high,
                          double *moves, double *seconds) {
    const double far = 1e17;
    std::cout.setstate(std::ios::failbit); // it prints each solution
    // What it minimises has the weights Q + rho, R + rho.
    const tinyMatrix state =
        (Eigen::Map<const Eigen::Vector4d>(q).array() - rho).matrix().asDiagonal();
    const tinyMatrix command = tinyMatrix::Constant(1, 1, r - rho);
    const tinyMatrix none = tinyMatrix::Zero(4, 1);
    TinySolver *solver = nullptr;
    for (int k = 0; k < count; k++) {
        const tinyMatrix a = In(dynamics + 16 * k, 4, 4), b = In(inputs + 4 * k, 4, 1);
        const tinyMatrix reference = In(wanted + 4 * (stages + 1) * k, stages + 1, 4).transpose();
        const tinyMatrix most = In(change + stages * k, 1, stages);
        tinyMatrix under = tinyMatrix::Constant(4, stages + 1, -far), over = -under;
        under.row(3).tail(stages) = In(low + stages * k, 1, stages);
        over.row(3).tail(stages) = In(high + stages * k, 1, stages);
        const tinyVector start = In(starts + 4 * k, 4, 1);
        if (!solver) {
            tiny_setup(&solver, a, b, none, state, command, rho, 4, 1, stages + 1, 0);
            tiny_update_settings(solver->settings, tolerance, tolerance, most_passes, 1, 1, 1, 0, 0,
                                 0, 0);
        }
        const auto begun = std::chrono::steady_clock::now();
        if (fresh[k]) {
            solver->work->Adyn = a;
            solver->work->Bdyn = b;
            tiny_precompute_and_set_cache(solver->cache, a, b, none, solver->work->Q.asDiagonal(),
                                          solver->work->R.asDiagonal(), 4, 1, rho, 0);
        }
        tiny_set_x0(solver, start);
        tiny_set_x_ref(solver, reference);
        tiny_set_bound_constraints(solver, under, over, -most, most);
        tiny_solve(solver);
        seconds[k] = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        moves[k] = solver->solution->u(0, 0);
    }
    return 0;
}
