/* A cubic B-spline on a regular grid as a graph w = h(u, v): value and derivatives by the weights of one cell.

   Numbers: nu, nv, u0, v0, pitch, then nu x nv coefficients, v running fastest. spline.py finds the coefficients. */

static int fits(const mjtNum* numbers, int count) {
  return count > 5 && numbers[0] >= 4 && numbers[1] >= 4 && numbers[4] > 0 && numbers[0] * numbers[1] == count - 5;
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

/* What is no number comes to the lower end, so that it never becomes an index. */
static mjtNum clipped(mjtNum x, mjtNum low, mjtNum high) { return !(x > low) ? low : x > high ? high : x; }

static void heights(const mjtNum* numbers, mjtNum u, mjtNum v, mjtNum out[6]) {
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
