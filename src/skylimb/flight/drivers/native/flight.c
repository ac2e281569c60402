/* Flies compiled ticks from inside of the engine, as its control callback.
 *
 * The engine calls back in every step, once positions and velocities are known and before forces are. In the first
 * step of a control tick that is the moment to sense, control and record; what else acts on a flight from outside
 * (a moving wall, a push, friction that varies) is done in the order in which the Python driver does it, so that
 * both fly the same numbers.
 *
 * Everything that a flight needs lies in its own record, whose address it carries in mjData.userdata: any number of
 * flights go on at once. Data that carries no record is left alone.
 */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <mujoco/mujoco.h>

#define MARK 1936419121.0 /* second word of userdata: the first one is a record's address */
/* A tick has 9 arguments and 4 results. The rest is room in which it calls functions of its own. */
#define MOST_ARGUMENTS 512
#define MOST_RESULTS 128

typedef int (*Tick)(const double** arg, double** res, long long* iw, double* w, int mem);

/* Functions of the engine, handed over because the engine's library is loaded already and not linked to. */
typedef struct {
  void (*forward_position)(const mjModel*, mjData*);
  void (*forward_velocity)(const mjModel*, mjData*);
  void (*apply)(const mjModel*, mjData*, const mjtNum*, const mjtNum*, const mjtNum*, int, mjtNum*);
  void (*velocity)(const mjModel*, const mjData*, int, int, mjtNum*, int);
  mjfGeneric previous; /* control callback of the program around us, or null */
} Engine;

/* `Flight`, the record of one flight, is declared here from its twin in flight_struct.py, which says what its fields are. */
@WRENCH@
@WRITTEN@
@FLIGHT@
/* `friction`, made of the symbols of `friction_function` in pair_friction.py, which says what it takes and gives. */
@FRICTION@
static Engine engine;

void skylimb_set_engine(const Engine* functions) { engine = *functions; }

/* Whether the flight is past saving. The verdict is Python's; this keeps a lost flight from burning time. */
static int surely_lost(const Flight* f, const mjData* d, int64_t k) {
  const double *q = d->qpos, *wanted = f->position + 3 * f->at;
  double x = q[0] - wanted[0], y = q[1] - wanted[1], z = q[2] - wanted[2];
  const double* signals = f->log + k * f->n_signals;
  for (int64_t i = 0; i < f->n_watched; i++)
    if (!isfinite(signals[f->watched[i]])) return 1;
  if (1.0 - 2.0 * (q[4] * q[4] + q[5] * q[5]) < f->limits[0]) return 1;
  if (x * x + y * y + z * z > f->limits[1] * f->limits[1]) return 1;
  return q[2] < f->limits[2];
}

/* Whether the engine has warned since this flight was continued. */
static int engine_warned(Flight* f, const mjData* d) {
  int any = 0;
  for (int i = 0; i < mjNWARNING; i++) any |= d->warning[i].number > f->warnings[i];
  if (any)
    for (int i = 0; i < mjNWARNING; i++) f->warnings[i] = d->warning[i].number - f->warnings[i];
  return any;
}

/* Put a flight that was lost to rest, at every step that the engine goes on with it: what diverges costs a hundred
 * times a step, and warns of what nobody asks for any more. */
static void lay_down(const mjModel* m, mjData* d) {
  memcpy(d->qpos, m->qpos0, sizeof(mjtNum) * (size_t)m->nq);
  memset(d->qvel, 0, sizeof(mjtNum) * (size_t)m->nv);
  memset(d->act, 0, sizeof(mjtNum) * (size_t)m->na);
  memset(d->ctrl, 0, sizeof(mjtNum) * (size_t)m->nu);
  memset(d->qfrc_applied, 0, sizeof(mjtNum) * (size_t)m->nv);
  memset(d->qacc_warmstart, 0, sizeof(mjtNum) * (size_t)m->nv);
  /* The engine has looked at the positions of this step already. */
  engine.forward_position(m, d);
  engine.forward_velocity(m, d);
}

static void move_wall(const Flight* f, const mjModel* m, mjData* d, int64_t k) {
  d->qpos[f->wall_qpos] = f->wall[2 * k];
  d->qvel[f->wall_dof] = f->wall[2 * k + 1];
  /* The engine has looked at the wall where it was: again. */
  engine.forward_position(m, d);
  engine.forward_velocity(m, d);
}

/* Add the wrenches of tick k to the joint forces that the tick gave. */
static void push(const Flight* f, const mjModel* m, mjData* d, int64_t k) {
  for (int64_t n = 0; n < f->n_wrenches; n++) {
    const Wrench* p = f->wrenches + n;
    if (k < p->begin || k >= p->end) continue;
    const mjtNum *x = d->xpos + 3 * p->body, *R = d->xmat + 9 * p->body;
    mjtNum at[3];
    for (int i = 0; i < 3; i++)
      at[i] = x[i] + (R[3 * i] * p->point[0] + R[3 * i + 1] * p->point[1] + R[3 * i + 2] * p->point[2]);
    engine.apply(m, d, p->force, p->torque, at, (int)p->body, d->qfrc_applied);
  }
}

/* Write the friction of tick k, for the place and the speed that the tip has at the beginning of this step. */
static void write_friction(const Flight* f, const mjModel* m, mjData* d, int64_t k) {
  mjtNum velocity[6];
  engine.velocity(m, d, mjOBJ_SITE, (int)f->site, velocity, 0);
  double now[8], found[2]; /* the cell of the tables, and a factor */
  memcpy(now, d->site_xpos + 3 * f->site, 3 * sizeof(double));
  memcpy(now + 3, velocity + 3, 3 * sizeof(double));
  memcpy(now + 6, f->wall + 2 * k, 2 * sizeof(double));
  const double* given[] = {f->friction_numbers, now};
  double* results[] = {found};
  friction(given, results, NULL, NULL, 0);
  int64_t cell = (int64_t)found[0];
  double adhesion = f->adhesions[cell];
  mjtNum* pair = f->model->pair_friction + 5 * f->pair;
  pair[0] = pair[1] = f->frictions[cell] * found[1];
  if (adhesion != f->model->pair_adhesion[f->pair]) {
    f->model->pair_adhesion[f->pair] = adhesion;
    f->model->pair_gap[f->pair] = adhesion / f->stiffness;
  }
}

/* Write what events make of the model's numbers at tick k: of actuators, or of all else. */
static void write_model(const Flight* f, int64_t k, int64_t actuators) {
  const double* row = f->written + f->n_written * k;
  for (int64_t n = 0; n < f->n_places; n++) {
    const Written* place = f->places + n;
    if (place->actuators == actuators) memcpy(place->to, row + place->column, (size_t)place->count * sizeof(mjtNum));
  }
}

/* Fetch what the next tick reads and writes while the engine is still at work: nothing else touches it. */
static void fetch_ahead(const Flight* f, int64_t k) {
#if defined(__GNUC__) || defined(__clang__)
  const char *row = (const char*)(f->rows + k * f->n_row);
  const char *asked = (const char*)(f->references + f->at * f->n_reference);
  const char *line = (const char*)(f->log + k * f->n_signals);
  for (int64_t i = 0; i < f->n_row * 8; i += 64) __builtin_prefetch(row + i, 0);
  for (int64_t i = 0; i < f->n_reference * 8; i += 64) __builtin_prefetch(asked + i, 0);
  for (int64_t i = 0; i < f->n_signals * 8; i += 64) __builtin_prefetch(line + i, 1);
#else
  (void)f, (void)k;
#endif
}

static void begin_tick(Flight* f, const mjModel* m, mjData* d, int64_t k) {
  if (f->fresh) {
    for (int i = 0; i < mjNWARNING; i++) f->warnings[i] = d->warning[i].number;
    f->fresh = 0;
  } else if (k % f->interval == 0 && engine_warned(f, d)) {
    f->warned = k;
    f->stopped = 1;
    return;
  }
  for (int64_t i = 0; i < f->n_changing; i++) f->gains[f->changing[i]] = f->changing_values[k * f->n_changing + i];
  const double *arg[MOST_ARGUMENTS], *row = f->rows + k * f->n_row;
  double* res[MOST_RESULTS];
  arg[0] = f->state[k & 1], arg[1] = d->qpos, arg[2] = d->qvel, arg[3] = d->act, arg[4] = d->history;
  arg[5] = row, arg[6] = f->references + f->at * f->n_reference, arg[7] = f->gains, arg[8] = f->rotors;
  res[0] = f->state[1 - (k & 1)], res[1] = d->ctrl, res[2] = f->log + k * f->n_signals, res[3] = d->qfrc_applied;
  f->tick(arg, res, NULL, f->work, 0);
  if (surely_lost(f, d, k)) {
    f->stopped = 1;
    return;
  }
  f->at = f->clock < 0 ? k + 1 : (int64_t)f->state[1 - (k & 1)][f->clock];
  if (f->wall_qpos >= 0) move_wall(f, m, d, k);
  if (f->n_places) write_model(f, k, 1);
  if (f->n_wrenches) push(f, m, d, k);
}

void skylimb_control(const mjModel* m, mjData* d) {
  if (m->nuserdata < 2 || d->userdata[1] != MARK) {
    if (engine.previous) engine.previous(m, d);
    return;
  }
  Flight* f = (Flight*)(uintptr_t)d->userdata[0];
  if (f->stopped) {
    if (f->finished && !f->closed) {
      f->closed = 1;
      if (f->warned < 0 && engine_warned(f, d)) f->warned = f->done / f->substeps;
    }
    if (!f->finished) lay_down(m, d);
    return;
  }
  int64_t k = f->done / f->substeps, step = f->done % f->substeps;
  if (step == 0) begin_tick(f, m, d, k);
  f->done++;
  if (step == f->substeps - 1 && k + 1 < f->count) fetch_ahead(f, k + 1);
  /* Collision and constraints of the next tick come before its callback; what actuators do comes after it. */
  if (f->n_places && step == f->substeps - 1 && k + 1 < f->count) write_model(f, k + 1, 0);
  if (f->frictions && step == f->substeps - 1 && k + 1 < f->count) write_friction(f, m, d, k + 1);
  if (f->done == f->count * f->substeps || (f->at > f->last && step == f->substeps - 1)) f->finished = f->stopped = 1;
}
