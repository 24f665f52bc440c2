/* Elementary functions for reference.c, without branches, so that a compiler turns loops over them into vector code.
 * All in powers of two and in turns, which saves scaling by ln 2 and 2 pi. Errors are far below the quadrature's. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#define ROUND 6755399441055744.0 /* 1.5 * 2^52: adding it rounds to an integer, which the low bits then hold */

static inline int64_t bits(double x) {
    int64_t i;
    memcpy(&i, &x, 8);
    return i;
}
static inline double from_bits(int64_t i) {
    double x;
    memcpy(&x, &i, 8);
    return x;
}
static inline double scaled(double p, double t) { return from_bits(bits(p) + (int64_t)((uint64_t)bits(t) << 52)); }

/* 2^(-y*y), relative error 1.4e-14. Horner has the fewest operations: best when many lanes hide its latency. */
static inline double exp2_minus_square(double y) {
    double t = fma(-y, y, ROUND), r = fma(-y, y, ROUND - t);
    double p = fma(1.0205905413765595e-07, r, 1.325964524488711e-06);
    p = fma(p, r, 1.5252672924850737e-05);
    p = fma(p, r, 0.0001540343375125101);
    p = fma(p, r, 0.0013333558200794592);
    p = fma(p, r, 0.009618129193934313);
    p = fma(p, r, 0.05550410866465167);
    p = fma(p, r, 0.2402265069564034);
    p = fma(p, r, 0.6931471805599462);
    return scaled(fma(p, r, 1.0000000000000135), t);
}

/* The same polynomial by Estrin's scheme: more operations, shorter chain. For the one-lane loop, which waits for every
 * result. */
static inline double exp2_minus_square_short(double y) {
    double t = fma(-y, y, ROUND), r = fma(-y, y, ROUND - t), r2 = r * r, r4 = r2 * r2;
    double p01 = fma(0.6931471805599462, r, 1.0000000000000135), p23 = fma(0.05550410866465167, r, 0.2402265069564034);
    double p45 = fma(0.0013333558200794592, r, 0.009618129193934313),
           p67 = fma(1.5252672924850737e-05, r, 0.0001540343375125101);
    double p89 = fma(1.0205905413765595e-07, r, 1.325964524488711e-06);
    return scaled(fma(fma(p89, r4, fma(p67, r2, p45)), r4, fma(p23, r2, p01)), t);
}

/* log2(x) for positive normal x: exponent + series of atanh in s = (m-1)/(m+1), m in [0.71, 1.41]. Error 1.3e-14. */
static inline double log2_atanh(double x) {
    int64_t e = (bits(x) - 0x3fe6a09e667f3bcdLL) >> 52;
    double f = from_bits(bits(x) - (int64_t)((uint64_t)e << 52)) - 1.0, s = f / (2.0 + f), z = s * s;
    double p = fma(0.28288502340748234, z, 0.31990680380701336);
    p = fma(p, z, 0.41220922406110433);
    p = fma(p, z, 0.5770779426603044);
    p = fma(p, z, 0.9617966941122649);
    return fma(s, fma(p, z, 2.885390081777851), (double)e);
}

/* The polynomials of quantities/scalar_math.py, for reference_lanes.c: 2^(-y*y), below 4 ulp. */
static inline double exp2_minus_square_exact(double y) {
    double t = fma(-y, y, ROUND), r = fma(-y, y, ROUND - t), r2 = r * r, r4 = r2 * r2;
    double p0 = fma(fma(0.05550410866444772, r, 0.24022650695910097), r2, fma(0.69314718055995, r, 1.0));
    double p1 = fma(fma(1.5252657260200837e-05, r, 0.0001540353044173605), r2,
                    fma(0.0013333558230164974, r, 0.009618129107606888));
    double p2 = fma(7.072585949269223e-09, r2, fma(1.0208690299958306e-07, r, 1.321544258792169e-06));
    return scaled(fma(fma(p2, r4, p1), r4, p0), t);
}

/* log2(x) for positive normal x, below 5 ulp, from the same place. */
static inline double log2_exact(double x) {
    int64_t e = (bits(x) - 0x3fe6a09e667f3bcdLL) >> 52;
    double f = from_bits(bits(x) - (int64_t)((uint64_t)e << 52)) - 1.0, s = f / (2.0 + f), z = s * s, z2 = z * z;
    double p0 = fma(0.9617966939243345, z, 2.885390081777927), p1 = fma(0.4121984020482752, z, 0.5770780172463286);
    double p2 = fma(fma(0.2429160853987535, z, 0.2614442493522915), z, 0.32061638813224547);
    return fma(s, fma(fma(p2, z2, p1), z2, p0), (double)e);
}

/* log2(x) from a 64-entry table: no division and a polynomial of degree 5. Shorter chain again; error 2e-15. */
typedef struct {
    double reciprocal[64], log2[64];
} Log2Table;
static void fill(Log2Table* table) {
    for (int i = 0; i < 64; i++) {
        table->reciprocal[i] = 1.0 / (1.0 + (i + 0.5) / 64);
        table->log2[i] = -log2(table->reciprocal[i]);
    }
}
static inline double log2_table(const Log2Table* table, double x) {
    int64_t b = bits(x);
    int i = (int)(b >> 46) & 63;
    double m = from_bits((b & 0xfffffffffffffLL) | 0x3ff0000000000000LL), r = fma(m, table->reciprocal[i], -1.0),
           r2 = r * r;
    double p = fma(-0.7213475204444817, r, 1.4426950408889634), q = fma(-0.36067376022224085, r, 0.4808983469629878);
    double s = fma(-0.2404491734814939, r, 0.2885390081777927), whole = (double)((b >> 52) - 1023) + table->log2[i];
    return fma(r, fma(fma(s, r2, q), r2, p), whole);
}

/* sin(2 pi t), error 1e-15: a cosine a quarter turn later, folded onto +-1/4 turn by its evenness, odd polynomial
 * there. */
static inline double sin_turns(double t) {
    double late = t - 0.25, x = 0.25 - fabs(late - ((late + ROUND) - ROUND)), y = x * x;
    double p = fma(-0.6925067010720717, y, 3.817365633469135);
    p = fma(p, y, -15.09450614073429);
    p = fma(p, y, 42.05868995395094);
    p = fma(p, y, -76.70585968962867);
    p = fma(p, y, 81.60524927557977);
    p = fma(p, y, -41.341702240398284);
    return x * fma(p, y, 6.283185307179585);
}
