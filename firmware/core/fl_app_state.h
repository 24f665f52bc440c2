/* What struct fl_app holds: all memory of the firmware but the stack, in the hands of the caller.
 *
 * What the background prepares and the tick takes exists twice: one copy in force, which the tick alone
 * reads, and one that waits, which the background alone writes. fl_swap says which is which. */
#ifndef FL_APP_STATE_H
#define FL_APP_STATE_H

#include "fl_app.h"
#include "fl_effect.h"
#include "fl_frame.h"

enum {
    FL_SAMPLES = 36,     /* of telemetry, each of a tick or of several */
    FL_REPLIES = 16,     /* frames that may come in before one goes out */
    FL_NO_INDEX = 65535, /* of a refusal that is about no word or point */
    FL_NO_STATE = 255,
    FL_HUM_TICKS = FL_TICK_HZ / 100, /* half a period of the mains at 50 Hz */
    FL_RAM = 16384       /* bytes */
};

/* `asked` is set by the background, taken by the next tick, which then sets `stale`: the copy that waits is
 * to be made equal to the one in force before it is written to. */
typedef struct { volatile uint8_t in_force, asked, stale; } fl_swap;

typedef union {
    fl_parameters named;
    double words[FL_WORDS];
} fl_table;
_Static_assert(sizeof(fl_table) == 8 * FL_WORDS, "the table is words and nothing else");

/* What the tick would have to divide for: cells of the duty table in a um, the duty of the ceiling, and the magnitude at
 * which each channel is at its end: forces, position, load. */
typedef struct {
    double cells_per_um, rise_um;
    int32_t ceiling_duty, bend_counts; /* most by which whole springs bend a reading of the force in a tick */
    uint32_t ends[4];
    double easing; /* N, of the set-point in a tick while an effect comes or goes */
} fl_derived;

/* What the image's own table says of the drive. The ceiling of a table that a host commits is at most as large a
 * share of its largest amplitude: so the duty at the pin is at most that of this ceiling. */
typedef struct { double largest_um, ceiling_um; } fl_built_in;

/* How the set-point table is played: `step` points a tick or a um, 2^-24. */
typedef struct {
    uint8_t source, loops;
    uint16_t count;
    uint32_t step;
    int32_t start_um;
} fl_play;

/* Ticks in a row at which something was so. */
typedef struct {
    uint32_t out_of_range, saturated, stuck[2], alone;
    int32_t low[2], high[2]; /* of the readings since stuck began to count */
    uint32_t late, second; /* late ticks in this second, ticks of it */
} fl_watch;

/* What app_sensors.c remembers. */
typedef struct {
    double force, position, load; /* of the tick before, the force's magnitude */
    double turned, pulled;        /* where the finger landed or was seen to turn; or pulled too much to tell, m */
    double level, restless;       /* mean of the force, and what the set-point moved lately, N */
    double peak, rung;            /* most in this swing, over half a period of the mains and of the springs */
    double asked, driven;         /* amplitude, um, forgotten as the force is */
    int32_t counts[2], moved[2], bent[2][2]; /* force: last, its differences, and theirs, of two ticks */
    int32_t jumped, contrary;
    int32_t since, half, period, at; /* ticks since the last swing, of the one before, of both before */
    uint8_t valid, heading, channel, up, beats;
    double forces[FL_HUM_TICKS];
} fl_sensors;

typedef struct {
    uint8_t fault;
    uint32_t tick;
    double value;
} fl_raised;

typedef struct {
    uint32_t tick;
    int16_t values[FL_CHANNELS];
} fl_kept;

typedef struct {
    uint8_t type, reason;
    uint16_t sequence, first, count;
} fl_reply;

/* A host that said hello: its last frame, and how that was answered. */
typedef struct {
    uint32_t id; /* 0: none */
    uint16_t sequence, index;
    uint8_t type, reason;
} fl_session;

struct fl_app {
    fl_identity identity;
    fl_built_in built;
    /* which parameters and which set-point table */
    fl_swap parameters;
    fl_play plays[2];
    fl_swap table;
    uint64_t phase; /* points, 2^-24 */
    fl_effect effect;
    double setpoint;
    uint8_t eases;
    volatile uint8_t asked_trigger; /* number and 1; the background sets, the tick takes */
    fl_derived derived[2];
    /* the loop; the tick alone writes */
    volatile uint32_t tick;
    volatile uint8_t state, fault, bad_table;
    double touch[FL_TOUCHES];
    fl_watch watch;
    fl_sensors sensors;
    double law_state[FL_STATES];
    fl_measurement measured; /* of the last tick, with what it led to */
    fl_force_command command;
    double believed, amplitude; /* um */
    int32_t since;              /* the loop closed, ticks; below 0 while it is open */
    uint8_t law_runs, touched;
    fl_raised raised;
    uint32_t overruns, longest;
    volatile uint16_t commits;
    /* asked of the tick; the background sets, the tick takes */
    volatile uint8_t asked_state, asked_clear;
    volatile uint8_t tell_fault; /* the tick sets, the background takes */
    volatile uint32_t heard_us;
    /* telemetry: the tick writes `head`, the background `tail` */
    fl_kept samples[FL_SAMPLES];
    volatile uint16_t head, tail, decimation;
    volatile uint32_t dropped;
    uint16_t mask, spacing; /* of the samples in the ring: ticks from one to the next */
    /* the link; the background alone */
    fl_decoder decoder;
    uint16_t last_sequence, sequence;
    uint8_t heard;
    uint32_t missed;
    fl_session sessions[2]; /* while the loop is on, its owner's and that of the latest other host */
    uint32_t owner, streamer, hellos;
    fl_reply replies[FL_REPLIES];
    uint8_t first_reply, reply_count;
    uint16_t coded, sent;
    uint8_t out[FL_LARGEST_CODED];
    /* large, so last: what is within 4 KB of the beginning is reached by one instruction */
    fl_table tables[2];
    fl_store stores[2];
};
_Static_assert(sizeof(struct fl_app) <= FL_RAM, "the firmware's memory is within its budget");

#endif
