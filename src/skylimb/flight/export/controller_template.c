/* The controller's numbers, and the function to call. */
#include <math.h>
#include "controller.h"

@EXACT@
#if SKYLIMB_DIGEST != @DIGEST@
#error "controller.h is of another export than controller.c"
#endif

const unsigned long skylimb_digest = @DIGEST@;

int @FUNCTION@(const double** arg, double** res, long long* iw, double* w, int mem);

const double skylimb_initial_state[SKYLIMB_STATE_SIZE] = {@STATE@};

const double skylimb_preset_gains[SKYLIMB_GAINS_SIZE] = {@GAINS@};

const double skylimb_least_command[SKYLIMB_COMMAND_SIZE] = {@LEAST@};

const double skylimb_greatest_command[SKYLIMB_COMMAND_SIZE] = {@GREATEST@};

const double skylimb_all_well[SKYLIMB_FLAGS_SIZE] = {@WELL@};

void skylimb_reset(double state[SKYLIMB_STATE_SIZE]) {
  int i;
  for (i = 0; i < SKYLIMB_STATE_SIZE; i++) state[i] = skylimb_initial_state[i];
}

unsigned long skylimb_controller_step(double state[SKYLIMB_STATE_SIZE],
                                      const double flags[SKYLIMB_FLAGS_SIZE],
                                      const double measurement[SKYLIMB_MEASUREMENT_SIZE],
                                      const double reference[SKYLIMB_REFERENCE_SIZE],
                                      const double gains[SKYLIMB_GAINS_SIZE],
                                      double command[SKYLIMB_COMMAND_SIZE],
                                      double signals[SKYLIMB_SIGNALS_SIZE]) {
  double next[SKYLIMB_STATE_SIZE];
  double work[@WORK@];
  const double* arg[@ARGUMENTS@] = {state, measurement, reference, gains};
  double* res[@RESULTS@] = {next, command, signals};
  int i;
  for (i = 0; i < SKYLIMB_FLAGS_SIZE; i++) state[SKYLIMB_STATE_FLAGS + i] = flags[i];
  @FUNCTION@(arg, res, 0, work, 0);
  for (i = 0; i < SKYLIMB_STATE_SIZE; i++) state[i] = next[i];
  return (unsigned long)signals[SKYLIMB_SIGNALS_SUPERVISOR_BITS] |
         (unsigned long)signals[SKYLIMB_SIGNALS_SUPERVISOR_MODE] << SKYLIMB_MODE_SHIFT;
}
