/* The place of a graph w = h(u, v) that is nearest to a point, by Newton's method.

   This text stands behind

     static void heights(const mjtNum* numbers, mjtNum u, mjtNum v, mjtNum h[6]);

   which gives h, h_u, h_v, h_uu, h_uv, h_vv. */

#define NEAR 0.01 /* m within which Newton's method needs no help */

static mjtNum squared(const mjtNum p[3], const mjtNum h[6], mjtNum u, mjtNum v) {
  return (h[0] - p[0]) * (h[0] - p[0]) + (u - p[1]) * (u - p[1]) + (v - p[2]) * (v - p[2]);
}

static int touch(const mjtNum* numbers, const mjtNum p[3], mjtNum reach, mjtNum normal[3], mjtNum* distance) {
  mjtNum u = p[1], v = p[2], h[6];
  heights(numbers, u, v, h);
  /* Nothing steeper than a slope of 10 can be within reach from this high above. */
  if (h[0] - p[0] > 10 * reach) return 0;
  mjtNum cost = squared(p, h, u, v);
  int near = cost < NEAR * NEAR;
  for (int k = 0; k < 60; k++) {
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
    mjtNum su = (C * gu - B * gv) / det, sv = (A * gv - B * gu) / det, from_u = u, from_v = v, tried;
    int last = su * su + sv * sv < 1e-20, halved = 0;
    for (;;) { /* far away a step that does not come closer is halved */
      u = from_u - su;
      v = from_v - sv;
      heights(numbers, u, v, h);
      tried = squared(p, h, u, v);
      if (last || near || halved == 30 || !(tried > cost * (1 + 1e-14) + 1e-30)) break;
      su *= 0.5;
      sv *= 0.5;
      halved++;
    }
    cost = tried;
    if (last || halved == 30) break;
  }
  mjtNum scale = 1 / sqrt(1 + h[1] * h[1] + h[2] * h[2]);
  normal[0] = -scale;
  normal[1] = h[1] * scale;
  normal[2] = h[2] * scale;
  *distance = (p[0] - h[0]) * normal[0] + (p[1] - u) * normal[1] + (p[2] - v) * normal[2];
  return 1;
}

/* For the analysis: h and its derivatives at n places (u, v), six numbers each. */
EXPORT void skylimb_heights(const mjtNum* numbers, int n, const mjtNum* u, const mjtNum* v, mjtNum* h) {
  for (int i = 0; i < n; i++) heights(numbers, u[i], v[i], h + 6 * i);
}
