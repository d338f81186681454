/* Beacons and commands of one tick, read by the world.
 * Twins: fes/protocol/messages.py, world/execution/marshalling.py. */
#ifndef FES_WORLD_MESSAGES_H
#define FES_WORLD_MESSAGES_H

#include "fes/arithmetic/core/msgpack.h"

#define MAX_TICK (((i64)1 << 53) - 1)
#define MAX_ID (((i64)1 << 31) - 1)
#define MAX_NUMBER 1e12
#define MAX_TWIST 1e9

enum { MAX_STATISTICS = 64, MAX_DECLARED = 256, MAX_LEARNT = 16, MAX_DETAILS = 64 };

/* Payloads of one tick, each from another robot. They follow each other, so that one address names them all. */
typedef struct {
    i64 version;              /* of the protocol */
    i64 tick;
    i64 robots;               /* in the team */
    i64 count;                /* of payloads */
} Batch;

/* The parts of a command beside its twist: the place of its links, and the lengths of its lists of numbers. */
typedef struct {
    i64 links_at, links_length;         /* from the first byte of the batch [bytes] */
    i64 estimates, learnt, details;     /* [numbers] */
    i64 is_model_free;                  /* 1, 0, or -1 if not known */
} Parts;

#endif
