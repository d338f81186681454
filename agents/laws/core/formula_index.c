/* The index from the channel's formula, which only the oracle knows. Twin: FormulaIndex of agents/laws/oracle.py.
 *
 * A library of its own: no process of a measured run loads it. */
#include "fes/arithmetic/core/power.h"

#define NEARLY_ZERO 1e-9
#define LEAST (-1e9)
#define LEAST_SPREAD 1e-300
#define MOST_SPREAD 1e100
#define AT_ONCE 64

typedef struct {
    double minimum_separation, shape_exponent, share_of_reach;
    double loss, path_loss_exponent;         /* of exp(-loss r^exponent) */
    double midpoint, width;                  /* of a logistic channel */
    i64 is_logistic, is_log;
    double trusted_share, trusted_length;
} Formula;

/* ln p at `count` separations. */
FES_INLINE void log_reception(const Formula *formula, i64 count, const double *r, double *result) {
    if (formula->is_logistic) {
        for (i64 i = 0; i < count; i++) result[i] = -fes_log_sum_exp((r[i] - formula->midpoint) / formula->width);
    } else if (formula->loss == 0.0) {
        memset(result, 0, (size_t)count * sizeof(double));
    } else {
        powers(count, r, formula->path_loss_exponent, result);
        for (i64 i = 0; i < count; i++) result[i] = -formula->loss * result[i];
    }
}

/* 1 / (1 + exp(-z)). */
FES_INLINE double logistic(double z) {
    double decay = fes_exp(-magnitude(z));
    return (z >= 0.0 ? 1.0 : decay) / (1.0 + decay);
}

/* r (ln p)' and r^2 (ln p)'' at `count` separations, from ln p. */
FES_INLINE void reception_slopes(const Formula *formula, i64 count, const double *restrict r,
                                 const double *restrict log, double *restrict loss, double *restrict curve) {
    double exponent = formula->path_loss_exponent, midpoint = formula->midpoint, width = formula->width;
    if (formula->is_logistic) {
        for (i64 i = 0; i < count; i++) {
            double lost = logistic((r[i] - midpoint) / width), per_width = r[i] / width;
            loss[i] = -lost * per_width;
            curve[i] = loss[i] * (1.0 - lost) * per_width;
        }
    } else {
        for (i64 i = 0; i < count; i++) {
            loss[i] = exponent * log[i];
            curve[i] = exponent * (exponent - 1.0) * log[i];
        }
    }
}

/* The slope of the index, or of its logarithm, and half the second derivative. */
FES_INLINE void derive(const Formula *formula, i64 count, int is_log, const double *restrict r,
                       const double *restrict decay, const double *restrict spread, const double *restrict rise,
                       const double *restrict loss, const double *restrict curve, const double *restrict value,
                       double *restrict slope, double *restrict bend) {
    double shape = formula->shape_exponent, share = formula->share_of_reach;
    for (i64 i = 0; i < count; i++) {
        int is_flat = decay[i] <= LEAST;
        double reach = is_flat ? 0.0 : share * spread[i];
        double steep = is_flat ? 0.0 : loss[i], curved = is_flat ? 0.0 : curve[i];
        /* r (ln S)' = s (f - q A) with f = A/(e^A - 1), and r f' = s f (1 - A/(1 - e^-A)) */
        double turn = spread[i] / rise[i];
        double fall = turn * (1.0 - rise[i]);
        double first = (shape * (fall - reach) + steep) / r[i];
        double second = (shape * (shape * (fall * (1.0 - turn) - reach) - fall + reach) + curved) / (r[i] * r[i]);
        slope[i] = is_log ? first : value[i] * first;
        bend[i] = 0.5 * (is_log ? second : value[i] * (second + first * first));
    }
}

/* The index at up to AT_ONCE separations, or its logarithm; its derivatives where `has_slope`. Both flags are
 * constants of each call, and each loop is short: so compilers compute several separations at once. */
FES_INLINE void evaluate(const Formula *given, i64 count, int is_log, int has_slope, const double *restrict separation,
                         double *restrict value, double *restrict slope, double *restrict bend,
                         double *restrict trusted) {
    const Formula formula = *given; /* the results cannot overlap a copy */
    double r[AT_ONCE], ratio[AT_ONCE], spread[AT_ONCE], log[AT_ONCE], decay[AT_ONCE], rise[AT_ONCE];
    double loss[AT_ONCE], curve[AT_ONCE];
    for (i64 i = 0; i < count; i++) {
        r[i] = larger(separation[i], NEARLY_ZERO);
        ratio[i] = r[i] / formula.minimum_separation;
    }
    powers(count, ratio, formula.shape_exponent, spread);
    log_reception(&formula, count, r, log);
    for (i64 i = 0; i < count; i++) {
        spread[i] = clipped(spread[i], LEAST_SPREAD, MOST_SPREAD);
        log[i] = has_slope ? larger(log[i], 2.0 * LEAST) : log[i];
        decay[i] = log[i] - formula.share_of_reach * spread[i];
    }
    for (i64 i = 0; i < count; i++) rise[i] = fes_one_minus_exp(spread[i]);
    if (is_log)
        for (i64 i = 0; i < count; i++) value[i] = larger(decay[i], LEAST) + fes_log(rise[i]);
    else
        for (i64 i = 0; i < count; i++) value[i] = fes_exp(decay[i]) * rise[i];
    if (!has_slope) return;
    reception_slopes(&formula, count, r, log, loss, curve);
    derive(&formula, count, is_log, r, decay, spread, rise, loss, curve, value, slope, bend);
    for (i64 i = 0; i < count; i++) trusted[i] = smaller(formula.trusted_share * separation[i], formula.trusted_length);
}

#define EVALUATE(name, is_log, has_slope)                                                                            \
    FES_WIDE static void name(const Formula *formula, i64 count, const double *separation, double *value,             \
                              double *slope, double *bend, double *trusted) {                                         \
        evaluate(formula, count, is_log, has_slope, separation, value, slope, bend, trusted);                         \
    }

EVALUATE(index_alone, 0, 0)
EVALUATE(index_parabola, 0, 1)
EVALUATE(log_alone, 1, 0)
EVALUATE(log_parabola, 1, 1)

/* The index at `count` separations, its slope, half its second derivative, and the length over which these count. All
 * but the value may be NULL together. */
FES_API void fes_formula_index(const void *settings, i64 count, const double *separation, double *value, double *slope,
                               double *bend, double *trusted) {
    const Formula *formula = settings;
    for (i64 first = 0; first < count; first += AT_ONCE) {
        i64 part = count - first < AT_ONCE ? count - first : AT_ONCE;
        const double *place = separation + first;
        if (!slope)
            (formula->is_log ? log_alone : index_alone)(formula, part, place, value + first, NULL, NULL, NULL);
        else
            (formula->is_log ? log_parabola : index_parabola)(formula, part, place, value + first, slope + first,
                                                              bend + first, trusted + first);
    }
}
