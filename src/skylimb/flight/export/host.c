/* Measurements in, commands out, as on a flight computer. 64-bit numbers of this machine, one block a tick:
 *   cc -std=c99 -O2 host.c controller.c controller_function.c -o host -lm && ./host < flight.bin > commands.bin
 * In: measurement, then reference. Out: command. On the error stream: how long a tick took, and what went wrong.
 */
#include <stdio.h>
#include <string.h>
#include <time.h>
#include "controller.h"

/* Why it ends before its input does, or gives less than it was asked for. */
static int ended(int code, const char* why) {
  fprintf(stderr, "host: %s\n", why);
  return code;
}

static double state[SKYLIMB_STATE_SIZE], signals[SKYLIMB_SIGNALS_SIZE], flags[SKYLIMB_FLAGS_SIZE];
static double given[SKYLIMB_MEASUREMENT_SIZE + SKYLIMB_REFERENCE_SIZE], command[SKYLIMB_COMMAND_SIZE];

int main(void) {
  const size_t count = sizeof given / sizeof *given;
  double worst = 0.0, total = 0.0;
  unsigned long before = 0;
  long ticks = 0;
  size_t read;
  if (skylimb_digest != SKYLIMB_DIGEST) return ended(3, "controller.h is of another export than controller.c");
  skylimb_reset(state);
  while ((read = fread(given, sizeof *given, count, stdin)) == count) {
    unsigned long status;
    clock_t begun = clock();
    double took;
    /* On a robot: flags[SKYLIMB_FLAGS_POSE] = 1 where a pose has come since the last tick, and so on. The input does
     * not say, so a flight whose frames were lost or late comes out otherwise from there on. */
    memcpy(flags, skylimb_all_well, sizeof flags);
    status = skylimb_controller_step(state, flags, given, given + SKYLIMB_MEASUREMENT_SIZE, skylimb_preset_gains,
                                     command, signals);
    took = (double)(clock() - begun) / CLOCKS_PER_SEC;
    if (took > worst) worst = took;
    total += took;
    if (status != before) fprintf(stderr, "tick %ld: mode %lu, status %#lx\n", ticks, SKYLIMB_MODE(status), status);
    before = status;
    ticks++;
    if (fwrite(command, sizeof command, 1, stdout) != 1) return ended(2, "commands cannot be written");
  }
  if (fflush(stdout) != 0) return ended(2, "commands cannot be written"); /* a full disk shows itself here */
  fprintf(stderr, "%ld ticks, %.1f us each, %.1f us at worst, of %g us\n", ticks, ticks ? 1e6 * total / (double)ticks : 0.0,
          1e6 * worst, 1e6 * SKYLIMB_PERIOD);
  if (read != 0) return ended(1, "the input ends within a tick, which is left out");
  return ticks > 0 ? 0 : ended(1, "the input is empty");
}
