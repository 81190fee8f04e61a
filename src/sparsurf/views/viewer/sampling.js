// Which dots are kept: the paper's sampling (eq. 2), pair by pair as in sampling/published.py, and the uniform one.

// Uniform numbers in (0, 1), the same for the same seed: xorshift (Marsaglia 2003, J. Stat. Softw. 8:14).
function randomNumbers(seed) {
  let state = Math.imul(seed + 1, 0x9e3779b1) | 1;
  return () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    return ((state >>> 0) + 0.5) / 4294967296;
  };
}

// -ln of uniform numbers: a pair is kept where its number exceeds -ln p.
function exponentials(count, seed) {
  const next = randomNumbers(seed), out = new Float64Array(count);
  for (let i = 0; i < count; i++) out[i] = -Math.log(next());
  return out;
}

// The centres and their pairs, with -ln(r_ij / r_patch) from the places of the dots; Å throughout.
function makeCover(columns, step, radius) {
  const { x, y, z, centre, size, pair, centreR, ox, oy, oz } = columns;
  const start = new Int32Array(size.length + 1), fall = new Float64Array(pair.length);
  for (let c = 0; c < size.length; c++) {
    start[c + 1] = start[c] + size[c];
    for (let q = start[c]; q < start[c + 1]; q++) {
      const j = pair[q], a = x[j] - ox[c], b = y[j] - oy[c], e = z[j] - oz[c];
      fall[q] = -Math.log((step * Math.sqrt(a * a + b * b + e * e)) / radius);
    }
  }
  return { centre, roughness: Float64Array.from(centreR, (value) => value / 1e7), start, dot: pair, fall };
}

// One draw of the paper's sampling: sets keep[j] to 1 for the kept dots and to 0 for the others.
function sample(cover, [alpha, beta, gamma, delta], luck, keep) {
  const { centre, roughness, start, dot, fall } = cover;
  keep.fill(0);
  for (let c = 0; c < centre.length; c++) {
    const flat = 1 - roughness[c], power = gamma * (1 + roughness[c]) + delta;
    const logA = Math.log(alpha) + (beta > 0 ? beta * Math.log(flat) : 0);
    for (let q = start[c]; q < start[c + 1]; q++) {
      const least = power > 0 ? power * fall[q] - logA : -logA;
      if (luck[q] > least) keep[dot[q]] = 1;
    }
    if (centre[c] >= 0) keep[centre[c]] = 1;
  }
}

// Dots in the order in which the uniform sampler chooses them, so that its first n are its subset of n dots.
function uniformOrder(n, seed) {
  const next = randomNumbers(seed), order = Uint32Array.from({ length: n }, (_, i) => i);
  for (let i = n - 1; i > 0; i--) {
    const j = Math.floor(next() * (i + 1));
    [order[i], order[j]] = [order[j], order[i]];
  }
  return order;
}
