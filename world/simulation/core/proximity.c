/* The pairs of robots within communication range. Twin: world/simulation/neighbor_list.py. */
#include "world.h"

int candidates_are_valid(const Candidates *candidates, i64 robots, const double *poses) {
    if (!candidates->positions) return 1;
    for (i64 robot = 0; robot < robots; robot++) {
        double dx = poses[POSE * robot + X] - candidates->positions[2 * robot + X];
        double dy = poses[POSE * robot + Y] - candidates->positions[2 * robot + Y];
        if (!(square_root(dx * dx + dy * dy) <= candidates->most_moved)) return 0;
    }
    return 1;
}

FES_WIDE static void separations(const Candidates *candidates, const double *restrict poses, double *restrict result) {
    for (i64 i = 0; i < candidates->count; i++) {
        const double *a = poses + POSE * candidates->a[i], *b = poses + POSE * candidates->b[i];
        double dx = a[X] - b[X], dy = a[Y] - b[Y];
        result[i] = square_root(dx * dx + dy * dy);
    }
}

/* The candidates' separations, and the pairs in range. As the candidates are sorted, each robot's peers ascend. */
void proximity_measure(const Settings *settings, const Candidates *candidates, i64 robots, World *now) {
    Pairs *pairs = &now->pairs;
    const i64 *a = candidates->a, *b = candidates->b;
    separations(candidates, now->poses, now->separation);
    memset(pairs->begin, 0, (size_t)(robots + 1) * sizeof(i64));
    for (i64 i = 0; i < candidates->count; i++) {
        now->mask[i] = now->separation[i] <= settings->communication_range;
        pairs->begin[a[i] + 1] += now->mask[i];
        pairs->begin[b[i] + 1] += now->mask[i];
    }
    for (i64 robot = 0; robot < robots; robot++) pairs->begin[robot + 1] += pairs->begin[robot];
    for (i64 i = 0; i < candidates->count; i++) {
        if (!now->mask[i]) continue;
        for (int side = 0; side < 2; side++) {
            i64 row = side ? b[i] : a[i], place = pairs->begin[row]++;
            pairs->rows[place] = row;
            pairs->peers[place] = side ? a[i] : b[i];
            pairs->pair[place] = i;
        }
    }
    /* each begin has moved to the next robot's */
    for (i64 robot = robots; robot > 0; robot--) pairs->begin[robot] = pairs->begin[robot - 1];
    pairs->begin[0] = 0;
}
