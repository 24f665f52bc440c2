/* The stimulus of stimulus.h. */
#include "stimulus.h"

#include "fl_frame.h"

enum { NONCE = 20261124, SESSION = NONCE + 1, HELLO = 10 }; /* of the first hello since reset; tick */
enum { STROKE = 2500, TOUCH = 9000, LIFTED = 800 }; /* ticks: of a way, of a touch, without */

/* Whole-number hash (the finaliser of MurmurHash3): noise that is a function of the tick. */
static uint32_t noise(uint32_t x) {
    x ^= x >> 16;
    x *= 0x85EBCA6Bu;
    x ^= x >> 13;
    x *= 0xC2B2AE35u;
    return x ^ x >> 16;
}

static int32_t spread(uint32_t x, int32_t counts) {
    return (int32_t)(noise(x) % (uint32_t)(2 * counts + 1)) - counts;
}

fl_sample fl_stimulus(uint32_t tick) {
    uint32_t phase = tick % (2 * STROKE);
    int32_t back = phase >= STROKE;
    int32_t way = (int32_t)(back ? 2 * STROKE - phase : phase); /* 0 to STROKE */
    int32_t lifted = tick % TOUCH >= TOUCH - LIFTED;
    int32_t wave = (int32_t)(tick % 500);
    int32_t force = lifted ? 0 : 6000 + 10 * (wave < 250 ? wave : 500 - wave);
    fl_sample sample;
    sample.position = -20000 + 16 * way + spread(4 * tick, 2);
    sample.load = lifted ? spread(4 * tick + 1, 3) : 8000 + spread(4 * tick + 1, 300);
    sample.force[0] = (back ? -force : force) + spread(4 * tick + 2, 150);
    sample.force[1] = spread(4 * tick + 3, 100);
    if (noise(tick) % 977 == 0) sample.force[0] = back ? -32768 : 32767;
    return sample;
}

static size_t frame(uint8_t *bytes, uint32_t tick, uint8_t type, const uint8_t *body, size_t count) {
    uint8_t plain[FL_HEADER + 8] = {type, (uint8_t)tick, (uint8_t)(tick >> 8)};
    for (int k = 0; k < 4; k++) plain[3 + k] = tick > HELLO ? (uint8_t)(SESSION >> 8 * k) : 0;
    for (size_t k = 0; k < count; k++) plain[FL_HEADER + k] = body[k];
    return fl_frame_encode(bytes, 64, plain, FL_HEADER + count);
}

size_t fl_stimulus_bytes(uint32_t tick, uint8_t *bytes) {
    const uint8_t every_channel[] = {4, 0, 0xFF, 0}; /* every fourth tick */
    const uint8_t closed[] = {FL_STATE_CLOSED};
    const uint8_t hello[] = {FL_MAJOR, NONCE & 255, NONCE >> 8 & 255, NONCE >> 16 & 255, NONCE >> 24};
    if (tick == HELLO) return frame(bytes, tick, FL_MESSAGE_HELLO, hello, sizeof hello);
    if (tick == 20) return frame(bytes, tick, FL_MESSAGE_IDENTIFY, 0, 0);
    if (tick == 40) return frame(bytes, tick, FL_MESSAGE_STREAM, every_channel, sizeof every_channel);
    if (tick == 60) return frame(bytes, tick, FL_MESSAGE_MODE, closed, sizeof closed);
    /* silent for long enough for a fault at 15000 to 17000, cleared and closed again afterwards */
    if (tick > 15000 && tick < 17000) return 0;
    if (tick == 17020) return frame(bytes, tick, FL_MESSAGE_CLEAR, 0, 0);
    if (tick == 17040) return frame(bytes, tick, FL_MESSAGE_MODE, closed, sizeof closed);
    if (tick % 500 == 0) return frame(bytes, tick, FL_MESSAGE_HEARTBEAT, 0, 0);
    return 0;
}

uint64_t fl_digest(uint64_t digest, const void *bytes, size_t count) {
    const uint8_t *byte = bytes;
    while (count-- > 0) digest = (digest ^ *byte++) * 0x100000001B3u;
    return digest;
}
