/* Reads the beacons and the commands of a tick. A message that is unusual in any way is left to the Python code, which
 * knows the reasons to reject it. */
#include "messages.h"

/* The start of a message of this tick and sender. */
static Reader started(const Batch *batch, i64 index, int fields) {
    Reader reader = read_message(batch->payloads[index], batch->lengths[index], batch->version, fields);
    i64 tick = read_integer(&reader, MAX_TICK), robot = read_integer(&reader, MAX_ID);
    if (tick != batch->tick || robot != batch->senders[index] || robot >= batch->robots) reader.is_broken = 1;
    return reader;
}

/* True for ascending ids of robots of the team, as int32. */
static int are_ids(Blob blob, i64 robots) {
    i64 before = -1;
    if (blob.length % 4) return 0;
    for (i64 at = 0; at < blob.length; at += 4) {
        int32_t id;
        memcpy(&id, blob.data + at, 4);
        if (id <= before) return 0;
        before = id;
    }
    return before < robots;
}

/* True for whole numbers of 64 bits within MAX_NUMBER of zero, at most `most` of them. */
static int are_numbers(Blob blob, i64 most) {
    if (blob.length % 8 || blob.length > 8 * most) return 0;
    for (i64 at = 0; at < blob.length; at += 8) {
        double number;
        memcpy(&number, blob.data + at, 8);
        if (!(magnitude(number) <= MAX_NUMBER)) return 0;
    }
    return 1;
}

static int are_flags(Blob blob, i64 count) {
    if (blob.length != count) return 0;
    for (i64 i = 0; i < count; i++)
        if (blob.data[i] > 1) return 0;
    return 1;
}

static int is_beacon(const Batch *batch, i64 index) {
    Reader reader = started(batch, index, 10);
    for (int i = 0; i < 3; i++) read_number(&reader, MAX_NUMBER);
    Blob links = read_blob(&reader), estimates = read_blob(&reader), selected = read_blob(&reader);
    Blob statistics = read_blob(&reader), declared = read_blob(&reader);
    i64 count = links.length / 4;
    return is_read(&reader) && are_ids(links, batch->robots) && estimates.length == 8 * count &&
           are_numbers(estimates, count) && are_flags(selected, count) && are_numbers(statistics, MAX_STATISTICS) &&
           declared.length <= MAX_DECLARED;
}

/* True if all payloads are beacons that every peer can read. */
FES_API i64 fes_world_beacons(const Batch *batch) {
    for (i64 index = 0; index < batch->count; index++)
        if (!is_beacon(batch, index)) return 0;
    return 1;
}

static double *copied(Blob blob, double *numbers) {
    if (blob.length) memcpy(numbers, blob.data, (size_t)blob.length);
    return numbers + blob.length / 8;
}

/* Reads a command; the place after its numbers, or NULL if it is unusual. */
static double *read_command(const Batch *batch, i64 index, double *twist, Parts *parts, double *numbers) {
    Reader reader = started(batch, index, 9);
    for (int i = 0; i < 2; i++) twist[i] = read_number(&reader, MAX_TWIST);
    Blob links = read_blob(&reader), estimates = read_blob(&reader), learnt = read_blob(&reader);
    Blob details = read_blob(&reader);
    u8 code = read_code(&reader);
    i64 count = links.length / 4;
    if (!is_read(&reader) || (code != 0xc0 && code != 0xc2 && code != 0xc3)) return NULL;
    if (!are_ids(links, batch->robots) || estimates.length != 8 * count || !are_numbers(estimates, count)) return NULL;
    if (!are_numbers(learnt, MAX_LEARNT * count) || !are_numbers(details, MAX_DETAILS)) return NULL;
    if (count && learnt.length / 8 % count) return NULL;
    i64 at = count ? links.data - batch->payloads[index] : 0;
    Parts read = {at, links.length, count, learnt.length / 8, details.length / 8, code == 0xc0 ? -1 : code - 0xc2};
    *parts = read;
    return copied(details, copied(learnt, copied(estimates, numbers)));
}

/* Reads commands: twists [count, 2], parts [count], and one list of all numbers; true if all commands are usual. */
FES_API i64 fes_world_commands(const Batch *batch, double *twists, Parts *parts, double *numbers) {
    for (i64 index = 0; numbers && index < batch->count; index++)
        numbers = read_command(batch, index, twists + 2 * index, parts + index, numbers);
    return numbers != NULL;
}
