/* Random and damaged beacons and commands into the world's reader, under sanitizers: `world SECONDS SEED`.
 *
 * The payloads of a tick lie in memory of exactly their length, so that a read beyond their end is seen. Prints how many
 * ticks were read, and how many were left to Python. */
#include <stdio.h>
#include <time.h>

#include "tests/fuzz/messages.h"
#include "world/simulation/core/messages.h"

enum { ROBOTS = 6, TEAM = 12 };

i64 fes_world_beacons(const Batch *batch, const u8 *data, const i64 *lengths, const i64 *senders);
i64 fes_world_commands(const Batch *batch, const u8 *data, const i64 *lengths, const i64 *senders, double *twists,
                       Parts *parts, double *numbers);

static i64 command(u8 *place, i64 tick, i64 robot) {
    Writer writer = started(place, 9, tick, robot, 2);
    i64 ids[30], count = random_ids(ids, below(400) ? 6 : 20);
    write_ids(&writer, ids, count);
    write_numbers(&writer, count);
    write_numbers(&writer, below(3) * count + !below(400));
    write_numbers(&writer, below(4));
    *writer.next++ = (u8)(0xc2 + below(2) - 2 * !below(3));
    return writer.next - place;
}

/* Reads one tick of messages; true if all were usual. */
static i64 tick_is_read(i64 tick) {
    i64 lengths[ROBOTS], senders[ROBOTS], total = 0, are_beacons = below(2), is_read;
    Batch batch = {VERSION, tick, TEAM, 1 + below(ROBOTS)};
    u8 message[LONGEST], *payloads[ROBOTS];
    for (i64 index = 0; index < batch.count; index++) {
        senders[index] = below(200) ? 2 * index : TEAM;
        lengths[index] =
            are_beacons ? beacon(message, tick, senders[index], below(6)) : command(message, tick, senders[index]);
        payloads[index] = sent(message, lengths + index);
        total += lengths[index];
    }
    u8 *data = joined(batch.count, payloads, lengths);
    double *twists = malloc(2 * ROBOTS * sizeof(double)), *numbers = malloc((size_t)(total / 8 + 1) * sizeof(double));
    Parts *parts = malloc(ROBOTS * sizeof(Parts));
    is_read = are_beacons ? fes_world_beacons(&batch, data, lengths, senders)
                          : fes_world_commands(&batch, data, lengths, senders, twists, parts, numbers);
    free(data);
    free(twists);
    free(numbers);
    free(parts);
    return is_read;
}

int main(int count, char **words) {
    if (count != 3) return 2;
    time_t end = time(NULL) + atoi(words[1]);
    random_state = strtoull(words[2], NULL, 10) * 2654435761u + 88172645463325252u;
    long answered = 0, left = 0;
    while (time(NULL) < end) {
        for (i64 tick = 0; tick < 2000; tick++) {
            i64 is_read = tick_is_read(tick);
            answered += is_read;
            left += !is_read;
        }
    }
    printf("%ld answered, %ld left to Python\n", answered, left);
    return answered && left ? 0 : 1;
}
