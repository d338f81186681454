/* The elementary functions and the random numbers over arrays, for fes/arithmetic/compiled.py. */
#include "philox.h"
#include "power.h"
#include "trigonometry.h"

#define OVER(name, function)                                                                                         \
    FES_API FES_WIDE void name(i64 count, const double *x, double *result) {                                          \
        for (i64 i = 0; i < count; i++) result[i] = function(x[i]);                                                   \
    }

OVER(fes_each_exp, fes_exp)
OVER(fes_each_one_minus_exp, fes_one_minus_exp)
OVER(fes_each_log, fes_log)
OVER(fes_each_log1p, fes_log1p)
OVER(fes_each_log_sum_exp, fes_log_sum_exp)
OVER(fes_each_wrap, fes_wrap)

FES_API void fes_each_sin_cos(i64 count, const double *x, double *sine, double *cosine) {
    for (i64 i = 0; i < count; i++) fes_sin_cos(x[i], sine + i, cosine + i);
}

FES_API void fes_each_atan2(i64 count, const double *y, const double *x, double *result) {
    for (i64 i = 0; i < count; i++) result[i] = fes_atan2(y[i], x[i]);
}

/* x^y, by products where y is a multiple of 1/2 from 0 to 16. */
FES_API FES_WIDE void fes_each_power(i64 count, const double *x, double y, double *result) {
    powers(count, x, y, result);
}

FES_API FES_WIDE void fes_each_product(i64 count, const double *x, i64 n, double *result) {
    products(count, x, n, result);
}

/* x^y[i] for normal positive x. */
FES_API void fes_each_real_power(i64 count, const double *x, const double *y, double *result) {
    for (i64 i = 0; i < count; i++) result[i] = fes_real_power(x[i], y[i]);
}

FES_API void fes_each_remainder(i64 count, const double *x, double y, double *result) {
    for (i64 i = 0; i < count; i++) result[i] = fes_remainder(x[i], y);
}

/* One number for each (sender, receiver) at a tick. */
FES_API void fes_each_uniform(i64 count, u64 key0, u64 key1, i64 tick, const i64 *sender, const i64 *receiver,
                              double *result) {
    for (i64 i = 0; i < count; i++) result[i] = fes_uniform(key0, key1, tick, sender[i], receiver[i]);
}
