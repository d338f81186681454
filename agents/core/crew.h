/* The data of a crew: its constants, its inputs at a tick, and its state in one buffer.
 *
 * Twins: agents/control/state.py, fes/model/contacts.py and fes/model/sensing.py. Pairs (robot, peer) lie one after
 * the other, those of robot i from begin[i] to begin[i + 1], by ascending peer: fes/arrays/edges.py. */
#ifndef FES_CREW_H
#define FES_CREW_H

#include "fes/arithmetic/core/exact.h"

enum { X, Y, HEADING, POSE };                     /* columns of poses */
enum { LINEAR, ANGULAR, TWIST };                  /* columns of twists */
enum { LOST = 1, DECODED = 2 };                   /* reception of a peer's last beacon */
enum { DISK, TWO_NEAREST, RELATIVE_NEIGHBORHOOD }; /* neighbor rules */
enum { ORACLE, SAMPLED, POOLED, ALONE };          /* seeking laws */
enum { ESTIMATE, DRIFT, BASELINE, ROWS };         /* rows of the state of a link */
enum { NODES = 5, STATISTICS = 5 };

#define NEVER (-((i64)1 << 62)) /* the tick of a beacon that was never heard */
#define MAX_NUMBER 1e12
#define MAX_TWIST 1e9

/* An index at separations: its value, its slope, half its second derivative, and the length over which that parabola
 * counts. All but the value may be NULL together. */
typedef void (*Index)(const void *settings, i64 count, const double *separation, double *value, double *slope,
                      double *bend, double *trusted);

/* The linear part of (18) over a sub-step: agents/laws/collocation.py. */
typedef struct {
    double nodes[NODES];
    double washout_start[NODES + 1];
    double washout_input[NODES + 1][NODES];
    double path_start[NODES + 2][3];
    double path_input[NODES + 2][NODES];
} Step;

/* The preference S(r) of (16): fes/model/objective.py. */
typedef struct {
    double minimum_separation, maximum_separation, shape_exponent, share_of_reach;
} Objective;

/* A learner of the channel: agents/laws/packet_counting.py. */
typedef struct {
    double short_share, long_share;     /* that remain after a tick */
    double slope_prior[2], slopes[2];
    double gain;
    double scale;                       /* rho_0 [m] */
} Method;

/* The constants of a crew. */
typedef struct {
    i64 robots;
    const i64 *ids;
    const i64 *first;                   /* of each robot's run: the id in the crew of its robot 0 [n] */
    const u64 *estimate_keys, *stagger_keys; /* of the streams of first estimates and of phases [n, 2] */
    double dt;
    i64 timeout;                        /* of a contact [ticks] */
    i64 rule;
    double tolerance;
    i64 seeking;
    i64 statistics;                     /* numbers in a beacon: STATISTICS, or 0 */
    double low_estimate, high_estimate;
    double dither_amplitude, dither_frequency;
    double consensus_gain;
    i64 extrapolates;
    i64 sub_steps;
    double index_gain;
    Step coupled, alone;
    Index index;
    const void *index_settings;
    Objective objective;
    Method method;
    double linear_gain, angular_gain;
    double linear_limit, angular_limit; /* infinite without one */
    double safe_separation;             /* negative without one */
    double separation_gain, give_way_gain;
} Crew;

/* Beacons of one tick: fes.model.sensing.Beacons. */
typedef struct {
    i64 count;                          /* -1: those that the crew itself has sent */
    const i64 *ids;
    const double *poses;
    const i64 *begin, *peers; /* of the links */
    const double *estimates;
    const u8 *selected;
    const double *statistics;
} Beacons;

/* The inputs of a tick. */
typedef struct {
    i64 tick;
    const double *poses;
    const double *skew;             /* of each robot's clock [n] [s]; NULL if all are exact */
    const i64 *begin, *in_range;    /* the peers in range */
    const u8 *reception;
    Beacons beacons;                /* of the tick before */
} Input;

/* Contacts: fes.model.contacts.Contacts. */
typedef struct {
    i64 *begin, *peers, *heard;
    double *x, *y, *heading, *estimates, *heard_separation, *dx, *dy, *separation, *statistics;
    u8 *selected_by_peer, *known, *is_link;
    i64 *heard_before;              /* only within a tick: the values before it */
    double *separation_before;
} Contacts;

/* Links, and the seeking state over them. */
typedef struct {
    i64 *begin, *rows, *peers, *contact;
    double *state;                  /* [ROWS, capacity]; a measured law has estimates only */
    double *ahead;
    u8 *selected;
    double *sent;                   /* the estimates in the beacons */
    double *learnt;                 /* [2, capacity] */
} Links;

/* The state of a crew in a buffer, and what it sends. */
typedef struct {
    i64 capacity;                   /* of contacts, and of links */
    double *poses;                  /* own poses at the last tick */
    i64 *linked_since, *since;
    Contacts contacts;
    Links links;
    double *fit;                    /* statistics of each learner [g, STATISTICS] */
    double *level, *exponent;       /* of each learner [g] */
    double *twists, *sent_poses, *sent_statistics;
} State;

/* The places of a state in a buffer; returns its length [bytes]. */
i64 state_at(const Crew *crew, i64 capacity, u8 *buffer, State *state);

#endif
