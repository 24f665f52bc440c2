/* What translated steps use of the C library's arithmetic, as instructions of the processor; nothing is called. */
#ifndef FL_MATH_H
#define FL_MATH_H

#define fma(a, b, c) __builtin_fma((a), (b), (c))
#define sqrt(x) __builtin_sqrt(x)
#define fabs(x) __builtin_fabs(x)
#define floor(x) __builtin_floor(x)
#define ceil(x) __builtin_ceil(x)
#define isnan(x) __builtin_isnan(x)
#define isinf(x) __builtin_isinf(x)
#define isfinite(x) __builtin_isfinite(x)
#define NAN __builtin_nan("")
#define INFINITY __builtin_inf()

#endif
