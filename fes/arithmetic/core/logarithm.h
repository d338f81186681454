/* log(x), log(1 + x) and log(1 + exp(z)). Twin: fes/arithmetic/logarithm.py, where the method is described. */
#ifndef FES_LOGARITHM_H
#define FES_LOGARITHM_H

#include "exponential.h"

#define SMALLEST_NORMAL 2.2250738585072014e-308
static const double LOG_SERIES[] = {
    0.1479610463708204, 0.15314035926270983, 0.18183564862737678, 0.22222198563570503, 0.2857142874247384,
    0.39999999999414326, 0.6666666666666734};

/* k and f of x = 2^k (1 + f), for a normal positive x. */
FES_INLINE double log_split(double x, i64 *k) {
    u64 b = bits(x);
    *k = (i64)((b - 0x3fe6a09e667f3bcdu + 0x4000000000000000u) >> 52) - 1024; /* minus the bits of sqrt(1/2) */
    return from_bits(b - ((u64)*k << 52)) - 1.0;
}

/* k log 2 + log(1 + f) + a small rest. */
FES_INLINE double log_combined(double k, double f, double rest) {
    double s = f / (f + 2.0), z = s * s, q;
    q = POLYNOMIAL(LOG_SERIES, z);
    q = (f - q * z) * s;
    return (f - (q - (k * LN2_LOW + rest))) + k * LN2_HIGH;
}

FES_INLINE double fes_log(double x) {
    int is_subnormal = x > 0.0 && x < SMALLEST_NORMAL;
    int is_positive = x > 0.0 && x < infinity();
    i64 k;
    double f = log_split((is_positive ? x : 1.0) * (is_subnormal ? 18014398509481984.0 : 1.0), &k); /* 2^54 */
    double result = log_combined(as_double(k - (is_subnormal ? 54 : 0)), f, 0.0);
    result = is_positive ? result : not_a_number();
    result = x == 0.0 ? -infinity() : result;
    return x == infinity() ? x : result;
}

/* log(1 + x), where shifted is 1 + x rounded, positive and finite. */
FES_INLINE double log1p_of(double x, double shifted) {
    i64 k;
    double f = log_split(shifted, &k);
    double rest = k == 0 ? 0.0 : (x - (shifted - 1.0)) / shifted;
    return log_combined(as_double(k), k == 0 ? x : f, rest);
}

FES_INLINE double fes_log1p(double x) {
    double shifted = x + 1.0;
    return shifted > 0.0 && shifted < infinity() ? log1p_of(x, shifted) : fes_log(shifted);
}

/* log(1 + exp(z)), without overflow. */
FES_INLINE double fes_log_sum_exp(double z) {
    double decay = fes_exp(-magnitude(z));
    return larger(z, 0.0) + log1p_of(decay, decay + 1.0);
}

#endif
