/* The controller '@CONTROLLER@' of the robot '@ROBOT@' under its supervisor, to be called every @PERIOD@ s.
 *
 * Every vector is flat; the numbers below say where each of its entries begins. Axes: W is the world, z up; C has
 * its origin in the centre of gravity, and z along the net thrust of a hover. The measured link is '@MEASURED@'.
 * Nothing is allocated and nothing is kept between calls but the state, which belongs to the caller. Whatever
 * comes in, NaN and infinity too, the command is finite and within its limits.
 */
#ifndef SKYLIMB_CONTROLLER_H
#define SKYLIMB_CONTROLLER_H

#define SKYLIMB_PERIOD @PERIOD@ /* s */
#define SKYLIMB_ROBOT @ROBOT_TEXT@
#define SKYLIMB_CONTROLLER @CONTROLLER_TEXT@

/* Of all of this export: a host compares it with `skylimb_digest` of what it was linked with. */
#define SKYLIMB_DIGEST @DIGEST@

@SIZES@

/* When the supervisor acts; its bits below name these keys.
@LIMITS@
 */

/* The status word: the mode from SKYLIMB_MODE_SHIFT on, and a bit for all that is wrong. */
#define SKYLIMB_MODE_SHIFT 24
#define SKYLIMB_MODE(status) ((status) >> SKYLIMB_MODE_SHIFT)
@STATUS@

#ifdef __cplusplus
extern "C" {
#endif

/* SKYLIMB_DIGEST of the code that was compiled. */
extern const unsigned long skylimb_digest;

/* What the state begins with, the preset's gains, the limits of a command, and the flags while all is well. */
extern const double skylimb_initial_state[SKYLIMB_STATE_SIZE];
extern const double skylimb_preset_gains[SKYLIMB_GAINS_SIZE];
extern const double skylimb_least_command[SKYLIMB_COMMAND_SIZE];
extern const double skylimb_greatest_command[SKYLIMB_COMMAND_SIZE];
extern const double skylimb_all_well[SKYLIMB_FLAGS_SIZE];

/* Begin a flight: a supervisor that has broken one off never goes back to it. */
void skylimb_reset(double state[SKYLIMB_STATE_SIZE]);

/* One control tick; the status word. Takes the state along; `signals` tells what went on inside. */
unsigned long skylimb_controller_step(double state[SKYLIMB_STATE_SIZE],
                                      const double flags[SKYLIMB_FLAGS_SIZE],
                                      const double measurement[SKYLIMB_MEASUREMENT_SIZE],
                                      const double reference[SKYLIMB_REFERENCE_SIZE],
                                      const double gains[SKYLIMB_GAINS_SIZE],
                                      double command[SKYLIMB_COMMAND_SIZE],
                                      double signals[SKYLIMB_SIGNALS_SIZE]);

#ifdef __cplusplus
}
#endif

#endif
