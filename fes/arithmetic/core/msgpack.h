/* The few forms of msgpack that messages between world and agents have, read with bounds and written.
 *
 * A reader that meets anything else, or the end of the bytes, is broken from then on: it gives zeros.
 * Twin: fes/protocol/wire.py. */
#ifndef FES_MSGPACK_H
#define FES_MSGPACK_H

#include "fes/arithmetic/core/exact.h"

typedef struct {
    const u8 *next, *end;
    int is_broken;
} Reader;

/* A part of a message, as bytes. */
typedef struct {
    const u8 *data;
    i64 length;
} Blob;

/* The next `count` bytes, or NULL. */
FES_INLINE const u8 *read_bytes(Reader *reader, i64 count) {
    if (reader->is_broken || count > reader->end - reader->next) {
        reader->is_broken = 1;
        return NULL;
    }
    const u8 *bytes = reader->next;
    reader->next += count;
    return bytes;
}

/* The next byte, or 0xc1, which msgpack never uses. */
FES_INLINE u8 read_code(Reader *reader) {
    const u8 *byte = read_bytes(reader, 1);
    return byte ? *byte : 0xc1;
}

/* A number of `size` bytes, the highest first. */
FES_INLINE u64 read_word(Reader *reader, int size) {
    const u8 *bytes = read_bytes(reader, size);
    u64 word = 0;
    for (int i = 0; bytes && i < size; i++) word = word << 8 | bytes[i];
    return word;
}

/* An integer from 0 to `most`. */
FES_INLINE i64 read_integer(Reader *reader, i64 most) {
    u8 code = read_code(reader);
    u64 value = code < 0x80 ? code : 0;
    if (code >= 0xcc && code <= 0xcf)
        value = read_word(reader, 1 << (code - 0xcc));
    else if (code >= 0x80)
        reader->is_broken = 1;
    if (value > (u64)most) reader->is_broken = 1;
    return reader->is_broken ? 0 : (i64)value;
}

/* A finite number within `most` of zero. */
FES_INLINE double read_number(Reader *reader, double most) {
    if (read_code(reader) != 0xcb) reader->is_broken = 1;
    double value = from_bits(read_word(reader, 8));
    if (!(magnitude(value) <= most)) reader->is_broken = 1;
    return reader->is_broken ? 0.0 : value;
}

FES_INLINE Blob read_blob(Reader *reader) {
    u8 code = read_code(reader);
    Blob blob = {NULL, 0};
    if (code < 0xc4 || code > 0xc6) {
        reader->is_broken = 1;
        return blob;
    }
    blob.length = (i64)read_word(reader, 1 << (code - 0xc4));
    blob.data = read_bytes(reader, blob.length);
    if (!blob.data) blob.length = 0;
    return blob;
}

/* An array that starts with the version of the protocol, of `count` entries beside it. */
FES_INLINE Reader read_message(const u8 *bytes, i64 length, i64 version, int count) {
    Reader reader = {bytes, bytes + length, length > (1 << 20)};
    if (read_code(&reader) != (u8)(0x91 + count) || read_integer(&reader, 127) != version) reader.is_broken = 1;
    return reader;
}

/* True if the whole message was read. */
FES_INLINE int is_read(const Reader *reader) { return !reader->is_broken && reader->next == reader->end; }

/* A writer without bounds: its caller has made room. */
typedef struct {
    u8 *next;
} Writer;

FES_INLINE void write_word(Writer *writer, u8 code, u64 word, int size) {
    *writer->next++ = code;
    for (int i = size - 1; i >= 0; i--) *writer->next++ = (u8)(word >> (8 * i));
}

FES_INLINE void write_integer(Writer *writer, i64 value) {
    u64 word = (u64)value;
    if (word < 0x80)
        *writer->next++ = (u8)word;
    else if (word < 0x100)
        write_word(writer, 0xcc, word, 1);
    else if (word < 0x10000)
        write_word(writer, 0xcd, word, 2);
    else if (word < 0x100000000)
        write_word(writer, 0xce, word, 4);
    else
        write_word(writer, 0xcf, word, 8);
}

FES_INLINE void write_number(Writer *writer, double value) { write_word(writer, 0xcb, bits(value), 8); }

/* The head of `length` bytes that follow. */
FES_INLINE void write_length(Writer *writer, i64 length) {
    if (length < 0x100)
        write_word(writer, 0xc4, (u64)length, 1);
    else if (length < 0x10000)
        write_word(writer, 0xc5, (u64)length, 2);
    else
        write_word(writer, 0xc6, (u64)length, 4);
}

FES_INLINE void write_blob(Writer *writer, const void *data, i64 length) {
    write_length(writer, length);
    if (length) memcpy(writer->next, data, (size_t)length);
    writer->next += length;
}

/* Ids as int32. */
FES_INLINE void write_ids(Writer *writer, const i64 *ids, i64 count) {
    write_length(writer, 4 * count);
    for (i64 i = 0; i < count; i++) {
        int32_t id = (int32_t)ids[i];
        memcpy(writer->next, &id, 4);
        writer->next += 4;
    }
}

#endif
