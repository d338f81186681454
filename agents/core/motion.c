/* Where each robot is pulled, and the twist that follows. Twins: agents/laws/formation.py, agents/control/motion.py. */
#include "fes/arithmetic/core/exponential.h"
#include "fes/arithmetic/core/trigonometry.h"
#include "laws.h"

/* g_i = sum_j a_ij (r_ij - r_des) [cos psi_ij, sin psi_ij] of (6), with the weights (9): half to the first link with
 * the largest error. */
void formation_pull(const Crew *crew, const State *now, const double *desired, double *pull) {
    const Contacts *contacts = &now->contacts;
    for (i64 robot = 0; robot < crew->robots; robot++) {
        i64 first = now->links.begin[robot], last = now->links.begin[robot + 1], worst = first;
        double largest = -1.0, x = 0.0, y = 0.0;
        double share = 0.5 * (1.0 / (double)(last - first > 2 ? last - first - 1 : 1));
        for (i64 link = first; link < last; link++) {
            double size = magnitude(contacts->separation[now->links.contact[link]] - desired[link]);
            if (size > largest) {
                largest = size;
                worst = link;
            }
        }
        for (i64 link = first; link < last; link++) {
            i64 pair = now->links.contact[link];
            double separation = contacts->separation[pair], dx = contacts->dx[pair], dy = contacts->dy[pair];
            double force = (link == worst ? 0.5 : share) * (separation - desired[link]);
            if (!(separation > 0.0)) { /* two robots coincide: the lower id looks along +x */
                dx = contacts->peers[pair] > crew->ids[robot] ? 1.0 : -1.0;
                separation = 1.0;
            }
            x += force * (dx / separation);
            y += force * (dy / separation);
        }
        pull[2 * robot + X] = x;
        pull[2 * robot + Y] = y;
    }
}

/* Twists to hold over a tick, by the exact flow of (6), (7). */
void motion_twists(const Crew *crew, const Input *input, const double *pull, double *twists) {
    for (i64 robot = 0; robot < crew->robots; robot++) {
        double x = pull[2 * robot + X], y = pull[2 * robot + Y], sine, cosine;
        double size = square_root(x * x + y * y);
        fes_sin_cos(input->poses[POSE * robot + HEADING], &sine, &cosine);
        double along = x * cosine + y * sine, across = y * cosine - x * sine;
        double rate = crew->angular_gain * crew->dt * size;
        double decay = fes_exp(-rate), rise = fes_one_minus_exp(rate);
        /* rounding may make the sum negative where g points straight backward */
        double ahead = larger((size + along) + (size - along) * decay, 0.0);
        double linear = crew->linear_gain * along;
        double angular = 2.0 * fes_atan2(across * rise, ahead) / crew->dt;
        twists[TWIST * robot + LINEAR] = clipped(linear, -crew->linear_limit, crew->linear_limit);
        twists[TWIST * robot + ANGULAR] = clipped(angular, -crew->angular_limit, crew->angular_limit);
    }
}
