/* A rig's hardware for tonus-rig-agent, as a shared library: version 2 of the interface.
 *
 * The library exports one function, tonus_driver_v2(), and needs nothing else of tonus than this file. One
 * that exports tonus_driver_v1() alone is still loaded; without disable() the rig then has no watchdog, and
 * says so. How to write one: README.md in this folder; a complete example: examples/driver.
 *
 * States      unconfigured --configure--> inactive --activate--> active --deactivate--> inactive
 * The agent keeps to them: it calls read and write only between activate and deactivate, configure only when
 * inactive or unconfigured, and destroy last. deactivate may come in every state and leaves the motors
 * without torque.
 *
 * Ownership   The table that tonus_driver_v1() returns is the library's and lives as long as the library is
 * loaded. What create() returns is the library's, given up by destroy(). Pointers that a function is handed
 * are the agent's and are not kept beyond the call; texts are UTF-8 and end with a zero.
 *
 * Threads     One thread at a time. read, write and begin_trial come from the realtime thread: they allocate
 * nothing, wait for nothing but the device, take no lock that another thread may hold, write no log, and
 * return within a small part of the period. The other functions may take their time. No function lets an
 * exception out.
 *
 * Units       SI, angles counter-clockwise. Encoder counts and volts are raw: tonus converts them by the
 * description.
 */
#ifndef TONUS_DRIVER_H
#define TONUS_DRIVER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A library states the version that it was built with; the agent refuses others than these. */
#define TONUS_DRIVER_VERSION 1u
#define TONUS_DRIVER_VERSION_2 2u

/* What a call came to; any other value counts as TONUS_DRIVER_FAILED. Anything but OK in the running loop is
 * a fault: the rig stops. */
enum {
  TONUS_DRIVER_OK = 0,
  TONUS_DRIVER_DISCONNECTED = 1, /* a sensor or the card does not answer */
  TONUS_DRIVER_FAILED = 2        /* the device refused */
};

/* The rig: two links in the horizontal plane, an encoder on each joint, a two-axis force sensor that turns
 * with the outer link. Asked for after configure(), constant from then on. joint angle (rad) = encoder_sign
 * (count - encoder_zero_count) / encoder_counts_per_rad force on the arm (N), sensor's axes =
 * force_calibration_N_per_V (volts - force_offset_V) */
typedef struct tonus_driver_description {
  double link_lengths_m[2];
  double encoder_counts_per_rad[2];
  double encoder_zero_count[2];
  double encoder_sign[2];              /* +1 or -1 */
  double force_calibration_N_per_V[4]; /* row-major 2x2 */
  double force_offset_V[2];
  double force_sensor_angle_rad; /* sensor's x axis from the outer link */
  double force_saturation_V;     /* |V| at which a channel is at its end stop */
  double handle_mass_kg;         /* on the hand's side of the flexure */
  int32_t has_own_clock;         /* not 0: time advances by one period a cycle, however fast it is called */
} tonus_driver_description;

/* One cycle's input. Every member is set by read(). */
typedef struct tonus_driver_reading {
  int64_t acquisition_ns; /* one monotonic clock; increases from read to read, also across activate */
  double encoder_count[2];
  double force_V[2];
  int32_t is_emergency_stop_pressed;
} tonus_driver_reading;

/* Where the subject's shoulder stands (in the robot's frame R) and the hand is to be (in the shoulder's frame
 * S) in the trial that begins. Hardware has no use for it. */
typedef struct tonus_driver_trial {
  double shoulder_origin_m[2];
  double shoulder_angle_rad;
  double posture_m[2];
} tonus_driver_trial;

typedef struct tonus_driver_v1_table {
  uint32_t version; /* TONUS_DRIVER_VERSION */
  uint32_t size;    /* sizeof(tonus_driver_v1_table) */

  /* One rig. `options` is the text of --driver-options, "" if there is none. NULL on failure, with the reason
   * in one line in `error` (at most error_size bytes with its zero); so it is with every `error` below. */
  void* (*create)(const char* options, char* error, size_t error_size);
  void (*destroy)(void* rig);

  /* 0 or an error. The period is finite and positive; refuse what the device cannot do, saying what is
   * allowed. */
  int (*configure)(void* rig, double period_s, char* error, size_t error_size);
  void (*describe)(void* rig, tonus_driver_description* description);
  int (*activate)(void* rig, char* error, size_t error_size);
  void (*deactivate)(void* rig);

  /* Realtime. read() fills the reading when it returns OK. write() gives the joint torques (N m) for the
   * period that begins; they are finite, and stay as they are until the next write. begin_trial may be NULL.
   */
  int (*read)(void* rig, tonus_driver_reading* reading);
  int (*write)(void* rig, const double torque_Nm[2]);
  void (*begin_trial)(void* rig, const tonus_driver_trial* trial);
} tonus_driver_v1_table;

/* The one symbol of version 1. */
const tonus_driver_v1_table* tonus_driver_v1(void);

/* A signal that the rig measures beside force and motion: EMG, grip force, a trigger. In `unit` it is value *
 * unit_per_value. Texts end with a zero. */
typedef struct tonus_driver_auxiliary {
  char name[33]; /* letters and digits, each channel's its own */
  char type[16]; /* of BIDS: EMG, ECG, EOG, EYEGAZE, GSR, PPG, PUPIL, RESP, TEMP, TRIG or MISC */
  char unit[17];
  double unit_per_value; /* not 0 */
  double rate_Hz;        /* a whole multiple of the rig's sample rate, at most 4000 */
} tonus_driver_auxiliary;

/* Version 2: what happens when the program or the computer does not go on. */
typedef struct tonus_driver_safety {
  double watchdog_ms; /* the device itself drops the torque when no write comes for so long; 0: it does not */
  int32_t moves_nothing_real; /* not 0: whatever it is told, nobody can be moved (a simulation) */
  char by_itself[256];        /* one line, what the device does by itself when nobody writes any more */
} tonus_driver_safety;

typedef struct tonus_driver_v2_table {
  tonus_driver_v1_table base; /* base.version is TONUS_DRIVER_VERSION_2, base.size that of this whole table. A
                               * larger table is accepted, and a smaller one that ends before
                               * count_auxiliary: later members are added at the end. */

  /* Asked for after configure(), constant from then on. */
  void (*describe_safety)(void* rig, tonus_driver_safety* safety);

  /* Drops the torque and keeps it down until the next activate(): by a separate enable line where the device
   * has one, else by writing zero torque. 0: the device has confirmed it. Called at any time, from any
   * thread, and from another process that has called nothing else of this library, while read() or write()
   * may hang; so it gets no rig, but the options of create(), and opens what it needs itself. May be called
   * again and again. */
  int (*disable)(const char* options);

  /* Realtime, may be NULL. heartbeat: once a cycle, after write(), with 0 and 1 in turn, for a circuit that
   * takes the enable away when the line stands still. set_onset: 1 in the cycle in which a perturbation
   * begins, 0 when it is over, for a digital output that other recorders can see. */
  void (*heartbeat)(void* rig, int32_t level);
  void (*set_onset)(void* rig, int32_t is_on);

  /* Auxiliary channels; all three or none. How many there are, at most 32, and what the one of this number
   * is: asked for after configure(), constant from then on. */
  uint32_t (*count_auxiliary)(void* rig);
  void (*describe_auxiliary)(void* rig, uint32_t channel, tonus_driver_auxiliary* description);

  /* Realtime: in each cycle after write(). For each channel in turn, the newest counts[channel] values up to
   * the cycle's read(), in the order of time: with a rate of 2 kHz in a loop of 1 kHz two a cycle, the last
   * one as old as the reading itself. A channel slower than the loop has 0 in most cycles. Every place holds
   * a NaN before; what was not measured is left so. */
  void (*read_auxiliary)(void* rig, const uint32_t* counts, float* values);
} tonus_driver_v2_table;

/* The one symbol of version 2; looked up first. */
const tonus_driver_v2_table* tonus_driver_v2(void);

#ifdef __cplusplus
}
#endif

#endif
