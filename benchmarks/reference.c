/* The paper's force loop in hand-written C: the yardstick for frictionloop's compiled loop. Same model, same semantics.
 * Inside a control period the amplitude is an exponential, and the sensor's convolution is a 6-node Gauss-Lobatto sum,
 * or (`ends`, for the grid) comes from the two ends of the period, which is frictionloop's own rule. The amplitude is
 * carried as y = a sqrt(tau log2 e), so that g(a) = f0 2^(-y^2), and its inverse is sqrt(log2(f0/u)). */
#include <pthread.h>
#include <stdatomic.h>

#include "reference_plan.h"

/* One lane with traces. It cannot use vectors over lanes, so its cost is the length of the chain f_m -> u -> a -> f_m.
 * `jump` skips the logarithm and the root while the clamp is active: the processor predicts that branch and runs ahead,
 * which halves the time where saturation comes in spells. */
static inline void one(const System* s, const double* pi, long n, uint64_t number, double* traces, int jump) {
    Plan p = prepare(s, n, s->noise_rms > 0, number);
    Log2Table table;
    fill(&table);
    double kp = pi[0], ki_Ts = pi[1] / s->rate_hz, I = 0, f_m = p.first_force, y = 0, g = 1;
    double micron = sqrt(log(2) / s->tau), log2_f0 = log2_table(&table, s->f0);
    double most = sqrt(log2_f0 - log2_table(&table, p.low));
    double *f_r = traces, *f_a = f_r + n, *measured = f_a + n, *command = measured + n;
    double *a = command + n, *d = a + n, *saturated = d + n;
    memcpy(f_r, p.f_r, n * sizeof(double)), memcpy(d, p.d, n * sizeof(double));
    for (long k = 0; k < n; k++) {
        double e = p.f_r[k] - f_m, v = fma(kp, e, I), u = v < p.low ? p.low : v, c, node[4];
        u = u > p.high ? p.high : u;
        f_a[k] = fma(s->f0, g, p.d[k]), measured[k] = f_m, command[k] = u, a[k] = y * micron, saturated[k] = v != u;
        if (jump && v >= p.high)
            c = 0;
        else if (jump && v <= p.low)
            c = most;
        else {
            double q = log2_f0 - log2_table(&table, u);
            c = sqrt(q > 0 ? q : 0);
        }
        I = (v - u) * e > 0 ? I : fma(ki_Ts, e, I); /* of one sign: the clamp is active and e pushes further into it */
        double known = fma(p.sensor_decay, f_m, p.D[k]) + p.W_f0[0] * g;
        for (int j = 0; j < 4; j++)
            node[j] = p.W_f0[j + 1] * exp2_minus_square_short(fma(c, 1 - p.E[j + 1], y * p.E[j + 1]));
        y = fma(c, 1 - p.E[5], y * p.E[5]);
        g = exp2_minus_square_short(y);
        f_m = fma(p.W_f0[5], g, known) + ((node[0] + node[2]) + (node[1] + node[3]));
    }
    free(p.f_r);
}
void run_one(const System* s, const double* pi, long n, uint64_t number, double* traces) {
    one(s, pi, n, number, traces, 0);
}
void run_one_jump(const System* s, const double* pi, long n, uint64_t number, double* traces) {
    one(s, pi, n, number, traces, 1);
}

typedef struct { /* one sweep, shared by its threads */
    const System* s;
    const Plan* p;
    const double* gains;
    double *out, spread;
    long lanes;
    const uint64_t* seeds;
    int ends;
    atomic_long next;
} Sweep;

/* A tile of lanes, metrics only. Two lane loops, because one has too many live vectors for the registers. */
__attribute__((always_inline)) static inline void tile(const Sweep* w, long lane0, int noise, int ends) {
    const Plan p = *w->p;
    double f_m[LANES], I[LANES] = {0}, y[LANES] = {0}, g[LANES], c[LANES], kp[LANES], ki_Ts[LANES];
    double error2[LANES] = {0}, clamped[LANES] = {0}, z[2][LANES] = {{0}};
    Random random;
    for (int i = 0; i < LANES; i++) { /* lanes past the end repeat the last one */
        long lane = lane0 + i < w->lanes ? lane0 + i : w->lanes - 1;
        kp[i] = w->gains[2 * lane], ki_Ts[i] = w->gains[2 * lane + 1] / w->s->rate_hz, g[i] = 1, f_m[i] = p.first_force;
        if (noise) seed(&random, i, w->seeds[lane]);
    }
    double f0 = w->s->f0, low = p.low, high = p.high, log2_f0 = p.log2_f0, decay = p.sensor_decay;
    double rms = w->s->noise_rms * p.noise_gain;
    for (long k = 0; k < p.n; k++) {
        double f_r = p.f_r[k], rest = p.d[k] - f_r, D = p.D[k];
        if (noise && k % 2 == 0) gaussians(&random, rms, z[0], z[1]);
        for (int i = 0; i < LANES; i++) {
            double e = f_r - f_m[i], v = fma(kp[i], e, I[i]), u = v < low ? low : v;
            u = u > high ? high : u;
            double error = fma(f0, g[i], rest), q = log2_f0 - log2_atanh(u), next = fma(ki_Ts[i], e, I[i]);
            I[i] = (v - u) * e > 0 ? I[i] : next;
            clamped[i] += v != u ? 1 : 0;
            error2[i] = fma(error, error, error2[i]);
            c[i] = sqrt(q > 0 ? q : 0);
        }
        for (int i = 0; i < LANES; i++) {
            double away = y[i] - c[i], f = fma(decay, f_m[i], noise ? D + z[k % 2][i] : D);
            if (ends) {
                f = fma(end_weight(p.ends[0], y[i], away), g[i], f);
                y[i] = fma(away, p.E[5], c[i]);
                g[i] = exp2_minus_square(y[i]);
                f_m[i] = fma(end_weight(p.ends[1], y[i], away * p.E[5]), g[i], f);
                continue;
            }
            f = fma(p.W_f0[0], g[i], f);
            f = fma(p.W_f0[1], exp2_minus_square(fma(away, p.E[1], c[i])), f);
            f = fma(p.W_f0[2], exp2_minus_square(fma(away, p.E[2], c[i])), f);
            f = fma(p.W_f0[3], exp2_minus_square(fma(away, p.E[3], c[i])), f);
            f = fma(p.W_f0[4], exp2_minus_square(fma(away, p.E[4], c[i])), f);
            y[i] = fma(away, p.E[5], c[i]);
            g[i] = exp2_minus_square(y[i]);
            f_m[i] = fma(p.W_f0[5], g[i], f);
        }
    }
    for (int i = 0; i < LANES && lane0 + i < w->lanes; i++)
        w->out[2 * (lane0 + i)] = 1 - error2[i] / w->spread, w->out[2 * (lane0 + i) + 1] = clamped[i] / p.n;
}

/* Functions of their own, so that the compiler sees fixed choices. */
#define KIND(name, noise, ends) \
    static __attribute__((noinline)) void name(const Sweep* w, long lane0) { tile(w, lane0, noise, ends); }
KIND(quiet, 0, 0)
KIND(noisy, 1, 0)
KIND(quiet_ends, 0, 1)
KIND(noisy_ends, 1, 1)

static void* work(void* sweep) {
    Sweep* w = sweep;
    for (long lane; (lane = atomic_fetch_add(&w->next, LANES)) < w->lanes;)
        (w->ends ? w->seeds ? noisy_ends : quiet_ends : w->seeds ? noisy : quiet)(w, lane);
    return NULL;
}

/* `seeds` NULL: all lanes share the noise numbered `number` (none if noise_rms is 0). Otherwise one seed per lane,
 * drawn inside the loop. */
int run_grid(const System* s, long lanes, const double* gains, const uint64_t* seeds, uint64_t number, long n,
             int threads, int ends, double* out) {
    Plan p = prepare(s, n, !seeds && s->noise_rms > 0, number);
    Sweep w = {s, &p, gains, out, 0, lanes, seeds, ends, 0};
    double mean = 0;
    pthread_t thread[64];
    for (long k = 0; k < n; k++) mean += p.f_r[k] / n;
    for (long k = 0; k < n; k++) w.spread += (p.f_r[k] - mean) * (p.f_r[k] - mean);
    for (int i = 1; i < threads && i < 64; i++)
        if (pthread_create(&thread[i], NULL, work, &w)) return -1;
    work(&w);
    for (int i = 1; i < threads && i < 64; i++) pthread_join(thread[i], NULL);
    free(p.f_r);
    return 0;
}
