/* Reads records from standard input and writes what the core makes of them: words, states, how many ticks,
 * measurements, set-points -> u, saturated and amplitude command of each tick, then the state and the belief. */
#include <stdio.h>
#include <stdlib.h>

#include "fl_host.h"
#include "fl_law.h"

static int32_t *take(size_t count) {
    int32_t *numbers = malloc(4 * count);
    if (!numbers || fread(numbers, 4, count, stdin) != count) exit(1);
    return numbers;
}

int main(void) {
    int32_t count;
    while (fread(&count, 4, 1, stdin) == 1) {
        int32_t believed = 0, *words = take(FL_WORDS), *state = take(FL_STATES);
        int32_t *measurements = take(5 * (size_t)count), *setpoints = take((size_t)count);
        int32_t *out = malloc(12 * (size_t)count);
        if (!out) return 1;
        fl_host_run(words, (size_t)count, state, &believed, measurements, setpoints, out);
        fwrite(out, 12, (size_t)count, stdout);
        fwrite(state, 4, FL_STATES, stdout);
        fwrite(&believed, 4, 1, stdout);
        free(words), free(state), free(measurements), free(setpoints), free(out);
    }
    return 0;
}
