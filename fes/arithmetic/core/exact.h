/* Operations without a rounding error. Twin: fes/arithmetic/exact.py.
 *
 * All C of this project computes with + - * / sqrt, comparisons, selections, and operations on integers and bits.
 * Without contraction (-ffp-contract=off) every compiler and processor then rounds as numpy does. */
#ifndef FES_EXACT_H
#define FES_EXACT_H

#include <stdint.h>
#include <string.h>

/* Functions whose loops gain from wider registers are compiled for each of them, and chosen when the library loads. */
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && !defined(FES_ONE_VERSION)
#define FES_WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define FES_WIDE
#endif

#define FES_API __attribute__((visibility("default")))
#define FES_INLINE static inline __attribute__((always_inline))

typedef int64_t i64;
typedef uint64_t u64;
typedef uint8_t u8;

#define ROUND 6755399441055744.0 /* 1.5 * 2^52: added, it leaves the nearest integer in the last bits */
#define ROUND_BITS 0x4338000000000000u

FES_INLINE u64 bits(double x) {
    u64 b;
    memcpy(&b, &x, sizeof b);
    return b;
}

FES_INLINE double from_bits(u64 b) {
    double x;
    memcpy(&x, &b, sizeof x);
    return x;
}

FES_INLINE double infinity(void) { return from_bits(0x7ff0000000000000u); }

FES_INLINE double not_a_number(void) { return from_bits(0x7ff8000000000000u); }

FES_INLINE double magnitude(double x) { return from_bits(bits(x) & 0x7fffffffffffffffu); }

FES_INLINE double with_sign_of(double x, double sign) {
    return from_bits((bits(x) & 0x7fffffffffffffffu) | (bits(sign) & 0x8000000000000000u));
}

FES_INLINE int is_finite(double x) { return (bits(x) & 0x7ff0000000000000u) != 0x7ff0000000000000u; }

/* As numpy's maximum and minimum: NaN if either is NaN. */
FES_INLINE double larger(double a, double b) { return (a >= b || a != a) ? a : b; }

FES_INLINE double smaller(double a, double b) { return (a <= b || a != a) ? a : b; }

FES_INLINE double clipped(double x, double low, double high) { return smaller(larger(x, low), high); }

/* A small integer as a double, by bits: few processors convert several at once. */
FES_INLINE double as_double(i64 n) { return from_bits((u64)n + ROUND_BITS) - ROUND; }

/* 2^n for n modulo 2^64, from -1022 to 1023. */
FES_INLINE double power_of_two(u64 n) { return from_bits((n + 1023) << 52); }

/* x 2^n for a normal x near 1 and n from -1100 to 1100: rounded once, where the result is subnormal. */
FES_INLINE double scaled(double x, i64 n) {
    /* a logical shift: registers of 32 bytes have no other; any n, that of NaN too, must not overflow */
    u64 half = (((u64)n + 2048) >> 1) - 1024;
    return x * power_of_two(half) * power_of_two((u64)n - half);
}

/* x 2^n for any finite x and n from -1074 to 1100: rounded once. */
FES_INLINE double scaled_any(double x, i64 n) {
    if (n < -1022) return x * from_bits((u64)1 << (n + 1074));
    return n > 1023 ? x * power_of_two(1023) * power_of_two((u64)n - 1023) : x * power_of_two((u64)n);
}

/* a b - product, where product is a b rounded (Dekker 1971). */
FES_INLINE double product_error(double a, double b, double product) {
    const double split = 134217729.0; /* 2^27 + 1 */
    double t = a * split;
    double a_high = t - (t - a), a_low = a - a_high;
    t = b * split;
    double b_high = t - (t - b), b_low = b - b_high;
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
}

FES_INLINE double square_root(double x) { return __builtin_sqrt(x); }

/* The polynomial of z with these coefficients, the highest first; each step is of two roundings. */
FES_INLINE double horner(const double *coefficients, int count, double z) {
    double q = z * coefficients[0] + coefficients[1];
#pragma GCC unroll 16
    for (int i = 2; i < count; i++) q = q * z + coefficients[i];
    return q;
}

#define POLYNOMIAL(coefficients, z) horner(coefficients, (int)(sizeof coefficients / sizeof coefficients[0]), z)

#endif
