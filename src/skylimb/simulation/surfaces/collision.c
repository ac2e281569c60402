/* Contact of a sphere with a smooth curved surface, in the place of the engine's sphere-ellipsoid function.

   The surface's numbers travel inside the model, as a custom numeric field that begins with MARK, and an ellipsoid
   whose user value is MARK stands for it. Any other sphere-ellipsoid pair goes to the engine's own function. Nothing
   here has state of its own, so that copies of a model on many threads collide alike.

   Axes of the surface: w into it, u and v along it. Numbers: MARK, kind, then
     profile (1): n, and n pieces of 8: kind (0 straight, 1 round outward, 2 round inward), u, w (start, or
                  centre), du, dw (unit tangent, or the unit direction to the arc's middle), length or radius, cosine of
                  the arc's half angle, unused;
     wave (2):    amplitude, wave number, phase, offset;
     spline (3):  nu, nv, u0, v0, pitch, then nu x nv coefficients of a cubic B-spline, v running fastest.
   MARK is defined by collision.py, from shape.py. The same geometry stands in Python in profile.py, wave.py and
   spline.py, which also explain it. */

#include <math.h>
#include <mujoco/mujoco.h>

#define MAX_DEPTH 0.05 /* m that a sphere's centre may be behind the surface */
#define SEAM 1e-12     /* pieces overlap by this much, so that nothing falls between them */

static mjfCollision engines_own = 0;

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT
#endif

EXPORT void skylimb_set_engines_own(mjfCollision function) { engines_own = function; }

static const mjtNum* surface_numbers(const mjModel* m) {
  for (int i = 0; i < m->nnumeric; i++) {
    const mjtNum* numbers = m->numeric_data + m->numeric_adr[i];
    if (m->numeric_size[i] > 2 && numbers[0] == MARK) return numbers;
  }
  return 0;
}

/* The place of touch: outward normal in (w, u, v) and signed distance of the centre from the surface. */
typedef struct { mjtNum normal[3]; mjtNum distance; } Touch;

/* ---- profile: straight and round pieces in the (u, w) plane, drawn out along v ---- */

static int piece_distance(const mjtNum* piece, mjtNum u, mjtNum w, mjtNum normal[2], mjtNum* distance) {
  mjtNum du = u - piece[1], dw = w - piece[2];
  if (piece[0] == 0) {
    mjtNum along = du * piece[3] + dw * piece[4];
    if (along < -SEAM || along > piece[5] + SEAM) return 0;
    /* u grows along the piece and the outside is where w is smaller. */
    normal[0] = piece[4];
    normal[1] = -piece[3];
    *distance = du * normal[0] + dw * normal[1];
    return 1;
  }
  mjtNum length = sqrt(du * du + dw * dw);
  if (length < 1e-12) return 0;
  du /= length;
  dw /= length;
  if (du * piece[3] + dw * piece[4] < piece[6] - SEAM) return 0;
  mjtNum side = piece[0] == 1 ? 1 : -1;
  normal[0] = side * du;
  normal[1] = side * dw;
  *distance = side * (length - piece[5]);
  return 1;
}

static int touch_profile(const mjtNum* numbers, const mjtNum p[3], Touch* touch) {
  int n = (int)numbers[0];
  const mjtNum* pieces = numbers + 1;
  touch->distance = 1e9;
  for (int i = 0; i < n; i++) {
    mjtNum normal[2], distance;
    if (!piece_distance(pieces + 8 * i, p[1], p[0], normal, &distance)) continue;
    /* A piece seen from behind lies beyond the one in front of it, so the nearest is the right one, from either side. */
    if (fabs(distance) < fabs(touch->distance)) {
      touch->normal[0] = normal[1];
      touch->normal[1] = normal[0];
      touch->normal[2] = 0;
      touch->distance = distance;
    }
  }
  return touch->distance < 1e9;
}

/* ---- graphs w = h(u, v): h and its first and second derivatives in out[6] ---- */

static void wave(const mjtNum* numbers, mjtNum u, mjtNum v, mjtNum out[6]) {
  mjtNum amplitude = numbers[0], k = numbers[1], angle = k * u + numbers[2];
  mjtNum s = sin(angle), c = cos(angle);
  out[0] = amplitude * s + numbers[3];
  out[1] = amplitude * k * c;
  out[2] = 0;
  out[3] = -amplitude * k * k * s;
  out[4] = out[5] = 0;
  (void)v;
}

static void cubic(mjtNum t, mjtNum b[4], mjtNum db[4], mjtNum ddb[4]) {
  mjtNum s = 1 - t;
  b[0] = s * s * s / 6;
  b[1] = (3 * t * t * t - 6 * t * t + 4) / 6;
  b[2] = (3 * s * s * s - 6 * s * s + 4) / 6;
  b[3] = t * t * t / 6;
  db[0] = -s * s / 2;
  db[1] = (9 * t * t - 12 * t) / 6;
  db[2] = -(9 * s * s - 12 * s) / 6;
  db[3] = t * t / 2;
  ddb[0] = s;
  ddb[1] = 3 * t - 2;
  ddb[2] = 3 * s - 2;
  ddb[3] = t;
}

static mjtNum clipped(mjtNum x, mjtNum low, mjtNum high) { return x < low ? low : x > high ? high : x; }

static void spline(const mjtNum* numbers, mjtNum u, mjtNum v, mjtNum out[6]) {
  int nu = (int)numbers[0], nv = (int)numbers[1];
  mjtNum pitch = numbers[4], x = (u - numbers[2]) / pitch, y = (v - numbers[3]) / pitch;
  mjtNum beyond_u = x - clipped(x, 1, nu - 2), beyond_v = y - clipped(y, 1, nv - 2);
  x -= beyond_u;
  y -= beyond_v;
  int i = (int)clipped(floor(x), 1, nu - 3), j = (int)clipped(floor(y), 1, nv - 3);
  const mjtNum* first = numbers + 5 + (i - 1) * nv + (j - 1);
  mjtNum bu[3][4], bv[3][4];
  cubic(x - i, bu[0], bu[1], bu[2]);
  cubic(y - j, bv[0], bv[1], bv[2]);
  for (int k = 0; k < 6; k++) out[k] = 0;
  for (int a = 0; a < 4; a++) {
    mjtNum row[3] = {0, 0, 0};
    const mjtNum* c = first + a * nv;
    for (int d = 0; d < 3; d++)
      row[d] = c[0] * bv[d][0] + c[1] * bv[d][1] + c[2] * bv[d][2] + c[3] * bv[d][3];
    out[0] += bu[0][a] * row[0];
    out[1] += bu[1][a] * row[0];
    out[2] += bu[0][a] * row[1];
    out[3] += bu[2][a] * row[0];
    out[4] += bu[1][a] * row[1];
    out[5] += bu[0][a] * row[2];
  }
  if (beyond_u != 0 || beyond_v != 0) { /* beyond the grid the surface goes on with the border's slope */
    out[0] += out[1] * beyond_u + out[2] * beyond_v + out[4] * beyond_u * beyond_v;
    out[1] += out[4] * beyond_v;
    out[2] += out[4] * beyond_u;
    if (beyond_u != 0) out[3] = 0;
    if (beyond_v != 0) out[5] = 0;
  }
  out[1] /= pitch;
  out[2] /= pitch;
  out[3] /= pitch * pitch;
  out[4] /= pitch * pitch;
  out[5] /= pitch * pitch;
}

static int touch_graph(int kind, const mjtNum* numbers, const mjtNum p[3], mjtNum reach, Touch* touch) {
  mjtNum u = p[1], v = p[2], h[6];
  void (*graph)(const mjtNum*, mjtNum, mjtNum, mjtNum*) = kind == 2 ? wave : spline;
  graph(numbers, u, v, h);
  /* Nothing steeper than a slope of 10 can be within reach from this high above. */
  if (h[0] - p[0] > 10 * reach) return 0;
  for (int k = 0; k < 20; k++) {
    mjtNum e = h[0] - p[0];
    mjtNum gu = u - p[1] + e * h[1], gv = v - p[2] + e * h[2];
    mjtNum a = 1 + h[1] * h[1], b = h[1] * h[2], c = 1 + h[2] * h[2];
    mjtNum A = a + e * h[3], B = b + e * h[4], C = c + e * h[5];
    mjtNum det = A * C - B * B;
    if (A < 0.1 * a || det < 0.1 * (a * c - b * b)) {
      /* Far from a hollow's centre of curvature Newton's matrix says nothing: use the part that is always positive. */
      A = a; B = b; C = c;
      det = A * C - B * B;
    }
    mjtNum su = (C * gu - B * gv) / det, sv = (A * gv - B * gu) / det;
    u -= su;
    v -= sv;
    graph(numbers, u, v, h);
    if (su * su + sv * sv < 1e-20) break;
  }
  mjtNum *n = touch->normal, scale = 1 / sqrt(1 + h[1] * h[1] + h[2] * h[2]);
  n[0] = -scale;
  n[1] = h[1] * scale;
  n[2] = h[2] * scale;
  touch->distance = (p[0] - h[0]) * n[0] + (p[1] - u) * n[1] + (p[2] - v) * n[2];
  return 1;
}

/* ---- the function in the engine's table: geom 1 is the sphere, geom 2 the ellipsoid ---- */

EXPORT int skylimb_collide(const mjModel* m, mjData* d, mjPreContact* con, int g1, int g2, mjtNum margin) {
  if (m->nuser_geom < 1 || m->geom_user[m->nuser_geom * g2] != MARK)
    return engines_own(m, d, con, g1, g2, margin);
  const mjtNum* numbers = surface_numbers(m);
  if (!numbers) return 0;
  const mjtNum *x = d->geom_xpos + 3 * g1, *o = d->geom_xpos + 3 * g2, *R = d->geom_xmat + 9 * g2;
  mjtNum radius = m->geom_size[3 * g1], r[3] = {x[0] - o[0], x[1] - o[1], x[2] - o[2]}, p[3];
  for (int i = 0; i < 3; i++) p[i] = R[i] * r[0] + R[3 + i] * r[1] + R[6 + i] * r[2];
  Touch t = {{0, 0, 0}, 0};
  mjtNum reach = radius + margin;
  int kind = (int)numbers[1];
  int found = kind == 1 ? touch_profile(numbers + 2, p, &t) : touch_graph(kind, numbers + 2, p, reach, &t);
  if (!found || t.distance > reach || t.distance < -MAX_DEPTH) return 0;
  con->dist = t.distance - radius;
  mjtNum back = t.distance - 0.5 * con->dist; /* the contact point lies midway between sphere and surface */
  for (int i = 0; i < 3; i++) {
    mjtNum outward = R[3 * i] * t.normal[0] + R[3 * i + 1] * t.normal[1] + R[3 * i + 2] * t.normal[2];
    con->normal[i] = -outward; /* from the sphere to the surface */
    con->pos[i] = x[i] - outward * back;
    con->tangent[i] = 0;
  }
  return 1;
}
