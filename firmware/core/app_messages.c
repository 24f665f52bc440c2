/* What the host asks: each message is checked, done, and answered. A frame that comes twice does no harm:
 * all that is asked for is a state to be in, but for `play`, which would begin anew and is known by its
 * sequence number. */
#include "fl_app_parts.h"

typedef struct {
    uint8_t type, fixed, item, most; /* bytes; bytes of what is repeated, and how often at most */
} fl_length;

static const fl_length lengths[] = {
    {FL_MESSAGE_IDENTIFY, 0, 0, 0}, {FL_MESSAGE_GET, 4, 0, 0},        {FL_MESSAGE_SET, 2, 4, 64},
    {FL_MESSAGE_COMMIT, 4, 0, 0},   {FL_MESSAGE_WAVEFORM, 2, 2, 128}, {FL_MESSAGE_PLAY, 16, 0, 0},
    {FL_MESSAGE_MODE, 1, 0, 0},     {FL_MESSAGE_STREAM, 4, 0, 0},     {FL_MESSAGE_HEARTBEAT, 0, 0, 0},
    {FL_MESSAGE_CLEAR, 0, 0, 0},    {FL_MESSAGE_STATISTICS, 0, 0, 0},
};
static const fl_answer done = {0, FL_NO_INDEX};

static fl_answer refused(uint8_t reason) { return (fl_answer){reason, FL_NO_INDEX}; }

/* Whether a body is as long as its message; `count` is how many repeated values it has. */
static fl_answer check_length(uint8_t type, size_t bytes, uint16_t *count) {
    for (size_t k = 0; k < sizeof lengths / sizeof lengths[0]; k++) {
        const fl_length *length = &lengths[k];
        if (length->type != type) continue;
        size_t rest = bytes - length->fixed;
        size_t odd = length->item ? rest % length->item : rest;
        if (bytes < length->fixed || odd) return refused(FL_REFUSAL_WRONG_LENGTH);
        *count = length->item ? (uint16_t)(rest / length->item) : 0;
        if (length->item && (*count < 1 || *count > length->most)) return refused(FL_REFUSAL_WRONG_LENGTH);
        return done;
    }
    return refused(FL_REFUSAL_UNKNOWN_MESSAGE);
}

static fl_answer mode(fl_app *app, uint8_t state) {
    if (state > FL_STATE_CLOSED) return refused(FL_REFUSAL_OUT_OF_RANGE);
    if (app->state == FL_STATE_FAULT && !app->asked_clear) return refused(FL_REFUSAL_NOT_NOW);
    app->asked_state = state;
    return done;
}

static fl_answer clear(fl_app *app) {
    if (app->state == FL_STATE_FAULT && fl_cause_lasts(app)) return refused(FL_REFUSAL_STILL_AT_FAULT);
    app->asked_clear = app->state == FL_STATE_FAULT;
    return done;
}

static fl_answer play(fl_app *app, uint16_t sequence, const uint8_t *body) {
    uint32_t crc = fl_crc32(0, body, 16);
    if (app->played && app->played_sequence == sequence && app->played_crc == crc) return done;
    fl_play wanted = {body[0], body[1], fl_u16(body + 2), fl_u32(body + 4), (int32_t)fl_u32(body + 8)};
    fl_answer answer = fl_play_table(app, &wanted, fl_u32(body + 12));
    if (answer.reason == 0) {
        app->played = 1;
        app->played_sequence = sequence;
        app->played_crc = crc;
    }
    return answer;
}

static fl_answer get(fl_app *app, uint16_t first, uint16_t count) {
    if (count < 1 || count > 64) return refused(FL_REFUSAL_OUT_OF_RANGE);
    if (first >= FL_WORDS || count > FL_WORDS - first)
        return (fl_answer){FL_REFUSAL_UNKNOWN_WORD, first < FL_WORDS ? FL_WORDS : first};
    fl_push_reply(app, (fl_reply){FL_MESSAGE_WORDS, 0, 0, first, count});
    return done;
}

/* A reply that tells something: 1 where the message asks for one. */
static int tells(fl_app *app, uint8_t type) {
    uint8_t reply = type == FL_MESSAGE_IDENTIFY     ? FL_MESSAGE_IDENTITY
                    : type == FL_MESSAGE_HEARTBEAT  ? FL_MESSAGE_STATUS
                    : type == FL_MESSAGE_STATISTICS ? FL_MESSAGE_COUNTED
                                                    : 0;
    if (type == FL_MESSAGE_IDENTIFY) app->played = 0; /* a host that begins counts from where it likes */
    if (reply) fl_push_reply(app, (fl_reply){reply, 0, 0, 0, 0});
    return reply != 0;
}

static void handle(fl_app *app, uint8_t type, uint16_t sequence, const uint8_t *body, size_t bytes) {
    uint16_t count = 0;
    fl_answer answer = check_length(type, bytes, &count);
    if (answer.reason == 0) {
        if (tells(app, type)) return;
        switch (type) {
        case FL_MESSAGE_GET: answer = get(app, fl_u16(body), fl_u16(body + 2)); break;
        case FL_MESSAGE_SET: answer = fl_set(app, fl_u16(body), body + 2, count); break;
        case FL_MESSAGE_COMMIT: answer = fl_commit(app, fl_u32(body)); break;
        case FL_MESSAGE_WAVEFORM: answer = fl_waveform(app, fl_u16(body), body + 2, count); break;
        case FL_MESSAGE_PLAY: answer = play(app, sequence, body); break;
        case FL_MESSAGE_MODE: answer = mode(app, body[0]); break;
        case FL_MESSAGE_STREAM: answer = fl_stream(app, fl_u16(body), fl_u16(body + 2)); break;
        case FL_MESSAGE_CLEAR: answer = clear(app); break;
        default: break;
        }
        if (type == FL_MESSAGE_GET && answer.reason == 0) return;
    }
    uint8_t reply = answer.reason ? FL_MESSAGE_REFUSED : FL_MESSAGE_DONE;
    fl_push_reply(app, (fl_reply){reply, answer.reason, sequence, answer.index, 0});
}

/* What only a device says came back over a looped cable: an answer would go round for ever. */
static int said_by_a_device(uint8_t type) {
    static const uint8_t types[] = {
        FL_MESSAGE_IDENTITY, FL_MESSAGE_WORDS, FL_MESSAGE_TELEMETRY, FL_MESSAGE_STATUS,
        FL_MESSAGE_COUNTED,  FL_MESSAGE_DONE,  FL_MESSAGE_REFUSED,   FL_MESSAGE_FAULT,
    };
    for (size_t k = 0; k < sizeof types; k++)
        if (types[k] == type) return 1;
    return 0;
}

/* Frames lost on the way: a step back is a late double or another host. */
static void follow_sequence(fl_app *app, uint8_t type, uint16_t sequence) {
    uint16_t gap = (uint16_t)(sequence - app->last_sequence - 1);
    if (app->heard && type != FL_MESSAGE_IDENTIFY && gap < 32768) app->missed += gap;
    app->heard = 1;
    app->last_sequence = sequence;
}

void fl_app_receive(fl_app *app, const uint8_t *bytes, size_t count, uint32_t now_us) {
    for (size_t k = 0; k < count; k++) {
        fl_fence();
        int length = fl_decode(&app->decoder, bytes[k]);
        const uint8_t *frame = app->decoder.frame;
        if (length < FL_HEADER || said_by_a_device(frame[0])) continue;
        uint16_t sequence = fl_u16(frame + 1);
        app->heard_us = now_us;
        follow_sequence(app, frame[0], sequence);
        handle(app, frame[0], sequence, frame + FL_HEADER, (size_t)length - FL_HEADER);
    }
}
