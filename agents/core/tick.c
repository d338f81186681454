/* One tick of a crew: the order of agents/control/crew.py. */
#include "laws.h"

#define FES_NEW_CONTACTS 1
#define FES_NEW_LINKS 2
#define FES_FAILED (-1)

static double bounded(double x) { return clipped(x, -MAX_NUMBER, MAX_NUMBER); }

/* The state that a robot carries whatever it hears. */
static void begin(const Crew *crew, const Input *input, const State *before, State *now) {
    memcpy(now->linked_since, before->linked_since, (size_t)crew->robots * sizeof(i64));
    for (i64 robot = 0; robot < crew->robots; robot++) {
        now->since[robot] = before->since[robot] < input->tick ? before->since[robot] : input->tick;
        for (int column = 0; column < POSE; column++) {
            double value = input->poses[POSE * robot + column];
            now->poses[POSE * robot + column] = value;
            now->sent_poses[POSE * robot + column] = bounded(value);
        }
    }
}

/* The separations that the robots want: their estimates, with the dither of their clocks if it is physical. */
static void desire(const Crew *crew, const Input *input, const State *now, double *desired) {
    double common = crew->seeking != ORACLE && !input->skew ? dither_at(crew, (double)input->tick * crew->dt + 0.0) : 0.0;
    for (i64 link = 0; link < now->links.begin[crew->robots]; link++) {
        desired[link] = now->links.state[link];
        if (crew->seeking == ORACLE) continue;
        double time = (double)input->tick * crew->dt + (input->skew ? input->skew[now->links.rows[link]] : 0.0);
        int is_common = !input->skew && crew->seeking != ALONE;
        double ahead = crew->seeking == ALONE ? now->links.ahead[link] : 0.0;
        desired[link] = desired[link] + (is_common ? common : dither_at(crew, time + ahead));
    }
}

/* The beacons and the numbers for observers. */
static void publish(const Crew *crew, State *now) {
    i64 links = now->links.begin[crew->robots];
    for (i64 link = 0; link < links; link++) now->links.sent[link] = bounded(now->links.state[link]);
    if (crew->seeking != POOLED && crew->seeking != ALONE) return;
    for (i64 link = 0; link < links; link++) {
        i64 learner = crew->seeking == POOLED ? now->links.rows[link] : link;
        now->links.learnt[link] = bounded(now->level[learner]);
        now->links.learnt[links + link] = bounded(now->exponent[learner]);
    }
    for (i64 i = 0; i < crew->robots * crew->statistics; i++) now->sent_statistics[i] = bounded(now->fit[i]);
}

/* Numbers that no other robot can use end the tick. */
static int are_usable(const Crew *crew, double *twists) {
    for (i64 i = 0; i < TWIST * crew->robots; i++) {
        if (!is_finite(twists[i])) return 0;
        twists[i] = clipped(twists[i], -MAX_TWIST, MAX_TWIST);
    }
    return 1;
}

static int are_equal(const i64 *begin, const i64 *peers, const i64 *other_begin, const i64 *other_peers, i64 robots) {
    size_t size = sizeof(i64);
    return !memcmp(begin, other_begin, (size_t)(robots + 1) * size) &&
           !memcmp(peers, other_peers, (size_t)begin[robots] * size);
}

/* The beacons that the crew itself has sent at the tick before. */
static Beacons own_beacons(const Crew *crew, const State *before) {
    const Links *links = &before->links;
    Beacons beacons = {crew->robots, crew->ids,   before->sent_poses, links->begin,
                       links->peers, links->sent, links->selected,    before->sent_statistics};
    return beacons;
}

/* The next state in `after`, of `capacity` contacts, from the state in `before`. Returns flags that say which pairs
 * changed, or FES_FAILED if a twist is not finite. `scratch` holds 2 n + capacity doubles. */
FES_API i64 fes_crew_tick(const Crew *crew, const Input *given, u8 *before_buffer, i64 before_capacity, u8 *after_buffer,
                          i64 capacity, double *scratch) {
    State before, now;
    double *pull = scratch, *desired = scratch + 2 * crew->robots;
    state_at(crew, before_capacity, before_buffer, &before);
    state_at(crew, capacity, after_buffer, &now);
    Input hears = *given;
    const Input *input = &hears;
    if (given->beacons.count < 0) hears.beacons = own_beacons(crew, &before);
    begin(crew, input, &before, &now);
    contacts_update(crew, input, &before, &now.contacts);
    u8 *selected = (u8 *)desired;
    rule_select(crew, &now.contacts, selected);
    links_update(crew, input, &before, &now, selected);
    desire(crew, input, &now, desired);
    formation_pull(crew, &now, desired, pull);
    int is_safe = crew->safe_separation >= 0.0;
    if (is_safe) separation_give_way(crew, input, &now, pull);
    motion_twists(crew, input, pull, now.twists);
    if (!are_usable(crew, now.twists)) return FES_FAILED;
    if (is_safe) separation_slow_down(crew, input, &now);
    int is_measured = crew->seeking == POOLED || crew->seeking == ALONE;
    if (is_measured) measured_update(crew, input, &before, &now);
    publish(crew, &now);
    if (is_measured)
        measured_seek(crew, input, &now);
    else
        perturbation_seek(crew, input, &now);
    i64 flags = 0;
    if (!are_equal(now.contacts.begin, now.contacts.peers, before.contacts.begin, before.contacts.peers, crew->robots))
        flags |= FES_NEW_CONTACTS;
    if (!are_equal(now.links.begin, now.links.peers, before.links.begin, before.links.peers, crew->robots))
        flags |= FES_NEW_LINKS;
    return flags;
}
