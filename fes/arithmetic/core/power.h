/* x^y. Twin: fes/arithmetic/power.py, where the method is described. */
#ifndef FES_POWER_H
#define FES_POWER_H

#include "logarithm.h"

static const double POWER_SERIES[] = {
    0.13251319912287723, 0.13250119072859887, 0.1538709071966058, 0.18181775666270608, 0.2222222264678884,
    0.2857142856908592, 0.4000000000000625, 0.6666666666666666};
#define POWER_LN2_HIGH 0.6931471805592082
#define POWER_LN2_LOW 7.371002565167799e-13
#define MOST_PRODUCTS 16.0
#define LARGEST 1.7976931348623157e308
#define MOST_REST 1e-9

/* exp(x + low), for a low below 1e-12. */
FES_INLINE double exp_with_rest(double x, double low) {
    double t = x * PER_LN2;
    t = t + ROUND;
    i64 n = (i64)(bits(t) - ROUND_BITS);
    t = t - ROUND;
    double w = x - t * LN2_HIGH, v = t * LN2_LOW;
    double r = w - v;
    double r_low = ((w - r) - v) + low;
    double tail = exp_tail(r);
    tail = tail + (r_low + r_low * (r + tail));
    double first = 1.0 + r;
    return scaled(first + ((r - (first - 1.0)) + tail), n);
}

/* x^y for a normal positive x and |y| up to 1e300. */
FES_INLINE double fes_real_power(double x, double y) {
    i64 k;
    double f = log_split(x, &k);
    double e = as_double(k) + 0.0 * x; /* NaN for NaN, which has an exponent too */
    double t = f + 2.0, s = f / t;
    double product = s * t;
    double s_low = (((f - product) - product_error(s, t, product)) - s * (f - (t - 2.0))) / t;
    double z = s * s, q;
    q = POLYNOMIAL(POWER_SERIES, z);
    q = (q * z * s + 2.0 * s_low) + e * POWER_LN2_LOW;
    double whole = e * POWER_LN2_HIGH, part = 2.0 * s;
    double total = whole + part;
    double low = ((whole - total) + part) + q;
    double high = total + low;
    low = (total - high) + low;
    product = y * high;
    low = product_error(y, high, product) + y * low;
    low = smaller(larger(low, -MOST_REST), MOST_REST);
    return exp_with_rest(smaller(larger(product, EXP_LEAST), EXP_MOST), low);
}

/* True if x^y is a product, and a root where y is not whole. */
FES_INLINE int is_product(double y) {
    return 0.0 <= y && y <= MOST_PRODUCTS && 2.0 * y == (double)(i64)(2.0 * y);
}

/* x^n of `count` numbers for n >= 0, by squaring from the highest bit of n; `result` is another array. */
FES_INLINE void products(i64 count, const double *x, i64 n, double *result) {
    i64 bit = 1;
    while (bit <= n >> 1) bit <<= 1;
    for (i64 i = 0; i < count; i++) result[i] = n == 0 ? 1.0 : x[i];
    for (bit >>= 1; bit; bit >>= 1) {
        for (i64 i = 0; i < count; i++) result[i] = result[i] * result[i];
        if (n & bit)
            for (i64 i = 0; i < count; i++) result[i] = result[i] * x[i];
    }
}

/* x^y of `count` numbers x >= 0; `result` is another array. */
FES_INLINE void powers(i64 count, const double *x, double y, double *result) {
    if (is_product(y)) {
        products(count, x, (i64)y, result);
        if (y != (double)(i64)y)
            for (i64 i = 0; i < count; i++) result[i] = result[i] * square_root(x[i]);
    } else {
        for (i64 i = 0; i < count; i++)
            result[i] = fes_real_power(smaller(larger(x[i], SMALLEST_NORMAL), LARGEST), y);
    }
}

FES_INLINE double fes_power(double x, double y) {
    double result;
    powers(1, &x, y, &result);
    return result;
}

#endif
