/* The seeking law (18) with any index. Twins: agents/laws/perturbation.py and agents/laws/seeking_perturbation.py. */
#include "fes/arithmetic/core/trigonometry.h"
#include "laws.h"

#define SWEEPS 4
#define MAX_EXTRAPOLATION 0.1
#define LANES 8 /* links that are computed side by side */

/* One number for each of several links, at each node. */
typedef double Nodes[NODES][LANES];

/* The state of several links, and the estimates of their peers. */
typedef struct {
    double state[ROWS][LANES], peer[LANES];
} Block;

double dither_at(const Crew *crew, double time) {
    double sine, cosine;
    fes_sin_cos(crew->dither_frequency * time, &sine, &cosine);
    return crew->dither_amplitude * sine;
}

/* The baselines of links that begin at this tick: the first samples. */
void perturbation_begin(const Crew *crew, i64 tick, i64 count, const double *estimates, double *baseline) {
    double dither = dither_at(crew, (double)tick * crew->dt);
    for (i64 link = 0; link < count; link++) {
        double place = estimates[link] + dither;
        if (crew->seeking == SAMPLED)
            baseline[link] = objective_preference(&crew->objective, place);
        else
            crew->index(crew->index_settings, 1, &place, baseline + link, NULL, NULL, NULL);
        baseline[link] = baseline[link] * crew->index_gain;
    }
}

/* Responses at `rows` times to `terms` inputs, term by term. */
#define RESPOND(result, rows, matrix, terms, input)                                                                  \
    for (int row = 0; row < (rows); row++)                                                                            \
        for (int lane = 0; lane < LANES; lane++) {                                                                    \
            double sum = (matrix)[row][0] * (input)[0][lane];                                                         \
            for (int term = 1; term < (terms); term++) sum = sum + (matrix)[row][term] * (input)[term][lane];         \
            (result)[row][lane] = sum;                                                                                \
        }

/* One sweep: the index along the path, its baseline and the path that follow. */
FES_INLINE void sweep(const Crew *crew, const Step *step, Nodes sample, Nodes wave, double held[NODES + 1][LANES],
                      double drift[NODES + 2][LANES], double baseline[NODES + 1][LANES],
                      double path[NODES + 2][LANES]) {
    for (int node = 0; node < NODES; node++)
        for (int lane = 0; lane < LANES; lane++) sample[node][lane] = sample[node][lane] * crew->index_gain;
    RESPOND(baseline, NODES + 1, step->washout_input, NODES, sample)
    for (int row = 0; row <= NODES; row++)
        for (int lane = 0; lane < LANES; lane++) baseline[row][lane] = baseline[row][lane] + held[row][lane];
    for (int node = 0; node < NODES; node++)
        for (int lane = 0; lane < LANES; lane++)
            sample[node][lane] = (sample[node][lane] - baseline[node][lane]) * wave[node][lane];
    RESPOND(path, NODES + 2, step->path_input, NODES, sample)
    for (int row = 0; row < NODES + 2; row++)
        for (int lane = 0; lane < LANES; lane++) path[row][lane] = path[row][lane] + drift[row][lane];
}

/* One sub-step of (18). `drawn` [LANES] are samples that count at every separation; NULL for the crew's index. */
FES_WIDE static void sub_step(const Crew *crew, const Step *step, Nodes wave, const double *drawn, Block *block) {
    double start[3][LANES], held[NODES + 1][LANES], drift[NODES + 2][LANES], path[NODES + 2][LANES];
    double baseline[NODES + 1][LANES];
    Nodes center, value, slope, bend, trusted, sample;
    memcpy(start[0], block->state[ESTIMATE], sizeof start[0]);
    memcpy(start[1], block->state[DRIFT], sizeof start[1]);
    memcpy(start[2], block->peer, sizeof start[2]);
    for (int row = 0; row <= NODES; row++)
        for (int lane = 0; lane < LANES; lane++)
            held[row][lane] = step->washout_start[row] * block->state[BASELINE][lane] + 0.0;
    RESPOND(drift, NODES + 2, step->path_start, 3, start)
    /* numpy begins each sum with 0.0, so that none is -0.0; the sums of a sweep are added to these */
    for (int row = 0; row < NODES + 2; row++)
        for (int lane = 0; lane < LANES; lane++) drift[row][lane] = drift[row][lane] + 0.0;
    memcpy(path, drift, sizeof path);
    for (int node = 0; node < NODES; node++)
        for (int lane = 0; lane < LANES; lane++) {
            center[node][lane] = drift[node][lane] + wave[node][lane];
            value[node][lane] = drawn ? drawn[lane] : 0.0;
            slope[node][lane] = bend[node][lane] = 0.0;
            trusted[node][lane] = infinity();
        }
    if (!drawn)
        crew->index(crew->index_settings, NODES * LANES, center[0], value[0], slope[0], bend[0], trusted[0]);
    for (int round = 0; round < SWEEPS; round++) {
        int is_far = 0;
        Nodes place;
        for (int node = 0; node < NODES; node++)
            for (int lane = 0; lane < LANES; lane++) {
                double ahead = path[node][lane] - drift[node][lane];
                sample[node][lane] =
                    value[node][lane] + ahead * (slope[node][lane] + ahead * bend[node][lane]);
                place[node][lane] = center[node][lane] + ahead;
                is_far |= magnitude(ahead) > trusted[node][lane];
            }
        if (is_far) {
            Nodes exact;
            crew->index(crew->index_settings, NODES * LANES, place[0], exact[0], NULL, NULL, NULL);
            for (int node = 0; node < NODES; node++)
                for (int lane = 0; lane < LANES; lane++)
                    if (magnitude(path[node][lane] - drift[node][lane]) > trusted[node][lane])
                        sample[node][lane] = exact[node][lane];
        }
        sweep(crew, step, sample, wave, held, drift, baseline, path);
    }
    memcpy(block->state[ESTIMATE], path[NODES], sizeof path[NODES]);
    memcpy(block->state[DRIFT], path[NODES + 1], sizeof path[NODES + 1]);
    memcpy(block->state[BASELINE], baseline[NODES], sizeof baseline[NODES]);
}

/* The peer's estimate of a link now, by its last beacon; NaN if none was heard. */
static double peer_now(const Crew *crew, const Input *input, const State *now, i64 link) {
    i64 contact = now->links.contact[link];
    double estimate = now->contacts.estimates[contact];
    if (!crew->extrapolates) return estimate;
    double age = crew->dt * (double)(input->tick - now->contacts.heard[contact]);
    return estimate + now->links.state[DRIFT * now->capacity + link] * smaller(age, MAX_EXTRAPOLATION);
}

/* One sample of J of (16): S(r) if the last tick's beacon decoded, else 0. */
static double sampled(const Crew *crew, const Input *input, const State *now, i64 link) {
    i64 contact = now->links.contact[link];
    if (now->contacts.heard[contact] != input->tick - 1) return 0.0;
    return objective_preference(&crew->objective, now->contacts.separation[contact]);
}

/* The dither of links at the nodes of a sub-step: the same for all links if all clocks are exact. */
static void waves(const Crew *crew, const Input *input, const State *now, const Step *step, i64 sub, const i64 *list,
                  i64 count, Nodes wave) {
    double later = (double)sub * crew->dt / (double)crew->sub_steps;
    for (int node = 0; node < NODES; node++)
        for (i64 lane = 0; lane < LANES; lane++) {
            double skew = input->skew ? input->skew[now->links.rows[list[lane < count ? lane : 0]]] : 0.0;
            double begin = (double)input->tick * crew->dt + skew;
            int is_known = lane > 0 && !input->skew;
            wave[node][lane] = is_known ? wave[node][0] : dither_at(crew, begin + later + step->nodes[node]);
        }
}

/* The links of `list` one tick later, all of them with the same linear part. `common` is the dither of exact clocks in
 * the first sub-step. */
static void advance(const Crew *crew, const Input *input, State *now, const Step *step, const i64 *list, i64 count,
                    const double *peers, Nodes common) {
    Block block;
    Nodes wave;
    double drawn[LANES];
    for (i64 lane = 0; lane < LANES; lane++) {
        i64 link = list[lane < count ? lane : 0]; /* a lane too many repeats the first link */
        for (int row = 0; row < ROWS; row++) block.state[row][lane] = now->links.state[row * now->capacity + link];
        block.peer[lane] = peers[lane < count ? lane : 0];
        if (crew->seeking == SAMPLED) drawn[lane] = sampled(crew, input, now, link);
    }
    for (i64 sub = 0; sub < crew->sub_steps; sub++) {
        int is_common = !input->skew && sub == 0;
        if (!is_common) waves(crew, input, now, step, sub, list, count, wave);
        sub_step(crew, step, is_common ? common : wave, crew->seeking == SAMPLED ? drawn : NULL, &block);
    }
    for (i64 lane = 0; lane < count; lane++)
        for (int row = 0; row < ROWS; row++)
            now->links.state[row * now->capacity + list[lane]] = block.state[row][lane];
}

void perturbation_seek(const Crew *crew, const Input *input, State *now) {
    i64 lists[2][LANES], counts[2] = {0, 0}, links = now->links.begin[crew->robots];
    double peers[2][LANES];
    Nodes common;
    if (!input->skew) waves(crew, input, now, &crew->coupled, 0, NULL, 0, common);
    for (i64 link = 0; link <= links; link++) {
        for (int is_coupled = 0; is_coupled < 2; is_coupled++)
            if (counts[is_coupled] == LANES || (link == links && counts[is_coupled])) {
                const Step *step = is_coupled ? &crew->coupled : &crew->alone;
                advance(crew, input, now, step, lists[is_coupled], counts[is_coupled], peers[is_coupled],
                        common);
                counts[is_coupled] = 0;
            }
        if (link == links) break;
        double peer = peer_now(crew, input, now, link);
        int is_coupled = is_finite(peer);
        peers[is_coupled][counts[is_coupled]] = is_coupled ? peer : 0.0;
        lists[is_coupled][counts[is_coupled]++] = link;
    }
}
