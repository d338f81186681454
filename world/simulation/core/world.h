/* The simulated world of a run at one tick, in one buffer.
 *
 * Twins: world/simulation/truth.py, neighbor_list.py and channel.py. Pairs (receiver, sender) lie one after the other,
 * those of receiver i from begin[i] to begin[i + 1], by ascending sender. */
#ifndef FES_WORLD_H
#define FES_WORLD_H

#include "fes/arithmetic/core/exact.h"

enum { X, Y, HEADING, POSE };           /* columns of poses */
enum { LINEAR, ANGULAR, TWIST };        /* columns of twists */
enum { CLOSED, LOST, DECODED };         /* fate of a beacon */
/* Totals: beacons sent, and decoded, over the pairs in range; the counter of the random words in the ledger. */
enum { SENT, HEARD, DRAWN, TOTALS };
enum { RAYLEIGH, LOGISTIC, PERFECT };   /* channels with a formula */

#define OPENING_TICKS 2
#define WORDS 4
#define UNKNOWN 2 /* state of the bursts of a contact before its first tick */

/* A channel and the bodies: world/config/radio.py. */
typedef struct {
    double dt;
    double communication_range;
    i64 model, is_certain;
    double scale, exponent;             /* of exp(-scale r^exponent) */
    double midpoint, width;             /* of a logistic channel */
    u64 key0, key1;                     /* of the fading */
} Settings;

/* Pairs of robots (a < b) that may be in range, sorted. */
typedef struct {
    i64 count;
    const i64 *a, *b;
    const double *positions;            /* of the robots when the list was made [n, 2]; NULL for a permanent list */
    double most_moved;                  /* up to which the list is valid [m] */
} Candidates;

/* The pairs in range. */
typedef struct {
    i64 *begin, *rows, *peers, *pair;   /* pair: position among the candidates */
} Pairs;

/* The ledger of each contact: Radio of channel.py. */
typedef struct {
    i64 *age, *sent, *decoded, *gap, *longest_gap;
    double *probability, *outage_sum;
    u8 *reception, *burst;
    u64 *words;                         /* random words of the four ticks about this one [WORDS] */
} Ledger;

/* One tick. */
typedef struct {
    double *poses;                      /* [n, 3] */
    double *separation;                 /* of the candidates */
    double *chance;                     /* probability that a beacon decodes, by candidate; only within a tick */
    u8 *mask;                           /* 1 for a candidate in range */
    Pairs pairs;
    Ledger ledger;
    i64 *totals;                        /* see below */
} World;

void arc_move(const Settings *settings, i64 robots, const double *poses, const double *twists, double *moved);
int candidates_are_valid(const Candidates *candidates, i64 robots, const double *poses);
void proximity_measure(const Settings *settings, const Candidates *candidates, i64 robots, World *now);
void radio_transmit(const Settings *settings, i64 robots, i64 candidates, i64 tick, const u8 *present,
                    const double *factor, World *before, World *now);

#endif
