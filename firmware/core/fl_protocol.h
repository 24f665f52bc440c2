/* Made by protocol/generate.py from protocol/frictionloop.toml: change that file. */
#ifndef FL_PROTOCOL_H
#define FL_PROTOCOL_H

#include "fl_fixed.h"

#define FL_MAJOR 4
#define FL_MINOR 0
#define FL_LARGEST_BODY 272
#define FL_TICK_HZ 5000
#define FL_SILENCE_MS 200
#define FL_RAMP_MS 100
#define FL_RISE_TICKS 2
#define FL_ALONE_S 60
#define FL_REPEAT_MS 100
#define FL_TRIES 10
#define FL_BEAT_MS 40
#define FL_WORDS_A_FRAME 64
#define FL_POINTS_A_FRAME 128
#define FL_EFFECT_STEPS 9
#define FL_ALL_TRIGGERS 255
#define FL_SAMPLES_A_FRAME 16
#define FL_OLDEST_MS 20
#define FL_TABLE_HASH 0xf0909b9bu
#define FL_WORDS 428

enum fl_board { FL_BOARD_HOST = 0, FL_BOARD_MPS2 = 1, FL_BOARD_TEENSY41 = 3 };

enum fl_source { FL_SOURCE_HOLD = 0, FL_SOURCE_TIME = 1, FL_SOURCE_POSITION = 2, FL_SOURCE_EFFECT = 3 };

enum fl_state { FL_STATE_IDLE = 0, FL_STATE_OPEN = 1, FL_STATE_CLOSED = 2, FL_STATE_FAULT = 3 };

enum fl_fault { FL_FAULT_NONE = 0, FL_FAULT_FORCE_RANGE = 1, FL_FAULT_SENSOR_STUCK = 2, FL_FAULT_SENSOR_SATURATED = 3, FL_FAULT_HOST_SILENT = 4, FL_FAULT_TICK_OVERRUN = 5, FL_FAULT_BAD_PARAMETER = 6, FL_FAULT_NO_FINGER = 7, FL_FAULT_BAD_IMAGE = 8, FL_FAULT_BROWN_OUT = 9, FL_FAULT_WATCHDOG = 10, FL_FAULT_SENSOR_JUMPS = 11, FL_FAULT_SENSOR_CONTRARY = 12, FL_FAULT_SENSOR_HUMS = 13 };

enum fl_reset { FL_RESET_UNKNOWN = 0, FL_RESET_POWER_ON = 1, FL_RESET_PIN = 2, FL_RESET_SOFTWARE = 3, FL_RESET_BROWN_OUT = 4, FL_RESET_WATCHDOG = 5, FL_RESET_OTHER = 6 };

enum fl_refusal { FL_REFUSAL_UNKNOWN_MESSAGE = 1, FL_REFUSAL_WRONG_LENGTH = 2, FL_REFUSAL_WRONG_VERSION = 3, FL_REFUSAL_UNKNOWN_WORD = 4, FL_REFUSAL_OUT_OF_RANGE = 5, FL_REFUSAL_WRONG_CRC = 6, FL_REFUSAL_NOT_NOW = 7, FL_REFUSAL_STILL_AT_FAULT = 8, FL_REFUSAL_NOT_OWNER = 9, FL_REFUSAL_NO_SESSION = 10, FL_REFUSAL_LATE = 11 };

enum fl_step { FL_STEP_TABLE = 0, FL_STEP_WAVE = 1, FL_STEP_ADD = 2, FL_STEP_MULTIPLY = 3, FL_STEP_LARGER = 4, FL_STEP_MIX = 5, FL_STEP_DIRECTION = 6, FL_STEP_SPEED = 7, FL_STEP_TRIGGER = 8, FL_STEP_SCALED = 9 };

enum fl_condition { FL_CONDITION_LOAD = 0, FL_CONDITION_SPEED = 1, FL_CONDITION_PLACE = 2 };

enum fl_message { FL_MESSAGE_IDENTIFY = 1, FL_MESSAGE_IDENTITY = 2, FL_MESSAGE_GET = 3, FL_MESSAGE_WORDS = 4, FL_MESSAGE_SET = 5, FL_MESSAGE_COMMIT = 6, FL_MESSAGE_WAVEFORM = 7, FL_MESSAGE_PLAY = 8, FL_MESSAGE_MODE = 9, FL_MESSAGE_STREAM = 10, FL_MESSAGE_TELEMETRY = 11, FL_MESSAGE_HEARTBEAT = 12, FL_MESSAGE_STATUS = 13, FL_MESSAGE_CLEAR = 14, FL_MESSAGE_STATISTICS = 15, FL_MESSAGE_COUNTED = 16, FL_MESSAGE_DONE = 17, FL_MESSAGE_REFUSED = 18, FL_MESSAGE_FAULT = 19, FL_MESSAGE_HELLO = 20, FL_MESSAGE_WELCOME = 21, FL_MESSAGE_TRIGGER = 22 };

enum fl_channel { FL_CHANNEL_F_R, FL_CHANNEL_F_M, FL_CHANNEL_U, FL_CHANNEL_A, FL_CHANNEL_POSITION, FL_CHANNEL_SPEED, FL_CHANNEL_LOAD, FL_CHANNEL_FLAGS, FL_CHANNELS };

/* The parameter table: FL_WORDS words in this order. */
typedef struct {
    int32_t law_number;  /* count: control law (control/laws): 1 PI, 2 lookup, 3 filtered PI, 4 limit observer */
    fl_gain law_gains[52];  /* gain: gains of the law: see gains and start words; unused ones are 0 */
    int32_t law_start[21];  /* count: state of the law when the loop goes on: see gains and start words */
    int32_t law_low_n;  /* q28, N: lowest force command, g(a_max) by the controller's model */
    int32_t law_high_n;  /* q28, N: highest force command, f0 by the controller's model */
    int32_t lookup_squares_um2[257];  /* q25, um^2: a^2 at 257 forces from low_n to high_n, evenly spaced */
    fl_gain lookup_cells_per_n;  /* gain, 1/N: 256 over high_n - low_n */
    int32_t overdrive_decay;  /* q28: decay of the believed plate in a period; 0 without overdrive */
    fl_gain overdrive_inverse;  /* gain: 1/(1 - decay) */
    int32_t drive_largest_um;  /* q28, um: amplitude at duty 1/2 */
    int32_t drive_ceiling_um;  /* q28, um: largest amplitude ever commanded; no larger a share of largest_um than the image was built with */
    int32_t drive_ramp_um;  /* q28, um: fall of the amplitude per tick while ramping down; from ceiling_um to 0 in ramp_ms at most */
    int32_t force_axes;  /* count: 1: the first channel, along the motion; 2: magnitude of both */
    int32_t force_zero_counts[2];  /* count: converter counts at no force */
    fl_gain force_n_per_count[2];  /* gain, N: newtons a count */
    int32_t touch_zero_counts;  /* count: load counts at no load */
    fl_gain touch_n_per_count;  /* gain, N: newtons of load a count */
    fl_gain touch_m_per_count;  /* gain, m: metres of position a count */
    int32_t touch_position_gain;  /* q28: alpha of the position's alpha-beta filter */
    fl_gain touch_speed_gain;  /* gain, 1/s: beta of that filter over dt */
    int32_t touch_touch_n;  /* q28, N: least load that counts as touch */
    int32_t touch_touch_share;  /* q28: least share of the running mean of the load */
    int32_t touch_mean_gain;  /* q28: gain of that mean */
    int32_t touch_least_speed_m_s;  /* q28, m/s: least speed that counts as sliding */
    int32_t touch_speed_share;  /* q28: least share of the running mean of the speed */
    int32_t touch_developed_m;  /* q28, m: way from landing to a skin that is stretched, after which a reading is valid; a turn takes twice that */
    int32_t touch_turn_m;  /* q28, m: way back that is a turn */
    int32_t touch_lead_s;  /* q28, s: from the sample to the middle of the period in which its command is in force: so far ahead an effect is asked */
    int32_t setpoint_hold_n;  /* q28, N: set-point while no table plays */
    int32_t safety_force_limit_n;  /* q28, N: largest plausible force */
    int32_t safety_force_ticks;  /* count: ticks at which a force must be out of range */
    int32_t safety_stuck_ticks;  /* count: ticks at which a reading must not change by more than a count */
    int32_t safety_overrun_ticks;  /* count: late ticks in a second */
    int32_t safety_force_jump_n;  /* q28, N: largest plausible change of the force's magnitude in a tick */
    int32_t safety_position_jump_m;  /* q28, m: largest plausible way of a finger in a tick */
    int32_t safety_load_jump_n;  /* q28, N: largest plausible change of the load in a tick */
    int32_t safety_contrary_n;  /* q28, N: largest plausible force without load, and along the motion */
    int32_t safety_turn_m;  /* q28, m: way after a turn on which the skin may still pull along the motion */
    int32_t safety_hum_n;  /* q28, N: least swing from peak to peak, at the beat of the mains, that is a hum; and at least half the force */
    int32_t safety_hum_ticks;  /* count: ticks over which a swing is told: whole periods of the sensor's springs, about half a period of the mains */
} fl_parameters;

/* Least and largest value of the words of parameters, one after the other; of a gain, of its shift. */
typedef struct { uint16_t first, count, stride; int32_t low, high; } fl_range;
#define FL_RANGES 28
#define FL_RANGE_TABLE { \
    {0, 1, 1, 0, 15}, \
    {1, 52, 2, -1, 62}, \
    {105, 21, 1, INT32_MIN, 2147483647}, \
    {126, 259, 1, 0, 2147483647}, \
    {385, 1, 2, -1, 62}, \
    {387, 1, 1, 0, 268435456}, \
    {388, 1, 2, -1, 62}, \
    {390, 2, 1, 0, 2120640102}, \
    {392, 1, 1, 3, 2120640102}, \
    {393, 1, 1, 1, 2}, \
    {394, 2, 1, -32768, 32767}, \
    {396, 2, 2, -1, 62}, \
    {400, 1, 1, -32768, 32767}, \
    {401, 2, 2, -1, 62}, \
    {405, 1, 1, 0, 268435456}, \
    {406, 1, 2, -1, 62}, \
    {408, 1, 1, 0, 2147483647}, \
    {409, 2, 1, 0, 268435456}, \
    {411, 1, 1, 0, 2147483647}, \
    {412, 1, 1, 0, 268435456}, \
    {413, 2, 1, 0, 2147483647}, \
    {415, 1, 1, 0, 268435456}, \
    {416, 2, 1, 0, 2147483647}, \
    {418, 1, 1, 1, 100}, \
    {419, 1, 1, 2, 500000}, \
    {420, 1, 1, 1, 50}, \
    {421, 6, 1, 0, 2147483647}, \
    {427, 1, 1, 1, 50}, \
}

#endif
