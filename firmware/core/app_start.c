/* Begin, and what the board can tell about itself. */
#include <string.h>

#include "fl_app_parts.h"

size_t fl_app_size(void) { return sizeof(fl_app); }

void fl_app_start(fl_app *app, const fl_identity *identity, const fl_parameters *parameters) {
    memset(app, 0, sizeof *app);
    app->identity = *identity;
    app->asked_state = FL_NO_STATE;
    fl_parameters_start(app, parameters);
}

void fl_app_took(fl_app *app, uint32_t duration) {
    if (duration > app->longest) app->longest = duration;
}
