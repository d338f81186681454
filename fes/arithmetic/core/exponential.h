/* exp(x) and 1 - exp(-a). Twin: fes/arithmetic/exponential.py, where the method is described. */
#ifndef FES_EXPONENTIAL_H
#define FES_EXPONENTIAL_H

#include "exact.h"

#define PER_LN2 1.4426950408889634
#define LN2_HIGH 0.693147180369123816490
#define LN2_LOW 1.90821492927058770002e-10
#define EXP_LEAST (-746.0)
#define EXP_MOST 710.0
static const double EXP_SERIES[] = {
    1.6059043836821613e-10, 2.08767569878681e-09, 2.505210838544172e-08, 2.7557319223985893e-07,
    2.755731922398589e-06, 2.48015873015873e-05, 0.0001984126984126984, 0.001388888888888889, 0.008333333333333333,
    0.041666666666666664, 0.16666666666666666, 0.5};

/* exp(r) - 1 - r for |r| <= 0.35. */
FES_INLINE double exp_tail(double r) {
    double q = POLYNOMIAL(EXP_SERIES, r);
    return q * (r * r);
}

/* n and p of exp(x) = 2^n (1 + p). */
FES_INLINE double exp_reduced(double x, i64 *n) {
    double t = x * PER_LN2 + ROUND;
    *n = (i64)(bits(t) - ROUND_BITS);
    t = t - ROUND;
    double r = (x - t * LN2_HIGH) - t * LN2_LOW;
    return exp_tail(r) + r;
}

FES_INLINE double fes_exp(double x) {
    i64 n;
    double p = exp_reduced(smaller(larger(x, EXP_LEAST), EXP_MOST), &n);
    return scaled(p + 1.0, n);
}

/* 1 - exp(-a) for a >= 0. */
FES_INLINE double fes_one_minus_exp(double a) {
    i64 n;
    double p = exp_reduced(larger(-a, -40.0), &n);
    double f = power_of_two((u64)n);
    return (1.0 - f) - p * f;
}

#endif
