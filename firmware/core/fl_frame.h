/* Frames: COBS(header, body, CRC-16) and a zero byte, which stands nowhere else. */
#ifndef FL_FRAME_H
#define FL_FRAME_H

#include <stddef.h>

#include "fl_protocol.h"

enum {
    FL_HEADER = 7,                                   /* bytes: type, sequence, stamp */
    FL_LARGEST_FRAME = FL_HEADER + FL_LARGEST_BODY,  /* header and body */
    FL_LARGEST_CODED = FL_LARGEST_FRAME + 2 + 2 + 1  /* with CRC, COBS's byte per 254 begun, zero byte */
};
_Static_assert(FL_LARGEST_FRAME + 2 <= 2 * 254, "two code bytes are enough");

/* The receiving end of a link; all zero at first. `frame` holds header and body until the next byte. */
typedef struct {
    uint8_t frame[FL_LARGEST_FRAME + 2];
    uint16_t count;      /* bytes of `frame` so far */
    uint8_t begun;       /* a byte other than zero came since the last zero byte */
    uint8_t left;        /* bytes until the next code byte */
    uint8_t zero;        /* the block that ends then stands for a zero byte */
    uint8_t too_long;    /* wait for the zero byte */
    uint32_t whole;      /* frames accepted */
    uint32_t broken;     /* frames with a wrong length, code or CRC */
} fl_decoder;

/* Code `count` bytes of header and body; returns the bytes written, 0 where they do not fit. */
size_t fl_frame_encode(uint8_t *out, size_t room, const uint8_t *frame, size_t count);

/* Take one byte; returns the length of a whole header and body in decoder->frame, else 0. */
int fl_decode(fl_decoder *decoder, uint8_t byte);

/* CRC-16/IBM-3740: polynomial 0x1021, no reflection. Begin with 0xFFFF; go on with what came out. */
uint16_t fl_crc16(uint16_t crc, const uint8_t *bytes, size_t count);

/* CRC-32 of zlib (ISO-HDLC). Begin with 0; go on with what came out. */
uint32_t fl_crc32(uint32_t crc, const uint8_t *bytes, size_t count);

#endif
