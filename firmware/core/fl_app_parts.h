/* What the files app_*.c are to each other. */
#ifndef FL_APP_PARTS_H
#define FL_APP_PARTS_H

#include <stdatomic.h>

#include "fl_app_state.h"

/* Reads and writes stay on their side of this line: tick and background share one core, so the compiler
 * alone could reorder what they see of each other. */
static inline void fl_fence(void) { atomic_signal_fence(memory_order_seq_cst); }

static inline const fl_parameters *fl_in_force(const fl_app *app) {
    return &app->tables[app->parameters.in_force].named;
}

static inline int fl_is_on(const fl_app *app) {
    return app->state == FL_STATE_OPEN || app->state == FL_STATE_CLOSED;
}

typedef struct {
    uint8_t reason; /* 0: done */
    uint16_t index;
} fl_answer;

/* app_scale.c: counts to newtons. */
double fl_force(const fl_parameters *p, const fl_sample *sample);

/* app_setpoint.c: set-point in N, and the table a tick further. */
double fl_setpoint(fl_app *app, const fl_measurement *measurement);
void fl_setpoint_begin(fl_app *app);

/* app_effect.c: the force that an effect asks for; a set-point on its way to another effect. */
double fl_effect_setpoint(fl_app *app, const fl_measurement *measurement);
double fl_eased(fl_app *app, double wanted);
fl_answer fl_trigger(fl_app *app, uint8_t number);

/* app_drive.c */
fl_derived fl_derive(const fl_parameters *p);
int32_t fl_duty(const fl_derived *derived, double amplitude);

/* app_safety.c */
void fl_derive_ends(uint32_t ends[4], const fl_parameters *p);
void fl_watch_step(fl_app *app, const fl_sample *sample, const fl_measurement *measurement, int32_t late);
void fl_state_step(fl_app *app, const fl_sample *sample, const fl_measurement *measurement, uint32_t now_us);
int fl_cause_lasts(const fl_app *app);
void fl_raise(fl_app *app, fl_raised raised);

/* app_sensors.c: watch what the sensors tell, and whether one is broken. */
void fl_sensors_step(fl_app *app, const fl_sample *sample, const fl_measurement *measurement, double setpoint);
fl_raised fl_sensors_fault(const fl_app *app, double force);

/* app_parameters.c: index of the first word that is wrong, else FL_NO_INDEX. */
uint16_t fl_check_table(const fl_table *table, fl_built_in built);
void fl_parameters_start(fl_app *app, const fl_parameters *parameters);
void fl_parameters_take(fl_app *app);
fl_answer fl_set(fl_app *app, uint16_t first, const uint8_t *values, uint16_t count);
fl_answer fl_commit(fl_app *app, uint32_t crc);

/* app_waveform.c */
void fl_waveform_take(fl_app *app);
fl_answer fl_waveform(fl_app *app, uint16_t first, const uint8_t *values, uint16_t count);
fl_answer fl_play_table(fl_app *app, const fl_play *play, uint32_t crc);

/* app_telemetry.c */
void fl_keep(fl_app *app, const fl_measurement *m, double setpoint, fl_force_command command);
fl_answer fl_stream(fl_app *app, uint16_t decimation, uint16_t mask);
size_t fl_telemetry(fl_app *app, uint8_t *body);

/* app_session.c */
int fl_is_owned(const fl_app *app);
fl_session *fl_session_of(fl_app *app, uint32_t id);
uint32_t fl_hello(fl_app *app, uint16_t sequence, uint32_t nonce);
fl_answer fl_admit(const fl_app *app, const fl_session *session, uint8_t type, const uint8_t *body);

/* app_replies.c */
void fl_push_reply(fl_app *app, fl_reply reply);

/* Whole numbers in bytes, little-endian. */
static inline uint16_t fl_u16(const uint8_t *b) { return (uint16_t)(b[0] | b[1] << 8); }
static inline uint32_t fl_u32(const uint8_t *b) { return fl_u16(b) | (uint32_t)fl_u16(b + 2) << 16; }
static inline uint8_t *fl_put16(uint8_t *b, uint16_t x) {
    b[0] = (uint8_t)x;
    b[1] = (uint8_t)(x >> 8);
    return b + 2;
}
static inline uint8_t *fl_put32(uint8_t *b, uint32_t x) {
    return fl_put16(fl_put16(b, (uint16_t)x), (uint16_t)(x >> 16));
}

/* Doubles in bytes, likewise. */
static inline double fl_f64(const uint8_t *b) {
    union { uint64_t bits; double x; } whole = {fl_u32(b) | (uint64_t)fl_u32(b + 4) << 32};
    return whole.x;
}
static inline uint8_t *fl_put64(uint8_t *b, double x) {
    union { double x; uint64_t bits; } whole = {x};
    return fl_put32(fl_put32(b, (uint32_t)(whole.bits & UINT32_MAX)), (uint32_t)(whole.bits >> 32));
}

#endif
