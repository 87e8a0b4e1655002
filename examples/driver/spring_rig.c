/* A driver for tonus-rig-agent, built with nothing but tonus_driver.h.
 *
 * The "hardware" is computed here: two joints that do not feel each other, each with inertia and friction,
 * and a hand that pulls the handle back to where it began, like a spring. Enough to run every phase of a
 * trial. Where a real driver talks to its card, it says so.
 *
 * Options, separated by blanks: stiffness=N_per_m (default 300), damping=Ns_per_m (default 20);
 * amplifier=FILE: the amplifier is a page of this file, which other programs can look at, and the rig's clock
 * is the machine's, as on hardware; hang_after=CYCLES: read() does not return after so many, for tests of
 * what happens then; auxiliary=on: three auxiliary channels, the spring's stretch with every cycle, the handle's
 * speed twice as fast, and the digital output of the onset.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include "tonus_driver.h"

#define COUNTS_PER_RAD 1273.2395447351628 /* 8000 a turn */
#define NEWTON_PER_VOLT 4.45

static const double kLinks[2] = {0.30, 0.35};              /* m */
static const double kInertia[2] = {0.95, 0.93};            /* kg m2 */
static const double kFriction[2] = {0.05, 0.05};           /* N m s/rad */
static const double kStart[2] = {0.0, 1.5707963267948966}; /* rad: the handle at 0.30 m, 0.35 m */
static const double kTorqueLimit = 25.0;                   /* N m */

/* What another program can see of the amplifier, and its enable line. Torque acts only while it is enabled.
 */
typedef struct amplifier {
  _Atomic int32_t is_enabled;
  _Atomic int32_t heartbeat;
  _Atomic int64_t disabled_ns; /* CLOCK_MONOTONIC, of the first disable since activate */
  _Atomic int64_t written_ns;  /* of the last write */
  _Atomic double torque[2];    /* N m */
} amplifier;

typedef struct rig {
  amplifier* out; /* NULL: inside this program alone */
  long hang_after, cycles;
  int has_auxiliary, is_onset;
  double stretch, speed, speed_before; /* at the last read, and one before; mm, mm/s */
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

static int64_t monotonic_ns(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* A real driver opens its card here. */
static amplifier* open_amplifier(const char* file) {
  const int descriptor = open(file, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0) return NULL;
  void* page = ftruncate(descriptor, sizeof(amplifier)) == 0
                   ? mmap(NULL, sizeof(amplifier), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0)
                   : MAP_FAILED;
  close(descriptor);
  return page == MAP_FAILED ? NULL : page;
}

/* The name behind amplifier=; empty: there is none. */
static void amplifier_name(const char* options, char name[256]) {
  const char* found = strstr(options, "amplifier=");
  name[0] = '\0';
  if (found != NULL) sscanf(found + strlen("amplifier="), "%255s", name);
}

static void* create(const char* options, char* error, size_t error_size) {
  rig* r = calloc(1, sizeof *r);
  if (r == NULL) return refuse(error, error_size, "no memory"), NULL;
  r->stiffness = 300.0;
  r->damping = 20.0;
  r->hang_after = -1;
  char word[300];
  int used = 0;
  for (const char* p = options; sscanf(p, "%299s%n", word, &used) == 1; p += used) {
    char rest = '\0';
    if (strncmp(word, "amplifier=", 10) == 0) {
      r->out = open_amplifier(word + 10);
      if (r->out != NULL) continue;
      snprintf(error, error_size, "option is %s: the file cannot be opened", word);
      free(r);
      return NULL;
    }
    if (sscanf(word, "hang_after=%ld%c", &r->hang_after, &rest) == 1) continue;
    if (strcmp(word, "auxiliary=on") == 0) {
      r->has_auxiliary = 1;
      continue;
    }
    const int good = sscanf(word, "stiffness=%lf%c", &r->stiffness, &rest) == 1 ||
                     sscanf(word, "damping=%lf%c", &r->damping, &rest) == 1;
    if (!good ||
        !(r->stiffness >= 0.0 && r->stiffness <= 5000.0 && r->damping >= 0.0 && r->damping <= 500.0)) {
      snprintf(error, error_size,
               "option: %s is not allowed; expected stiffness=0..5000 (N/m) and damping=0..500 (N s/m)", word);
      free(r);
      return NULL;
    }
  }
  memcpy(r->q, kStart, sizeof r->q);
  place(r->q, r->rest);
  return r; /* A real driver opens its card here, or in configure(). */
}

static void destroy(void* self) {
  rig* r = self;
  if (r->out != NULL) munmap(r->out, sizeof(amplifier));
  free(r);
}

static int configure(void* self, double period, char* error, size_t error_size) {
  rig* r = self;
  if (!(period >= 1e-5 && period <= 0.01)) {
    snprintf(error, error_size, "period: %g s is not allowed; expected 0.00001 s to 0.01 s", period);
    return 1;
  }
  r->period = period;
  return 0;
}

static void describe(void* self, tonus_driver_description* d) {
  const rig* r = self;
  memset(d, 0, sizeof *d);
  for (int i = 0; i < 2; ++i) {
    d->link_lengths_m[i] = kLinks[i];
    d->encoder_counts_per_rad[i] = COUNTS_PER_RAD;
    d->encoder_sign[i] = 1.0;
  }
  d->force_calibration_N_per_V[0] = NEWTON_PER_VOLT;
  d->force_calibration_N_per_V[3] = NEWTON_PER_VOLT;
  d->force_saturation_V = 10.0;
  d->has_own_clock = r->out == NULL; /* A real driver: 0, and stamps of CLOCK_MONOTONIC. */
}

static int activate(void* self, char* error, size_t error_size) {
  rig* r = self;
  (void)error, (void)error_size;
  if (r->out != NULL) { /* A real driver enables its amplifiers here. */
    r->out->torque[0] = r->out->torque[1] = 0.0;
    r->out->disabled_ns = 0;
    r->out->is_enabled = 1;
  }
  return 0;
}

static void deactivate(void* self) {
  rig* r = self;
  r->torque[0] = r->torque[1] = 0.0; /* A real driver writes zero torque and disables its amplifiers. */
  if (r->out == NULL) return;
  r->out->torque[0] = r->out->torque[1] = 0.0;
  r->out->is_enabled = 0;
}

/* A card with a buffer of its own has these values there. */
static void measure_auxiliary(rig* r) {
  double point[2];
  place(r->q, point);
  const double x2 = kLinks[1] * cos(r->q[0] + r->q[1]), y2 = kLinks[1] * sin(r->q[0] + r->q[1]);
  r->stretch = 1e3 * hypot(point[0] - r->rest[0], point[1] - r->rest[1]);
  r->speed_before = r->speed;
  r->speed = 1e3 * hypot(-point[1] * r->rate[0] - y2 * r->rate[1], point[0] * r->rate[0] + x2 * r->rate[1]);
}

static int read_rig(void* self, tonus_driver_reading* reading) {
  rig* r = self;
  const double turn = r->q[0] + r->q[1]; /* the sensor turns with the outer link */
  while (r->hang_after >= 0 && r->cycles > r->hang_after) pause();
  ++r->cycles;
  reading->acquisition_ns = r->out == NULL ? r->now_ns : monotonic_ns();
  for (int i = 0; i < 2; ++i) reading->encoder_count[i] = floor(r->q[i] * COUNTS_PER_RAD);
  reading->force_V[0] = (cos(turn) * r->force[0] + sin(turn) * r->force[1]) / NEWTON_PER_VOLT;
  reading->force_V[1] = (-sin(turn) * r->force[0] + cos(turn) * r->force[1]) / NEWTON_PER_VOLT;
  reading->is_emergency_stop_pressed = 0;
  measure_auxiliary(r);
  return TONUS_DRIVER_OK;
}

/* Semi-implicit Euler, ten steps a period. */
static int write_rig(void* self, const double torque[2]) {
  rig* r = self;
  const double h = r->period / 10.0;
  const int is_on = r->out == NULL || r->out->is_enabled;
  for (int i = 0; i < 2; ++i) {
    r->torque[i] = is_on ? fmax(-kTorqueLimit, fmin(kTorqueLimit, torque[i])) : 0.0;
    if (r->out != NULL) r->out->torque[i] = r->torque[i];
  }
  if (r->out != NULL) r->out->written_ns = monotonic_ns();
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
  return is_on ? TONUS_DRIVER_OK : TONUS_DRIVER_FAILED;
}

static void describe_safety(void* self, tonus_driver_safety* safety) {
  const rig* r = self;
  memset(safety, 0, sizeof *safety);
  safety->moves_nothing_real = r->out == NULL;
  snprintf(safety->by_itself, sizeof safety->by_itself, "nothing: the last torque stays");
}

/* From another process too: everything that it needs it opens itself. */
static int disable(const char* options) {
  char name[256];
  amplifier_name(options, name);
  if (name[0] == '\0') return TONUS_DRIVER_FAILED;
  amplifier* out = open_amplifier(name);
  if (out == NULL) return TONUS_DRIVER_FAILED;
  int64_t never = 0;
  out->is_enabled = 0;
  out->torque[0] = out->torque[1] = 0.0;
  atomic_compare_exchange_strong(&out->disabled_ns, &never, monotonic_ns());
  munmap(out, sizeof *out);
  return TONUS_DRIVER_OK;
}

static void heartbeat(void* self, int32_t level) {
  rig* r = self;
  if (r->out != NULL) r->out->heartbeat = level;
}

/* A real driver sets its digital output. */
static void set_onset(void* self, int32_t is_on) { ((rig*)self)->is_onset = is_on; }

static uint32_t count_auxiliary(void* self) { return ((rig*)self)->has_auxiliary ? 3 : 0; }

static void describe_auxiliary(void* self, uint32_t channel, tonus_driver_auxiliary* d) {
  static const char* const kNames[3] = {"Stretch", "Speed", "Onset"};
  static const char* const kUnits[3] = {"mm", "mm/s", "n/a"};
  const rig* r = self;
  snprintf(d->name, sizeof d->name, "%s", kNames[channel]);
  snprintf(d->type, sizeof d->type, "%s", channel == 2 ? "TRIG" : "MISC");
  snprintf(d->unit, sizeof d->unit, "%s", kUnits[channel]);
  d->unit_per_value = 1.0;
  d->rate_Hz = round((channel == 1 ? 2.0 : 1.0) / r->period);
}

/* A channel has 0 or 1 values in a cycle here, the speed 2: the first one half a cycle before the reading. */
static void read_auxiliary(void* self, const uint32_t* counts, float* values) {
  const rig* r = self;
  for (uint32_t i = 0; i < counts[0]; ++i) *values++ = (float)r->stretch;
  for (uint32_t i = 0; i < counts[1]; ++i)
    *values++ = (float)(i + 1 == counts[1] ? r->speed : 0.5 * (r->speed_before + r->speed));
  for (uint32_t i = 0; i < counts[2]; ++i) *values++ = (float)r->is_onset;
}

const tonus_driver_v2_table* tonus_driver_v2(void) {
  static const tonus_driver_v2_table table = {
      .base = {.version = TONUS_DRIVER_VERSION_2,
               .size = sizeof(tonus_driver_v2_table),
               .create = create,
               .destroy = destroy,
               .configure = configure,
               .describe = describe,
               .activate = activate,
               .deactivate = deactivate,
               .read = read_rig,
               .write = write_rig,
               .begin_trial = NULL},
      .describe_safety = describe_safety,
      .disable = disable,
      .heartbeat = heartbeat,
      .set_onset = set_onset,
      .count_auxiliary = count_auxiliary,
      .describe_auxiliary = describe_auxiliary,
      .read_auxiliary = read_auxiliary,
  };
  return &table;
}
