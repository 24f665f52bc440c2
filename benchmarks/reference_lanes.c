/* The grid once more, doing the work of frictionloop's kernel: every lane has a System of its own (friction law, the
 * controller's model and clamp, plate, sensor, noise, gains), so that any parameter can be swept, and logarithm and
 * powers are those of quantities/scalar_math.py. Set-point and disturbance are shared, as in frictionloop's grid.
 *
 * A tile has two halves. While the command of one half waits for its division and root, the plant of the other half
 * keeps the multipliers busy: one loop over lanes does both, and the compiler mixes them (build.py asks it to). */
#define HALF 32
#define LANES (2 * HALF)
#define ALWAYS static inline __attribute__((always_inline)) /* a call in a loop over lanes would keep it scalar */

#include <pthread.h>
#include <stdatomic.h>

#include "reference_plan.h"

typedef struct {
    double f0, tau, a_max, model_f0, model_tau, model_a_max, plate_hz, sensor_hz, noise_rms, kp, ki;
} Lane;

typedef struct { /* one sweep, shared by its threads */
    const System* s;
    const Lane* lane;
    const uint64_t* seeds;
    double *f_r, *sine, *cosine, *out, spread; /* the disturbance's swing, and the same a quarter turn later */
    long lanes, n;
    atomic_long next;
} Sweep;

typedef struct { /* half a tile: a row per quantity, a column per lane */
    _Alignas(64) double kp[HALF];
    double ki_Ts[HALF], low[HALF], high[HALF], log2_high[HALF], model[HALF], ceiling[HALF];
    double f0[HALF], decay[HALF], noise_gain[HALF], E[6][HALF], W_f0[6][HALF];
    double steady[HALF], in_phase[HALF], quadrature[HALF]; /* what the disturbance adds to f_m */
    double f_m[HALF], I[HALF], y[HALF], g[HALF], c[HALF], error2[HALF], clamped[HALF];
} Half;

typedef struct {
    double f_r, rest, sine, cosine, D; /* of one period: set-point, d - f_r, swings, what d adds if lanes share it */
} Signals;

/* The sums at t_k, the PI law with its clamp, and the command: the model's inverse, limited by the plate. */
ALWAYS void control(Half* h, int i, Signals now) {
    double e = now.f_r - h->f_m[i], v = fma(h->kp[i], e, h->I[i]), u = v < h->low[i] ? h->low[i] : v;
    u = u > h->high[i] ? h->high[i] : u;
    double error = fma(h->f0[i], h->g[i], now.rest), next = fma(h->ki_Ts[i], e, h->I[i]);
    double q = (h->log2_high[i] - log2_exact(u)) * h->model[i];
    h->I[i] = (v - u) * e > 0 ? h->I[i] : next;
    h->clamped[i] += v != u ? 1 : 0;
    h->error2[i] = fma(error, error, h->error2[i]);
    q = sqrt(q > 0 ? q : 0);
    h->c[i] = q < h->ceiling[i] ? q : h->ceiling[i];
}

/* One period of plate, friction law and sensor. `shared`: all lanes of the tile have one sensor corner. */
ALWAYS void plant(Half* h, int i, Signals now, const double* normal, int noise, int shared) {
    double swing = fma(now.sine, h->in_phase[i], fma(now.cosine, h->quadrature[i], h->steady[i]));
    double D = shared ? now.D : swing, c = h->c[i], away = h->y[i] - c;
    double f = fma(h->decay[i], h->f_m[i], noise ? fma(h->noise_gain[i], normal[i], D) : D);
    f = fma(h->W_f0[0][i], h->g[i], f);
    f = fma(h->W_f0[1][i], exp2_minus_square_exact(fma(away, h->E[1][i], c)), f);
    f = fma(h->W_f0[2][i], exp2_minus_square_exact(fma(away, h->E[2][i], c)), f);
    f = fma(h->W_f0[3][i], exp2_minus_square_exact(fma(away, h->E[3][i], c)), f);
    f = fma(h->W_f0[4][i], exp2_minus_square_exact(fma(away, h->E[4][i], c)), f);
    double y = fma(away, h->E[5][i], c), g = exp2_minus_square_exact(y);
    h->y[i] = y, h->g[i] = g;
    h->f_m[i] = fma(h->W_f0[5][i], g, f);
}

static inline Signals signals(const Sweep* w, const Half* h, long k) {
    double sine = w->sine[k], cosine = w->cosine[k], rest = w->s->disturbance_offset + sine - w->f_r[k];
    double D = fma(sine, h->in_phase[0], fma(cosine, h->quadrature[0], h->steady[0]));
    return (Signals){w->f_r[k], rest, sine, cosine, D};
}

ALWAYS void run(const Sweep* w, Half* restrict a, Half* restrict b, Random* random, int noise, int shared) {
    _Alignas(64) double z[2][LANES];
    Signals now = signals(w, a, 0);
    for (int i = 0; i < HALF; i++) control(a, i, now);
    for (long k = 0; k < w->n - 1; k++) {
        Signals later = signals(w, a, k + 1);
        if (noise && k % 2 == 0) gaussians(random, 1, z[0], z[1]);
        for (int i = 0; i < HALF; i++) control(b, i, now), plant(a, i, now, z[k % 2], noise, shared);
        for (int i = 0; i < HALF; i++) control(a, i, later), plant(b, i, now, z[k % 2] + HALF, noise, shared);
        now = later;
    }
    for (int i = 0; i < HALF; i++) control(b, i, now); /* nothing is read after the last sums */
}

/* Functions of their own, so that the compiler sees fixed choices, and halves that do not overlap. */
#define KIND(name, noise, shared)                                                                                      \
    static __attribute__((noinline)) void name(const Sweep* w, Half* restrict a, Half* restrict b, Random* random) {   \
        run(w, a, b, random, noise, shared);                                                                           \
    }
KIND(quiet, 0, 0)
KIND(quiet_shared, 0, 1)
KIND(noisy, 1, 0)
KIND(noisy_shared, 1, 1)

/* Coefficients and start of column i. */
static void fill_lane(Half* h, int i, const Sweep* w, const Lane* l) {
    double Ts = 1 / w->s->rate_hz, corner = 2 * PI * l->sensor_hz, at[6], weight[6];
    lobatto(at, weight);
    h->steady[i] = h->in_phase[i] = h->quadrature[i] = 0;
    for (int j = 0; j < 6; j++) {
        double W = weight[j] * corner * Ts * exp(-corner * (1 - at[j]) * Ts);
        double turn = 2 * PI * w->s->disturbance_hz * at[j] * Ts;
        h->E[j][i] = exp(-2 * PI * l->plate_hz * at[j] * Ts), h->W_f0[j][i] = W * l->f0;
        h->steady[i] += W * w->s->disturbance_offset;
        h->in_phase[i] += W * cos(turn), h->quadrature[i] += W * sin(turn);
    }
    h->kp[i] = l->kp, h->ki_Ts[i] = l->ki * Ts, h->f0[i] = l->f0, h->decay[i] = exp(-corner * Ts);
    h->noise_gain[i] = l->noise_rms * (1 - h->decay[i]);
    h->low[i] = l->model_f0 * exp(-l->model_tau * l->model_a_max * l->model_a_max), h->high[i] = l->model_f0;
    /* amplitudes are y = a sqrt(tau log2 e) with the finger's tau: the model's is a factor under the root */
    h->log2_high[i] = log2(l->model_f0), h->model[i] = l->tau / l->model_tau;
    h->ceiling[i] = l->a_max * sqrt(l->tau / log(2));
    h->f_m[i] = l->f0 + w->s->disturbance_offset + w->sine[0], h->g[i] = 1;
    h->I[i] = h->y[i] = h->error2[i] = h->clamped[i] = 0;
}

static void* work(void* sweep) {
    Sweep* w = sweep;
    Half half[2];
    Random random;
    for (long first; (first = atomic_fetch_add(&w->next, LANES)) < w->lanes;) {
        int shared = 1;
        for (int i = 0; i < LANES; i++) { /* lanes past the end repeat the last one */
            long number = first + i < w->lanes ? first + i : w->lanes - 1;
            fill_lane(half + i / HALF, i % HALF, w, w->lane + number);
            shared &= w->lane[number].sensor_hz == w->lane[first].sensor_hz;
            if (w->seeds) seed(&random, i, w->seeds[number]);
        }
        (w->seeds ? shared ? noisy_shared : noisy : shared ? quiet_shared : quiet)(w, half, half + 1, &random);
        for (int i = 0; i < LANES && first + i < w->lanes; i++) {
            const Half* h = half + i / HALF;
            double* out = w->out + 2 * (first + i);
            out[0] = 1 - h->error2[i % HALF] / w->spread, out[1] = h->clamped[i % HALF] / w->n;
        }
    }
    return NULL;
}

/* R2_identity and saturation index per lane. `seeds`: one per lane, NULL for no noise. Rate and signals come from the
 * System, all else from the lanes. */
int run_lanes(const System* s, long lanes, const Lane* lane, const uint64_t* seeds, long n, int threads, double* out) {
    Plan p = prepare(s, n, 0, 0);
    double offset = s->setpoint_offset, sum = 0, squares = 0;
    for (long k = 0; k < n; k++) {
        p.d[k] -= s->disturbance_offset;
        p.D[k] = s->disturbance_amplitude * sin_turns(k * (s->disturbance_hz / s->rate_hz) + 0.25);
    }
    for (long k = 0; k < n; k++) sum += p.f_r[k] - offset, squares += (p.f_r[k] - offset) * (p.f_r[k] - offset);
    Sweep w = {s, lane, seeds, p.f_r, p.d, p.D, out, squares - sum * sum / n, lanes, n, 0};
    pthread_t thread[64];
    for (int i = 1; i < threads && i < 64; i++)
        if (pthread_create(&thread[i], NULL, work, &w)) return -1;
    work(&w);
    for (int i = 1; i < threads && i < 64; i++) pthread_join(thread[i], NULL);
    free(p.f_r);
    return 0;
}
