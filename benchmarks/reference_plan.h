/* What the loops need, worked out once per call: constants of a control period, and the signals. */
#include "reference_noise.h"

#include <stdlib.h>

#define PI 3.14159265358979323846

typedef struct {
    double f0, tau, a_max, plate_hz, sensor_hz, noise_rms, rate_hz;
    double setpoint_offset, setpoint_amplitude, start_hz, stop_hz, sweep_s;
    double disturbance_offset, disturbance_amplitude, disturbance_hz;
} System;

typedef struct {
    double low, high, log2_f0, sensor_decay, noise_gain, first_force;
    double E[6], W[6], W_f0[6]; /* at the nodes: plate decay, and weight times sensor kernel, bare and times f0 */
    double ends[2][6]; /* terms of the rule of the two ends, times f0 */
    long n;
    double *f_r, *d, *D; /* set-point, disturbance, and what disturbance and shared noise add to f_m over a period */
} Plan;

/* Six Gauss-Lobatto nodes and weights on [0, 1]. */
static void lobatto(double at[6], double weight[6]) {
    double inner = sqrt(7);
    for (int j = 0; j < 6; j++) {
        int end = j == 0 || j == 5, outer = j == 1 || j == 4;
        double x = end ? 1 : sqrt(1. / 3 + (outer ? 2 : -2) * inner / 21);
        at[j] = (1 + (j < 3 ? -x : x)) / 2;
        weight[j] = (end ? 1. / 15 : (14 + (outer ? -inner : inner)) / 30) / 2;
    }
}

/* Friction over a period of constant command, from value and three derivatives at its two ends (loop/kernel/endpoint_quadrature.py): the
 * terms 1, p, q, p^2, p q, p^3 of either end, p = y z and q = z^2 for an amplitude y = command + z. */
static void end_terms(double theta, double turned, double terms[2][6]) {
    double A[8][9] = {{0}}, at[6], weight[6], k = 2 * log(2) * turned, l = turned;
    for (int d = 0; d < 8; d++) { /* exact for x^d: its derivatives at 0 and 1, and its integral by halved stretches */
        double factor = 1;
        for (int j = 0; j < 4; j++) {
            A[d][j] = d == j ? factor : 0, A[d][4 + j] = factor;
            factor *= d - j;
        }
        lobatto(at, weight);
        for (int piece = 0; piece < 256; piece++)
            for (int j = 0; j < 6; j++) {
                double x = (piece + at[j]) / 256;
                A[d][8] += weight[j] / 256 * theta * exp(-theta * (1 - x)) * pow(x, d);
            }
    }
    for (int c = 0; c < 8; c++) { /* Gauss and Jordan */
        int best = c;
        for (int r = c; r < 8; r++)
            if (fabs(A[r][c]) > fabs(A[best][c])) best = r;
        for (int j = 0; j < 9; j++) {
            double swap = A[c][j];
            A[c][j] = A[best][j], A[best][j] = swap;
        }
        for (int r = 0; r < 8; r++) {
            double by = r == c ? 0 : A[r][c] / A[c][c];
            for (int j = 0; j < 9; j++) A[r][j] -= by * A[c][j];
        }
    }
    for (int e = 0; e < 2; e++) {
        double w[4];
        for (int j = 0; j < 4; j++) w[j] = A[4 * e + j][8] / A[4 * e + j][4 * e + j];
        terms[e][0] = w[0], terms[e][1] = k * w[1] - k * l * w[2] + k * l * l * w[3];
        terms[e][2] = -k * l * w[2] + 3 * k * l * l * w[3], terms[e][3] = k * k * w[2] - 3 * k * k * l * w[3];
        terms[e][4] = -3 * k * k * l * w[3], terms[e][5] = k * k * k * w[3];
    }
}
static inline double end_weight(const double c[6], double y, double z) {
    double p = y * z, q = z * z;
    return fma(p, fma(p, fma(p, c[5], c[3]), fma(q, c[4], c[1])), fma(q, c[2], c[0]));
}

static Plan prepare(const System* s, long n, int noise, uint64_t number) {
    Plan p = {.low = s->f0 * exp(-s->tau * s->a_max * s->a_max), .high = s->f0, .log2_f0 = log2_atanh(s->f0), .n = n};
    double Ts = 1 / s->rate_hz, w = 2 * PI * s->sensor_hz, in_phase = 0, quadrature = 0, total = 0, at[6], weight[6];
    lobatto(at, weight);
    for (int j = 0; j < 6; j++) {
        double turn = 2 * PI * s->disturbance_hz * at[j] * Ts;
        p.E[j] = exp(-2 * PI * s->plate_hz * at[j] * Ts);
        p.W[j] = weight[j] * w * Ts * exp(-w * (1 - at[j]) * Ts);
        p.W_f0[j] = p.W[j] * s->f0;
        total += p.W[j], in_phase += p.W[j] * cos(turn), quadrature += p.W[j] * sin(turn);
    }
    end_terms(w * Ts, 2 * PI * s->plate_hz * Ts, p.ends);
    for (int j = 0; j < 12; j++) p.ends[j / 6][j % 6] *= s->f0;
    p.sensor_decay = exp(-w * Ts), p.noise_gain = 1 - p.sensor_decay;
    double* memory = malloc((3 * n + 2 * LANES) * sizeof(double)); /* signals, and scratch for the noise */
    if (!memory) abort();
    double *f_r = p.f_r = memory, *d = p.d = memory + n, *D = p.D = memory + 2 * n;
    double octaves = log2(s->stop_hz / s->start_hz), rise = octaves / s->sweep_s * Ts; /* octaves per period */
    double turns = s->start_hz * s->sweep_s / (octaves * log(2));
    for (long k = 0; k < n; k++) {
        double chirp = turns * (1 / exp2_minus_square(sqrt(k * rise)) - 1), t = k * (s->disturbance_hz * Ts);
        double sine = s->disturbance_amplitude * sin_turns(t), cosine = s->disturbance_amplitude * sin_turns(t + 0.25);
        f_r[k] = s->setpoint_offset + s->setpoint_amplitude * sin_turns(chirp);
        d[k] = s->disturbance_offset + sine;
        D[k] = s->disturbance_offset * total + sine * in_phase + cosine * quadrature;
    }
    p.first_force = s->f0 + p.d[0];
    if (noise) gaussian_series(number, s->noise_rms * p.noise_gain, n, p.D, p.D + n);
    return p;
}
