/* The radio: the fate of each beacon at each robot in range. Twin: world/simulation/channel.py. */
#include "fes/arithmetic/core/philox.h"
#include "fes/arithmetic/core/power.h"
#include "world.h"

#define AT_ONCE 64

/* Probabilities that beacons decode at `count` separations: (3) for a Rayleigh channel. Twin: fes/model/outage.py. */
FES_WIDE static void probabilities(const Settings *settings, i64 count, const double *restrict separation,
                                   double *restrict result) {
    double scale = -settings->scale, exponent = settings->exponent, loss[AT_ONCE];
    double midpoint = settings->midpoint, width = settings->width;
    if (settings->model == LOGISTIC) {
        for (i64 i = 0; i < count; i++) {
            double z = -((separation[i] - midpoint) / width);
            double decay = fes_exp(-magnitude(z));
            result[i] = (z >= 0.0 ? 1.0 : decay) / (1.0 + decay);
        }
    } else if (scale == 0.0) {
        for (i64 i = 0; i < count; i++) result[i] = 1.0;
    } else {
        powers(count, separation, exponent, loss);
        for (i64 i = 0; i < count; i++) result[i] = fes_exp(scale * loss[i]);
    }
}

/* The probability of each candidate: both directions have the same. */
static void measure_probabilities(const Settings *settings, i64 candidates, World *before) {
    for (i64 first = 0; first < candidates; first += AT_ONCE) {
        i64 count = candidates - first < AT_ONCE ? candidates - first : AT_ONCE;
        probabilities(settings, count, before->separation + first, before->chance + first);
    }
}

/* A contact that has just come in range. */
static void opened(Ledger *now, i64 place) {
    now->age[place] = now->sent[place] = now->decoded[place] = now->gap[place] = now->longest_gap[place] = 0;
    now->reception[place] = CLOSED;
    now->probability[place] = not_a_number();
    now->outage_sum[place] = 0.0;
    now->burst[place] = UNKNOWN;
}

/* The ledger of a contact after one more beacon. */
static void counted(const Ledger *before, i64 old, double probability, int is_open, int is_on_air, int is_decoded,
                    Ledger *now, i64 place) {
    i64 gap = is_on_air != is_decoded ? before->gap[old] + 1 : 0;
    now->age[place] = before->age[old] + 1;
    now->reception[place] = (u8)(is_open + is_decoded);
    now->sent[place] = before->sent[old] + is_on_air;
    now->decoded[place] = before->decoded[old] + is_decoded;
    now->probability[place] = probability;
    now->outage_sum[place] = before->outage_sum[old] + (1.0 - probability) * (double)is_on_air;
    now->gap[place] = gap;
    now->longest_gap[place] = before->longest_gap[old] > gap ? before->longest_gap[old] : gap;
    now->burst[place] = before->burst[old];
}

/* The radio one tick later, over the pairs that are then in range. `factor` [n] is that of each robot's own transmitter
 * on the reception probability; NULL where all are healthy. */
void radio_transmit(const Settings *settings, i64 robots, i64 candidates, i64 tick, const u8 *present,
                    const double *factor, World *before, World *now) {
    const Pairs *old = &before->pairs, *pairs = &now->pairs;
    measure_probabilities(settings, candidates, before);
    int is_random = factor || !settings->is_certain, are_drawn = before->totals[DRAWN] == tick / WORDS;
    now->totals[SENT] = now->totals[HEARD] = 0;
    now->totals[DRAWN] = is_random ? tick / WORDS : -1;
    for (i64 robot = 0; robot < robots; robot++) {
        i64 known = old->begin[robot], end = old->begin[robot + 1];
        for (i64 place = pairs->begin[robot]; place < pairs->begin[robot + 1]; place++) {
            i64 peer = pairs->peers[place];
            while (known < end && old->peers[known] < peer) known++;
            if (known == end || old->peers[known] != peer) {
                opened(&now->ledger, place);
                continue;
            }
            double probability = before->chance[old->pair[known]];
            if (factor) probability = probability * factor[peer];
            int is_open = before->ledger.age[known] + 1 >= OPENING_TICKS, are_present = present[robot] && present[peer];
            int is_on_air = is_open && are_present, is_decoded = is_on_air;
            if (is_random) {
                u64 *words = now->ledger.words + WORDS * place;
                memcpy(words, before->ledger.words + WORDS * known, WORDS * sizeof(u64));
                if (!are_drawn || before->ledger.age[known] < OPENING_TICKS) /* it has just come in range */
                    fes_philox(settings->key0, settings->key1, tick / WORDS, peer, robot, words);
                is_decoded = is_on_air && fes_unit(words[tick % WORDS]) < probability;
            }
            counted(&before->ledger, known, probability, is_open, is_on_air, is_decoded, &now->ledger, place);
            now->totals[SENT] += is_open && are_present;
            now->totals[HEARD] += is_decoded;
        }
    }
}
