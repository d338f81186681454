/* Random messages for the programs of this folder: numbers, ids, lists, and damage. */
#ifndef FES_FUZZ_MESSAGES_H
#define FES_FUZZ_MESSAGES_H

#include <stdlib.h>

#include "fes/arithmetic/core/msgpack.h"

enum { VERSION = 3, LONGEST = 2048 };

static u64 random_state;

static u64 random_word(void) { /* xorshift64 */
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return random_state;
}

static i64 below(i64 bound) { return (i64)(random_word() % (u64)bound); }

static double random_number(void) {
    static const double special[] = {0.0, -0.0, 1e12, -1e12, 5e-324, 1e-300, 70.0};
    u64 kind = random_word() % 4096;
    if (kind < 2) return kind ? from_bits(random_word()) : 1e13; /* most of these are rejected */
    return kind < 256 ? special[kind % 7] : (double)below(4000000) / 1e4 - 200.0;
}

/* Ascending ids, some of them of robots that do not exist. */
static i64 random_ids(i64 *ids, i64 most) {
    i64 count = below(most + 1), id = below(2);
    for (i64 i = 0; i < count; i++) {
        ids[i] = id;
        id += 1 + !below(8);
    }
    return count;
}

static void write_codes(Writer *writer, i64 count, int highest) {
    write_length(writer, count);
    for (i64 i = 0; i < count; i++) *writer->next++ = (u8)below(highest + 1);
}

static void write_numbers(Writer *writer, i64 count) {
    write_length(writer, 8 * count);
    for (i64 i = 0; i < count; i++) {
        double value = random_number();
        memcpy(writer->next, &value, 8);
        writer->next += 8;
    }
}

/* A message of `count` fields behind the version: tick and robot, and `numbers` numbers. */
static Writer started(u8 *place, int count, i64 tick, i64 robot, int numbers) {
    Writer writer = {place};
    *writer.next++ = (u8)(0x91 + count);
    write_integer(&writer, VERSION);
    write_integer(&writer, tick);
    write_integer(&writer, robot);
    for (int i = 0; i < numbers; i++) write_number(&writer, random_number());
    return writer;
}

static i64 beacon(u8 *place, i64 tick, i64 robot, i64 statistics) {
    Writer writer = started(place, 10, tick, robot, 3);
    i64 ids[30], count = random_ids(ids, below(400) ? 6 : 30);
    write_ids(&writer, ids, count);
    write_numbers(&writer, count);
    write_codes(&writer, count, 1);
    write_numbers(&writer, statistics);
    write_blob(&writer, NULL, 0);
    return writer.next - place;
}

/* A copy of a message of exactly its length, damaged one time in 64. */
static u8 *sent(u8 *message, i64 *length) {
    if (!below(64)) {
        i64 place = below(*length);
        u64 kind = random_word() % 4;
        if (kind == 0) message[place] ^= (u8)(1u << below(8));
        if (kind == 1) *length = place;
        if (kind == 2) message[place] = (u8)random_word();
        if (kind == 3) (*length)++;
    }
    u8 *copy = malloc((size_t)*length + (*length == 0));
    memcpy(copy, message, (size_t)*length);
    return copy;
}

/* Joins payloads in memory of exactly their length, and frees them. */
static u8 *joined(i64 count, u8 *const *payloads, const i64 *lengths) {
    i64 total = 0;
    for (i64 i = 0; i < count; i++) total += lengths[i];
    u8 *data = malloc((size_t)total + !total), *next = data;
    for (i64 i = 0; i < count; next += lengths[i++]) {
        memcpy(next, payloads[i], (size_t)lengths[i]);
        free(payloads[i]);
    }
    return data;
}

#endif
