/* Measurements in, commands out, as on a flight computer. 64-bit numbers of this machine, one block a tick:
 *   cc -std=c99 -O2 host.c controller.c controller_function.c -o host -lm && ./host < flight.bin > commands.bin
 * In: measurement, then reference. Out: command. On the error stream: how long a tick took.
 */
#include <stdio.h>
#include <time.h>
#include "controller.h"

static double state[SKYLIMB_STATE_SIZE], signals[SKYLIMB_SIGNALS_SIZE];
static double given[SKYLIMB_MEASUREMENT_SIZE + SKYLIMB_REFERENCE_SIZE], command[SKYLIMB_COMMAND_SIZE];

int main(void) {
  const size_t count = sizeof given / sizeof *given;
  double worst = 0.0, total = 0.0;
  long ticks = 0;
  size_t read;
  for (int i = 0; i < SKYLIMB_STATE_SIZE; i++) state[i] = skylimb_initial_state[i];
  while ((read = fread(given, sizeof *given, count, stdin)) == count) {
    clock_t begun = clock();
    skylimb_controller_step(state, given, given + SKYLIMB_MEASUREMENT_SIZE, skylimb_preset_gains, command, signals);
    double took = (double)(clock() - begun) / CLOCKS_PER_SEC;
    if (took > worst) worst = took;
    total += took;
    ticks++;
    if (fwrite(command, sizeof command, 1, stdout) != 1) return 2; /* nobody takes the commands */
  }
  fprintf(stderr, "%ld ticks, %.1f us each, %.1f us at worst, of %g us\n", ticks, ticks ? 1e6 * total / (double)ticks : 0.0,
          1e6 * worst, 1e6 * SKYLIMB_PERIOD);
  return read == 0 && ticks > 0 ? 0 : 1; /* a last block that is cut is no tick */
}
