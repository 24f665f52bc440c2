/* What the host asks: each message is checked, done, and answered. What a session asks for is done once: a frame that
 * comes twice is known by its sequence number, and answered as before. */
#include "fl_app_parts.h"

typedef struct {
    uint8_t type, fixed, item, most; /* bytes; bytes of what is repeated, and how often at most */
} fl_length;

static const fl_length lengths[] = {
    {FL_MESSAGE_IDENTIFY, 0, 0, 0},
    {FL_MESSAGE_HELLO, 5, 0, 0},
    {FL_MESSAGE_GET, 4, 0, 0},
    {FL_MESSAGE_SET, 2, 8, FL_WORDS_A_FRAME},
    {FL_MESSAGE_COMMIT, 4, 0, 0},
    {FL_MESSAGE_WAVEFORM, 2, 2, FL_POINTS_A_FRAME},
    {FL_MESSAGE_PLAY, 16, 0, 0},
    {FL_MESSAGE_MODE, 1, 0, 0},
    {FL_MESSAGE_STREAM, 4, 0, 0},
    {FL_MESSAGE_HEARTBEAT, 0, 0, 0},
    {FL_MESSAGE_CLEAR, 0, 0, 0},
    {FL_MESSAGE_STATISTICS, 0, 0, 0},
    {FL_MESSAGE_TRIGGER, 1, 0, 0},
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

/* The session's from the moment of its frame on: the tick that takes it finds its owner alive. */
static fl_answer mode(fl_app *app, uint8_t state, uint32_t session, uint32_t now_us) {
    if (state > FL_STATE_CLOSED) return refused(FL_REFUSAL_OUT_OF_RANGE);
    if (app->state == FL_STATE_FAULT && !app->asked_clear) return refused(FL_REFUSAL_NOT_NOW);
    if (state != FL_STATE_IDLE) { /* who stops it does not own it */
        app->owner = session;
        app->heard_us = now_us;
    }
    fl_fence();
    app->asked_state = state;
    return done;
}

static fl_answer clear(fl_app *app) {
    if (app->state == FL_STATE_FAULT && fl_cause_lasts(app)) return refused(FL_REFUSAL_STILL_AT_FAULT);
    app->asked_clear = app->state == FL_STATE_FAULT;
    return done;
}

static fl_answer play(fl_app *app, const uint8_t *body) {
    fl_play wanted = {body[0], body[1], fl_u16(body + 2), fl_u32(body + 4), (int32_t)fl_u32(body + 8)};
    return fl_play_table(app, &wanted, fl_u32(body + 12));
}

static fl_answer stream(fl_app *app, const uint8_t *body, uint32_t session) {
    fl_answer answer = fl_stream(app, fl_u16(body), fl_u16(body + 2));
    if (answer.reason == 0) app->streamer = session;
    return answer;
}

static fl_answer get(fl_app *app, uint16_t first, uint16_t count) {
    if (count < 1 || count > FL_WORDS_A_FRAME) return refused(FL_REFUSAL_OUT_OF_RANGE);
    if (first >= FL_WORDS || count > FL_WORDS - first)
        return (fl_answer){FL_REFUSAL_UNKNOWN_WORD, first < FL_WORDS ? FL_WORDS : first};
    fl_push_reply(app, (fl_reply){FL_MESSAGE_WORDS, 0, 0, first, count});
    return done;
}

static void answer_with(fl_app *app, uint16_t sequence, fl_answer answer) {
    uint8_t reply = answer.reason ? FL_MESSAGE_REFUSED : FL_MESSAGE_DONE;
    fl_push_reply(app, (fl_reply){reply, answer.reason, sequence, answer.index, 0});
}

enum { COMMANDS, TOLD, NOT_TOLD }; /* what a message is about */

/* What tells and changes nothing, for whoever asks. */
static int tells(fl_app *app, uint8_t type, uint16_t sequence, const uint8_t *body) {
    uint8_t reply = type == FL_MESSAGE_IDENTIFY     ? FL_MESSAGE_IDENTITY
                    : type == FL_MESSAGE_HEARTBEAT  ? FL_MESSAGE_STATUS
                    : type == FL_MESSAGE_STATISTICS ? FL_MESSAGE_COUNTED
                                                    : 0;
    if (reply) fl_push_reply(app, (fl_reply){reply, 0, 0, 0, 0});
    if (type != FL_MESSAGE_GET) return reply ? TOLD : COMMANDS;
    fl_answer answer = get(app, fl_u16(body), fl_u16(body + 2));
    if (answer.reason == 0) return TOLD;
    answer_with(app, sequence, answer);
    return NOT_TOLD;
}

static void greet(fl_app *app, uint16_t sequence, const uint8_t *body) {
    uint32_t id = fl_hello(app, sequence, fl_u32(body + 1));
    fl_push_reply(app, (fl_reply){FL_MESSAGE_WELCOME, 0, sequence, (uint16_t)id, (uint16_t)(id >> 16)});
}

typedef struct {
    uint8_t type;
    uint16_t sequence, count;
    const uint8_t *body;
    uint32_t now_us;
} fl_asked;

static fl_answer commanded(fl_app *app, const fl_session *session, const fl_asked *asked) {
    const uint8_t *body = asked->body;
    fl_answer answer = fl_admit(app, session, asked->type, body);
    if (answer.reason) return answer;
    switch (asked->type) {
    case FL_MESSAGE_SET: return fl_set(app, fl_u16(body), body + 2, asked->count);
    case FL_MESSAGE_COMMIT: return fl_commit(app, fl_u32(body));
    case FL_MESSAGE_WAVEFORM: return fl_waveform(app, fl_u16(body), body + 2, asked->count);
    case FL_MESSAGE_PLAY: return play(app, body);
    case FL_MESSAGE_MODE: return mode(app, body[0], session->id, asked->now_us);
    case FL_MESSAGE_STREAM: return stream(app, body, session->id);
    case FL_MESSAGE_TRIGGER: return fl_trigger(app, body[0]);
    default: return clear(app);
    }
}

/* A frame of a session, by its sequence: new, the last one again, or one that was overtaken. A sign of life is one that
 * is new, whole and not refused. */
static void follow(fl_app *app, fl_session *session, const fl_asked *asked) {
    uint16_t step = (uint16_t)(asked->sequence - session->sequence);
    if (step >= 32768 || (step == 0 && asked->type != session->type)) {
        answer_with(app, asked->sequence, refused(FL_REFUSAL_LATE));
        return;
    }
    int told = tells(app, asked->type, asked->sequence, asked->body);
    if (told != COMMANDS) {
        *session = (fl_session){session->id, asked->sequence, FL_NO_INDEX, asked->type, 0};
        if (told == TOLD && step && session->id == app->owner) app->heard_us = asked->now_us;
        return;
    }
    if (step) {
        fl_answer answer = commanded(app, session, asked);
        *session = (fl_session){session->id, asked->sequence, answer.index, asked->type, answer.reason};
        if (answer.reason == 0 && session->id == app->owner) app->heard_us = asked->now_us;
    }
    answer_with(app, asked->sequence, (fl_answer){session->reason, session->index});
}

static void handle(fl_app *app, uint32_t stamp, fl_asked asked, size_t bytes) {
    fl_answer answer = check_length(asked.type, bytes, &asked.count);
    if (asked.type == FL_MESSAGE_HELLO && bytes && asked.body[0] != FL_MAJOR) /* whatever its length there */
        answer = refused(FL_REFUSAL_WRONG_VERSION);
    if (asked.type == FL_MESSAGE_IDENTIFY) stamp = 0; /* answered in any session, and without */
    fl_session *session = fl_session_of(app, stamp);
    if (answer.reason) answer_with(app, asked.sequence, answer);
    else if (asked.type == FL_MESSAGE_HELLO) greet(app, asked.sequence, asked.body);
    else if (session) follow(app, session, &asked);
    else if (stamp || tells(app, asked.type, asked.sequence, asked.body) == COMMANDS)
        answer_with(app, asked.sequence, refused(FL_REFUSAL_NO_SESSION));
}

/* What only a device says came back over a looped cable: an answer would go round for ever. */
static int said_by_a_device(uint8_t type) {
    static const uint8_t types[] = {
        FL_MESSAGE_IDENTITY, FL_MESSAGE_WORDS, FL_MESSAGE_TELEMETRY, FL_MESSAGE_STATUS,
        FL_MESSAGE_COUNTED,  FL_MESSAGE_DONE,  FL_MESSAGE_REFUSED,   FL_MESSAGE_FAULT,
        FL_MESSAGE_WELCOME,
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
        follow_sequence(app, frame[0], sequence);
        fl_asked asked = {frame[0], sequence, 0, frame + FL_HEADER, now_us};
        handle(app, fl_u32(frame + 3), asked, (size_t)length - FL_HEADER);
    }
}
