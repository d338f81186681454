/* Safe separation: a filter that keeps robots apart. Twin: agents/control/separation.py, where it is described. */
#include "fes/arithmetic/core/trigonometry.h"
#include "laws.h"

#define SWEEPS 3

/* A known peer that is near enough to bound the motion of a robot. */
typedef struct {
    double x, y;   /* unit vector to the place where it was last heard */
    double bound;  /* largest closing speed [m/s] */
    double spread; /* sine of the half-angle of all places where it can be */
} Near;

/* True if a contact is near; `near` is then its bound. */
static int is_near(const Crew *crew, const Input *input, const State *now, i64 robot, i64 pair, Near *near) {
    const Contacts *contacts = &now->contacts;
    double dx = contacts->x[pair] - input->poses[POSE * robot + X];
    double dy = contacts->y[pair] - input->poses[POSE * robot + Y];
    double distance = square_root(dx * dx + dy * dy);
    double reach = crew->linear_limit * crew->dt * (double)(input->tick - contacts->heard[pair]);
    double room = distance - crew->safe_separation - reach;
    if (!contacts->known[pair] || !(0.5 * crew->separation_gain * room < crew->linear_limit)) return 0;
    int is_apart = distance > 0.0;
    double size = is_apart ? distance : 1.0;
    near->x = is_apart ? dx / size : contacts->peers[pair] > crew->ids[robot] ? 1.0 : -1.0;
    near->y = is_apart ? dy / size : 0.0;
    near->bound = larger(0.5 * crew->separation_gain * room, 0.0);
    near->spread = reach < distance ? reach / size : 1.0;
    return 1;
}

/* A vector, not longer than `longest`. */
static void clip(double *x, double *y, double longest) {
    double size = square_root(*x * *x + *y * *y);
    if (!(size > longest)) return;
    double scale = longest / size;
    *x = *x * scale;
    *y = *y * scale;
}

/* Steps 1 and 2: a part to the right of each near peer, then no part that would close too fast. */
void separation_give_way(const Crew *crew, const Input *input, const State *now, double *pull) {
    double longest = crew->linear_limit / crew->linear_gain, gain = crew->linear_gain;
    Near near;
    for (i64 robot = 0; robot < crew->robots; robot++) {
        i64 first = now->contacts.begin[robot], last = now->contacts.begin[robot + 1];
        double x = pull[2 * robot + X], y = pull[2 * robot + Y], right_x = 0.0, right_y = 0.0;
        clip(&x, &y, longest);
        int has_peers = 0;
        for (i64 pair = first; pair < last; pair++) {
            if (!is_near(crew, input, now, robot, pair, &near)) continue;
            has_peers = 1;
            double closing = gain * (x * near.x + y * near.y);
            double part = crew->give_way_gain * larger(closing - near.bound, 0.0) / gain;
            right_x += part * near.y;
            right_y += part * near.x;
        }
        if (has_peers) {
            x = x + right_x;
            y = y - right_y;
            for (int sweep = 0; sweep < SWEEPS; sweep++)
                for (i64 pair = first; pair < last; pair++) {
                    if (!is_near(crew, input, now, robot, pair, &near)) continue;
                    double closing = x * near.x + y * near.y + near.spread * square_root(x * x + y * y);
                    double excess = larger(gain * closing - near.bound, 0.0) / gain;
                    x = x - excess * near.x;
                    y = y - excess * near.y;
                }
            clip(&x, &y, longest);
        }
        pull[2 * robot + X] = x;
        pull[2 * robot + Y] = y;
    }
}

/* Largest speed of a robot that moves along the unit vector (x, y), for one near peer. */
static double speed_bound(const Near *near, double x, double y) {
    double ahead = x * near->x + y * near->y;
    double aside = magnitude(x * near->y - y * near->x);
    double narrow = square_root(1.0 - near->spread * near->spread);
    double cosine = ahead >= narrow ? 1.0 : ahead * narrow + aside * near->spread;
    cosine = near->spread < 1.0 ? cosine : 1.0; /* the peer can be in every direction */
    return cosine > 0.0 ? near->bound / cosine : infinity();
}

/* Step 3: bounds on the linear speeds. A robot that cannot have heard a peer yet does not drive. */
void separation_slow_down(const Crew *crew, const Input *input, const State *now) {
    Near near;
    for (i64 robot = 0; robot < crew->robots; robot++) {
        double *twist = now->twists + TWIST * robot;
        double speed = input->tick - now->since[robot] < 2 ? 0.0 : twist[LINEAR];
        double half_turn = 0.5 * crew->dt * twist[ANGULAR], sine, cosine, turn_sine, turn_cosine;
        double bound = infinity();
        int has_peers = 0;
        for (i64 pair = now->contacts.begin[robot]; pair < now->contacts.begin[robot + 1]; pair++) {
            if (!is_near(crew, input, now, robot, pair, &near)) continue;
            if (!has_peers) {
                fes_sin_cos(input->poses[POSE * robot + HEADING] + half_turn, &sine, &cosine);
                fes_sin_cos(half_turn, &turn_sine, &turn_cosine);
                double sense = (speed > 0.0 ? 1.0 : speed < 0.0 ? -1.0 : 0.0) * (turn_sine * half_turn < 0.0 ? -1.0 : 1.0);
                sine = sense * sine;
                cosine = sense * cosine;
                has_peers = 1;
            }
            bound = smaller(bound, speed_bound(&near, cosine, sine));
        }
        if (has_peers) speed = bound == 0.0 ? 0.0 : smaller(larger(speed, -bound), bound);
        twist[LINEAR] = speed;
    }
}
