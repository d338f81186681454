/* Random and damaged messages into an agent's tick, under sanitizers: `agent SECONDS SEED`.
 *
 * The messages of a tick lie in memory of exactly their length, so that a read beyond their end is seen. Prints how many ticks were
 * answered, and how many were left to Python. */
#include <stdio.h>
#include <time.h>

#include "agents/core/wire.h"
#include "tests/fuzz/messages.h"

enum { ROBOTS = 3, SENDERS = 9, PAIRS = 24, LINKS = 64 };

i64 fes_agent_tick(const Crew *crew, Messages *messages, Input *input, u8 *before_buffer, i64 before_capacity,
                   u8 *after_buffer, double *scratch, i64 *range, const u8 *observations, const u8 *beacons);

static i64 observation(u8 *place, i64 tick, i64 robot) {
    Writer writer = started(place, 10, tick, robot, POSE);
    i64 ids[30], count = random_ids(ids, below(100) ? 5 : 30);
    write_ids(&writer, ids, count);
    write_codes(&writer, count, DECODED);
    *writer.next++ = 0xc2;
    write_integer(&writer, 0);
    write_integer(&writer, tick - !below(100)); /* a fix of another tick is left to Python */
    return writer.next - place;
}

static Crew crew_of(i64 seeking, i64 rule, const i64 *ids, const i64 *first, const u64 *keys) {
    Crew crew;
    memset(&crew, 0, sizeof crew);
    crew.robots = ROBOTS;
    crew.ids = ids;
    crew.first = first;
    crew.estimate_keys = crew.stagger_keys = keys;
    crew.dt = 0.02;
    crew.timeout = 5;
    crew.rule = rule;
    crew.tolerance = 0.1;
    crew.seeking = seeking;
    crew.statistics = seeking == POOLED ? STATISTICS : 0;
    crew.low_estimate = 50.0;
    crew.high_estimate = 90.0;
    crew.dither_amplitude = 0.2;
    crew.dither_frequency = 100.0;
    crew.consensus_gain = 4.0;
    crew.extrapolates = crew.sub_steps = 1;
    crew.index_gain = 40000.0;
    crew.objective = (Objective){50.0, 150.0, 4.0, 1.0 / 81.0};
    crew.method = (Method){0.998, 0.9998, {0.025, 0.01}, {0.5, 8.0}, 0.3, 75.0};
    crew.linear_gain = crew.separation_gain = crew.give_way_gain = 1.0;
    crew.angular_gain = 10.0;
    crew.linear_limit = 5.0;
    crew.angular_limit = infinity();
    crew.safe_separation = 2.0;
    return crew;
}

int main(int count, char **words) {
    if (count != 3) return 2;
    time_t end = time(NULL) + atoi(words[1]);
    random_state = strtoull(words[2], NULL, 10) * 2654435761u + 88172645463325252u;
    i64 ids[ROBOTS] = {1, 2, 5}, first[ROBOTS] = {0}, since[ROBOTS] = {0}, lengths[ROBOTS], beacon_lengths[SENDERS];
    u64 keys[2 * ROBOTS] = {1, 2, 3, 4, 5, 6};
    u8 *observations[ROBOTS], *beacons[SENDERS];
    i64 begin[ROBOTS + 1], in_range[PAIRS], sender_ids[SENDERS], link_begin[SENDERS + 1], link_peers[LINKS];
    i64 ends[2 * ROBOTS];
    double poses[3 * ROBOTS], sender_poses[3 * SENDERS], estimates[LINKS], statistics[STATISTICS * SENDERS];
    u8 reception[PAIRS], selected[LINKS], message[LONGEST];
    long answered = 0, left = 0;
    while (time(NULL) < end) {
        Crew crew = crew_of(1 + below(3), below(3), ids, first, keys);
        i64 senders = below(4) ? SENDERS : 1; /* a message alone has nothing behind its end */
        crew.robots = below(4) ? ROBOTS : 1;
        State state;
        u8 none[8];
        i64 size = state_at(&crew, PAIRS, none, &state);
        u8 *before = calloc(1, (size_t)size), *after = calloc(1, (size_t)size);
        u8 *out = malloc(ROBOTS * (256 + 8 * STATISTICS) + 64 * PAIRS);
        double *scratch = malloc((2 * ROBOTS + PAIRS) * sizeof(double));
        i64 *range = calloc(ROBOTS + 1 + PAIRS, sizeof(i64));
        state_at(&crew, PAIRS, before, &state);
        for (i64 robot = 0; robot < crew.robots; robot++) state.since[robot] = state.linked_since[robot] = (i64)1 << 60;
        for (i64 tick = 0; tick < 200; tick++) {
            Messages messages = {VERSION, since, NULL, lengths, 0, NULL, beacon_lengths, PAIRS, LINKS, poses, begin, in_range,
                                 reception, sender_ids, link_begin, link_peers, sender_poses, estimates, statistics,
                                 selected, below(3) - 1, out, ends};
            Input input;
            memset(&input, 0, sizeof input);
            input.tick = tick;
            for (i64 robot = 0; robot < crew.robots; robot++) {
                lengths[robot] = observation(message, tick, ids[robot]);
                observations[robot] = sent(message, lengths + robot);
            }
            for (i64 id = 0; tick && messages.senders < senders; id += 1 + !below(60)) {
                beacon_lengths[messages.senders] = beacon(message, tick - 1, id, crew.statistics);
                beacons[messages.senders] = sent(message, beacon_lengths + messages.senders);
                messages.senders++;
            }
            u8 *sensed = joined(crew.robots, observations, lengths);
            u8 *heard = joined(messages.senders, beacons, beacon_lengths);
            i64 flags =
                fes_agent_tick(&crew, &messages, &input, before, PAIRS, after, scratch, range, sensed, heard);
            free(sensed);
            free(heard);
            answered += flags >= 0;
            left += flags < 0;
            if (flags < 0) continue;
            u8 *last = before;
            before = after;
            after = last;
        }
        free(before);
        free(after);
        free(out);
        free(scratch);
        free(range);
    }
    printf("%ld answered, %ld left to Python\n", answered, left);
    return answered && left ? 0 : 1;
}
