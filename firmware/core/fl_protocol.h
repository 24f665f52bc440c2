/* Made by protocol/generate.py from protocol/frictionloop.toml: change that file. */
#ifndef FL_PROTOCOL_H
#define FL_PROTOCOL_H

#include <stdint.h>

#define FL_MAJOR 5
#define FL_MINOR 0
#define FL_LARGEST_BODY 272
#ifndef FL_TICK_HZ /* as the image is built */
#define FL_TICK_HZ 5000
#endif
#define FL_SILENCE_MS 200
#define FL_RAMP_MS 100
#define FL_RISE_TICKS 2
#define FL_ALONE_S 60
#define FL_REPEAT_MS 100
#define FL_TRIES 10
#define FL_BEAT_MS 40
#define FL_WORDS_A_FRAME 32
#define FL_POINTS_A_FRAME 128
#define FL_EFFECT_STEPS 9
#define FL_ALL_TRIGGERS 255
#define FL_SAMPLES_A_FRAME 16
#define FL_BAUD 2000000
#define FL_OLDEST_MS 20
#define FL_TABLE_HASH 0x38feabacu
#define FL_WORDS 395

enum fl_board { FL_BOARD_HOST = 0, FL_BOARD_MPS2 = 1, FL_BOARD_TEENSY41 = 3 };

enum fl_source { FL_SOURCE_HOLD = 0, FL_SOURCE_TIME = 1, FL_SOURCE_POSITION = 2, FL_SOURCE_EFFECT = 3 };

enum fl_state { FL_STATE_IDLE = 0, FL_STATE_OPEN = 1, FL_STATE_CLOSED = 2, FL_STATE_FAULT = 3 };

enum fl_fault { FL_FAULT_NONE = 0, FL_FAULT_FORCE_RANGE = 1, FL_FAULT_SENSOR_STUCK = 2, FL_FAULT_SENSOR_SATURATED = 3, FL_FAULT_HOST_SILENT = 4, FL_FAULT_TICK_OVERRUN = 5, FL_FAULT_BAD_PARAMETER = 6, FL_FAULT_NO_FINGER = 7, FL_FAULT_BAD_IMAGE = 8, FL_FAULT_BROWN_OUT = 9, FL_FAULT_WATCHDOG = 10, FL_FAULT_SENSOR_JUMPS = 11, FL_FAULT_SENSOR_CONTRARY = 12, FL_FAULT_SENSOR_HUMS = 13, FL_FAULT_LAW_WRONG = 14 };

enum fl_reset { FL_RESET_UNKNOWN = 0, FL_RESET_POWER_ON = 1, FL_RESET_PIN = 2, FL_RESET_SOFTWARE = 3, FL_RESET_BROWN_OUT = 4, FL_RESET_WATCHDOG = 5, FL_RESET_OTHER = 6 };

enum fl_refusal { FL_REFUSAL_UNKNOWN_MESSAGE = 1, FL_REFUSAL_WRONG_LENGTH = 2, FL_REFUSAL_WRONG_VERSION = 3, FL_REFUSAL_UNKNOWN_WORD = 4, FL_REFUSAL_OUT_OF_RANGE = 5, FL_REFUSAL_WRONG_CRC = 6, FL_REFUSAL_NOT_NOW = 7, FL_REFUSAL_STILL_AT_FAULT = 8, FL_REFUSAL_NOT_OWNER = 9, FL_REFUSAL_NO_SESSION = 10, FL_REFUSAL_LATE = 11 };

enum fl_step { FL_STEP_TABLE = 0, FL_STEP_WAVE = 1, FL_STEP_ADD = 2, FL_STEP_MULTIPLY = 3, FL_STEP_LARGER = 4, FL_STEP_MIX = 5, FL_STEP_DIRECTION = 6, FL_STEP_SPEED = 7, FL_STEP_TRIGGER = 8, FL_STEP_SCALED = 9 };

enum fl_condition { FL_CONDITION_LOAD = 0, FL_CONDITION_SPEED = 1, FL_CONDITION_PLACE = 2 };

enum fl_message { FL_MESSAGE_IDENTIFY = 1, FL_MESSAGE_IDENTITY = 2, FL_MESSAGE_GET = 3, FL_MESSAGE_WORDS = 4, FL_MESSAGE_SET = 5, FL_MESSAGE_COMMIT = 6, FL_MESSAGE_WAVEFORM = 7, FL_MESSAGE_PLAY = 8, FL_MESSAGE_MODE = 9, FL_MESSAGE_STREAM = 10, FL_MESSAGE_TELEMETRY = 11, FL_MESSAGE_HEARTBEAT = 12, FL_MESSAGE_STATUS = 13, FL_MESSAGE_CLEAR = 14, FL_MESSAGE_STATISTICS = 15, FL_MESSAGE_COUNTED = 16, FL_MESSAGE_DONE = 17, FL_MESSAGE_REFUSED = 18, FL_MESSAGE_FAULT = 19, FL_MESSAGE_HELLO = 20, FL_MESSAGE_WELCOME = 21, FL_MESSAGE_TRIGGER = 22 };

enum fl_channel { FL_CHANNEL_F_R, FL_CHANNEL_F_M, FL_CHANNEL_U, FL_CHANNEL_A, FL_CHANNEL_POSITION, FL_CHANNEL_SPEED, FL_CHANNEL_LOAD, FL_CHANNEL_FLAGS, FL_CHANNELS };

/* The parameter table: FL_WORDS words in this order, all doubles. */
typedef struct {
    double law_hash;  /* count: control law: CRC-32 of the C of the image's own, or 0 for the lookup, which every image has */
    double law_gains[64];  /* f64: gains of the law without its clamp */
    double law_start[32];  /* f64: state of the law when the loop goes on */
    double law_low_n;  /* f64, N: lowest force command, g(a_max) by the controller's model */
    double law_high_n;  /* f64, N: highest force command, f0 by the controller's model */
    double lookup_entries;  /* count: entries of the table of squares; 0: the amplitude is calculated */
    double lookup_log2_nominal;  /* f64: log2 of f0 in N by the controller's model */
    double lookup_um2_per_halving;  /* f64, um^2: ln 2/tau by the controller's model */
    double lookup_squares_um2[257];  /* f64, um^2: a^2 at forces from low_n to high_n, evenly spaced */
    double lookup_cells_per_n;  /* f64, 1/N: entries less one over high_n - low_n */
    double overdrive_decay;  /* f64: decay of the believed plate in a period; 0 without overdrive */
    double overdrive_inverse;  /* f64: 1/(1 - decay) */
    double drive_largest_um;  /* f64, um: amplitude at duty 1/2 */
    double drive_ceiling_um;  /* f64, um: largest amplitude ever commanded; no larger a share of largest_um than the image was built with */
    double drive_ramp_um;  /* f64, um: fall of the amplitude per tick while ramping down; from ceiling_um to 0 in ramp_ms at most */
    double force_axes;  /* count: 1: the first channel, along the motion; 2: magnitude of both */
    double force_zero_counts[2];  /* count: converter counts at no force */
    double force_n_per_count[2];  /* f64, N: newtons a count */
    double touch_zero_counts;  /* count: load counts at no load */
    double touch_n_per_count;  /* f64, N: newtons of load a count */
    double touch_m_per_count;  /* f64, m: metres of position a count */
    double touch_position_gain;  /* f64: alpha of the position's alpha-beta filter */
    double touch_speed_gain;  /* f64, 1/s: beta of that filter over dt */
    double touch_touch_n;  /* f64, N: least load that counts as touch */
    double touch_touch_share;  /* f64: least share of the running mean of the load */
    double touch_mean_gain;  /* f64: gain of that mean */
    double touch_least_speed_m_s;  /* f64, m/s: least speed that counts as sliding */
    double touch_speed_share;  /* f64: least share of the running mean of the speed */
    double touch_developed_m;  /* f64, m: way from landing to a skin that is stretched, after which a reading is valid; a turn takes twice that */
    double touch_turn_m;  /* f64, m: way back that is a turn */
    double touch_lead_s;  /* f64, s: from the sample to the middle of the period in which its command is in force: so far ahead an effect is asked */
    double setpoint_hold_n;  /* f64, N: set-point while no table plays */
    double safety_force_limit_n;  /* f64, N: largest plausible force */
    double safety_force_ticks;  /* count: ticks at which a force must be out of range */
    double safety_stuck_ticks;  /* count: ticks at which a reading must not change by more than a count */
    double safety_overrun_ticks;  /* count: late ticks in a second */
    double safety_force_jump_n;  /* f64, N: largest plausible change of the force's magnitude in a tick */
    double safety_position_jump_m;  /* f64, m: largest plausible way of a finger in a tick */
    double safety_load_jump_n;  /* f64, N: largest plausible change of the load in a tick */
    double safety_contrary_n;  /* f64, N: largest plausible force without load, and along the motion */
    double safety_turn_m;  /* f64, m: way after a turn on which the skin may still pull along the motion */
    double safety_hum_n;  /* f64, N: least swing from peak to peak, at the beat of the mains, that is a hum; and at least half the force */
    double safety_hum_ticks;  /* count: ticks over which a swing is told: whole periods of the sensor's springs, about half a period of the mains */
} fl_parameters;

/* Least and largest value of parameters, one after the other, and whether they are whole numbers. */
typedef struct { uint16_t first, whole; double low, high; } fl_range;
#define FL_RANGES 31
#define FL_RANGE_TABLE { \
    {0, 1, 0.0, 4294967295.0}, \
    {1, 0, -1e+30, 1e+30}, \
    {97, 0, 0.0, 8.0}, \
    {99, 1, 0.0, 257.0}, \
    {100, 0, -1000.0, 1000.0}, \
    {101, 0, 0.0, 1e+30}, \
    {102, 0, 0.0, 1000000.0}, \
    {359, 0, 0.0, 1000000000000.0}, \
    {360, 0, 0.0, 1.0}, \
    {361, 0, 1.0, 1e+30}, \
    {362, 0, 0.0, 7.9}, \
    {364, 0, 1e-08, 7.9}, \
    {365, 1, 1.0, 2.0}, \
    {366, 1, -32768.0, 32767.0}, \
    {368, 0, -1e+30, 1e+30}, \
    {370, 1, -32768.0, 32767.0}, \
    {371, 0, -1e+30, 1e+30}, \
    {373, 0, 0.0, 1.0}, \
    {374, 0, -1e+30, 1e+30}, \
    {375, 0, 0.0, 8.0}, \
    {376, 0, 0.0, 1.0}, \
    {378, 0, 0.0, 8.0}, \
    {379, 0, 0.0, 1.0}, \
    {380, 0, 0.0, 8.0}, \
    {382, 0, 0.0, 1.0}, \
    {383, 0, 0.0, 8.0}, \
    {385, 1, 1.0, 1000.0}, \
    {386, 1, 2.0, 2000000.0}, \
    {387, 1, 1.0, 50.0}, \
    {388, 0, 0.0, 8.0}, \
    {394, 1, 1.0, 200.0}, \
}

#endif
