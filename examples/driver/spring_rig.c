/* A driver for tonus-rig-agent, built with nothing but tonus_driver.h.
 *
 * The "hardware" is computed here: two joints that do not feel each other, each with inertia and friction,
 * and a hand that pulls the handle back to where it began, like a spring. Enough to run every phase of a
 * trial. Where a real driver talks to its card, it says so.
 *
 * Options, separated by blanks: stiffness=N_per_m (default 300), damping=Ns_per_m (default 20).
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tonus_driver.h"

#define COUNTS_PER_RAD 1273.2395447351628 /* 8000 a turn */
#define NEWTON_PER_VOLT 4.45

static const double kLinks[2] = {0.30, 0.35};              /* m */
static const double kInertia[2] = {0.95, 0.93};            /* kg m2 */
static const double kFriction[2] = {0.05, 0.05};           /* N m s/rad */
static const double kStart[2] = {0.0, 1.5707963267948966}; /* rad: the handle at 0.30 m, 0.35 m */
static const double kTorqueLimit = 25.0;                   /* N m */

typedef struct rig {
  double period;
  double stiffness, damping; /* of the hand */
  double q[2], rate[2];
  double rest[2];   /* m: where the hand holds the handle */
  double force[2];  /* N on the hand, in R */
  double torque[2]; /* as last written */
  int64_t now_ns;
} rig;

static int refuse(char* error, size_t size, const char* what) {
  snprintf(error, size, "%s", what);
  return 1;
}

static void place(const double q[2], double point[2]) {
  point[0] = kLinks[0] * cos(q[0]) + kLinks[1] * cos(q[0] + q[1]);
  point[1] = kLinks[0] * sin(q[0]) + kLinks[1] * sin(q[0] + q[1]);
}

static void* create(const char* options, char* error, size_t error_size) {
  rig* r = calloc(1, sizeof *r);
  if (r == NULL) return refuse(error, error_size, "no memory"), NULL;
  r->stiffness = 300.0;
  r->damping = 20.0;
  char word[64];
  int used = 0;
  for (const char* p = options; sscanf(p, "%63s%n", word, &used) == 1; p += used) {
    char rest = '\0';
    const int good = sscanf(word, "stiffness=%lf%c", &r->stiffness, &rest) == 1 ||
                     sscanf(word, "damping=%lf%c", &r->damping, &rest) == 1;
    if (!good ||
        !(r->stiffness >= 0.0 && r->stiffness <= 5000.0 && r->damping >= 0.0 && r->damping <= 500.0)) {
      snprintf(error, error_size,
               "option is %s, allowed are stiffness=0..5000 (N/m) and damping=0..500 (N s/m)", word);
      free(r);
      return NULL;
    }
  }
  memcpy(r->q, kStart, sizeof r->q);
  place(r->q, r->rest);
  return r; /* A real driver opens its card here, or in configure(). */
}

static void destroy(void* self) { free(self); }

static int configure(void* self, double period, char* error, size_t error_size) {
  rig* r = self;
  if (!(period >= 1e-5 && period <= 0.01))
    return refuse(error, error_size, "period is refused, allowed is 0.00001 s to 0.01 s");
  r->period = period;
  return 0;
}

static void describe(void* self, tonus_driver_description* d) {
  (void)self;
  memset(d, 0, sizeof *d);
  for (int i = 0; i < 2; ++i) {
    d->link_lengths_m[i] = kLinks[i];
    d->encoder_counts_per_rad[i] = COUNTS_PER_RAD;
    d->encoder_sign[i] = 1.0;
  }
  d->force_calibration_N_per_V[0] = NEWTON_PER_VOLT;
  d->force_calibration_N_per_V[3] = NEWTON_PER_VOLT;
  d->force_saturation_V = 10.0;
  d->has_own_clock = 1; /* A real driver: 0, and stamps of CLOCK_MONOTONIC. */
}

static int activate(void* self, char* error, size_t error_size) {
  (void)self, (void)error, (void)error_size;
  return 0; /* A real driver enables its amplifiers here. */
}

static void deactivate(void* self) {
  rig* r = self;
  r->torque[0] = r->torque[1] = 0.0; /* A real driver writes zero torque and disables its amplifiers. */
}

static int read_rig(void* self, tonus_driver_reading* reading) {
  rig* r = self;
  const double turn = r->q[0] + r->q[1]; /* the sensor turns with the outer link */
  reading->acquisition_ns = r->now_ns;
  for (int i = 0; i < 2; ++i) reading->encoder_count[i] = floor(r->q[i] * COUNTS_PER_RAD);
  reading->force_V[0] = (cos(turn) * r->force[0] + sin(turn) * r->force[1]) / NEWTON_PER_VOLT;
  reading->force_V[1] = (-sin(turn) * r->force[0] + cos(turn) * r->force[1]) / NEWTON_PER_VOLT;
  reading->is_emergency_stop_pressed = 0;
  return TONUS_DRIVER_OK;
}

/* Semi-implicit Euler, ten steps a period. */
static int write_rig(void* self, const double torque[2]) {
  rig* r = self;
  const double h = r->period / 10.0;
  for (int i = 0; i < 2; ++i) r->torque[i] = fmax(-kTorqueLimit, fmin(kTorqueLimit, torque[i]));
  for (int step = 0; step < 10; ++step) {
    double point[2];
    place(r->q, point);
    const double x2 = kLinks[1] * cos(r->q[0] + r->q[1]), y2 = kLinks[1] * sin(r->q[0] + r->q[1]);
    const double velocity[2] = {-point[1] * r->rate[0] - y2 * r->rate[1],
                                point[0] * r->rate[0] + x2 * r->rate[1]};
    for (int i = 0; i < 2; ++i)
      r->force[i] = r->stiffness * (point[i] - r->rest[i]) + r->damping * velocity[i];
    const double back[2] = {-point[1] * r->force[0] + point[0] * r->force[1],
                            -y2 * r->force[0] + x2 * r->force[1]};
    for (int i = 0; i < 2; ++i) {
      r->rate[i] += h / kInertia[i] * (r->torque[i] - kFriction[i] * r->rate[i] - back[i]);
      r->q[i] += h * r->rate[i];
    }
  }
  r->now_ns += (int64_t)llround(1e9 * r->period);
  return TONUS_DRIVER_OK;
}

const tonus_driver_v1_table* tonus_driver_v1(void) {
  static const tonus_driver_v1_table table = {
      .version = TONUS_DRIVER_VERSION,
      .size = sizeof(tonus_driver_v1_table),
      .create = create,
      .destroy = destroy,
      .configure = configure,
      .describe = describe,
      .activate = activate,
      .deactivate = deactivate,
      .read = read_rig,
      .write = write_rig,
      .begin_trial = NULL,
  };
  return &table;
}
