/* Flies the test vector:  cc main.c controller.c controller_function.c -o example -lm && ./example */
#include <math.h>
#include <stdio.h>
#include "controller.h"
#include "test_vector.h"

static double difference(const double* found, const double* wanted, int count) {
  double most = 0.0;
  for (int i = 0; i < count; i++) {
    double apart = fabs(found[i] - wanted[i]) / fmax(1.0, fabs(wanted[i]));
    if (!(apart <= most)) most = apart; /* also takes what is not a number */
  }
  return most;
}

int main(void) {
  double state[SKYLIMB_STATE_SIZE], command[SKYLIMB_COMMAND_SIZE], signals[SKYLIMB_SIGNALS_SIZE];
  double most = 0.0;
  skylimb_reset(state);
  for (int k = 0; k < TEST_TICKS; k++) {
    skylimb_controller_step(state, skylimb_all_well, test_measurement[k], test_reference[k], skylimb_preset_gains,
                            command, signals);
    double apart = fmax(difference(command, test_command[k], SKYLIMB_COMMAND_SIZE),
                        difference(signals, test_signals[k], SKYLIMB_SIGNALS_SIZE));
    if (!(apart <= most)) most = apart;
  }
  printf("%d ticks, largest difference %.3g (at most %.3g)\n", TEST_TICKS, most, TEST_TOLERANCE);
  return most <= TEST_TOLERANCE ? 0 : 1;
}
