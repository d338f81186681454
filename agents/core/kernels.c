/* Each kernel by itself, so that tests can compare it with its twin in numpy. */
#include "laws.h"

enum { CONTACTS, RULE, LINKS, PULL, GIVE_WAY, TWISTS, SLOW_DOWN, MEASURED, MEASURED_SEEK, PERTURBATION_SEEK };

/* Runs one kernel on the states in two buffers. `numbers` is what it takes and gives beside them: the selected
 * contacts, the desired separations or the pull, and the pull or the twists. Returns 0, or -1 for no such kernel. */
FES_API i64 fes_crew_kernel(i64 kernel, const Crew *crew, const Input *input, u8 *before_buffer, i64 before_capacity,
                            u8 *after_buffer, i64 capacity, double *numbers, double *more) {
    State before, now;
    state_at(crew, before_capacity, before_buffer, &before);
    state_at(crew, capacity, after_buffer, &now);
    switch (kernel) {
    case CONTACTS: contacts_update(crew, input, &before, &now.contacts); return 0;
    case RULE: rule_select(crew, &now.contacts, (u8 *)numbers); return 0;
    case LINKS: links_update(crew, input, &before, &now, (const u8 *)numbers); return 0;
    case PULL: formation_pull(crew, &now, numbers, more); return 0;
    case GIVE_WAY: separation_give_way(crew, input, &now, numbers); return 0;
    case TWISTS: motion_twists(crew, input, numbers, more); return 0;
    case SLOW_DOWN: separation_slow_down(crew, input, &now); return 0;
    case MEASURED: measured_update(crew, input, &before, &now); return 0;
    case MEASURED_SEEK: measured_seek(crew, input, &now); return 0;
    case PERTURBATION_SEEK: perturbation_seek(crew, input, &now); return 0;
    default: return -1;
    }
}
