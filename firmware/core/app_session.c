/* Who may command: a host that said hello has a session. The loop is its who closed it, until it is off. */
#include "fl_app_parts.h"

/* Also between the request and the tick that takes it. */
int fl_is_owned(const fl_app *app) {
    uint8_t asked = app->asked_state;
    return fl_is_on(app) || asked == FL_STATE_OPEN || asked == FL_STATE_CLOSED;
}

fl_session *fl_session_of(fl_app *app, uint32_t id) {
    for (int k = 0; k < 2; k++)
        if (id && app->sessions[k].id == id) return &app->sessions[k];
    return 0;
}

/* A session of its own for each hello, so that nothing said in an earlier one is taken again. The same hello that comes
 * twice is answered alike. */
uint32_t fl_hello(fl_app *app, uint16_t sequence, uint32_t nonce) {
    const fl_session *same = fl_session_of(app, nonce + app->hellos);
    if (same) return same->id;
    fl_session *owner = fl_is_owned(app) ? fl_session_of(app, app->owner) : 0;
    fl_session *other = owner == app->sessions ? app->sessions + 1 : app->sessions;
    if (!owner) app->sessions[1].id = 0;
    uint32_t id;
    do id = nonce + ++app->hellos;
    while (id == 0 || (owner && id == owner->id));
    *other = (fl_session){id, sequence, FL_NO_INDEX, FL_MESSAGE_HELLO, 0};
    return id;
}

/* While the loop is on it is one session's. Telemetry that nobody gets is for whoever asks, and anyone may stop. */
fl_answer fl_admit(const fl_app *app, const fl_session *session, uint8_t type, const uint8_t *body) {
    int is_free = type == FL_MESSAGE_STREAM && (app->decimation == 0 || app->streamer == session->id);
    if (type == FL_MESSAGE_MODE && body[0] == FL_STATE_IDLE) is_free = 1;
    uint8_t refused = fl_is_owned(app) && session->id != app->owner && !is_free;
    return (fl_answer){refused ? FL_REFUSAL_NOT_OWNER : 0, FL_NO_INDEX};
}
