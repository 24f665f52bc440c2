/* The scenario in the timer's interrupt and the background, for -icount runs: prints the digests and ends.
 *
 * The background may take longer than a tick, to make a frame of telemetry; the interrupt then passes one
 * by, so that the order is the host's, whatever the speed. */
#include "built.h"
#include "fl_app_state.h"
#include "mps2.h"
#include "scenario.h"

volatile uint32_t fl_ticks;
static fl_app state;
static fl_app *const app = &state;
static fl_scenario scenario;
static volatile uint32_t served, passed, late;

void fl_tick(int32_t tick_late) {
    if (fl_ticks >= FL_SCENARIO_TICKS) return;
    late += (uint32_t)tick_late;
    if (served != fl_ticks) {
        passed++;
        return;
    }
    fl_scenario_tick(&scenario, app, fl_ticks);
    fl_ticks++;
}

static void print(const char *name, uint64_t value) {
    char text[] = " 0000000000000000\n";
    for (int k = 0; k < 16; k++) text[16 - k] = "0123456789abcdef"[value >> 4 * k & 15];
    semihosting_write(name);
    semihosting_write(text);
}

int main(void) {
    board_start();
    fl_scenario_start(&scenario, app, &board_identity, board_is_whole() ? &fl_built_parameters.table : 0);
    board_run();
    for (uint32_t tick = 0; tick < FL_SCENARIO_TICKS; tick++) {
        while (fl_ticks == tick) {}
        fl_scenario_background(&scenario, app, tick);
        served = tick + 1;
    }
    print("drives", scenario.drives);
    print("bytes", scenario.bytes);
    print("sent", scenario.sent);
    print("passed", passed);
    print("late", late);
    semihosting_exit(0);
}
