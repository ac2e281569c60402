/* Contact of a sphere with one kind of curved surface, in the place of the engine's sphere-ellipsoid function.

   This text is compiled behind what `collision.py` puts before it: the engine's header, MARK, EXPORT, and of the
   kind's shape

     static int fits(const mjtNum* numbers, int count);   whether these can be a shape's numbers
     static int touch(const mjtNum* numbers, const mjtNum p[3], mjtNum reach, mjtNum normal[3], mjtNum* distance);

   `touch` finds the place that is nearest to a point: the outward normal there and the signed distance from it. It may
   answer 0, that there is none, for a point that is farther than `reach` away.

   The numbers of a shape travel inside the model, as a custom numeric field that begins with MARK, and an ellipsoid whose
   user value is MARK stands for it. Any other pair goes to the function that was in the engine's table before: that of
   another kind of surface, and in the end the engine's own. Nothing here has state of its own, so that copies of a model
   on many threads collide alike.

   Axes of the surface: w into it, u and v along it; a point is (w, u, v). */

#ifdef ENGINE
#define MAX_DEPTH 0.05 /* m that a sphere's centre may be behind the surface */

static mjfCollision before = 0;

static const mjtNum* surface_numbers(const mjModel* m) {
  for (int i = 0; i < m->nnumeric; i++) {
    const mjtNum* numbers = m->numeric_data + m->numeric_adr[i];
    int size = m->numeric_size[i];
    if (size > 0 && numbers[0] == MARK) return fits(numbers + 1, size - 1) ? numbers + 1 : 0;
  }
  return 0;
}

/* The function in the engine's table: geom 1 is the sphere, geom 2 the ellipsoid. */
static int collide(const mjModel* m, mjData* d, mjPreContact* con, int g1, int g2, mjtNum margin) {
  if (m->nuser_geom < 1 || m->geom_user[m->nuser_geom * g2] != MARK) return before(m, d, con, g1, g2, margin);
  const mjtNum* numbers = surface_numbers(m);
  if (!numbers) return 0;
  const mjtNum *x = d->geom_xpos + 3 * g1, *o = d->geom_xpos + 3 * g2, *R = d->geom_xmat + 9 * g2;
  mjtNum radius = m->geom_size[3 * g1], r[3] = {x[0] - o[0], x[1] - o[1], x[2] - o[2]}, p[3];
  for (int i = 0; i < 3; i++) p[i] = R[i] * r[0] + R[3 + i] * r[1] + R[6 + i] * r[2];
  mjtNum normal[3], distance, reach = radius + margin;
  if (!touch(numbers, p, reach, normal, &distance)) return 0;
  if (!(distance <= reach && distance >= -MAX_DEPTH)) return 0; /* also when it is no number */
  con->dist = distance - radius;
  mjtNum back = distance - 0.5 * con->dist; /* the contact point lies midway between sphere and surface */
  for (int i = 0; i < 3; i++) {
    mjtNum outward = R[3 * i] * normal[0] + R[3 * i + 1] * normal[1] + R[3 * i + 2] * normal[2];
    con->normal[i] = -outward; /* from the sphere to the surface */
    con->pos[i] = x[i] - outward * back;
    con->tangent[i] = 0;
  }
  return 1;
}

/* Put this kind's function into the engine's table, once. */
EXPORT void skylimb_install(mjfCollision* slot) {
  if (before) return;
  before = *slot;
  *slot = collide;
}
#endif

/* For the analysis: nearest points of the surface and outward normals there, of n points; NaN where there is none. */
EXPORT void skylimb_closest(const mjtNum* numbers, int n, const mjtNum* points, mjtNum* feet, mjtNum* normals) {
  for (int i = 0; i < 3 * n; i += 3) {
    mjtNum distance;
    int found = touch(numbers, points + i, INFINITY, normals + i, &distance);
    for (int k = i; k < i + 3; k++) {
      feet[k] = found ? points[k] - distance * normals[k] : NAN;
      if (!found) normals[k] = NAN;
    }
  }
}
