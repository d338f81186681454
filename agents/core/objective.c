/* The robots' own half of the index (16): the separations that they prefer. Twin: fes/model/objective.py. */
#include "fes/arithmetic/core/power.h"
#include "laws.h"

double objective_preference(const Objective *objective, double separation) {
    double spread = fes_power(separation / objective->minimum_separation, objective->shape_exponent);
    return fes_one_minus_exp(spread) * fes_exp(-objective->share_of_reach * spread);
}

void objective_derivatives(const Objective *objective, double separation, double *slope, double *curvature) {
    double shape = objective->shape_exponent;
    double spread = fes_power(separation / objective->minimum_separation, shape);
    double reach = objective->share_of_reach * spread;
    /* A/(e^A - 1) is 1 where A is 0, and 0 where A is large */
    double bounded = smaller(larger(spread, 1e-300), 700.0);
    double decay = fes_exp(-bounded), rise = fes_one_minus_exp(bounded);
    double turn = bounded / rise;
    double fall = turn * decay;
    *slope = shape / separation * (fall - reach);
    *curvature = shape / (separation * separation) * (shape * (fall * (1.0 - turn) - reach) - fall + reach);
}
