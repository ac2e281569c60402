/* The controller '@CONTROLLER@' of the robot '@ROBOT@', to be called every @PERIOD@ s.
 *
 * Every vector is flat; the numbers below say where each of its entries begins. Axes: W is the world, z up.
 * Nothing is allocated and nothing is kept between calls but the state, which belongs to the caller.
 */
#ifndef SKYLIMB_CONTROLLER_H
#define SKYLIMB_CONTROLLER_H

#define SKYLIMB_PERIOD @PERIOD@ /* s */

@SIZES@

#ifdef __cplusplus
extern "C" {
#endif

/* What the state begins with, and the preset's gains. */
extern const double skylimb_initial_state[SKYLIMB_STATE_SIZE];
extern const double skylimb_preset_gains[SKYLIMB_GAINS_SIZE];

/* One control tick. Takes the state along; `signals` tells what went on inside. */
void skylimb_controller_step(double state[SKYLIMB_STATE_SIZE],
                             const double measurement[SKYLIMB_MEASUREMENT_SIZE],
                             const double reference[SKYLIMB_REFERENCE_SIZE],
                             const double gains[SKYLIMB_GAINS_SIZE],
                             double command[SKYLIMB_COMMAND_SIZE],
                             double signals[SKYLIMB_SIGNALS_SIZE]);

#ifdef __cplusplus
}
#endif

#endif
