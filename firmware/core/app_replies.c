/* What the device says: a fault first, then replies in the order they were asked for, then telemetry. */
#include <string.h>

#include "fl_app_parts.h"

/* With no room for the answer there is none, and the host asks again. */
void fl_push_reply(fl_app *app, fl_reply reply) {
    if (app->reply_count == FL_REPLIES) return;
    app->replies[(app->first_reply + app->reply_count) % FL_REPLIES] = reply;
    app->reply_count++;
}

/* Text in so many bytes, padded with zeros. */
static uint8_t *text(uint8_t *at, const char *said, size_t bytes) {
    memset(at, 0, bytes);
    for (size_t k = 0; k < bytes && said && said[k]; k++) at[k] = (uint8_t)said[k];
    return at + bytes;
}

static uint8_t *identity(const fl_app *app, uint8_t *at) {
    *at++ = FL_MAJOR;
    *at++ = FL_MINOR;
    *at++ = app->identity.board;
    at = fl_put32(fl_put32(at, FL_TICK_HZ), FL_TABLE_HASH);
    at = fl_put32(fl_put16(fl_put16(at, FL_WORDS), FL_POINTS), app->identity.serial);
    at = fl_put32(text(text(at, app->identity.revision, 16), fl_own.kind, 32), fl_own.hash);
    *at++ = app->identity.reset;
    return at;
}

static uint8_t *words(const fl_app *app, const fl_reply *reply, uint8_t *at) {
    const fl_table *table = &app->tables[app->parameters.in_force];
    at = fl_put16(at, reply->first);
    for (uint16_t k = 0; k < reply->count; k++) at = fl_put64(at, table->words[reply->first + k]);
    return at;
}

static uint8_t *status(const fl_app *app, uint8_t *at) {
    *at++ = app->state;
    *at++ = app->fault;
    at = fl_put16(fl_put32(at, app->tick), app->commits);
    *at++ = app->identity.reset;
    return at;
}

static uint8_t *counted(const fl_app *app, uint8_t *at) {
    uint32_t counts[] = {app->tick,           app->overruns, app->longest, app->decoder.whole,
                         app->decoder.broken, app->missed,   app->dropped};
    for (size_t k = 0; k < sizeof counts / sizeof counts[0]; k++) at = fl_put32(at, counts[k]);
    return at;
}

static uint8_t *refused(const fl_reply *reply, uint8_t *at) {
    at = fl_put16(at, reply->sequence);
    *at++ = reply->reason;
    return fl_put16(at, reply->first);
}

static uint8_t *answered(const fl_app *app, const fl_reply *reply, uint8_t *at) {
    switch (reply->type) {
    case FL_MESSAGE_IDENTITY: return identity(app, at);
    case FL_MESSAGE_WORDS: return words(app, reply, at);
    case FL_MESSAGE_STATUS: return status(app, at);
    case FL_MESSAGE_COUNTED: return counted(app, at);
    case FL_MESSAGE_WELCOME: return fl_put16(fl_put16(fl_put16(at, reply->sequence), reply->first), reply->count);
    case FL_MESSAGE_REFUSED: return refused(reply, at);
    default: return fl_put16(at, reply->sequence);
    }
}

static uint8_t *fault(fl_app *app, uint8_t *at) {
    app->tell_fault = 0;
    fl_fence();
    *at++ = app->raised.fault;
    return fl_put64(fl_put32(at, app->raised.tick), app->raised.value);
}

/* Body of the next frame and its type; 0 where there is none. */
static uint8_t next_body(fl_app *app, uint8_t *body, size_t *count) {
    if (app->tell_fault) {
        *count = (size_t)(fault(app, body) - body);
        return FL_MESSAGE_FAULT;
    }
    if (app->reply_count) {
        const fl_reply *reply = &app->replies[app->first_reply];
        *count = (size_t)(answered(app, reply, body) - body);
        app->first_reply = (app->first_reply + 1) % FL_REPLIES;
        app->reply_count--;
        return reply->type;
    }
    *count = fl_telemetry(app, body);
    return *count ? FL_MESSAGE_TELEMETRY : 0;
}

static int next_frame(fl_app *app, uint32_t now_us) {
    uint8_t frame[FL_LARGEST_FRAME];
    size_t count = 0;
    frame[0] = next_body(app, frame + FL_HEADER, &count);
    if (frame[0] == 0) return 0;
    fl_put32(fl_put16(frame + 1, app->sequence), now_us);
    app->sequence++;
    app->coded = (uint16_t)fl_frame_encode(app->out, sizeof app->out, frame, FL_HEADER + count);
    app->sent = 0;
    return 1;
}

size_t fl_app_transmit(fl_app *app, uint8_t *bytes, size_t room, uint32_t now_us) {
    size_t filled = 0;
    fl_fence();
    while (filled < room) {
        if (app->sent == app->coded && !next_frame(app, now_us)) break;
        size_t left = (size_t)(app->coded - app->sent), some = left < room - filled ? left : room - filled;
        memcpy(bytes + filled, app->out + app->sent, some);
        app->sent += (uint16_t)some;
        filled += some;
    }
    return filled;
}
