// The page's controls: what is shown, in which colour, and what the tables say about it.

const LAW = ["alpha", "beta", "gamma", "delta"];
const UNKNOWN = 255;
const view = { turn: [1, 0, 0, 0, 1, 0, 0, 0, 1], shift: [0, 0], zoom: 1, seed: 1, picked: -1, shown: new Uint32Array(0) };
let head, dots, scene, cover, luck, keep, ranked = {}, coloured = "";

async function start() {
  [head, dots] = await unpack(PACKED);
  const n = head.stored, places = new Float32Array(3 * n), middle = ["x", "y", "z"].map((axis) => {
    let low = Infinity, high = -Infinity;
    for (const value of dots[axis]) [low, high] = [Math.min(low, value), Math.max(high, value)];
    return (low + high) / 2;
  });
  ["x", "y", "z"].forEach((axis, k) => dots[axis].forEach((value, i) => (places[3 * i + k] = head.step * (value - middle[k]))));
  cover = makeCover(dots, head.step, head.radius);
  keep = new Uint8Array(n);
  view.turn = [...head.turn];
  const corners = new Float32Array(3 * dots.mx.length);
  ["x", "y", "z"].forEach((axis, k) => dots[`m${axis}`].forEach((value, i) => (corners[3 * i + k] = head.meshStep * value - head.step * middle[k])));
  scene = makeScene(element("canvas"), places, normals(dots.u, dots.v, head.octahedron), corners, Uint32Array.from(dots.triangle));
  if (element("up")) element("up").hidden = window.top !== window; // inside of a report
  fillMenus();
  listen();
  newDraw();
  choose();
  paint();
  redrawWhereNeeded();
}

function fillMenus() {
  const option = (text, value) => new Option(text, value);
  for (const [name, words] of Object.entries(head.samplers)) element("sampler").add(option(words, name));
  head.values.forEach((each, k) => element("colour").add(option(inLetters(each.name), k)));
  if (dots.kind) element("colour").add(option("kind of dot", "kind"));
  [element("sampler").value, element("colour").value] = [head.sampler, head.colour];
  element("presets").add(option("…", ""));
  head.presets.forEach(([words], k) => element("presets").add(option(words, k)));
}

// The order in which a nested sampler chooses the dots, kept until another draw is asked for.
function order(name) {
  if (name === "minimal") ranked[name] ??= Uint32Array.from(dots.minimal.keys()).filter((i) => dots.minimal[i]);
  if (!ranked[name] && dots[`rank ${name}`]) {
    ranked[name] = new Uint32Array(head.stored);
    dots[`rank ${name}`].forEach((place, i) => (ranked[name][place] = i));
  }
  return (ranked[name] ??= uniformOrder(head.stored, view.seed));
}

function newDraw() {
  luck = exponentials(cover.dot.length, view.seed);
  delete ranked.uniform;
}

// The dots that the controls ask for.
function choose() {
  const name = element("sampler").value, all = head.stored;
  const n = Math.max(1, Math.round((element("percent").value / 100) * all));
  if (name === "all") view.shown = Uint32Array.from({ length: all }, (_, i) => i);
  else if (name === "minimal") view.shown = order(name);
  else if (name !== "paper") view.shown = order(name).slice(0, n);
  else {
    sample(cover, LAW.map((each) => +element(each).value), luck, keep);
    const found = [];
    for (let i = 0; i < all; i++) if (keep[i]) found.push(i);
    view.shown = Uint32Array.from(found);
  }
  if (!view.shown.includes(view.picked)) pick(-1);
  element("law").hidden = name !== "paper";
  element("pale").parentElement.hidden = name === "all";
  element("amount").hidden = ["paper", "all", "minimal"].includes(name);
  element("again").hidden = !(name === "uniform" || name === "paper");
  for (const id of ["percent", "size", ...LAW]) element(id).parentElement.querySelector("output").textContent = element(id).value;
  element("percent-text").textContent += " %";
  const whole = name === "minimal" && view.shown.length === head.minimal ? head.total : all;
  const share = ((100 * view.shown.length) / whole).toFixed(1), count = view.shown.length.toLocaleString("en");
  element("shown").textContent = `${count} of ${whole.toLocaleString("en")} dots (${share} %).`;
  if (all < head.total) element("shown").textContent += ` The page holds the first ${all.toLocaleString("en")} of ${head.total.toLocaleString("en")} dots.`;
  if (name === "paper") element("nearest").replaceChildren(...nearest());
  redraw();
}

// The row of the grid nearest to the sliders, value by value since the grid has all combinations, and what it says.
function nearest() {
  let best = 0, least = Infinity;
  const wish = LAW.map((name) => +element(name).value);
  head.grid.forEach((row, r) => {
    const gap = wish.reduce((sum, value, k) => sum + (value - row[k]) ** 2, 0);
    if (gap < least) [best, least] = [r, gap];
  });
  if (!head.grid.length) return [];
  const row = head.grid[best], table = document.createElement("table"), words = document.createElement("p");
  words.append(...subscripts(`Nearest combination of the study: (${row.slice(0, 4).join(", ")}), n_S ${number(row[4], 1)} %.`));
  const line = (texts, kind) => {
    const tr = table.insertRow();
    texts.forEach((text) => tr.appendChild(document.createElement(kind)).append(...subscripts(text)));
  };
  line(["reading", "Z_tS", "Z_tR", "d"], "th");
  head.readings.forEach((words, r) => line([words, ...row.slice(5 + 3 * r, 8 + 3 * r).map((value) => number(value, 2))], "td"));
  const note = document.createElement("p");
  note.append(...subscripts("Z is the mean distance of the descriptors from those of the full surface (0 is best), for the sampled dots (Z_tS) and for a random subset of the same size (Z_tR). Where d = Z_tR − Z_tS is above 0, the sampling is better."));
  return [words, table, note];
}

// Colours of all dots, and the legend that tells what they mean.
function paint() {
  const wish = element("colour").value, out = new Uint8Array(3 * head.stored);
  if (wish === "kind") {
    dots.kind.forEach((kind, i) => out.set(head.kinds[kind < 0 ? 3 : kind][1], 3 * i));
    const present = head.kinds.filter((_, k) => dots.kind.includes(k === 3 ? -1 : k));
    element("legend").replaceChildren(...boxed(present));
    coloured = present.map(([name]) => name).join(", ");
  } else {
    const scale = head.values[wish], values = dots[`value ${wish}`];
    const share = (value) => Math.min(1, Math.max(0, (scale.low + ((scale.high - scale.low) * value) / 254 - scale.dark) / (scale.bright - scale.dark || 1)));
    values.forEach((value, i) => out.set(value === UNKNOWN ? GREY : shade(share(value)), 3 * i));
    const legend = legendOf(scale, scale.unit);
    const unknown = values.includes(UNKNOWN) ? boxed([[scale["unknown is"], GREY]]) : [], known = values.some((value) => value !== UNKNOWN);
    element("legend").replaceChildren(...subscripts(scale.name), ...(known ? legend.nodes : []), ...unknown);
    coloured = inLetters(scale.name) + (known ? legend.words : "") + (unknown.length ? `, grey ${scale["unknown is"]}` : "");
  }
  scene.colour(out);
  redraw();
}

// Discs that just cover the surface when all dots are there, larger on request.
const radius = () => (view.shown.length === head.stored ? 1.3 : 0.9) * head.spacing * element("size").value;

function drawNow(behind = ofPage()) {
  cleared();
  scene.draw(view, view.shown, radius(), element("pale").checked ? 1.3 * head.spacing : 0, view.picked, behind);
}

function pick(i) {
  view.picked = i;
  if (i < 0) {
    element("picked").textContent = "Click or tap a dot to see which it is.";
    return;
  }
  const words = [`Dot ${dots.index[i]}`];
  if (dots.residue && dots.residue[i] >= 0) words.push(head.residues[dots.residue[i]]);
  if (dots.kind && dots.kind[i] >= 0) words.push(head.kinds[dots.kind[i]][0]);
  head.values.forEach((each, k) => {
    const value = dots[`value ${k}`][i];
    const symbol = k ? each.symbol.replaceAll("_", " ") : each.symbol; // the name of a field has no subscript
    words.push(`${symbol} = ${value === UNKNOWN ? "unknown" : number(each.low + ((each.high - each.low) * value) / 254, 2) + each.unit}`);
  });
  element("picked").replaceChildren(...subscripts(`${words.join(", ")}.`));
}

function drawAgain() {
  view.seed += 1;
  newDraw();
  choose();
}

function picture() {
  return pictureAbove([`${document.title}: ${element("shown").textContent}`, caption()]);
}

function caption() {
  const name = element("sampler");
  const law = name.value === "paper" ? ` (${LAW.map((each) => element(each).value).join(", ")})` : "";
  return `${name.selectedOptions[0].text}${law}; colour: ${coloured}`;
}

function save() {
  saveAs(document.title, picture());
}

// Move a slider to a value, which its limits and steps may lack.
function slide(slider, value) {
  slider.min = Math.min(slider.min, value);
  slider.max = Math.max(slider.max, value);
  slider.value = value;
  if (Number(slider.value) !== value) slider.step = "any";
  slider.value = value;
}

function listen() {
  for (const id of ["sampler", "percent", "size", "pale", ...LAW]) element(id).addEventListener("input", choose);
  element("colour").addEventListener("input", paint);
  element("presets").addEventListener("input", (event) => {
    if (event.target.value === "") return;
    LAW.forEach((name, k) => slide(element(name), head.presets[event.target.value][1][k]));
    choose();
  });
  for (const [id, action] of [["again", drawAgain], ["reset", putBack], ["save", save]]) element(id).addEventListener("click", action);
  const step = 0.12, keys = {
    ArrowLeft: () => turn(-step, 0), ArrowRight: () => turn(step, 0), ArrowUp: () => turn(0, -step), ArrowDown: () => turn(0, step),
    "+": () => zoom(1.15), "=": () => zoom(1.15), "-": () => zoom(1 / 1.15), 0: putBack, n: drawAgain, s: save,
  };
  const canvas = element("canvas");
  onKeys(canvas, keys);
  follow(canvas, (left, top) => {
    pick(scene.pick(view, view.shown, radius(), left, top));
    redraw();
  });
}

start().catch((error) => {
  element("shown").textContent = `Nothing can be drawn: ${error.message}.`;
  console.error(error);
});
