// What is drawn, by 3Dmol.js: the surface, the molecule below it, the dots on it; how it is turned; what lies below the mouse.

const CHOSEN = [224, 60, 10], GREY = [165, 165, 165], PLAIN = [222, 222, 222];
const MAX_CORNERS = 60000; // of a shape, since 3Dmol.js numbers corners in 16 bits and loses colours where it cuts a shape itself
const SEEN_THROUGH = 55; // percent, of a surface in front of the chosen residue, or around a ligand
const SIDES = 7, LIFT = 0.12; // of a disc, and Å by which it lies above the surface
const NEAR = 12; // px, from the mouse to a dot or an atom
const AXES = ["x", "y", "z"];
const element = (id) => document.getElementById(id);
const view = { chosen: -1, members: new Set(), frame: 0, picked: -1, shown: [], surface: [], discs: [], touched: false };
let head, data, viewer, model, meshes = [], atoms = [], atomsOf = [], dots = null, home;

// Runs the library, and lightens its shadows: it has no light from all sides, so that creases would be black.
async function library() {
  const packed = Uint8Array.from(atob(LIBRARY), (letter) => letter.charCodeAt(0));
  const text = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"))).text();
  const lit = text.replace(/max\( (-?dotProduct), 0\.0 \)/g, "(0.45 + 0.55 * max( $1, 0.0 ))");
  document.head.append(Object.assign(document.createElement("script"), { textContent: lit }));
}

async function start() {
  [head, data] = await unpack(PACKED);
  head.labels = head.residues;
  for (let frame = 0; frame < nFrames(); frame++) meshes.push(meshOf(frame));
  (data["residue of atom"] ?? []).forEach((residue, atom) => (atomsOf[residue] ??= []).push(atom));
  atoms = placesOfAtoms();
  if (data.u) dots = dotsOf();
  fillMenus();
  listen();
  describe();
  if (!document.createElement("canvas").getContext("webgl2")) throw new Error("this browser offers no WebGL 2; the tables below do not need it");
  await library();
  viewer = $3Dmol.createViewer(element("stage"), { antialias: true, upscale: false, cartoonQuality: 6, orthographic: true, disableFog: true });
  atOnce(() => {
    background();
    if (atoms.length) model = viewer.addModel(mmcif(), "cif");
    if (model && nFrames() > 1) model.setCoordinates(atoms.map((frame) => frame.map(({ x, y, z }) => [x, y, z])), "array");
    setOpacity(opacityAtStart());
    chooseDots();
    drawSurface();
    style();
    centre();
    face(head.turn);
    fit();
    home = viewer.getView();
    listenToPicture();
  });
  document.body.dataset.ready = "yes";
}

// Draws once after some actions: most methods of the library draw by themselves, which takes long.
function atOnce(act) {
  const renderer = viewer.getRenderer(), draw = renderer.render;
  renderer.render = (scene, camera) => (scene.updateMatrixWorld(), camera.matrixWorldInverse.getInverse(camera.matrixWorld));
  try {
    act();
  } finally {
    renderer.render = draw;
  }
  viewer.render();
}

const nFrames = () => Math.max(1, head.frames.length);
// Less than 100 % where a ligand lies inside the surface.
const opacityAtStart = () => (data.kinds?.slice(0, head.surfaced).includes(2) ? SEEN_THROUGH : 100);
const nameOfChosen = () => (view.members.size > 1 ? `${view.members.size} residues` : head.labels[view.chosen]);
const hasSurface = () => meshes[view.frame].triangles.length > 0;
const at = (x, y, z) => ({ x, y, z });
const columnsOf = (names, step) => data[names[0]].length ? Array.from(data[names[0]], (_, i) => at(...names.map((name) => step * data[name][i]))) : [];

// Corners with their normals and residues, and triangles as `coded_triangles` wrote them: 0 is a new corner.
function meshOf(frame) {
  const facing = normals(data[`u${frame}`], data[`v${frame}`], head.octahedron), codes = data[`triangles${frame}`];
  const corners = columnsOf(AXES.map((axis) => axis + frame), head.step), ways = corners.map((_, i) => at(...facing.subarray(3 * i, 3 * i + 3)));
  let next = 0;
  const triangles = codes.map((code) => (code ? next - code : next++));
  return { corners, ways, triangles, residues: data[`residue${frame}`], parts: partsOf(corners, ways, triangles) };
}

// Pieces of a mesh with at most MAX_CORNERS corners; `from` are their numbers in the mesh.
function partsOf(corners, ways, triangles) {
  const out = [];
  let place, piece = { from: { length: Infinity } };
  triangles.forEach((corner, i) => {
    if (i % 3 === 0 && piece.from.length > MAX_CORNERS) {
      out.push((piece = { from: [], faceArr: [] }));
      place = new Map();
    }
    if (!place.has(corner)) place.set(corner, piece.from.push(corner) - 1);
    piece.faceArr.push(place.get(corner));
  });
  for (const part of out) Object.assign(part, { vertexArr: part.from.map((i) => corners[i]), normalArr: part.from.map((i) => ways[i]) });
  return out;
}

// Positions of the atoms in each frame, which are stored as steps from the frame before.
function placesOfAtoms() {
  if (!data.element?.length) return [];
  const out = [];
  for (let frame = 0; frame < nFrames(); frame++) {
    const steps = columnsOf(AXES.map((axis) => `atom ${axis}${frame}`), head.step), before = out[frame - 1];
    out.push(before ? steps.map(({ x, y, z }, i) => at(x + before[i].x, y + before[i].y, z + before[i].z)) : steps);
  }
  return out;
}

function dotsOf() {
  const facing = normals(data.u, data.v, head.octahedron), places = columnsOf(AXES, head.dots.step);
  return { places, ways: places.map((_, i) => at(...facing.subarray(3 * i, 3 * i + 3))), residues: data.residue };
}

// The atoms as mmCIF, in which names and numbers have no limit of length; 3Dmol.js finds bonds and secondary structure.
function mmcif() {
  const names = ["group_PDB", "id", "type_symbol", "label_atom_id", "label_comp_id", "label_asym_id", "auth_asym_id", "auth_seq_id", "label_seq_id", "pdbx_PDB_ins_code", "Cartn_x", "Cartn_y", "Cartn_z", "pdbx_PDB_model_num"];
  const word = (text) => (/^[a-z0-9]+$/i.test(text) ? text : `"${text.replace(/["\s]/g, "_") || "?"}"`); // 3Dmol.js keeps the quotes of residues
  const lines = atoms[0].map(({ x, y, z }, i) => {
    const residue = data["residue of atom"][i], [name, number, chain] = head.parts[residue], [, sequence, code] = number.match(/^(-?\d+)(.*)$/) ?? [0, residue, ""];
    const kind = data.kinds[residue] < 2 ? "ATOM" : "HETATM";
    return [kind, i + 1, head.elements[data.element[i]] || "X", word(head.names[data.name[i]]), word(name), word(chain || "A"), word(chain || "A"), sequence, sequence, word(code), x.toFixed(2), y.toFixed(2), z.toFixed(2), 1].join(" ");
  });
  return ["data_page", "loop_", ...names.map((name) => `_atom_site.${name}`), ...lines, ""].join("\n");
}

const rgb = ([r, g, b]) => ({ r: r / 255, g: g / 255, b: b / 255 });
const opacity = () => element("opacity").value / 100;

function drawSurface() {
  for (const shape of view.surface) viewer.removeShape(shape);
  const made = coloursOfSurface();
  view.surface = meshes[view.frame].parts.map(({ from, ...part }) => viewer.addCustom({ ...part, color: from.map((corner) => made[corner]), opacity: opacity() }));
  drawDots();
}

// Colours everything anew, and fills the key.
function paint() {
  const made = coloursOfSurface();
  view.surface.forEach((shape, k) => shape.updateStyle({ color: meshes[view.frame].parts[k].from.map((corner) => made[corner]), opacity: opacity() }));
  drawDots();
  viewer.render();
}

// Discs on the surface, in pieces.
function drawDots() {
  for (const shape of view.discs) viewer.removeShape(shape);
  view.discs = [];
  if (!view.shown.length) return;
  const made = coloursOfDots(), radius = radiusOfDots(), per = Math.floor(MAX_CORNERS / SIDES), turns = [...Array(SIDES).keys()].map((side) => (2 * Math.PI * side) / SIDES);
  for (let first = 0; first < view.shown.length; first += per) {
    const vertexArr = [], normalArr = [], faceArr = [], color = [];
    for (const i of view.shown.slice(first, first + per)) {
      const way = dots.ways[i], { x, y, z } = way, from = vertexArr.length, p = dots.places[i], big = i === view.picked ? 2 * radius : radius;
      const [a, b, c] = Math.abs(x) < 0.7 ? [0, z, -y] : [-z, 0, x], length = Math.hypot(a, b, c), u = [a / length, b / length, c / length];
      const v = [y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0]], ink = rgb(i === view.picked ? CHOSEN : made(i));
      turns.forEach((turn, side) => {
        const [e, f] = [big * Math.cos(turn), big * Math.sin(turn)];
        vertexArr.push(at(p.x + LIFT * x + e * u[0] + f * v[0], p.y + LIFT * y + e * u[1] + f * v[1], p.z + LIFT * z + e * u[2] + f * v[2]));
        normalArr.push(way);
        color.push(ink);
        if (side > 1) faceArr.push(from, from + side - 1, from + side);
      });
    }
    view.discs.push(viewer.addCustom({ vertexArr, normalArr, faceArr, color, opacity: 1 }));
  }
}

// Discs that nearly cover the surface where all dots are shown, larger on request.
const radiusOfDots = () => (view.shown.length === head.dots.stored ? 0.75 : 0.4) * Math.min(head.dots.spacing, 1) * element("size").value;

// The polymer, its partners as sticks, and the chosen residue.
function style() {
  viewer.removeAllLabels();
  if (model) {
    const residues = (fits) => ({ predicate: (atom) => fits(data["residue of atom"][atom.index]) });
    const ofChain = ({ index }) => head.chains[data.chain[data["residue of atom"][index]]][1].reduce((all, channel) => 256 * all + channel);
    const cartoon = (color) => ({ cartoon: { ...(element("colour").value === "chain" ? { colorfunc: ofChain } : { color }), style: head.trace ? "trace" : "rectangle" } });
    const shown = { cartoon: cartoon("#9aa3ad"), stick: { stick: { radius: 0.15 } }, line: { line: {} }, none: {} }[element("inside").value];
    viewer.setStyle({}, shown);
    viewer.setStyle(residues((r) => r >= head.surfaced), cartoon("#d98e2b"));
    viewer.setStyle(residues((r) => data.kinds[r] === 2), { stick: { radius: 0.22, colorscheme: "greenCarbon" }, sphere: { scale: 0.25, colorscheme: "greenCarbon" } });
    if (view.chosen >= 0 && atomsOfChosen().length) viewer.addStyle({ index: atomsOfChosen() }, { stick: { radius: 0.25, colorscheme: "orangeCarbon" } });
  }
  const middle = view.chosen >= 0 && middleOfChosen();
  if (middle) viewer.addLabel(nameOfChosen(), { position: middle.place, fontSize: 15, backgroundColor: "black", backgroundOpacity: 0.7, inFront: true, alignment: "bottomCenter" });
}

const atomsOfChosen = () => [...view.members].flatMap((residue) => atomsOf[residue] ?? []);

// The mean place and normal of the corners of what is chosen, or the mean place of its atoms if it is buried; null without either.
function middleOfChosen() {
  const { corners, ways, residues } = meshes[view.frame], places = [], facing = [];
  residues?.forEach((each, i) => view.members.has(each) && (places.push(corners[i]), facing.push(ways[i])));
  if (!places.length) places.push(...atomsOfChosen().map((atom) => atoms[view.frame][atom]));
  const mean = (all) => at(...AXES.map((axis) => all.reduce((sum, each) => sum + each[axis], 0) / all.length));
  return places.length ? { place: mean(places), way: facing.length ? mean(facing) : null } : null;
}

// Products of rotations, as quaternions [x, y, z, w], and what one does to a direction.
const after = ([x, y, z, w], [p, r, s, t]) => [w * p + x * t + y * s - z * r, w * r - x * s + y * t + z * p, w * s + x * r - y * p + z * t, w * t - x * p - y * r - z * s];

function turned([x, y, z, w], [a, b, c]) {
  const u = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * u[0] + y * u[2] - z * u[1], b + w * u[1] + z * u[0] - x * u[2], c + w * u[2] + x * u[1] - y * u[0]];
}

// Turns the camera by the rows of a rotation, about the middle.
function face(t) {
  const part = (sum, sign) => Math.sign(sign || 1) * Math.sqrt(Math.max(0, 1 + sum)) / 2;
  viewer.setView([...viewer.getView().slice(0, 4), part(t[0] - t[4] - t[8], t[7] - t[5]), part(t[4] - t[0] - t[8], t[2] - t[6]), part(t[8] - t[0] - t[4], t[3] - t[1]), part(t[0] + t[4] + t[8])]);
}

const drawn = () => [...meshes[view.frame].corners, ...(atoms[view.frame] ?? []), ...(hasSurface() ? [] : dots.places)];

// Looks at the middle of all that is drawn and cuts nothing off: before the first picture, zoomTo only knows atoms.
function centre() {
  viewer.zoomTo({}, 0);
  const ends = AXES.map((axis) => drawn().reduce(([low, high], place) => [Math.min(low, place[axis]), Math.max(high, place[axis])], [Infinity, -Infinity]));
  const size = 50 + 2 * Math.hypot(...ends.map(([low, high]) => high - low));
  viewer.setView([...ends.map(([low, high]) => -(low + high) / 2), ...viewer.getView().slice(3)]);
  viewer.setSlab(-size, size);
}

// Zooms and moves so that everything that is drawn fills the picture above the key.
function fit() {
  const stage = element("stage"), { clientWidth } = stage, box = stage.getBoundingClientRect(), above = stage.clientHeight - element("legend").offsetHeight;
  const all = drawn();
  for (let round = 0; round < 3; round++) {
    const flat = viewer.modelToScreen(all), ends = (axis) => flat.reduce(([low, high], place) => [Math.min(low, place[axis]), Math.max(high, place[axis])], [Infinity, -Infinity]);
    const [[left, right], [top, bottom]] = [ends("x"), ends("y")];
    if (round < 2) viewer.zoom(0.88 / Math.max((right - left) / clientWidth, (bottom - top) / above, 0.01));
    else viewer.translateScene(box.left + scrollX + clientWidth / 2 - (left + right) / 2, box.top + scrollY + above / 2 - (top + bottom) / 2);
  }
}

// Brings what is chosen to the front and the middle; makes the surface pale where another part of it lies before that.
function go() {
  const middle = middleOfChosen();
  if (!middle) return;
  const now = viewer.getView(), [a, b, c] = middle.way ? turned(now.slice(4, 8), AXES.map((axis) => middle.way[axis])) : [0, 0, 1], length = Math.hypot(a, b, c);
  if (length > 1e-6) {
    const add = c / length > -0.9999 ? [b / length, -a / length, 0, 1 + c / length] : [1, 0, 0, 0], size = Math.hypot(...add);
    viewer.setView([...now.slice(0, 4), ...after(add.map((value) => value / size), now.slice(4, 8))]);
  }
  if (atomsOfChosen().length) viewer.center({ index: atomsOfChosen() }, 0);
  if (view.touched || !hasSurface()) return;
  const { x, y } = viewer.modelToScreen(middle.place);
  if (!view.members.has(pick(x, y).residue)) setOpacity(SEEN_THROUGH);
}

// What lies in front at a place of the document: a shown dot, or the residue of the nearest corner of the triangle there.
function pick(left, top) {
  const q = viewer.getView().slice(4, 8), depthOf = ({ x, y, z }) => turned(q, [x, y, z])[2];
  const found = { residue: -1, dot: -1 };
  let high = -Infinity;
  const { corners, triangles, residues } = meshes[view.frame], flat = hasSurface() && opacity() > 0.05 ? viewer.modelToScreen(corners) : [];
  for (let t = 0; t < triangles.length && flat.length; t += 3) {
    const [a, b, c] = [flat[triangles[t]], flat[triangles[t + 1]], flat[triangles[t + 2]]];
    const area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area >= 0) continue; // seen from inside
    const u = ((b.x - left) * (c.y - top) - (b.y - top) * (c.x - left)) / area, v = ((c.x - left) * (a.y - top) - (c.y - top) * (a.x - left)) / area, w = 1 - u - v;
    if (u < 0 || v < 0 || w < 0) continue;
    const three = [0, 1, 2].map((k) => corners[triangles[t + k]]), depth = u * depthOf(three[0]) + v * depthOf(three[1]) + w * depthOf(three[2]);
    if (depth > high) [high, found.residue] = [depth, residues ? residues[triangles[t + [u, v, w].indexOf(Math.max(u, v, w))]] : -1];
  }
  if (view.shown.length) {
    const shown = viewer.modelToScreen(view.shown.map((i) => dots.places[i]));
    let front = high - 1.5;
    view.shown.forEach((i, k) => {
      const gap = Math.hypot(shown[k].x - left, shown[k].y - top);
      if (gap > NEAR || depthOf(dots.ways[i]) < 0.05) return;
      const depth = depthOf(dots.places[i]) - 0.2 * gap;
      if (depth > front) [front, found.dot] = [depth, i];
    });
    if (found.dot >= 0) found.residue = dots.residues?.[found.dot] ?? -1;
  }
  if (opacity() <= 0.05 && atoms.length) {
    let front = -Infinity;
    viewer.modelToScreen(atoms[view.frame]).forEach(({ x, y }, i) => {
      const depth = depthOf(atoms[view.frame][i]);
      if (Math.hypot(x - left, y - top) < NEAR && depth > front) [front, found.residue] = [depth, data["residue of atom"][i]];
    });
  }
  return found;
}

function background() {
  const [r, g, b] = getComputedStyle(document.body).backgroundColor.match(/\d+/g).map(Number);
  viewer.setBackgroundColor((r << 16) + (g << 8) + b, 1);
}

// The picture on white, as the address of a PNG.
function onWhite() {
  viewer.setBackgroundColor(0xffffff, 1);
  viewer.render();
  const address = viewer.pngURI();
  background();
  viewer.render();
  return address;
}
