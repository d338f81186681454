/* The contacts of a crew after the beacons of a tick.
 *
 * Twins: agents/runtime/reception.py, which applies the radio's verdict, and agents/control/contacts.py. */
#include "laws.h"

/* Position of an id among `count` ascending ones, or -1. */
static i64 position(const i64 *ids, i64 count, i64 id) {
    i64 low = 0, high = count;
    while (low < high) {
        i64 middle = (low + high) / 2;
        if (ids[middle] < id)
            low = middle + 1;
        else
            high = middle;
    }
    return low < count && ids[low] == id ? low : -1;
}

/* A contact as it was before the tick; without one (old < 0) it has heard no beacon. */
static void carried(const Crew *crew, const Contacts *before, i64 old, Contacts *now, i64 place) {
    int is_new = old < 0;
    now->heard[place] = is_new ? NEVER : before->heard[old];
    now->x[place] = is_new ? 0.0 : before->x[old];
    now->y[place] = is_new ? 0.0 : before->y[old];
    now->heading[place] = is_new ? 0.0 : before->heading[old];
    now->estimates[place] = is_new ? not_a_number() : before->estimates[old];
    now->selected_by_peer[place] = is_new ? 0 : before->selected_by_peer[old];
    now->heard_separation[place] = is_new ? 0.0 : before->heard_separation[old];
    for (i64 i = 0; i < crew->statistics; i++)
        now->statistics[place * crew->statistics + i] = is_new ? 0.0 : before->statistics[old * crew->statistics + i];
    now->heard_before[place] = now->heard[place];
    now->separation_before[place] = now->heard_separation[place];
}

/* The content of a sender's beacon, at its receiver. */
static void heard(const Crew *crew, const Beacons *beacons, i64 sender, i64 receiver, i64 tick, Contacts *now,
                  i64 place) {
    i64 first = beacons->begin[sender];
    i64 link = position(beacons->peers + first, beacons->begin[sender + 1] - first, receiver);
    now->heard[place] = tick;
    now->x[place] = beacons->poses[POSE * sender + X];
    now->y[place] = beacons->poses[POSE * sender + Y];
    now->heading[place] = beacons->poses[POSE * sender + HEADING];
    now->estimates[place] = link < 0 ? not_a_number() : beacons->estimates[first + link];
    now->selected_by_peer[place] = link < 0 ? 0 : beacons->selected[first + link];
    for (i64 i = 0; i < crew->statistics; i++)
        now->statistics[place * crew->statistics + i] = beacons->statistics[sender * crew->statistics + i];
}

/* The line of sight from the own pose of the previous tick, and whether the peer is known. */
static void measured(const Crew *crew, const double *own, i64 tick, int is_heard, Contacts *now, i64 place) {
    double dx = now->x[place] - own[X], dy = now->y[place] - own[Y];
    now->dx[place] = dx;
    now->dy[place] = dy;
    now->separation[place] = square_root(dx * dx + dy * dy);
    if (is_heard) now->heard_separation[place] = now->separation[place];
    now->known[place] = now->heard[place] >= tick + 1 - crew->timeout;
}

/* The contacts now: all peers in range that each robot has heard since they came in range. */
void contacts_update(const Crew *crew, const Input *input, const State *before, Contacts *now) {
    const Contacts *old = &before->contacts;
    const Beacons *beacons = &input->beacons;
    i64 place = 0, tick = input->tick - 1, hint = 0;
    now->begin[0] = 0;
    for (i64 robot = 0; robot < crew->robots; robot++) {
        i64 known = old->begin[robot], end = old->begin[robot + 1];
        for (i64 pair = input->begin[robot]; pair < input->begin[robot + 1]; pair++) {
            i64 peer = input->in_range[pair], sender = -1;
            while (known < end && old->peers[known] < peer) known++;
            int is_old = known < end && old->peers[known] == peer;
            if (input->reception[pair] == DECODED) {
                /* senders often lie one after the other, or are all robots */
                hint = peer < beacons->count && beacons->ids[peer] == peer ? peer : hint + 1;
                sender = hint < beacons->count && beacons->ids[hint] == peer
                             ? hint
                             : position(beacons->ids, beacons->count, peer);
            }
            if (!is_old && sender < 0) continue;
            now->peers[place] = peer;
            carried(crew, old, is_old ? known : -1, now, place);
            if (sender >= 0) heard(crew, beacons, sender, crew->ids[robot], tick, now, place);
            measured(crew, before->poses + POSE * robot, tick, sender >= 0, now, place);
            place++;
        }
        now->begin[robot + 1] = place;
    }
}
