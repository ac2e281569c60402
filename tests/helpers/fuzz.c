/* Random measurements, references, gains and words into exported C: every command and pace finite, within limits.
 *   fuzz TICKS SEED; prints how many ticks were flown in each mode.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "controller.h"
#include "test_vector.h"

static uint64_t seed;

static uint64_t drawn(void) {
  seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
  return seed;
}

static double uniform(void) { return (double)(drawn() >> 11) / 9007199254740992.0; }

static double odd(double usual) {
  static const double special[] = {NAN, INFINITY, -INFINITY, 0.0, -0.0, DBL_MIN / 8, 4.9e-324, DBL_MAX, -DBL_MAX,
                                   1e300, -1e300, 1e9, 1e-300};
  uint64_t kind = drawn() % 16;
  if (kind < 13) return special[kind];
  return kind == 13 ? usual + uniform() - 0.5 : kind == 14 ? usual * 1e6 * (uniform() - 0.5) : 7.0 * (uniform() - 0.5);
}

static void spoil(double* values, int count, double share) {
  for (int i = 0; i < count; i++)
    if (uniform() < share) values[i] = odd(values[i]);
}

int main(int argc, char** argv) {
  double state[SKYLIMB_STATE_SIZE], flags[SKYLIMB_FLAGS_SIZE], measurement[SKYLIMB_MEASUREMENT_SIZE];
  double reference[SKYLIMB_REFERENCE_SIZE], gains[SKYLIMB_GAINS_SIZE];
  double command[SKYLIMB_COMMAND_SIZE], signals[SKYLIMB_SIGNALS_SIZE];
  long ticks = argc > 1 ? atol(argv[1]) : 1000, modes[8] = {0};
  double share = 0.0;
  seed = argc > 2 ? (uint64_t)atol(argv[2]) * 2654435761u + 1 : 1;
  skylimb_reset(state);
  for (long k = 0; k < ticks; k++) {
    unsigned long status;
    int row = (int)(k % TEST_TICKS);
    if (k % 400 == 0) { /* another flight: how often something is spoilt, up to everything */
      skylimb_reset(state);
      share = uniform() < 0.3 ? 0.0 : pow(10.0, -4.0 * uniform());
    }
    memcpy(flags, skylimb_all_well, sizeof flags);
    memcpy(measurement, test_measurement[row], sizeof measurement);
    memcpy(reference, test_reference[row], sizeof reference);
    memcpy(gains, skylimb_preset_gains, sizeof gains);
    spoil(measurement, SKYLIMB_MEASUREMENT_SIZE, share);
    spoil(reference, SKYLIMB_REFERENCE_SIZE, 0.3 * share);
    spoil(gains, SKYLIMB_GAINS_SIZE, 0.1 * share);
    spoil(flags, SKYLIMB_FLAGS_SIZE, 0.1 * share);
    if (uniform() < 1e-3 * share) spoil(state, SKYLIMB_STATE_SIZE, share); /* memory that somebody wrote into */
    for (int i = 0; i < SKYLIMB_COMMAND_SIZE; i++) command[i] = NAN;
    status = skylimb_controller_step(state, flags, measurement, reference, gains, command, signals);
    modes[SKYLIMB_MODE(status) & 7]++;
#ifdef SKYLIMB_SIGNALS_PACE
    if (!(signals[SKYLIMB_SIGNALS_PACE] >= 0.0 && signals[SKYLIMB_SIGNALS_PACE] <= 100.0)) {
      printf("tick %ld: the pace is %g\n", k, signals[SKYLIMB_SIGNALS_PACE]);
      return 1;
    }
#endif
    for (int i = 0; i < SKYLIMB_COMMAND_SIZE; i++)
      if (!(isfinite(command[i]) && command[i] >= skylimb_least_command[i] && command[i] <= skylimb_greatest_command[i])) {
        printf("tick %ld: command %d is %g in mode %lu\n", k, i, command[i], SKYLIMB_MODE(status));
        return 1;
      }
  }
  for (int i = 0; i < 5; i++) printf("%ld ", modes[i]);
  printf("\n");
  return 0;
}
