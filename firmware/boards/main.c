/* The main program of every board: the tick in the timer's interrupt, the host in the background. */
#include "board.h"
#include "built.h"
#include "fl_app_state.h"

static fl_app state;
static fl_app *const app = &state;
volatile uint32_t fl_ticks;

void fl_tick(int32_t late) {
    fl_sample sample = board_sample();
    fl_drive drive = fl_app_tick(app, &sample, fl_ticks * FL_TICK_US, late);
    board_drive(drive.duty);
    fl_ticks++;
    fl_app_took(app, board_took());
}

/* One turn of the background; returns 0 when no byte moved: then only an interrupt brings anything new. */
static int serve(void) {
    static uint8_t out[64];
    static size_t sent, filled;
    uint8_t in[64];
    size_t received = board_read(in, sizeof in);
    if (received > 0) fl_app_receive(app, in, received, board_now_us());
    if (sent == filled) {
        sent = 0;
        filled = fl_app_transmit(app, out, sizeof out, board_now_us());
    }
    size_t moved = board_write(out + sent, filled - sent);
    sent += moved;
    return received > 0 || moved > 0;
}

int main(void) {
    board_start();
    fl_identity identity = board_identity;
    identity.reset = board_reset();
    fl_app_start(app, &identity, board_is_whole() ? &fl_built_parameters.table : 0);
    board_run();
    for (;;)
        if (!serve()) board_rest();
}
