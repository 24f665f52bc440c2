/* Frames on a byte stream. S. Cheshire and M. Baker, "Consistent overhead byte stuffing", IEEE/ACM
 * Transactions on Networking 7 (2), 1999. A lost receiver finds itself again at the next zero byte. */
#include "fl_frame.h"

typedef struct {
    uint8_t *code, *next;  /* the code byte of the block that grows, the byte after it */
} fl_coder;

static void fl_put(fl_coder *coder, uint8_t byte) { *coder->next++ = byte; }

static void fl_block(fl_coder *coder) {
    coder->code = coder->next;
    fl_put(coder, 1);
}

/* A full block of 254 bytes stands for no zero byte at its end; the next begins only when a byte follows. */
static void fl_code(fl_coder *coder, uint8_t byte) {
    if (*coder->code == 0xFF) fl_block(coder);
    if (byte == 0) {
        fl_block(coder);
        return;
    }
    fl_put(coder, byte);
    (*coder->code)++;
}

size_t fl_frame_encode(uint8_t *out, size_t room, const uint8_t *frame, size_t count) {
    size_t check = count + 2;  /* room is checked once, for the worst case */
    if (count > FL_LARGEST_FRAME || room < check + (check + 253) / 254 + 1) return 0;
    uint16_t crc = fl_crc16(0xFFFF, frame, count);
    fl_coder coder = {out, out};
    fl_block(&coder);
    for (size_t i = 0; i < count; i++) fl_code(&coder, frame[i]);
    fl_code(&coder, (uint8_t)(crc & 0xFF));
    fl_code(&coder, (uint8_t)(crc >> 8));
    fl_put(&coder, 0);
    return (size_t)(coder.next - out);
}

static void fl_keep(fl_decoder *decoder, uint8_t byte) {
    if (decoder->count < sizeof decoder->frame) {
        decoder->frame[decoder->count++] = byte;
    } else {
        decoder->too_long = 1;
    }
}

/* The zero byte came: `frame` holds a frame or is broken; nothing between two zero bytes is neither. */
static int fl_ended(fl_decoder *decoder) {
    int count = decoder->count, begun = decoder->begun, cut = decoder->left != 0 || decoder->too_long;
    decoder->count = 0;
    decoder->begun = decoder->left = decoder->zero = decoder->too_long = 0;
    if (!begun) return 0;
    if (!cut && count >= FL_HEADER + 2) {
        const uint8_t *end = decoder->frame + count - 2;
        uint16_t crc = fl_crc16(0xFFFF, decoder->frame, (size_t)count - 2);
        if (crc == (end[0] | end[1] << 8)) {
            decoder->whole++;
            return count - 2;
        }
    }
    decoder->broken++;
    return 0;
}

int fl_decode(fl_decoder *decoder, uint8_t byte) {
    if (byte == 0) return fl_ended(decoder);
    decoder->begun = 1;
    if (decoder->too_long) return 0;
    if (decoder->left > 0) {
        decoder->left--;
        fl_keep(decoder, byte);
        return 0;
    }
    if (decoder->zero) fl_keep(decoder, 0);
    decoder->left = (uint8_t)(byte - 1);
    decoder->zero = byte != 0xFF;
    return 0;
}
