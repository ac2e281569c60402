/* Faults that last, after any history, in exported C: each ends in its mode or a later one within its time, no later
 * mode is left again, and every command is within limits.
 *   lasting FLIGHTS SEED; prints how many flights ended in each mode.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "controller.h"
#include "test_vector.h"

enum { POSE, JOINTS, LATE, LAND, STOP }; /* as in `flags` */
enum { FAULTS = 6, LONGEST = 250 };

static const struct {
  const char* name;
  int ticks;      /* of 5 ms, in which it has to be met */
  unsigned least; /* mode that it ends in, or a later one */
} faults[FAULTS] = {{"stop", 1, 4},           {"land", 1, 2},   {"pose is no number", 202, 4},
                    {"no new pose", 202, 4}, {"angles are no numbers", 122, 2}, {"no command", 102, 2}};

static uint64_t seed;

static uint64_t drawn(void) {
  seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
  return seed;
}

static int chance(double share) { return (double)(drawn() >> 11) / 9007199254740992.0 < share; }

static double about(double size) { return size * ((double)(drawn() >> 11) / 4503599627370496.0 - 1.0); }

static void history(double* flags, double* measurement, double* step) {
  if (chance(0.02)) *step += about(chance(0.3) ? 2.0 : 0.1); /* the clock of the stamps is set */
  if (chance(0.1)) flags[POSE] = 0.0;
  if (chance(0.1)) flags[JOINTS] = 0.0;
  if (chance(0.1)) flags[LATE] = 1.0;
  if (chance(0.0005)) flags[LAND] = 1.0;
  if (chance(0.05)) measurement[drawn() % SKYLIMB_MEASUREMENT_VELOCITY] += about(0.5);
  if (chance(0.02)) measurement[drawn() % SKYLIMB_MEASUREMENT_SIZE] = NAN;
}

static void lasting(int fault, double* flags, double* measurement) {
  if (fault == 0) flags[STOP] = 1.0;
  if (fault == 1) flags[LAND] = 1.0;
  if (fault == 2) measurement[SKYLIMB_MEASUREMENT_QUATERNION] = NAN;
  if (fault == 3) flags[POSE] = 0.0;
  if (fault == 4) measurement[SKYLIMB_MEASUREMENT_JOINT_ANGLES] = NAN;
  if (fault == 5) flags[LATE] = 1.0;
}

int main(int argc, char** argv) {
  double state[SKYLIMB_STATE_SIZE], flags[SKYLIMB_FLAGS_SIZE], measurement[SKYLIMB_MEASUREMENT_SIZE];
  double command[SKYLIMB_COMMAND_SIZE], signals[SKYLIMB_SIGNALS_SIZE];
  long flights = argc > 1 ? atol(argv[1]) : 100, modes[8] = {0};
  seed = argc > 2 ? (uint64_t)atol(argv[2]) * 2654435761u + 1 : 1;
  for (long flight = 0; flight < flights; flight++) {
    int fault = (int)(drawn() % FAULTS), onset = 20 + (int)(drawn() % 400), met = 0;
    unsigned mode = 0, before = 0;
    double step = 0.0;
    skylimb_reset(state);
    for (int k = 0; k < onset + LONGEST; k++) {
      int row = k / 2 % TEST_TICKS;
      memcpy(flags, skylimb_all_well, sizeof flags);
      memcpy(measurement, test_measurement[row], sizeof measurement);
      if (k < onset)
        history(flags, measurement, &step);
      else
        lasting(fault, flags, measurement);
      measurement[SKYLIMB_MEASUREMENT_CAPTURE_AGE] += step;
      for (int i = 0; i < SKYLIMB_COMMAND_SIZE; i++) command[i] = NAN;
      mode = (unsigned)SKYLIMB_MODE(skylimb_controller_step(state, flags, measurement, test_reference[row],
                                                            skylimb_preset_gains, command, signals)) & 7u;
      for (int i = 0; i < SKYLIMB_COMMAND_SIZE; i++)
        if (!(command[i] >= skylimb_least_command[i] && command[i] <= skylimb_greatest_command[i] && isfinite(command[i]))) {
          printf("flight %ld, tick %d: command %d is %g\n", flight, k, i, command[i]);
          return 1;
        }
      if (before >= 2 && mode < before) {
        printf("flight %ld, tick %d: mode %u after %u\n", flight, k, mode, before);
        return 1;
      }
      before = mode;
      met |= k >= onset && mode >= faults[fault].least;
      if (k - onset + 1 == faults[fault].ticks && !met) {
        printf("flight %ld: '%s' for %d ticks, and mode %u\n", flight, faults[fault].name, faults[fault].ticks, mode);
        return 1;
      }
    }
    modes[mode]++;
  }
  for (int i = 0; i < 5; i++) printf("%ld ", modes[i]);
  printf("\n");
  return 0;
}
