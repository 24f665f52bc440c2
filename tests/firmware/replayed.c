/* Sensors' readings through the whole firmware, beside the plate's own amplitude: which faults they raise.
 *
 * After a fault the board is idle for a second, and then on again. */
#include "fl_app_parts.h"

enum { REST = FL_TICK_HZ };

/* `samples` has force along and across, position and load, a row a tick, `amplitudes` that of the plate in um; `told`
 * gets tick, fault and value of at most `room` faults. Returns how many there were. */
int32_t fl_replayed(
    const double *words, int32_t count, const int32_t *samples, const double *setpoints, const double *amplitudes,
    int32_t room, double *told) {
    static fl_app app;
    static const fl_identity identity = {FL_BOARD_HOST, 0, "replayed", FL_RESET_POWER_ON};
    fl_app_start(&app, &identity, (const fl_parameters *)words);
    int32_t found = 0, rest = 0;
    app.state = FL_STATE_OPEN;
    for (int32_t k = 0; k < count; k++, samples += 4) {
        fl_sample sample = {{samples[0], samples[1]}, samples[2], samples[3]};
        app.tables[0].named.setpoint_hold_n = setpoints[k];
        app.heard_us = (uint32_t)k * 200;
        app.amplitude = amplitudes[k];
        fl_app_tick(&app, &sample, app.heard_us, 0);
        if (app.state == FL_STATE_FAULT) {
            if (found < room) {
                told[3 * found] = k;
                told[3 * found + 1] = app.fault;
                told[3 * found + 2] = app.raised.value;
            }
            found++;
            app.state = FL_STATE_IDLE;
            app.fault = FL_FAULT_NONE;
            rest = REST;
        }
        if (rest && --rest == 0) app.state = FL_STATE_OPEN;
    }
    return found;
}
