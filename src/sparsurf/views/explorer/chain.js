// The tube along each chain and the sticks of a residue, as triangles.

const TUBE = 0.4, STICK = 0.22, BALL = 0.34; // Å, radii
const STEPS_OF_TUBE = 4, SIDES = 8; // between two residues, and around a tube or stick
const BONDED = 2, BONDED_TO_HEAVIER = 2.5; // Å, at most
const LIGHTER = new Set(["H", "D", "C", "N", "O", "F"]);
const OF_ELEMENT = { C: [150, 150, 150], N: [48, 80, 248], O: [230, 40, 30], S: [220, 190, 30], P: [240, 130, 20], H: [230, 230, 230], D: [230, 230, 230] };
const OF_OTHERS = [140, 90, 170], OF_CHAIN = [150, 156, 165], OF_CHOSEN = [224, 60, 10];

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const plus = (a, b, by = 1) => [a[0] + by * b[0], a[1] + by * b[1], a[2] + by * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => {
  const length = Math.hypot(...a) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
};

// Triangles that grow: of rings around a path, and of balls.
class Solid {
  constructor() {
    [this.places, this.normals, this.colours, this.triangles] = [[], [], [], []];
  }

  corner(place, normal, colour) {
    this.places.push(...place);
    this.normals.push(...normal);
    this.colours.push(...colour);
  }

  // A tube around a path of [place, colour], with rings that do not twist.
  tube(path, radius) {
    let side = null;
    const begin = this.places.length / 3;
    path.forEach(([place, colour], k) => {
      const along = unit(minus(path[Math.min(k + 1, path.length - 1)][0], path[Math.max(k - 1, 0)][0]));
      side ??= Math.abs(along[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
      side = unit(plus(side, along, -dot(side, along)));
      const up = cross(along, side);
      for (let s = 0; s < SIDES; s++) {
        const [c, d] = [Math.cos((2 * Math.PI * s) / SIDES), Math.sin((2 * Math.PI * s) / SIDES)];
        const normal = [0, 1, 2].map((axis) => c * side[axis] + d * up[axis]);
        this.corner(plus(place, normal, radius), normal, colour);
      }
      if (!k) return;
      for (let s = 0; s < SIDES; s++) {
        const a = begin + k * SIDES + s, b = begin + k * SIDES + ((s + 1) % SIDES);
        this.triangles.push(a - SIDES, b - SIDES, a, a, b - SIDES, b);
      }
    });
  }

  ball(place, radius, colour) {
    const begin = this.places.length / 3, rings = SIDES / 2;
    for (let r = 0; r <= rings; r++) {
      for (let s = 0; s < SIDES; s++) {
        const [a, b] = [(Math.PI * r) / rings, (2 * Math.PI * s) / SIDES];
        const normal = [Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a)];
        this.corner(plus(place, normal, radius), normal, colour);
        if (!r) continue;
        const [at, next] = [begin + r * SIDES + s, begin + r * SIDES + ((s + 1) % SIDES)];
        this.triangles.push(at - SIDES, at, next - SIDES, next - SIDES, at, next);
      }
    }
  }
}

// A smooth curve through places (Catmull and Rom 1974): the place at share t from b to c.
function between(a, b, c, d, t) {
  return [0, 1, 2].map((k) => {
    const [p, q, r, s] = [a[k], b[k], c[k], d[k]];
    return 0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s) * t * t + (3 * q - p - 3 * r + s) * t * t * t);
  });
}

// Stretches of residues that follow each other along a chain; `farthest` is the distance of each, Å, to a bonded one before it.
function stretchesOf(trace, chain, atomAt, farthest) {
  const stretches = [];
  let before = -1;
  trace.forEach((atom, residue) => {
    if (atom < 0) return;
    const joined = before >= 0 && residue === before + 1 && chain[residue] === chain[before];
    if (joined && Math.hypot(...minus(atomAt(atom), atomAt(trace[before]))) < farthest[residue]) stretches.at(-1).push(residue);
    else stretches.push([residue]);
    before = residue;
  });
  return stretches;
}

// The tube of all chains; the chosen residue has its own colour.
function tubeOf(solid, trace, chain, atomAt, chosen, farthest) {
  for (const stretch of stretchesOf(trace, chain, atomAt, farthest)) {
    if (stretch.length < 2) continue;
    const places = stretch.map((residue) => atomAt(trace[residue])), path = [];
    const colour = (k) => (stretch[k] === chosen ? OF_CHOSEN : OF_CHAIN);
    for (let k = 0; k + 1 < places.length; k++) {
      for (let step = 0; step < STEPS_OF_TUBE; step++) {
        const t = step / STEPS_OF_TUBE;
        const place = between(places[Math.max(0, k - 1)], places[k], places[k + 1], places[Math.min(places.length - 1, k + 2)], t);
        path.push([place, colour(t < 0.5 ? k : k + 1)]);
      }
    }
    path.push([places.at(-1), colour(places.length - 1)]);
    solid.tube(path, TUBE);
  }
}

// The atoms of a residue as balls, and their bonds as sticks, half in the colour of each atom.
function sticksOf(solid, atoms, elementOf, atomAt) {
  const colour = (atom) => OF_ELEMENT[elementOf(atom)] ?? OF_OTHERS;
  for (const atom of atoms) solid.ball(atomAt(atom), BALL, colour(atom));
  atoms.forEach((a, k) => {
    for (const b of atoms.slice(k + 1)) {
      const [from, to] = [atomAt(a), atomAt(b)], light = LIGHTER.has(elementOf(a)) && LIGHTER.has(elementOf(b));
      const gap = Math.hypot(...minus(from, to));
      if (gap < 0.5 || gap > (light ? BONDED : BONDED_TO_HEAVIER)) continue;
      const middle = plus(from, minus(to, from), 0.5);
      solid.tube([[from, colour(a)], [middle, colour(a)]], STICK);
      solid.tube([[middle, colour(b)], [to, colour(b)]], STICK);
    }
  });
}
