/* The kernels of a robot: one function each, in the order of a tick. */
#ifndef FES_LAWS_H
#define FES_LAWS_H

#include "crew.h"

void contacts_update(const Crew *crew, const Input *input, const State *before, Contacts *now);
void rule_select(const Crew *crew, const Contacts *contacts, u8 *selected);
void links_update(const Crew *crew, const Input *input, const State *before, State *now, const u8 *selected);
void formation_pull(const Crew *crew, const State *now, const double *desired, double *pull);
void separation_give_way(const Crew *crew, const Input *input, const State *now, double *pull);
void separation_slow_down(const Crew *crew, const Input *input, const State *now);
void motion_twists(const Crew *crew, const Input *input, const double *pull, double *twists);
void measured_update(const Crew *crew, const Input *input, const State *before, State *now);
void measured_seek(const Crew *crew, const Input *input, State *now);
void measured_fit(const Crew *crew, const double *statistics, double *level, double *exponent);
void perturbation_begin(const Crew *crew, i64 tick, i64 count, const double *estimates, double *baseline);
void perturbation_seek(const Crew *crew, const Input *input, State *now);

/* a sin(beta_0 t) [m] at a time [s]. */
double dither_at(const Crew *crew, double time);
/* S(r) of (16). */
double objective_preference(const Objective *objective, double separation);
/* (ln S)' and (ln S)''. */
void objective_derivatives(const Objective *objective, double separation, double *slope, double *curvature);

#endif
