/* A twin that runs in step with other simulators, as in an FMU. hypertuna.h has the conventions.
 *
 * It has the robot's own controller, or is the plant alone, driven by servo pulses. Positions, pressures and the
 * plant's sensor readings are those of the present instant; power and the controller's outputs are those of the last
 * tick.
 */
#ifndef HYPERTUNA_DEVICE_H
#define HYPERTUNA_DEVICE_H

#include "hypertuna.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ht_device ht_device;

/* Read a robot's image and make its twin; `plant` is 1 for the plant alone. */
HT_API ht_device* ht_device_create(const unsigned char* image, size_t size, const ht_start* start, int plant,
                                   char* fault, size_t room);
HT_API void ht_device_free(ht_device* device);
HT_API int ht_device_joints(const ht_device* device);
HT_API double ht_device_tick(const ht_device* device); /* s */

/* Set what holds from now on: a command, as in ht_twin_command; or for the plant alone, the pulses [s] of two servos
 * per joint and of the fins, clipped to the limits of the robot's controller. */
HT_API void ht_device_command(ht_device* device, const double* gait, const double fins[2], int armed);
HT_API void ht_device_drive(ht_device* device, const double* pulses);
/* From now on: with `steered` 1 the robot's pilot, by its own sensors, sets biases and fins toward a depth of the nose
 * [m] and a heading [rad, counter-clockwise from east], and reduces amplitudes where the bias needs the reach of a
 * joint; the command's biases and fins are ignored. The pilot decides ten times a second. The depth is clipped to the
 * range of the depth sensor, from 0. With `steered` 0 the command holds. Returns 0 where no pilot can steer: the plant
 * alone, in the plane, and a robot without a pilot. */
HT_API int ht_device_steer(ht_device* device, int steered, double depth, double heading);
/* Set the current from now on [m/s], toward east and north, at sea. */
HT_API void ht_device_flow(ht_device* device, const double current[2]);

/* The same as the functions of ht_twin with these names. A state includes that of the pilot; restore it to a device of
 * the same robot, kind and start. */
HT_API int ht_device_advance(ht_device* device, int ticks);
HT_API const char* ht_device_column(const ht_device* device, int index, int* width);
HT_API void ht_device_read(const ht_device* device, double* row);
HT_API size_t ht_device_state_size(const ht_device* device);
HT_API void ht_device_save(const ht_device* device, unsigned char* state);
HT_API int ht_device_restore(ht_device* device, const unsigned char* state, size_t size);

#ifdef __cplusplus
}
#endif
#endif
