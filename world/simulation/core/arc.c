/* The unicycle (5), integrated exactly. Twin: fes/model/kinematics.py. */
#include "fes/arithmetic/core/trigonometry.h"
#include "world.h"

void arc_move(const Settings *settings, i64 robots, const double *poses, const double *twists, double *moved) {
    for (i64 robot = 0; robot < robots; robot++) {
        const double *pose = poses + POSE * robot, *twist = twists + TWIST * robot;
        double *next = moved + POSE * robot;
        double half_turn = 0.5 * settings->dt * twist[ANGULAR], middle = pose[HEADING] + half_turn;
        double sine, cosine, turn_sine, turn_cosine;
        fes_sin_cos(half_turn, &turn_sine, &turn_cosine);
        fes_sin_cos(middle, &sine, &cosine);
        /* the chord of an arc of angle 2b has length v dt sin(b)/b */
        double shortening = half_turn == 0.0 ? 1.0 : turn_sine / half_turn;
        double chord = settings->dt * twist[LINEAR] * shortening;
        next[X] = pose[X] + chord * cosine;
        next[Y] = pose[Y] + chord * sine;
        next[HEADING] = fes_wrap(middle + half_turn);
    }
}
