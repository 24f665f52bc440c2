/* Gaussian numbers for reference.c. */
#include "reference_math.h"

#ifndef LANES
#define LANES 64 /* lanes of a tile: all their state stays in the first-level cache */
#endif

/* LANES independent xoshiro256++ generators (Blackman and Vigna 2019), seeded by splitmix64. */
typedef struct {
    uint64_t s[4][LANES];
} Random;
static void seed(Random* random, int lane, uint64_t x) {
    for (int i = 0; i < 4; i++) {
        uint64_t z = x += 0x9e3779b97f4a7c15ULL;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
        random->s[i][lane] = z ^ (z >> 31);
    }
}

/* Two normal numbers per lane from 64 random bits (Box and Muller): 32 for the radius, 30 for the angle in a quarter
 * turn, 2 signs. The angle is centred (+- 1/8 turn), where five terms give sin and cos to 5e-11, and turned back by 45
 * degrees with the scale. */
static inline void gaussians(Random* random, double scale, double* restrict first, double* restrict second) {
    uint64_t (*s)[LANES] = random->s;
    for (int i = 0; i < LANES; i++) {
        uint64_t sum = s[0][i] + s[3][i], x = ((sum << 23) | (sum >> 41)) + s[0][i], shifted = s[1][i] << 17, s3;
        s[2][i] ^= s[0][i];
        s3 = s[3][i] ^ s[1][i];
        s[1][i] ^= s[2][i];
        s[0][i] ^= s3;
        s[2][i] ^= shifted;
        s[3][i] = (s3 << 45) | (s3 >> 19);
        double uniform = ((double)(int64_t)(x >> 32) + 0.5) * 0x1p-32,
               angle = (double)(int64_t)(x & 0x3fffffff) * 0x1p-32 - 0.125;
        double radius = scale * sqrt(-0.6931471805599453 * log2_atanh(uniform)); /* = sqrt(-2 ln uniform) / sqrt 2 */
        double y = angle * angle, p = fma(41.47283323950919, y, -76.6978663502028),
               q = fma(59.2201689582961, y, -85.44284467308167);
        p = fma(fma(fma(p, y, 81.60520471104576), y, -41.341702153394905), y, 6.2831853071524) * angle;
        q = fma(fma(fma(q, y, 64.93931613570905), y, -19.739208650130596), y, 0.9999999999524894);
        first[i] = from_bits(bits(radius * (q - p)) ^ (int64_t)((x & 0x80000000ULL) << 32));
        second[i] = from_bits(bits(radius * (q + p)) ^ (int64_t)((x & 0x40000000ULL) << 33));
    }
}

/* Add `n` numbers with standard deviation `rms` to `out`, all from one seed; `scratch` holds 2 * LANES. */
static void gaussian_series(uint64_t number, double rms, long n, double* out, double* scratch) {
    Random random;
    for (int i = 0; i < LANES; i++) seed(&random, i, number * LANES + i);
    for (long k = 0; k < n; k += 2 * LANES) {
        gaussians(&random, rms, scratch, scratch + LANES);
        for (long i = 0; i < 2 * LANES && k + i < n; i++) out[k + i] += scratch[i];
    }
}
