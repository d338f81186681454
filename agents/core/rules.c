/* Neighbor rules: the contacts that a robot selects as neighbors. Twin: agents/laws/neighbor_rules.py. */
#include "laws.h"

/* Separation of a contact; an unknown one is infinitely far. */
static double reach(const Contacts *contacts, i64 pair) {
    return contacts->known[pair] ? contacts->separation[pair] : infinity();
}

/* The two nearest contacts; among equals those of the lowest ids. As numpy sorts, NaN comes last, and unknown contacts
 * take a place. */
static void two_nearest(const Contacts *contacts, i64 first, i64 last, u8 *selected) {
    for (int choice = 0; choice < 2; choice++) {
        i64 nearest = -1;
        double least = 0.0;
        for (i64 pair = first; pair < last; pair++) {
            double value = reach(contacts, pair);
            int is_less = value < least || (least != least && value == value);
            if (selected[pair] || (nearest >= 0 && !is_less)) continue;
            nearest = pair;
            least = value;
        }
        if (nearest >= 0) selected[nearest] = 1;
    }
    for (i64 pair = first; pair < last; pair++) selected[pair] &= contacts->known[pair];
}

/* True if max(d_ik, d_jk) < d_ij, for the positions of (i, j) and (i, k). */
static int excludes(const Contacts *contacts, double length, i64 pair, i64 witness) {
    if (!contacts->known[witness] || !(contacts->separation[witness] < length)) return 0;
    double dx = contacts->x[witness] - contacts->x[pair], dy = contacts->y[witness] - contacts->y[pair];
    return square_root(dx * dx + dy * dy) < length;
}

/* The contacts to which no third robot is closer from both ends, by a share of their length. */
static void relative_neighborhood(const Contacts *contacts, double tolerance, i64 first, i64 last, u8 *selected) {
    for (i64 pair = first; pair < last; pair++) {
        if (!contacts->known[pair]) continue;
        double length = contacts->separation[pair];
        if (tolerance > 0.0) length = (1.0 - tolerance) * length;
        i64 witness = first;
        while (witness < last && !excludes(contacts, length, pair, witness)) witness++;
        selected[pair] = witness == last;
    }
}

void rule_select(const Crew *crew, const Contacts *contacts, u8 *selected) {
    memset(selected, 0, (size_t)contacts->begin[crew->robots]);
    for (i64 robot = 0; robot < crew->robots; robot++) {
        i64 first = contacts->begin[robot], last = contacts->begin[robot + 1];
        if (crew->rule == RELATIVE_NEIGHBORHOOD)
            relative_neighborhood(contacts, crew->tolerance, first, last, selected);
        else if (crew->rule == TWO_NEAREST)
            two_nearest(contacts, first, last, selected);
        else
            memcpy(selected + first, contacts->known + first, (size_t)(last - first));
    }
}
