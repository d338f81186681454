/* Uniform random numbers by a counter: Philox 4x64 with ten rounds (Salmon and others 2011), as numpy's Philox.
 * Twin: fes/arithmetic/draws.py. */
#ifndef FES_PHILOX_H
#define FES_PHILOX_H

#include "exact.h"

FES_INLINE u64 high_word(u64 a, u64 b) {
    return (u64)(((unsigned __int128)a * b) >> 64);
}

/* The four words of a counter, for a sender and a receiver. */
FES_INLINE void fes_philox(u64 key0, u64 key1, i64 counter, i64 sender, i64 receiver, u64 words[4]) {
    /* numpy increments the counter before it generates words */
    u64 c0 = (u64)counter + 1, c1 = (u64)sender, c2 = (u64)receiver, c3 = 0;
    for (int round = 0; round < 10; round++) {
        u64 high0 = high_word(0xd2e7470ee14c6c93u, c0), low0 = 0xd2e7470ee14c6c93u * c0;
        u64 high1 = high_word(0xca5a826395121157u, c2), low1 = 0xca5a826395121157u * c2;
        c0 = high1 ^ c1 ^ key0;
        c2 = high0 ^ c3 ^ key1;
        c1 = low1;
        c3 = low0;
        key0 += 0x9e3779b97f4a7c15u;
        key1 += 0xbb67ae8584caa73bu;
    }
    words[0] = c0;
    words[1] = c1;
    words[2] = c2;
    words[3] = c3;
}

/* The number in [0, 1) of a word. */
FES_INLINE double fes_unit(u64 word) { return (double)(word >> 11) * 1.1102230246251565e-16; /* 2^-53 */ }

/* The number in [0, 1) of a tick, for a sender and a receiver. */
FES_INLINE double fes_uniform(u64 key0, u64 key1, i64 tick, i64 sender, i64 receiver) {
    u64 words[4];
    fes_philox(key0, key1, tick >> 2, sender, receiver, words);
    return fes_unit(words[tick & 3]);
}

#endif
