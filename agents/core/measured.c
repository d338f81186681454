/* The seeking laws that climb ln J along a slope measured by counting beacons.
 *
 * Twins: agents/laws/packet_counting.py, agents/laws/seeking_measured.py, fes/model/beacon_slots.py. */
#include "fes/arithmetic/core/power.h"
#include "laws.h"

#define MIXING 0.1
#define LOW (-6.0)
#define HIGH 1.5
#define NEAREST 0.1
#define LEAST_WEIGHT 2.0
#define LEVEL_PRIOR (-2.2503673273124454)
#define PRIOR_WEIGHT (0.1 / 2.25)
#define SPEED 5.0
#define LEAST_CURVATURE 2e-4
#define FARTHEST 150.0
#define MOST_MISSED 10000

/* The level and the exponent that fit the statistics of a learner and the priors best. */
void measured_fit(const Crew *crew, const double *statistics, double *level, double *exponent) {
    const Method *method = &crew->method;
    double slope = clipped((statistics[4] + method->slope_prior[0]) / (statistics[3] + method->slope_prior[1]),
                           method->slopes[0], method->slopes[1]);
    *exponent = slope;
    *level = clipped((statistics[2] - slope * statistics[1] + PRIOR_WEIGHT * LEVEL_PRIOR) /
                         (statistics[0] + PRIOR_WEIGHT),
                     LOW, HIGH);
}

/* The statistics of a robot, mixed with those of the peers that it heard at this tick. */
static void mix(const Contacts *contacts, i64 first, i64 last, i64 tick, const double *own, double *mixed) {
    double count = 0.0, total[STATISTICS] = {0.0};
    for (i64 pair = first; pair < last; pair++) {
        if (contacts->heard[pair] != tick - 1) continue;
        count += 1.0;
        for (int i = 0; i < STATISTICS; i++) total[i] += contacts->statistics[STATISTICS * pair + i];
    }
    double share = smaller(MIXING, 1.0 / (1.0 + count));
    for (int i = 0; i < STATISTICS; i++) mixed[i] = own[i] + share * (total[i] - count * own[i]);
}

/* The sums of new samples of a learner. */
typedef struct {
    double known, mean_place, mean_response; /* of the samples before */
    double level, exponent;
    double sums[STATISTICS];
} Lesson;

/* Adds a beacon slot at a separation. */
static void learn(const Method *method, Lesson *lesson, double separation, int is_decoded) {
    double u = fes_log(larger(separation / method->scale, NEAREST));
    double predictor = clipped(lesson->level + lesson->exponent * u, LOW, HIGH);
    double rate = fes_exp(predictor); /* -ln p */
    double p = fes_exp(-rate), lost = fes_one_minus_exp(rate);
    double odds = p / lost;
    double weight = rate * rate * odds;
    double response = weight * predictor + (is_decoded ? -rate : rate * odds);
    double centered = u - lesson->mean_place;
    lesson->sums[0] += weight;
    lesson->sums[1] += weight * u;
    lesson->sums[2] += response;
    lesson->sums[3] += lesson->known * weight * (centered * centered);
    lesson->sums[4] += lesson->known * centered * (response - weight * lesson->mean_response);
}

/* Adds the slots of a contact that become known at this tick: the decoded one, or those missed before it. */
static void learn_slots(const Method *method, Lesson *lesson, const Contacts *contacts, i64 pair, i64 tick,
                        int is_missed) {
    i64 last = contacts->heard_before[pair];
    if (contacts->heard[pair] != tick - 1 || !contacts->is_link[pair] || last < 0) return;
    double end = contacts->heard_separation[pair];
    if (!is_missed) {
        learn(method, lesson, end, 1);
        return;
    }
    i64 missed = tick - 2 - last, counted = missed < MOST_MISSED ? missed : MOST_MISSED;
    double start = contacts->separation_before[pair];
    for (i64 order = missed - counted + 1; order <= missed; order++)
        learn(method, lesson, start + (end - start) * (double)order / (double)(missed + 1), 0);
}

/* The statistics and the fit of a learner after the slots of the contacts from `first` to `last`. */
static void update(const Crew *crew, const Contacts *contacts, i64 first, i64 last, i64 tick, double *statistics,
                   double *level, double *exponent) {
    const Method *method = &crew->method;
    for (int i = 0; i < STATISTICS; i++) statistics[i] *= i < 3 ? method->short_share : method->long_share;
    int is_known = statistics[0] > LEAST_WEIGHT;
    double safe = is_known ? statistics[0] : 1.0;
    Lesson lesson = {is_known, statistics[1] / safe, statistics[2] / safe, *level, *exponent, {0.0}};
    for (int is_missed = 0; is_missed < 2; is_missed++)
        for (i64 pair = first; pair < last; pair++) learn_slots(method, &lesson, contacts, pair, tick, is_missed);
    for (int i = 0; i < STATISTICS; i++) statistics[i] += lesson.sums[i];
    measured_fit(crew, statistics, level, exponent);
}

/* The fit of the channel after the beacons of the previous tick. */
void measured_update(const Crew *crew, const Input *input, const State *before, State *now) {
    const Contacts *contacts = &now->contacts;
    for (i64 robot = 0; robot < crew->robots; robot++) {
        i64 first = contacts->begin[robot], last = contacts->begin[robot + 1];
        if (crew->seeking == POOLED) {
            double *statistics = now->fit + STATISTICS * robot;
            mix(contacts, first, last, input->tick, before->fit + STATISTICS * robot, statistics);
            now->level[robot] = before->level[robot];
            now->exponent[robot] = before->exponent[robot];
            update(crew, contacts, first, last, input->tick, statistics, now->level + robot, now->exponent + robot);
            continue;
        }
        for (i64 link = now->links.begin[robot]; link < now->links.begin[robot + 1]; link++) {
            i64 pair = now->links.contact[link];
            update(crew, contacts, pair, pair + 1, input->tick, now->fit + STATISTICS * link, now->level + link,
                   now->exponent + link);
        }
    }
}

/* Speed [m/s] at which an estimate climbs ln J by the fit of its learner: a bounded Newton step. */
static double drift(const Crew *crew, double level, double exponent, double estimate) {
    double rate = fes_exp(level + exponent * fes_log(estimate / crew->method.scale));
    double channel = -exponent * rate / estimate; /* (ln p)' */
    double slope, curvature;
    objective_derivatives(&crew->objective, estimate, &slope, &curvature);
    slope = slope + channel;
    curvature = curvature + channel * (exponent - 1.0) / estimate;
    double size = crew->objective.maximum_separation / FARTHEST;
    double step = -crew->method.gain * slope / smaller(curvature, -LEAST_CURVATURE / (size * size));
    return clipped(step, -SPEED * size, SPEED * size);
}

/* The estimates after a tick of climbing, and of consensus with the peers. */
void measured_seek(const Crew *crew, const Input *input, State *now) {
    (void)input;
    double size = crew->objective.maximum_separation / FARTHEST;
    for (i64 link = 0; link < now->links.begin[crew->robots]; link++) {
        i64 learner = crew->seeking == POOLED ? now->links.rows[link] : link;
        double estimate = now->links.state[link], peer = now->contacts.estimates[now->links.contact[link]];
        double speed = drift(crew, now->level[learner], now->exponent[learner], estimate);
        speed += crew->consensus_gain * (is_finite(peer) ? peer - estimate : 0.0);
        now->links.state[link] = clipped(estimate + crew->dt * speed, 20.0 * size, 145.0 * size);
    }
}
