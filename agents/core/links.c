/* The links of a crew: contacts that the neighbor rule of either end selected, and how new ones begin.
 *
 * Twins: agents/control/links.py, `_relink` of agents/control/crew.py, agents/laws/link_estimates.py. */
#include "fes/arithmetic/core/philox.h"
#include "laws.h"

#define FIRST_EXCHANGE_TICKS 2

/* Mean of what the peers of a robot estimate on average, by the beacons of this tick; NaN without any. */
static double reported(const Input *input, const Contacts *contacts, i64 first, i64 last) {
    const Beacons *beacons = &input->beacons;
    double total = 0.0, count = 0.0;
    i64 sender = 0;
    for (i64 pair = first; pair < last; pair++) {
        if (contacts->heard[pair] != input->tick - 1) continue;
        while (sender < beacons->count && beacons->ids[sender] < contacts->peers[pair]) sender++;
        if (sender == beacons->count) break;
        i64 begin = beacons->begin[sender], end = beacons->begin[sender + 1];
        double sum = 0.0;
        for (i64 link = begin; link < end; link++) sum += beacons->estimates[link];
        double mean = end > begin ? sum / (double)(end - begin) : not_a_number();
        if (!is_finite(mean)) continue;
        total += mean;
        count += 1.0;
    }
    return count > 0.0 ? total / count : not_a_number();
}

/* The estimate with which a new link of a robot begins: the robot's own mean, the reported mean, or a seeded draw. */
static double first_estimate(const Crew *crew, i64 robot, i64 peer, int is_without_mean, double mean,
                             double from_peers) {
    if (!is_without_mean) return mean;
    if (is_finite(from_peers)) return from_peers;
    const u64 *key = crew->estimate_keys + 2 * robot;
    i64 own = crew->ids[robot] - crew->first[robot], other = peer - crew->first[robot];
    return crew->low_estimate + (crew->high_estimate - crew->low_estimate) * fes_uniform(key[0], key[1], 0, own, other);
}

/* Time by which the dither of a link is ahead of the common one, the same at both ends. */
static double stagger(const Crew *crew, i64 robot, i64 peer) {
    const u64 *key = crew->stagger_keys + 2 * robot;
    i64 own = crew->ids[robot] - crew->first[robot], other = peer - crew->first[robot];
    double share = fes_uniform(key[0], key[1], 0, own < other ? own : other, own < other ? other : own);
    return 2.0 * 3.141592653589793 / crew->dither_frequency * share;
}

/* The state of a link that was one before. */
static void carried(const Crew *crew, const State *before, i64 old, State *now, i64 link) {
    int is_measured = crew->seeking == POOLED || crew->seeking == ALONE;
    for (i64 row = 0; row < (is_measured ? 1 : ROWS); row++)
        now->links.state[row * now->capacity + link] = before->links.state[row * before->capacity + old];
    if (crew->seeking != ALONE) return;
    now->links.ahead[link] = before->links.ahead[old];
    memcpy(now->fit + STATISTICS * link, before->fit + STATISTICS * old, STATISTICS * sizeof(double));
    now->level[link] = before->level[old];
    now->exponent[link] = before->exponent[old];
}

/* The state of a link that begins at this tick with an estimate. */
static void begun(const Crew *crew, i64 tick, double estimate, i64 robot, State *now, i64 link) {
    now->links.state[link] = estimate;
    if (crew->seeking == ORACLE || crew->seeking == SAMPLED) {
        now->links.state[DRIFT * now->capacity + link] = 0.0;
        perturbation_begin(crew, tick, 1, &estimate, now->links.state + BASELINE * now->capacity + link);
    } else if (crew->seeking == ALONE) {
        now->links.ahead[link] = stagger(crew, robot, now->links.peers[link]);
        memset(now->fit + STATISTICS * link, 0, STATISTICS * sizeof(double));
        measured_fit(crew, now->fit + STATISTICS * link, now->level + link, now->exponent + link);
    }
}

void links_update(const Crew *crew, const Input *input, const State *before, State *now, const u8 *selected) {
    const Contacts *contacts = &now->contacts;
    Links *links = &now->links;
    const Links *old = &before->links;
    i64 link = 0;
    links->begin[0] = 0;
    for (i64 robot = 0; robot < crew->robots; robot++) {
        i64 first = contacts->begin[robot], last = contacts->begin[robot + 1], begin = link;
        for (i64 pair = first; pair < last; pair++) {
            contacts->is_link[pair] = selected[pair] | (contacts->selected_by_peer[pair] & contacts->known[pair]);
            if (!contacts->is_link[pair]) continue;
            links->rows[link] = robot;
            links->peers[link] = contacts->peers[pair];
            links->selected[link] = selected[pair];
            links->contact[link++] = pair;
        }
        links->begin[robot + 1] = link;
        if (link > begin && input->tick < now->linked_since[robot]) now->linked_since[robot] = input->tick;
        i64 known = old->begin[robot], end = old->begin[robot + 1];
        int is_fresh = input->tick - now->linked_since[robot] < FIRST_EXCHANGE_TICKS, is_asked = 0;
        double total = 0.0, from_peers = not_a_number();
        for (i64 i = known; i < end; i++) total += old->state[i];
        double mean = total / (double)(end > known ? end - known : 1);
        int is_without_mean = is_fresh || end == known;
        for (i64 i = begin; i < link; i++) {
            while (known < end && old->peers[known] < links->peers[i]) known++;
            if (known < end && old->peers[known] == links->peers[i]) {
                carried(crew, before, known, now, i);
                continue;
            }
            /* at the start of a run the peers' estimates are draws too */
            if (!is_asked && is_fresh && now->since[robot] > 0) from_peers = reported(input, contacts, first, last);
            is_asked = 1;
            double estimate = first_estimate(crew, robot, links->peers[i], is_without_mean, mean, from_peers);
            begun(crew, input->tick, estimate, robot, now, i);
        }
    }
}
