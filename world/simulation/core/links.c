/* Separations and errors of the robots' links. Twin: world/metrics/link_errors.py. */
#include "world.h"

/* The links in use, once for each two robots, and the estimates of each direction. */
typedef struct {
    i64 links, pairs, both;
    const i64 *a, *b;                   /* rows of the two ends of each link */
    const i64 *forward, *backward;      /* positions of the two estimates of a link that has both */
} Links;

enum { DISAGREEMENT, ESTIMATE_ERROR, SEPARATION_ERROR, ESTIMATES };

FES_API void fes_world_separations(const Links *links, const double *poses, double *separation) {
    for (i64 i = 0; i < links->links; i++) {
        const double *a = poses + POSE * links->a[i], *b = poses + POSE * links->b[i];
        double dx = a[X] - b[X], dy = a[Y] - b[Y];
        separation[i] = square_root(dx * dx + dy * dy);
    }
}

/* The largest distance of values from `optimal`; NaN if one of them is NaN. */
static double largest_error(i64 count, const double *values, double optimal) {
    double largest = 0.0;
    for (i64 i = 0; i < count; i++) largest = larger(largest, magnitude(values[i] - optimal));
    return largest;
}

/* The disagreement, the largest errors, and the sum of all estimates: terms are added in their order. */
FES_API void fes_world_link_errors(const Links *links, const double *estimates, const double *separation,
                                   double optimal, double *numbers) {
    double disagreement = 0.0, total = -0.0; /* -0 + x is x, also for x = -0 */
    for (i64 i = 0; i < links->both; i++)
        disagreement += magnitude(estimates[links->forward[i]] - estimates[links->backward[i]]);
    for (i64 i = 0; i < links->pairs; i++) total += estimates[i];
    numbers[DISAGREEMENT] = disagreement;
    numbers[ESTIMATE_ERROR] = largest_error(links->pairs, estimates, optimal);
    numbers[SEPARATION_ERROR] = largest_error(links->links, separation, optimal);
    numbers[ESTIMATES] = total;
}
