/* The controller's numbers, and the function to call. */
#include "controller.h"

int @FUNCTION@(const double** arg, double** res, long long* iw, double* w, int mem);

const double skylimb_initial_state[SKYLIMB_STATE_SIZE] = {@STATE@};

const double skylimb_preset_gains[SKYLIMB_GAINS_SIZE] = {@GAINS@};

void skylimb_controller_step(double state[SKYLIMB_STATE_SIZE],
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
  @FUNCTION@(arg, res, 0, work, 0);
  for (i = 0; i < SKYLIMB_STATE_SIZE; i++) state[i] = next[i];
}
