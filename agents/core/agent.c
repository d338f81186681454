/* One tick of an agent's process, from the bytes of its messages to the bytes of its answers; and the messages of a
 * crew that is moved by arrays. */
#include "laws.h"
#include "wire.h"

#define FES_NEW_RANGE 4
#define FES_TOO_LITTLE_ROOM (-2)
#define FES_UNUSUAL (-3)

i64 fes_crew_tick(const Crew *crew, const Input *input, u8 *before_buffer, i64 before_capacity, u8 *after_buffer,
                  i64 capacity, double *scratch);

/* Reads the messages of a tick, moves the crew from the state in `before` to that in `after`, of as many contacts as
 * the messages have room for, and writes the answers. `range` holds the peers in range of the tick before: n + 1
 * begins, then their ids; it is replaced. Returns flags as fes_crew_tick does, with FES_NEW_RANGE where the peers in
 * range differ. A negative result has changed nothing but `after`: Python then reads the messages. `observations` and
 * `beacons` are the bytes that the messages name. */
FES_API i64 fes_agent_tick(const Crew *crew, Messages *messages, Input *input, u8 *before_buffer, i64 before_capacity,
                           u8 *after_buffer, double *scratch, i64 *range, const u8 *observations, const u8 *beacons) {
    messages->observations = observations;
    messages->beacons = beacons;
    int result = wire_read(crew, messages, input);
    if (result != READ) return result == UNUSUAL ? FES_UNUSUAL : FES_TOO_LITTLE_ROOM;
    i64 flags = fes_crew_tick(crew, input, before_buffer, before_capacity, after_buffer, messages->pairs, scratch);
    if (flags < 0) return flags;
    State now;
    state_at(crew, messages->pairs, after_buffer, &now);
    Sending sending = {messages->out, messages->ends, NULL, NULL};
    wire_write(crew, messages, input->tick, &now, &sending);
    size_t begins = (size_t)(crew->robots + 1) * sizeof(i64), ids = (size_t)messages->begin[crew->robots] * sizeof(i64);
    i64 *in_range = range + crew->robots + 1;
    if (!memcmp(range, messages->begin, begins) && !memcmp(in_range, messages->in_range, ids)) return flags;
    memcpy(range, messages->begin, begins);
    memcpy(in_range, messages->in_range, ids);
    return flags | FES_NEW_RANGE;
}

/* Writes the messages of the last tick: observations from its input, beacons and commands from its state in `buffer`.
 * Robots without a mark have none. Returns the length of all of them; their ends are messages->ends [3 n]. */
FES_API i64 fes_crew_payloads(const Crew *crew, const Messages *messages, const Input *input, u8 *buffer, i64 capacity,
                              const u8 *present, const u8 *decodable) {
    State now;
    state_at(crew, capacity, buffer, &now);
    Sending sending = {messages->out, messages->ends, present, decodable};
    sending.out = wire_write_observations(crew, messages, input, &sending);
    sending.ends += crew->robots;
    wire_write(crew, messages, input->tick, &now, &sending);
    return messages->ends[3 * crew->robots - 1];
}
