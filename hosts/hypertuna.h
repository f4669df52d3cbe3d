/* hypertuna for any host: a browser page, an FMU, an environment for learning, a program of your own.
 *
 * A robot is read from an image (`hypertuna robot image NAME -o FILE`). A robot is never changed, and may be shared
 * between threads; a twin has its own state. Nothing throws and there are no globals. SI units and radians; angles of
 * bends are counter-clockwise. A function that fails returns null and writes a sentence to `fault`, a buffer of `room`
 * bytes.
 *
 * A gait is a row of 1 + 3 G numbers for G joint groups: frequency [Hz]; amplitudes, phases and biases [rad].
 */
#ifndef HYPERTUNA_H
#define HYPERTUNA_H

#include <stddef.h>
#include <stdint.h>

#if !defined(HT_API) && defined(__GNUC__)
#define HT_API __attribute__((visibility("default")))
#elif !defined(HT_API)
#define HT_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ht_robot ht_robot;
typedef struct ht_twin ht_twin;

/* --- the robot ------------------------------------------------------------------------------------------------- */

HT_API ht_robot* ht_robot_read(const unsigned char* image, size_t size, char* fault, size_t room);
HT_API void ht_robot_free(ht_robot* robot);

/* The image's text: JSON with the names of robot, joints, models and gaits. */
HT_API const char* ht_robot_text(const ht_robot* robot, size_t* size);
HT_API int ht_robot_groups(const ht_robot* robot);
HT_API int ht_robot_links(const ht_robot* robot);
/* Models of the robot in water: water laws with joints of each kind, named in the text. 0 is the robot's own choice. */
HT_API int ht_robot_models(const ht_robot* robot);
/* Missions that the robot's pilot can fly, described in the text in this order; 0 where it has no pilot. */
HT_API int ht_robot_missions(const ht_robot* robot);

/* --- swimming: settled gaits ------------------------------------------------------------------------------------ */

/* Name of a quantity of a settled gait; null after the last. */
HT_API const char* ht_quantity(int index);
/* Label and unit of a quantity in words; where it is shown: only in data (0), also in records (1), or also in summaries
 * (2); and whether an optimization can seek no (0), large (1) or small (2) values of it. */
HT_API const char* ht_quantity_label(int index);
HT_API const char* ht_quantity_unit(int index);
HT_API int ht_quantity_shown(int index);
HT_API int ht_quantity_better(int index);
/* Name of a quantity that has derivatives; null after the last. */
HT_API const char* ht_derivative(int index);

/* Settled beats of gaits (count, 1 + 3 G): quantities (count, as many as ht_quantity names). With `follow` a start from
 * rest is followed toward each beat, which takes a hundred times as long: `arrived` is 1 where it reaches the beat. */
HT_API void ht_swim(const ht_robot* robot, int model, const double* gaits, int count, int follow, double* quantities);

/* The verdict on a gait with these quantities, as a sentence or two. */
HT_API void ht_verdict(const double* gait, const double* quantities, char* text, size_t room);

/* Derivatives of a settled gait's quantities with respect to the gait's numbers (as many as ht_derivative names,
 * 1 + 3 G). */
HT_API void ht_gradient(const ht_robot* robot, int model, const double* gait, double* derivatives);

/* Path of a settled beat: rows of time [s], x, y [m] and heading [rad] of the nose, and the bend of the front joint of
 * each link [rad], steps + 1 of them (128 a beat is usual). */
HT_API void ht_path(const ht_robot* robot, int model, const double* gait, int steps, double* rows);

/* --- the twin: the whole robot from command to wake ------------------------------------------------------------ */

typedef struct ht_start {
    int sea;           /* 0: the plane of still water; 1: in space, with a current and a bottom */
    uint64_t seed;     /* of the sensors' errors */
    double speed;      /* m/s at the start, ahead */
    double depth;      /* m of the nose at the start, at sea */
    double heading;    /* rad at the start, at sea: counter-clockwise from east */
    double current[2]; /* m/s toward east and north, at sea */
    double bottom;     /* m of depth; infinite in deep water */
} ht_start;

HT_API ht_twin* ht_twin_create(const ht_robot* robot, const ht_start* start, char* fault, size_t room);
/* A flight: a twin at sea that flies a mission under the robot's own pilot, as `hypertuna mission --seed` does. Seed 0
 * flies the mission as its file describes it, other seeds scatter current and satellites. A flight takes no command,
 * and ends by itself: its column `ending` is 0 until then, and afterwards 1 plus a place in the text's list of
 * endings. */
HT_API ht_twin* ht_twin_fly(const ht_robot* robot, int mission, uint32_t seed, char* fault, size_t room);
HT_API void ht_twin_free(ht_twin* twin);

/* Set the command from now on: a gait and the angles of the two fins [rad]; `armed` 0 lets the tail rest. */
HT_API void ht_twin_command(ht_twin* twin, const double* gait, const double fins[2], int armed);
/* Give the sensor channels `first` to `last` a fault from now on: kind 1 stuck, 2 open, 3 spikes, 4 NaN, 0 none. */
HT_API void ht_twin_break(ht_twin* twin, int kind, int first, int last);
/* Jam the servo of a flight's fin (0 port, 1 starboard) from now on: kind 1 where it is, 2 level, 3 up, 4 down; 0
 * repairs the servo. */
HT_API void ht_twin_jam(ht_twin* twin, int fin, int kind);
/* Make control ticks; returns how many were made: fewer where a flight is over, or where a tick led to a physically
 * impossible state; the row then shows that tick. */
HT_API int ht_twin_advance(ht_twin* twin, int ticks);

/* Name and number of values of a column of the last tick's row; null after the last. */
HT_API const char* ht_twin_column(const ht_twin* twin, int index, int* width);
/* All columns of the last tick, one after another. */
HT_API void ht_twin_read(const ht_twin* twin, double* row);

/* Save the twin's complete state, as bytes of this size, without its command and its faults; restore it to a twin of
 * the same robot and mission. ht_twin_restore returns 0 where the size differs. */
HT_API size_t ht_twin_state_size(const ht_twin* twin);
HT_API void ht_twin_save(const ht_twin* twin, unsigned char* state);
HT_API int ht_twin_restore(ht_twin* twin, const unsigned char* state, size_t size);

#ifdef __cplusplus
}
#endif
#endif
