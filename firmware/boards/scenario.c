/* The scenario of scenario.h. */
#include "scenario.h"

enum { TICK_US = 1000000 / FL_TICK_HZ };

void fl_scenario_start(
    fl_scenario *scenario, fl_app *app, const fl_identity *identity, const fl_parameters *table) {
    *scenario = (fl_scenario){FL_DIGEST, FL_DIGEST, 0};
    fl_app_start(app, identity, table);
}

void fl_scenario_tick(fl_scenario *scenario, fl_app *app, uint32_t tick) {
    fl_sample sample = fl_stimulus(tick);
    fl_drive drive = fl_app_tick(app, &sample, tick * TICK_US, 0);
    scenario->drives = fl_digest(scenario->drives, &drive.duty, sizeof drive.duty);
    scenario->drives = fl_digest(scenario->drives, &drive.amplitude, sizeof drive.amplitude);
}

void fl_scenario_background(fl_scenario *scenario, fl_app *app, uint32_t tick) {
    uint8_t bytes[64];
    uint32_t now_us = tick * TICK_US;
    size_t count = fl_stimulus_bytes(tick, bytes);
    if (count > 0) fl_app_receive(app, bytes, count, now_us);
    count = fl_app_transmit(app, bytes, sizeof bytes, now_us);
    scenario->bytes = fl_digest(scenario->bytes, bytes, count);
    scenario->sent += (uint32_t)count;
}

void fl_scenario_run(
    fl_scenario *scenario, fl_app *app, const fl_identity *identity, const fl_parameters *table) {
    fl_scenario_start(scenario, app, identity, table);
    for (uint32_t tick = 0; tick < FL_SCENARIO_TICKS; tick++) {
        fl_scenario_tick(scenario, app, tick);
        fl_scenario_background(scenario, app, tick);
    }
}
