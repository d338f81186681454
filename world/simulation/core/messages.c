/* Reads the beacons and the commands of a tick. A message that is unusual in any way is left to the Python code, which
 * knows the reasons to reject it. */
#include "messages.h"

/* The start of a message of this tick and sender. */
static Reader started(const Batch *batch, Blob payload, i64 sender, int fields) {
    Reader reader = read_message(payload.data, payload.length, batch->version, fields);
    i64 tick = read_integer(&reader, MAX_TICK), robot = read_integer(&reader, MAX_ID);
    if (tick != batch->tick || robot != sender || robot >= batch->robots) reader.is_broken = 1;
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

/* True for numbers of 64 bits within MAX_NUMBER of zero, at most `most` of them. */
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

static int is_beacon(const Batch *batch, Blob payload, i64 sender) {
    Reader reader = started(batch, payload, sender, 10);
    for (int i = 0; i < 3; i++) read_number(&reader, MAX_NUMBER);
    Blob links = read_blob(&reader), estimates = read_blob(&reader), selected = read_blob(&reader);
    Blob statistics = read_blob(&reader), declared = read_blob(&reader);
    i64 count = links.length / 4;
    return is_read(&reader) && are_ids(links, batch->robots) && estimates.length == 8 * count &&
           are_numbers(estimates, count) && are_flags(selected, count) && are_numbers(statistics, MAX_STATISTICS) &&
           declared.length <= MAX_DECLARED;
}

/* True if all payloads are beacons that every peer can read; `lengths` and `senders` are [count]. */
FES_API i64 fes_world_beacons(const Batch *batch, const u8 *data, const i64 *lengths, const i64 *senders) {
    for (i64 index = 0; index < batch->count; data += lengths[index++]) {
        Blob payload = {data, lengths[index]};
        if (!is_beacon(batch, payload, senders[index])) return 0;
    }
    return 1;
}

static double *copied(Blob blob, double *numbers) {
    if (blob.length) memcpy(numbers, blob.data, (size_t)blob.length);
    return numbers + blob.length / 8;
}

/* Reads a command that begins `at` bytes after the first byte of the batch; the place after its numbers, or NULL if it
 * is unusual. */
static double *read_command(const Batch *batch, Blob payload, i64 at, i64 sender, double *twist, Parts *parts,
                            double *numbers) {
    Reader reader = started(batch, payload, sender, 9);
    for (int i = 0; i < 2; i++) twist[i] = read_number(&reader, MAX_TWIST);
    Blob links = read_blob(&reader), estimates = read_blob(&reader), learnt = read_blob(&reader);
    Blob details = read_blob(&reader);
    u8 code = read_code(&reader);
    i64 count = links.length / 4;
    if (!is_read(&reader) || (code != 0xc0 && code != 0xc2 && code != 0xc3)) return NULL;
    if (!are_ids(links, batch->robots) || estimates.length != 8 * count || !are_numbers(estimates, count)) return NULL;
    if (!are_numbers(learnt, MAX_LEARNT * count) || !are_numbers(details, MAX_DETAILS)) return NULL;
    if (count && learnt.length / 8 % count) return NULL;
    parts->links_at = count ? at + (links.data - payload.data) : 0;
    parts->links_length = links.length;
    parts->estimates = count;
    parts->learnt = learnt.length / 8;
    parts->details = details.length / 8;
    parts->is_model_free = code == 0xc0 ? -1 : code - 0xc2;
    return copied(details, copied(learnt, copied(estimates, numbers)));
}

/* Reads commands: twists [count, 2], parts [count], and one list of all numbers; true if all commands are usual. */
FES_API i64 fes_world_commands(const Batch *batch, const u8 *data, const i64 *lengths, const i64 *senders,
                               double *twists, Parts *parts, double *numbers) {
    for (i64 index = 0, at = 0; numbers && index < batch->count; at += lengths[index++]) {
        Blob payload = {data + at, lengths[index]};
        numbers = read_command(batch, payload, at, senders[index], twists + 2 * index, parts + index, numbers);
    }
    return numbers != NULL;
}
