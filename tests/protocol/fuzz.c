/* Corrupted frames against the decoder, in a loop: prints inputs, accepted wrong, lost after junk, broken.
 *
 * An input is a frame that a line has spoilt, followed by a whole one, which must be accepted whatever came before. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fl_frame.h"

static uint64_t state;

static uint32_t draw(uint32_t below) {  /* SplitMix64 */
    uint64_t z = state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return (uint32_t)((z ^ z >> 31) >> 32) % below;
}

typedef struct { uint8_t bytes[2 * FL_LARGEST_CODED]; size_t count; } line;

static size_t random_frame(uint8_t *frame) {
    size_t count = FL_HEADER + (draw(8) ? draw(24) : draw(FL_LARGEST_BODY + 1));
    uint32_t zeros = draw(4); /* in a frame without any COBS needs more than one block of 254 bytes */
    for (size_t i = 0; i < count; i++) frame[i] = zeros && draw(3) == 0 ? 0 : (uint8_t)(1 + draw(255));
    return count;
}

static void flip(line *spoilt) {
    for (uint32_t times = 1 + draw(4); times > 0; times--) spoilt->bytes[draw((uint32_t)spoilt->count)] ^= 1 << draw(8);
}

static void cut(line *spoilt) {  /* drop a stretch */
    size_t first = draw((uint32_t)spoilt->count), many = 1 + draw((uint32_t)(spoilt->count - first));
    memmove(spoilt->bytes + first, spoilt->bytes + first + many, spoilt->count - first - many);
    spoilt->count -= many;
}

static void repeat(line *spoilt) {  /* send a stretch twice */
    size_t first = draw((uint32_t)spoilt->count), many = 1 + draw((uint32_t)(spoilt->count - first));
    memmove(spoilt->bytes + first + many, spoilt->bytes + first, spoilt->count - first);
    spoilt->count += many;
}

static void noise(line *spoilt) {
    spoilt->count = 1 + draw(FL_LARGEST_CODED);
    for (size_t i = 0; i < spoilt->count; i++) spoilt->bytes[i] = (uint8_t)draw(256);
}

static void spoil(line *spoilt) {
    void (*const ways[])(line *) = {flip, flip, cut, repeat, noise};
    ways[draw(5)](spoilt);
    if (spoilt->count > 0 && spoilt->count <= FL_LARGEST_CODED && draw(4) == 0) ways[draw(3)](spoilt);
}

int main(int count, char **words) {
    uint64_t inputs = strtoull(words[1], 0, 10), wrong = 0, lost = 0;
    static fl_decoder decoder;
    state = count > 2 ? strtoull(words[2], 0, 10) : 0;
    for (uint64_t input = 0; input < inputs; input++) {
        uint8_t frame[FL_LARGEST_FRAME], whole[FL_LARGEST_CODED];
        line spoilt;
        size_t length = random_frame(frame);
        spoilt.count = fl_frame_encode(spoilt.bytes, sizeof spoilt.bytes, frame, length);
        spoil(&spoilt);
        for (size_t i = 0; i <= spoilt.count; i++) {
            int got = fl_decode(&decoder, i < spoilt.count ? spoilt.bytes[i] : 0);
            wrong += got > 0 && ((size_t)got != length || memcmp(decoder.frame, frame, length) != 0);
        }
        length = random_frame(frame);
        size_t coded = fl_frame_encode(whole, sizeof whole, frame, length);
        int got = 0;
        for (size_t i = 0; i < coded; i++) got = fl_decode(&decoder, whole[i]);
        lost += (size_t)got != length || memcmp(decoder.frame, frame, length) != 0;
    }
    printf("%llu %llu %llu %u\n", (unsigned long long)inputs, (unsigned long long)wrong, (unsigned long long)lost,
           (unsigned)decoder.broken);
    return 0;
}
