/* sin and cos together, atan2, and angles modulo a turn. Twins: fes/arithmetic/trigonometry.py and angle.py, and
 * wrap of fes/arrays/geometry.py. */
#ifndef FES_TRIGONOMETRY_H
#define FES_TRIGONOMETRY_H

#include "exact.h"

#define PI 3.141592653589793
#define TURN 6.283185307179586
static const double SINE_SERIES[] = {
    1.5896066701344328e-10, -2.5050745023009887e-08, 2.755731360442391e-06, -0.00019841269829542273,
    0.008333333333322061, -0.1666666666666663};
static const double COSINE_SERIES[] = {
    -1.1358423270163104e-11, 2.0875698703482154e-09, -2.75573141639367e-07, 2.4801587288799876e-05,
    -0.0013888888888872975, 0.041666666666666595};
static const double ANGLE_SERIES[] = {
    0.015180712401285002, -0.0334596562200217, 0.04502886246280583, -0.05218233859488475, 0.05876994030225937,
    -0.06666223777122599, 0.07692282545950359, -0.09090908134583649, 0.11111111087885486, -0.1428571428538302,
    0.19999999999997628, -0.33333333333333326};

/* The remainder of |x| / y for y > 0, exact, by one subtraction for each bit of the quotient. */
FES_INLINE double remainder_of_magnitudes(double x, double y) {
    double left = magnitude(x);
    if (!(left < infinity())) return not_a_number();
    while (left >= y) {
        i64 shift = (i64)(bits(left) >> 52) - (i64)(bits(y) >> 52);
        double step = scaled_any(y, shift);
        if (step > left) step = scaled_any(y, shift - 1);
        left = left - step;
    }
    return left;
}

/* numpy's remainder for a normal y > 0: in [0, y), up to rounding where x is negative. */
FES_INLINE double fes_remainder(double x, double y) {
    double rest = remainder_of_magnitudes(x, y);
    return rest != 0.0 && x < 0.0 ? y - rest : rest;
}

/* The same angle [rad] in [-pi, pi), up to rounding at the ends. */
FES_INLINE double fes_wrap(double angle) { return fes_remainder(angle + PI, TURN) - PI; }

FES_INLINE void fes_sin_cos(double x, double *sine, double *cosine) {
    if (magnitude(x) > 1e6) x = fes_remainder(x, TURN);
    double t = x * 0.6366197723675814;
    t = t + ROUND;
    u64 n = bits(t);
    t = t - ROUND;
    double y = x - t * 1.5707963267341256, w = t * 6.077100506303966e-11;
    double high = y - w;
    double v = high - y;
    double low = ((y - (high - v)) - (w + v)) - t * 2.0222662487111665e-21;
    double r = high + low;
    double e = ((high - r) + low) - t * 8.4784276603689e-32;
    double z = r * r, half = 0.5 * z, s, c;
    s = POLYNOMIAL(SINE_SERIES, z);
    c = POLYNOMIAL(COSINE_SERIES, z);
    s = (s * z * r + (e - half * e)) + r;
    w = 1.0 - half;
    c = ((c * (z * z) - r * e) + ((1.0 - w) - half)) + w;
    *sine = (n & 1 ? c : s) * (n & 2 ? -1.0 : 1.0);
    *cosine = (n & 1 ? s : c) * ((n + 1) & 2 ? -1.0 : 1.0);
}

/* num and den of the same quotient with a den in [1, 2); 0/0 becomes 0/1. */
FES_INLINE void angle_scaled(double *num, double *den) {
    u64 b = bits(*den);
    i64 exponent = (i64)(b >> 52);
    if (exponent == 0x7ff) return; /* NaN */
    if (*den == 0.0) {
        *num = *num + *num;
        *den = 1.0;
        return;
    }
    i64 shift = 0;
    if (exponent == 0) { /* subnormal */
        b = bits(*den * 18014398509481984.0); /* 2^54 */
        exponent = (i64)(b >> 52);
        shift = 54;
    }
    *num = scaled_any(*num, 1023 - exponent + shift);
    *den = from_bits((b & 0x000fffffffffffffu) | 0x3ff0000000000000u);
}

/* The angle of finite (x, y) [rad]; NaN for NaN. */
FES_INLINE double fes_atan2(double y, double x) {
    double across = magnitude(y), along = magnitude(x);
    double num = smaller(across, along), den = larger(across, along);
    angle_scaled(&num, &den);
    int is_steep = across > along, is_bent = num > 0.41421356237309503 * den, is_back = x < 0.0;
    double less = den * (double)is_bent, more = num * (double)is_bent;
    double n = num - less, d = den + more;
    double n_low = num - (n + less), d_low = more - (d - den);
    double q = n / d, product = q * d;
    double error = ((((n - product) - product_error(q, d, product)) + n_low) - q * d_low) / d;
    error = magnitude(q) > 3.8725919148493183e-121 ? error : 0.0; /* 2^-400 */
    double z = q * q, tail;
    tail = POLYNOMIAL(ANGLE_SERIES, z);
    tail = tail * z * q + (error - z * error);
    double eighths = is_bent ? 1.0 : is_steep ? 2.0 : 0.0;
    eighths = is_back ? 4.0 - eighths : eighths;
    double sign = is_steep != is_back ? -1.0 : 1.0;
    q = sign * q;
    tail = sign * tail;
    double base = eighths * 0.7853981633974483, high = base + q;
    double result = high + (((base - high) + q) + (tail + eighths * 3.061616997868383e-17));
    return with_sign_of(result, y);
}

#endif
