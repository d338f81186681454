/* Reads observations and beacons, and writes beacons and commands. A message that is unusual in any way is left to the
 * Python code, which knows the reasons to reject it. */
#include "wire.h"
#include "fes/arithmetic/core/msgpack.h"

#define MAX_TICK (((i64)1 << 53) - 1)
#define MAX_ID (((i64)1 << 31) - 1)
#define LARGEST_NUMBER 1.7976931348623157e308
#define MAX_DECLARED 256

/* Ascending ids from int32; returns how many, or -1 if they are none, or more than `room`. */
static i64 read_ids(Blob blob, i64 *ids, i64 room) {
    i64 count = blob.length / 4;
    if (blob.length % 4 || count > room) return -1;
    for (i64 i = 0; i < count; i++) {
        int32_t id;
        memcpy(&id, blob.data + 4 * i, 4);
        ids[i] = id;
        if (id < 0 || (i && ids[i] <= ids[i - 1])) return -1;
    }
    return count;
}

/* `count` numbers within MAX_NUMBER of zero; 0 if they are not. */
static int read_numbers(Blob blob, double *numbers, i64 count) {
    if (blob.length != 8 * count) return 0;
    if (count) memcpy(numbers, blob.data, (size_t)blob.length);
    for (i64 i = 0; i < count; i++)
        if (!(magnitude(numbers[i]) <= MAX_NUMBER)) return 0;
    return 1;
}

/* `count` codes from 0 to `highest`; 0 if they are not. */
static int read_codes(Blob blob, u8 *codes, i64 count, u8 highest) {
    if (blob.length != count) return 0;
    for (i64 i = 0; i < count; i++) {
        codes[i] = blob.data[i];
        if (codes[i] > highest) return 0;
    }
    return 1;
}

/* The observation of one robot; its peers follow those of the robots before it. */
static int read_observation(const Crew *crew, Messages *messages, Input *input, i64 row, const u8 *payload) {
    Reader reader = read_message(payload, messages->observation_lengths[row], messages->version, 10);
    i64 tick = read_integer(&reader, MAX_TICK), robot = read_integer(&reader, MAX_ID), first = messages->begin[row];
    for (int i = 0; i < POSE; i++) messages->poses[POSE * row + i] = read_number(&reader, LARGEST_NUMBER);
    Blob peers = read_blob(&reader), reception = read_blob(&reader);
    int is_running = read_code(&reader) == 0xc2; /* not over */
    i64 since = read_integer(&reader, MAX_TICK), fixed = read_integer(&reader, MAX_TICK);
    /* the crew computes with the fixes of its tick: Python locates a robot with another one */
    if (!is_read(&reader) || fixed != tick || !is_running || robot != crew->ids[row] || tick != input->tick ||
        since != messages->since[row])
        return UNUSUAL;
    if (peers.length / 4 > messages->pairs - first) return TOO_LITTLE_ROOM;
    i64 count = read_ids(peers, messages->in_range + first, messages->pairs - first);
    if (count < 0 || !read_codes(reception, messages->reception + first, count, DECODED)) return UNUSUAL;
    messages->begin[row + 1] = first + count;
    return READ;
}

/* The beacon of one sender; its links follow those of the senders before it. */
static int read_beacon(const Crew *crew, Messages *messages, i64 tick, i64 row, const u8 *payload) {
    Reader reader = read_message(payload, messages->beacon_lengths[row], messages->version, 10);
    i64 stamp = read_integer(&reader, MAX_TICK), first = messages->link_begin[row];
    messages->sender_ids[row] = read_integer(&reader, MAX_ID);
    for (int i = 0; i < POSE; i++) messages->sender_poses[POSE * row + i] = read_number(&reader, MAX_NUMBER);
    Blob links = read_blob(&reader), estimates = read_blob(&reader), selected = read_blob(&reader);
    Blob statistics = read_blob(&reader), declared = read_blob(&reader);
    if (!is_read(&reader) || stamp != tick || declared.length > MAX_DECLARED ||
        (row && messages->sender_ids[row] <= messages->sender_ids[row - 1]))
        return UNUSUAL;
    i64 count = read_ids(links, messages->link_peers + first, messages->links - first);
    if (count < 0 || !read_numbers(estimates, messages->estimates + first, count) ||
        !read_codes(selected, messages->selected + first, count, 1) ||
        !read_numbers(statistics, messages->statistics + row * crew->statistics, crew->statistics))
        return UNUSUAL;
    messages->link_begin[row + 1] = first + count;
    return READ;
}

/* True if the beacon of each peer that decoded is there. */
static int are_complete(const Crew *crew, const Messages *messages) {
    for (i64 robot = 0; robot < crew->robots; robot++) {
        i64 sender = 0;
        for (i64 pair = messages->begin[robot]; pair < messages->begin[robot + 1]; pair++) {
            if (messages->reception[pair] != DECODED) continue;
            while (sender < messages->senders && messages->sender_ids[sender] < messages->in_range[pair]) sender++;
            if (sender == messages->senders || messages->sender_ids[sender] != messages->in_range[pair]) return 0;
        }
    }
    return 1;
}

int wire_read(const Crew *crew, Messages *messages, Input *input) {
    messages->begin[0] = messages->link_begin[0] = 0;
    const u8 *payload = messages->observations;
    for (i64 row = 0; row < crew->robots; payload += messages->observation_lengths[row++]) {
        int result = read_observation(crew, messages, input, row, payload);
        if (result != READ) return result;
    }
    payload = messages->beacons;
    for (i64 row = 0; row < messages->senders; payload += messages->beacon_lengths[row++]) {
        int result = read_beacon(crew, messages, input->tick - 1, row, payload);
        if (result != READ) return result;
    }
    Beacons beacons = {messages->senders, messages->sender_ids, messages->sender_poses, messages->link_begin,
                       messages->link_peers, messages->estimates, messages->selected, messages->statistics};
    input->poses = messages->poses;
    input->begin = messages->begin;
    input->in_range = messages->in_range;
    input->reception = messages->reception;
    input->beacons = beacons;
    return are_complete(crew, messages) ? READ : UNUSUAL;
}

/* The start of each message of a robot. */
static Writer started(const Crew *crew, const Messages *messages, i64 tick, i64 robot, u8 *place, int count) {
    Writer writer = {place};
    *writer.next++ = (u8)(0x91 + count);
    write_integer(&writer, messages->version);
    write_integer(&writer, tick);
    write_integer(&writer, crew->ids[robot]);
    return writer;
}

static u8 *write_beacon(const Crew *crew, const Messages *messages, i64 tick, const State *now, i64 robot, u8 *place) {
    Writer writer = started(crew, messages, tick, robot, place, 10);
    i64 first = now->links.begin[robot], count = now->links.begin[robot + 1] - first, q = crew->statistics;
    for (int i = 0; i < POSE; i++) write_number(&writer, now->sent_poses[POSE * robot + i]);
    write_ids(&writer, now->links.peers + first, count);
    write_blob(&writer, now->links.sent + first, 8 * count);
    write_blob(&writer, now->links.selected + first, count);
    write_blob(&writer, now->sent_statistics + q * robot, 8 * q);
    write_blob(&writer, NULL, 0); /* nothing is declared */
    return writer.next;
}

static u8 *write_command(const Crew *crew, const Messages *messages, i64 tick, const State *now, i64 robot, u8 *place) {
    Writer writer = started(crew, messages, tick, robot, place, 9);
    i64 first = now->links.begin[robot], count = now->links.begin[robot + 1] - first;
    i64 links = now->links.begin[crew->robots];
    int rows = crew->seeking == POOLED || crew->seeking == ALONE ? 2 : 0;
    for (int i = 0; i < TWIST; i++) write_number(&writer, now->twists[TWIST * robot + i]);
    write_ids(&writer, now->links.peers + first, count);
    write_blob(&writer, now->links.sent + first, 8 * count);
    write_length(&writer, 8 * rows * count);
    for (int row = 0; row < rows; row++) {
        memcpy(writer.next, now->links.learnt + row * links + first, (size_t)(8 * count));
        writer.next += 8 * count;
    }
    write_blob(&writer, NULL, 0); /* no details */
    *writer.next++ = messages->is_model_free < 0 ? 0xc0 : (u8)(0xc2 + messages->is_model_free);
    return writer.next;
}

void wire_write(const Crew *crew, const Messages *messages, i64 tick, const State *now, const Sending *sending) {
    u8 *place = sending->out;
    i64 *ends = sending->ends;
    for (i64 robot = 0; robot < crew->robots; robot++) {
        if (!sending->decodable || sending->decodable[robot])
            place = write_beacon(crew, messages, tick, now, robot, place);
        *ends++ = place - messages->out;
    }
    for (i64 robot = 0; robot < crew->robots; robot++) {
        if (!sending->present || sending->present[robot])
            place = write_command(crew, messages, tick, now, robot, place);
        *ends++ = place - messages->out;
    }
}

u8 *wire_write_observations(const Crew *crew, const Messages *messages, const Input *input, const Sending *sending) {
    u8 *place = sending->out;
    for (i64 robot = 0; robot < crew->robots; robot++) {
        i64 first = input->begin[robot], count = input->begin[robot + 1] - first;
        if (sending->present[robot]) {
            Writer writer = started(crew, messages, input->tick, robot, place, 10);
            for (int i = 0; i < POSE; i++) write_number(&writer, input->poses[POSE * robot + i]);
            write_ids(&writer, input->in_range + first, count);
            write_blob(&writer, input->reception + first, count);
            *writer.next++ = 0xc2; /* not over */
            write_integer(&writer, messages->since[robot]);
            write_integer(&writer, input->tick); /* the fix is of this tick */
            place = writer.next;
        }
        sending->ends[robot] = place - messages->out;
    }
    return place;
}
