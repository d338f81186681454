/* One tick of the world: the order of world/simulation/truth.py. */
#include "world.h"

#define NEW_PAIRS 1
#define CANDIDATES_TOO_OLD (-1)

/* The inputs of a tick. */
typedef struct {
    i64 robots, tick;
    const double *poses, *twists;
    const u8 *present;
    const double *factor;               /* of each robot's transmitter; NULL where all are healthy */
    Candidates before, now;             /* the same, unless a new list was made */
    i64 sent, decoded;                  /* of the tick, over the pairs in range: filled in */
    double least;                       /* the smallest separation of the candidates [m]: filled in */
} Input;

/* Takes `count` numbers of `size` bytes from the buffer; each array begins at a multiple of eight bytes. */
static void *taken(u8 *buffer, i64 *used, i64 count, i64 size) {
    u8 *place = buffer + *used;
    *used += (count * size + 7) / 8 * 8;
    return place;
}

/* The places of a tick in a buffer; returns its length [bytes]. */
static i64 world_at(i64 robots, i64 candidates, u8 *buffer, World *world) {
    i64 used = 0, pairs = 2 * candidates;
    Ledger *ledger = &world->ledger;
#define NUMBERS(place, count) place = taken(buffer, &used, count, 8)
#define CODES(place, count) place = taken(buffer, &used, count, 1)
    NUMBERS(world->poses, POSE * robots);
    NUMBERS(world->totals, TOTALS);
    NUMBERS(world->separation, candidates);
    CODES(world->mask, candidates);
    NUMBERS(world->pairs.begin, robots + 1);
    NUMBERS(world->pairs.rows, pairs);
    NUMBERS(world->pairs.peers, pairs);
    NUMBERS(world->pairs.pair, pairs);
    NUMBERS(ledger->age, pairs);
    NUMBERS(ledger->sent, pairs);
    NUMBERS(ledger->decoded, pairs);
    NUMBERS(ledger->gap, pairs);
    NUMBERS(ledger->longest_gap, pairs);
    NUMBERS(ledger->probability, pairs);
    NUMBERS(ledger->outage_sum, pairs);
    CODES(ledger->reception, pairs);
    CODES(ledger->burst, pairs);
    NUMBERS(ledger->words, WORDS * pairs);
    NUMBERS(world->chance, candidates);
    return used;
}

/* The length of a tick [bytes], and the place of each of its arrays in the order above. */
FES_API i64 fes_world_layout(i64 robots, i64 candidates, i64 *places) {
    static u8 buffer[8];
    World world;
    i64 length = world_at(robots, candidates, buffer, &world);
    const Ledger *ledger = &world.ledger;
    const void *arrays[] = {
        world.poses, world.totals, world.separation, world.mask, world.pairs.begin, world.pairs.rows,
        world.pairs.peers, world.pairs.pair, ledger->age, ledger->sent, ledger->decoded, ledger->gap,
        ledger->longest_gap, ledger->probability, ledger->outage_sum, ledger->reception, ledger->burst,
    };
    for (i64 i = 0; i < (i64)(sizeof arrays / sizeof arrays[0]); i++) places[i] = (i64)((const u8 *)arrays[i] - buffer);
    return length;
}

/* The smallest of numbers; NaN does not count. */
static double smallest(i64 count, const double *values) {
    double least = infinity();
    for (i64 i = 0; i < count; i++)
        if (values[i] < least) least = values[i];
    return least;
}

/* The next tick in `after`, from the tick in `before`. Returns flags, or CANDIDATES_TOO_OLD: then the caller makes a
 * new list for the poses in `after`, and calls again. */
FES_API i64 fes_world_tick(const Settings *settings, Input *input, u8 *before_buffer, u8 *after_buffer) {
    World before, now;
    world_at(input->robots, input->before.count, before_buffer, &before);
    world_at(input->robots, input->now.count, after_buffer, &now);
    arc_move(settings, input->robots, input->poses, input->twists, now.poses);
    if (!candidates_are_valid(&input->now, input->robots, now.poses)) return CANDIDATES_TOO_OLD;
    proximity_measure(settings, &input->now, input->robots, &now);
    radio_transmit(settings, input->robots, input->before.count, input->tick, input->present, input->factor,
                   &before, &now);
    input->sent = now.totals[SENT];
    input->decoded = now.totals[HEARD];
    input->least = smallest(input->now.count, now.separation);
    const Pairs *old = &before.pairs, *pairs = &now.pairs;
    size_t size = sizeof(i64);
    int is_same = !memcmp(pairs->begin, old->begin, (size_t)(input->robots + 1) * size) &&
                  !memcmp(pairs->peers, old->peers, (size_t)pairs->begin[input->robots] * size);
    return is_same ? 0 : NEW_PAIRS;
}
