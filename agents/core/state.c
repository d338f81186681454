/* The places of a crew's state in its buffer. */
#include "crew.h"

/* Takes `count` numbers of `size` bytes from the buffer; each array begins at a multiple of eight bytes. */
static void *taken(u8 *buffer, i64 *used, i64 count, i64 size) {
    u8 *place = buffer + *used;
    *used += (count * size + 7) / 8 * 8;
    return place;
}

i64 state_at(const Crew *crew, i64 capacity, u8 *buffer, State *state) {
    i64 n = crew->robots, m = capacity, used = 0;
    i64 learners = crew->seeking == POOLED ? n : crew->seeking == ALONE ? m : 0;
    i64 rows = crew->seeking == POOLED || crew->seeking == ALONE ? 1 : ROWS;
    Contacts *contacts = &state->contacts;
    Links *links = &state->links;
#define NUMBERS(place, count) place = taken(buffer, &used, count, 8)
#define CODES(place, count) place = taken(buffer, &used, count, 1)
    state->capacity = capacity;
    NUMBERS(state->poses, POSE * n);
    NUMBERS(state->linked_since, n);
    NUMBERS(state->since, n);
    NUMBERS(contacts->begin, n + 1);
    NUMBERS(contacts->peers, m);
    NUMBERS(contacts->heard, m);
    NUMBERS(contacts->x, m);
    NUMBERS(contacts->y, m);
    NUMBERS(contacts->heading, m);
    NUMBERS(contacts->estimates, m);
    NUMBERS(contacts->heard_separation, m);
    NUMBERS(contacts->dx, m);
    NUMBERS(contacts->dy, m);
    NUMBERS(contacts->separation, m);
    NUMBERS(contacts->statistics, m * crew->statistics);
    CODES(contacts->selected_by_peer, m);
    CODES(contacts->known, m);
    CODES(contacts->is_link, m);
    NUMBERS(links->begin, n + 1);
    NUMBERS(links->rows, m);
    NUMBERS(links->peers, m);
    NUMBERS(links->contact, m);
    NUMBERS(links->state, rows * m);
    NUMBERS(links->ahead, crew->seeking == ALONE ? m : 0);
    NUMBERS(state->fit, STATISTICS * learners);
    NUMBERS(state->level, learners);
    NUMBERS(state->exponent, learners);
    NUMBERS(state->twists, TWIST * n);
    NUMBERS(state->sent_poses, POSE * n);
    NUMBERS(state->sent_statistics, n * crew->statistics);
    CODES(links->selected, m);
    NUMBERS(links->sent, m);
    NUMBERS(links->learnt, learners ? 2 * m : 0);
    NUMBERS(contacts->heard_before, m);
    NUMBERS(contacts->separation_before, m);
    return used;
}

/* The length of a state [bytes], and the place of each of its arrays in the order above. */
FES_API i64 fes_crew_layout(const Crew *crew, i64 capacity, i64 *places) {
    static u8 buffer[8];
    State state;
    i64 length = state_at(crew, capacity, buffer, &state), i = 0;
    const Contacts *contacts = &state.contacts;
    const Links *links = &state.links;
    const void *arrays[] = {
        state.poses, state.linked_since, state.since, contacts->begin, contacts->peers, contacts->heard, contacts->x,
        contacts->y, contacts->heading, contacts->estimates, contacts->heard_separation, contacts->dx, contacts->dy,
        contacts->separation, contacts->statistics, contacts->selected_by_peer, contacts->known, contacts->is_link,
        links->begin, links->rows, links->peers, links->contact, links->state, links->ahead, state.fit, state.level,
        state.exponent, state.twists, state.sent_poses, state.sent_statistics, links->selected, links->sent,
        links->learnt,
    };
    for (; i < (i64)(sizeof arrays / sizeof arrays[0]); i++) places[i] = (i64)((const u8 *)arrays[i] - buffer);
    return length;
}
