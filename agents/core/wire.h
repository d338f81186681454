/* The messages of one process at a tick, as bytes. Twins: fes/protocol/messages.py, agents/runtime/marshalling.py. */
#ifndef FES_WIRE_H
#define FES_WIRE_H

#include "crew.h"

/* The messages that came in, and the places for what they hold and for what goes out. */
typedef struct {
    i64 version;                       /* of the protocol */
    const i64 *since;                  /* tick from which each robot takes part [n] */
    const u8 *observations;            /* of the robots, in their order, one after the other */
    const i64 *observation_lengths;    /* [n] */
    i64 senders;
    const u8 *beacons;                 /* by ascending sender, one after the other */
    const i64 *beacon_lengths;         /* [senders] */
    i64 pairs;                         /* room for pairs in range, and for links of the senders */
    i64 links;
    double *poses;                     /* [n, 3] */
    i64 *begin, *in_range;             /* the peers in range */
    u8 *reception;
    i64 *sender_ids, *link_begin, *link_peers;
    double *sender_poses, *estimates, *statistics;
    u8 *selected;
    i64 is_model_free;                 /* 1, 0, or -1 if not known */
    u8 *out;                           /* payloads: the beacons of all robots, then their commands */
    i64 *ends;                         /* of each payload [2 n] */
} Messages;

enum { READ, TOO_LITTLE_ROOM, UNUSUAL };

/* Reads the observations of the tick of the input, and the beacons of the tick before; READ, or why the caller must read
 * them itself. */
int wire_read(const Crew *crew, Messages *messages, Input *input);

/* Where messages are written, and of which robots. */
typedef struct {
    u8 *out;
    i64 *ends;             /* of each payload, after messages->out */
    const u8 *present;     /* marks of the robots with an observation and a command [n]; NULL for all */
    const u8 *decodable;   /* of those with a beacon */
} Sending;

/* Writes the beacons of a tick, then its commands. A robot without a mark has a payload of no bytes. */
void wire_write(const Crew *crew, const Messages *messages, i64 tick, const State *now, const Sending *sending);
/* Writes the observations of a tick, from the input of the crew; returns their end. */
u8 *wire_write_observations(const Crew *crew, const Messages *messages, const Input *input, const Sending *sending);

#endif
