// The page that links the surface, the list and the profile of the residues, and the frames of a trajectory.

const UNKNOWN = 255, CHOSEN = [224, 60, 10];
const SEEN_THROUGH = 0.45; // opacity of the surface above the chain
const FRAMES_PER_SECOND = 5;
const CURVE = { width: 380, height: 110, left: 58, right: 10, top: 10, bottom: 22 }; // px, of a drawing over time and its margins
const view = { turn: [1, 0, 0, 0, 1, 0, 0, 0, 1], shift: [0, 0], zoom: 1, frame: 0, chosen: -1, places: null };
let head, data, scene, middle, listed = [], order = [], atomsOf = new Map(), coloured = "", playing = null;

async function start() {
  [head, data] = await unpack(PACKED);
  readShapes();
  head.elementOf = (atom) => head.elements[data.element[atom]];
  data["residue of atom"].forEach((residue, atom) => atomsOf.set(residue, [...(atomsOf.get(residue) ?? []), atom]));
  view.turn = [...head.turn];
  scene = makeMeshes(element("canvas"), reach());
  fillMenus();
  listen();
  showFrame(0);
  describe();
  redrawWhereNeeded();
  document.body.dataset.ready = "yes";
}

const nFrames = () => Math.max(1, head.frames.length);

// Corners, triangles and atoms of each frame, in Å from the middle of the first.
function readShapes() {
  const ends = ["x", "y", "z"].map((axis) => data[`${axis}0`].reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]));
  middle = ends.map(([low, high]) => (low + high) / 2);
  head.shapes = [];
  let before = null;
  for (let frame = 0; frame < nFrames(); frame++) {
    const n = data[`x${frame}`].length, places = new Float32Array(3 * n), atoms = new Float32Array(3 * data.element.length);
    ["x", "y", "z"].forEach((axis, k) => {
      data[`${axis}${frame}`].forEach((value, i) => (places[3 * i + k] = head.step * (value - middle[k])));
      data[`atom ${axis}${frame}`].forEach((value, i) => (atoms[3 * i + k] = head.step * (before ? value : value - middle[k]) + (before ? before[3 * i + k] : 0)));
    });
    head.shapes.push({ places, atoms, facing: normals(data[`u${frame}`], data[`v${frame}`], head.octahedron), residues: data[`residue${frame}`], triangles: trianglesOf(data[`triangles${frame}`]) });
    before = atoms;
  }
}

// Reads what `coded_triangles` wrote: how far a corner lies before the next new one, 0 if it is new.
function trianglesOf(codes) {
  const out = new Uint32Array(codes.length);
  let next = 0;
  codes.forEach((code, i) => {
    out[i] = next - code;
    if (!code) next += 1;
  });
  return out;
}

function reach() {
  let far = 1;
  for (const { places } of head.shapes) for (let i = 0; i < places.length; i += 3) far = Math.max(far, Math.hypot(places[i], places[i + 1], places[i + 2]));
  return far;
}

// A number of a residue in a frame; null where it has none.
function numberOf(k, residue, frame = view.frame) {
  const table = head.numbers[k], n = head.residues.length;
  const steps = data[`number ${k}`][(table.frames > 1 ? frame * n : 0) + residue];
  return steps < 0 ? null : table.low + table.step * steps;
}

const written = ({ unit, digits }, value) => `${number(value, digits)}${value !== null && unit ? ` ${unit}` : ""}`;

function fillMenus() {
  head.corners.forEach((scale, k) => element("colour").add(new Option(inLetters(scale.name), `corner ${k}`)));
  if (head.kinds.length) element("colour").add(new Option("kind of dot", "kind"));
  head.numbers.forEach((table, k) => table.colours && element("colour").add(new Option(table.name, `number ${k}`)));
  if (head.colour) element("colour").value = head.colour;
  order = head.order;
  const list = element("residues");
  listed = order.map((residue) => {
    const row = document.createElement("div"), label = document.createElement("span"), value = document.createElement("span");
    [row.id, row.dataset.residue] = [`residue-${residue}`, residue];
    row.setAttribute("role", "option");
    row.setAttribute("aria-selected", "false");
    label.textContent = head.residues[residue];
    value.textContent = written(head.numbers[0], numberOf(0, residue, 0));
    row.append(label, value);
    list.append(row);
    return row;
  });
  if (nFrames() > 1) element("frame").max = nFrames() - 1;
}

// Every part of the page shows a residue, or none of them if it is -1. `turns`: the surface turns it to the viewer.
function choose(residue, turns = true) {
  view.chosen = residue;
  if (residue >= 0 && view.through === undefined) element("through").checked = true;
  if (residue < 0) view.through = undefined;
  if (residue < 0) element("through").checked = false;
  for (const row of listed) row.setAttribute("aria-selected", String(+row.dataset.residue === residue));
  const row = document.getElementById(`residue-${residue}`), list = element("residues");
  if (row) {
    row.hidden = false;
    list.setAttribute("aria-activedescendant", row.id);
    list.scrollTop = row.offsetTop - list.offsetTop - list.clientHeight / 2;
  } else list.removeAttribute("aria-activedescendant");
  for (const mark of document.querySelectorAll(".profile [data-residue]")) {
    const isChosen = +mark.dataset.residue === residue;
    mark.classList.toggle("chosen", isChosen);
    if (isChosen) {
      const box = mark.closest(".wide"), place = mark.getBoundingClientRect(), frame = box.getBoundingClientRect();
      if (place.left < frame.left || place.right > frame.right) box.scrollLeft += place.left - frame.left - frame.width / 2;
    }
  }
  for (const button of document.querySelectorAll("button.residue")) button.setAttribute("aria-pressed", String(+button.dataset.residue === residue));
  if (residue >= 0 && turns) face(residue);
  describe();
  drawInside();
  paint();
  curves();
}

// Turns the surface so that a residue lies in front.
function face(residue) {
  const at = centreOf(residue);
  if (!at || Math.hypot(...at) < 1e-6) return;
  const t = view.turn, to = unit([0, 3, 6].map((row) => dot(t.slice(row, row + 3), at)));
  const axis = cross(to, [0, 0, 1]), sine = Math.hypot(...axis), cosine = to[2];
  view.shift = [0, 0];
  if (sine < 1e-6 && cosine > 0) return redraw();
  const [x, y, z] = sine < 1e-6 ? [0, 1, 0] : unit(axis), c = 1 - cosine;
  const by = [
    [cosine + x * x * c, x * y * c - z * sine, x * z * c + y * sine],
    [y * x * c + z * sine, cosine + y * y * c, y * z * c - x * sine],
    [z * x * c - y * sine, z * y * c + x * sine, cosine + z * z * c],
  ];
  view.turn = by.flatMap((row) => [0, 1, 2].map((k) => row[0] * t[k] + row[1] * t[3 + k] + row[2] * t[6 + k]));
  redraw();
}

// The mean place of the corners of a residue, or of its atoms if it is buried.
function centreOf(residue) {
  const { places, residues, atoms } = head.shapes[view.frame], sum = [0, 0, 0];
  let n = 0;
  residues.forEach((each, i) => {
    if (each !== residue) return;
    for (let k = 0; k < 3; k++) sum[k] += places[3 * i + k];
    n += 1;
  });
  for (const atom of n ? [] : (atomsOf.get(residue) ?? [])) {
    for (let k = 0; k < 3; k++) sum[k] += atoms[3 * atom + k];
    n += 1;
  }
  return n ? sum.map((value) => value / n) : null;
}

function describe() {
  const residue = view.chosen;
  element("chosen").textContent = residue < 0 ? "Click a residue on the surface, in the list or in the profile, or search for one." : sayOf(residue);
}

function sayOf(residue) {
  const said = head.numbers.map((table, k) => [table, numberOf(k, residue)]).filter(([, value]) => value !== null);
  const isOn = head.shapes[view.frame].residues.includes(residue);
  return `${head.residues[residue]}: ${said.map(([table, value]) => `${table.name} ${written(table, value)}`).join("; ")}.${isOn ? "" : " It has no surface here: it is buried."}`;
}

function showFrame(frame) {
  view.frame = frame;
  const { places, triangles, residues, facing } = head.shapes[frame];
  scene.surface(places, triangles, residues, facing);
  if (nFrames() > 1) {
    element("frame").value = frame;
    element("frame-text").textContent = head.frames[frame];
    element("frame").setAttribute("aria-valuetext", head.frames[frame]);
  }
  describe();
  drawInside();
  paint();
  curves();
}

function drawInside() {
  const { atoms } = head.shapes[view.frame], solid = new Solid();
  const at = (atom) => [atoms[3 * atom], atoms[3 * atom + 1], atoms[3 * atom + 2]];
  tubeOf(solid, data.trace, data.chain, at, view.chosen, data.farthest);
  if (view.chosen >= 0) sticksOf(solid, atomsOf.get(view.chosen) ?? [], head.elementOf, at);
  scene.inside(solid);
  redraw();
}

// Colours of all corners, those of the chosen residue in one of their own, and the legend.
function paint() {
  const [kind, k] = element("colour").value.split(" "), { residues } = head.shapes[view.frame];
  if (kind === "kind") return paintKinds(residues);
  const scale = (kind === "corner" ? head.corners : head.numbers)[k], out = new Uint8Array(3 * residues.length);
  const share = (value) => Math.min(1, Math.max(0, (value - scale.dark) / (scale.bright - scale.dark || 1)));
  const values = kind === "corner" ? data[`corner ${k}`] : null, found = new Map();
  const valueAt = (i) => {
    if (values) return values[i] === UNKNOWN ? null : scale.low + ((scale.high - scale.low) * values[i]) / 254;
    if (!found.has(residues[i])) found.set(residues[i], residues[i] < 0 ? null : numberOf(k, residues[i]));
    return found.get(residues[i]);
  };
  let hasUnknown = false;
  for (let i = 0; i < residues.length; i++) {
    const value = valueAt(i);
    hasUnknown ||= value === null;
    out.set(isChosen(residues[i]) ? CHOSEN : value === null ? GREY : shade(share(value)), 3 * i);
  }
  legend(scale, hasUnknown);
  scene.colour(out);
  redraw();
}

const isChosen = (residue) => view.chosen >= 0 && residue === view.chosen;

function paintKinds(residues) {
  const out = new Uint8Array(3 * residues.length), kinds = head.kinds.filter((_, k) => data.kind.includes(k === 3 ? -1 : k));
  data.kind.forEach((kind, i) => out.set(isChosen(residues[i]) ? CHOSEN : head.kinds[kind < 0 ? 3 : kind][1], 3 * i));
  element("legend").replaceChildren(...boxed([...kinds, ...ofChosen()]));
  coloured = kinds.map(([name]) => name).join(", ");
  scene.colour(out);
  redraw();
}

const ofChosen = () => (view.chosen < 0 ? [] : [[head.residues[view.chosen], CHOSEN]]);

function legend(scale, hasUnknown) {
  const drawn = legendOf(scale, scale.unit ? ` ${scale.unit.trim()}` : "");
  const nodes = boxed([...(hasUnknown ? [[scale["unknown is"], GREY]] : []), ...ofChosen()]);
  element("legend").replaceChildren(...subscripts(scale.name), ...drawn.nodes, ...nodes);
  coloured = inLetters(scale.name) + drawn.words;
}

function drawNow(behind = ofPage()) {
  const canvas = cleared();
  scene.draw(view, behind, element("through").checked ? SEEN_THROUGH : 1);
  const tag = element("tag"), at = view.chosen < 0 ? null : centreOf(view.chosen);
  tag.hidden = !at;
  if (!at) return;
  const t = view.turn, pixel = (canvas.clientWidth / canvas.width) / scene.perPixel(view);
  tag.textContent = head.residues[view.chosen];
  tag.style.left = `${canvas.clientWidth / 2 + pixel * (dot(t.slice(0, 3), at) + view.shift[0])}px`;
  tag.style.top = `${canvas.clientHeight / 2 - pixel * (dot(t.slice(3, 6), at) + view.shift[1])}px`;
}

// Residues whose name, number and chain begin with the words of a search, those of which all words are equal first.
function foundBy(text) {
  const words = text.trim().toUpperCase().replace(/([A-Z]{3})(\d)/, "$1 $2").split(/[\s:,]+/).filter(Boolean);
  const parts = (residue) => head.residues[residue].toUpperCase().split(" ");
  const all = (residue, fits) => words.every((word) => parts(residue).some((part) => fits(part, word)));
  const same = order.filter((residue) => all(residue, (part, word) => part === word));
  const begun = order.filter((residue) => all(residue, (part, word) => part.startsWith(word)));
  return { words, same, all: [...same, ...begun.filter((residue) => !same.includes(residue))] };
}

function search(enter) {
  const { words, same, all } = foundBy(element("search").value), shown = new Set(all);
  for (const row of listed) row.hidden = words.length > 0 && !shown.has(+row.dataset.residue);
  const said = words.length ? `${all.length} residue${all.length === 1 ? "" : "s"} found.` : "";
  element("found").textContent = said;
  if (words.length && (enter ? all.length : words.length > 1 && same.length === 1)) choose(enter ? all[0] : same[0]);
}

// The next residue of the list that is shown, by steps.
function step(by) {
  const shown = listed.filter((row) => !row.hidden), at = shown.findIndex((row) => +row.dataset.residue === view.chosen);
  if (shown.length) choose(+shown[Math.min(shown.length - 1, Math.max(0, at < 0 ? 0 : at + by))].dataset.residue);
}

// The next residue along the chain.
function along(by) {
  choose(Math.min(head.residues.length - 1, Math.max(0, view.chosen < 0 ? 0 : view.chosen + by)));
}

function toFrame(frame) {
  if (nFrames() > 1) showFrame(Math.min(nFrames() - 1, Math.max(0, frame)));
}

function play() {
  clearInterval(playing);
  playing = playing === null ? setInterval(() => toFrame((view.frame + 1) % nFrames()), 1000 / FRAMES_PER_SECOND) : null;
  element("play").textContent = playing === null ? "Play" : "Stop";
}

// The area of the surface, and the numbers of the chosen residue, over the frames.
function curves() {
  if (nFrames() < 2) return;
  const drawn = [curve("area of the surface (Å²)", head.areas, 0)];
  head.numbers.forEach((table, k) => {
    if (table.frames < 2 || view.chosen < 0) return;
    const values = head.frames.map((_, frame) => numberOf(k, view.chosen, frame));
    drawn.push(curve(`${table.name} of ${head.residues[view.chosen]}${table.unit ? ` (${table.unit})` : ""}`, values, table.digits));
  });
  element("curves").replaceChildren(...drawn);
}

function curve(title, values, digits) {
  const known = values.filter((value) => value !== null), [low, high] = [Math.min(...known), Math.max(...known)];
  const figure = document.createElement("div"), heading = document.createElement("p"), { width, height, left, right, top, bottom } = CURVE;
  heading.textContent = title[0].toUpperCase() + title.slice(1);
  figure.className = "over-time";
  figure.append(heading);
  if (!known.length) {
    figure.append("no value in any frame");
    return figure;
  }
  const across = (frame) => left + ((width - left - right) * frame) / (values.length - 1);
  const down = (value) => top + (height - top - bottom) * (high > low ? (high - value) / (high - low) : 0.5);
  const svg = (name, values_, text) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(values_)) node.setAttribute(key, value);
    if (text) node.textContent = text;
    return node;
  };
  const drawing = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img" });
  drawing.setAttribute("aria-label", `${title}: from ${number(low, digits)} to ${number(high, digits)}; ${number(values[view.frame], digits)} in the shown frame`);
  for (const value of high > low ? [low, high] : [low]) {
    drawing.append(svg("line", { class: "level", x1: left, x2: width - right, y1: down(value), y2: down(value) }));
    drawing.append(svg("text", { x: left - 6, y: down(value) + 4, "text-anchor": "end" }, digits ? number(value, digits) : value.toLocaleString("en", { maximumFractionDigits: 0 })));
  }
  const stretches = [[]];
  values.forEach((value, frame) => (value === null ? stretches.push([]) : stretches.at(-1).push(`${across(frame).toFixed(1)},${down(value).toFixed(1)}`)));
  for (const points of stretches) if (points.length) drawing.append(svg("polyline", { class: "curve", points: points.join(" ") }));
  drawing.append(svg("line", { class: "now", x1: across(view.frame), x2: across(view.frame), y1: top, y2: height - bottom }));
  if (values[view.frame] !== null) drawing.append(svg("circle", { class: "now", cx: across(view.frame), cy: down(values[view.frame]), r: 4 }));
  drawing.append(svg("text", { x: left, y: height - 6 }, head.frames[0]), svg("text", { x: width - right, y: height - 6, "text-anchor": "end" }, head.frames.at(-1)));
  drawing.addEventListener("click", (event) => {
    const box = drawing.getBoundingClientRect(), place = ((event.clientX - box.left) * width) / box.width;
    toFrame(Math.round(((place - left) / (width - left - right)) * (values.length - 1)));
  });
  figure.append(drawing);
  return figure;
}

function picture() {
  const residue = view.chosen < 0 ? "" : `; ${head.residues[view.chosen]} in orange`;
  return pictureAbove([[document.title, head.frames[view.frame]].filter(Boolean).join(", "), `colour: ${coloured}${residue}`]);
}

function save() {
  saveAs([document.title, head.frames[view.frame]].filter(Boolean).join(" "), picture());
}

function listen() {
  element("colour").addEventListener("input", paint);
  element("through").addEventListener("input", () => {
    view.through = element("through").checked;
    redraw();
  });
  element("search").addEventListener("input", () => search(false));
  onKeys(element("search"), { Enter: () => search(true), ArrowDown: () => element("residues").focus() });
  for (const [id, action] of [["reset", putBack], ["save", save], ["none", () => choose(-1)]]) element(id).addEventListener("click", action);
  const by = 0.12, canvas = element("canvas");
  onKeys(canvas, {
    ArrowLeft: () => turn(-by, 0), ArrowRight: () => turn(by, 0), ArrowUp: () => turn(0, -by), ArrowDown: () => turn(0, by),
    "+": () => zoom(1.15), "=": () => zoom(1.15), "-": () => zoom(1 / 1.15), 0: putBack, s: save, Escape: () => choose(-1),
    n: () => along(1), p: () => along(-1), ".": () => toFrame(view.frame + 1), ",": () => toFrame(view.frame - 1),
  });
  onKeys(element("residues"), {
    ArrowDown: () => step(1), ArrowUp: () => step(-1), PageDown: () => step(10), PageUp: () => step(-10),
    Home: () => step(-Infinity), End: () => step(Infinity), Escape: () => choose(-1),
  });
  element("residues").addEventListener("click", (event) => {
    const row = event.target.closest("[data-residue]");
    if (row) choose(+row.dataset.residue);
  });
  for (const button of document.querySelectorAll("button.residue")) {
    button.addEventListener("click", () => {
      choose(+button.dataset.residue);
      element("canvas").scrollIntoView({ block: "nearest" });
    });
  }
  for (const profile of document.querySelectorAll(".profile .wide")) {
    onKeys(profile, { ArrowRight: () => along(1), ArrowLeft: () => along(-1), Escape: () => choose(-1) });
    profile.addEventListener("click", (event) => {
      const marks = [...profile.querySelectorAll("[data-residue]")];
      const away = (mark) => {
        const box = mark.getBoundingClientRect();
        return Math.abs(box.left + box.width / 2 - event.clientX);
      };
      if (marks.length) choose(+marks.reduce((a, b) => (away(b) < away(a) ? b : a)).dataset.residue);
    });
  }
  if (nFrames() > 1) {
    element("frame").addEventListener("input", () => toFrame(+element("frame").value));
    element("play").addEventListener("click", play);
  }
  follow(canvas, (left, top) => choose(scene.pick(view, left, top), false));
}

start().catch((error) => {
  element("chosen").textContent = `Nothing can be drawn: ${error.message}.`;
  console.error(error);
});
