// Which dots are shown: those of a subset, or of a sampler with its sliders, and what the tables of a study say about them.

const LAW = ["alpha", "beta", "gamma", "delta"];
const MAX_DISCS = 40000; // where all dots are shown; of more, the surface alone has their colours
let cover, luck, keep, ranked = {}, seed = 1;

const asked = () => element("sampler").value;
const allDots = () => Uint32Array.from({ length: head.dots.stored }, (_, i) => i);

function fillLaw() {
  cover = makeCover(data, head.dots.step, head.dots.radius);
  keep = new Uint8Array(head.dots.stored);
  for (const [name, words] of Object.entries(head.dots.samplers)) element("sampler").add(new Option(words, name));
  element("sampler").value = head.dots.sampler;
  element("presets").add(new Option("…", ""));
  head.dots.presets.forEach(([words], k) => element("presets").add(new Option(words, k)));
  newDraw();
}

// The order in which a nested sampler chooses the dots, kept until another draw is asked for.
function order(name) {
  if (name === "minimal") ranked[name] ??= allDots().filter((i) => data.minimal[i]);
  if (!ranked[name] && data[`rank ${name}`]) {
    ranked[name] = new Uint32Array(head.dots.stored);
    data[`rank ${name}`].forEach((place, i) => (ranked[name][place] = i));
  }
  return (ranked[name] ??= uniformOrder(head.dots.stored, seed));
}

function newDraw() {
  luck = exponentials(cover.dot.length, seed);
  delete ranked.uniform;
}

function chosenDots() {
  const name = asked(), all = head.dots.stored;
  if (name === "none") return new Uint32Array(0);
  if (name === "all") return allDots();
  if (name === "minimal") return order(name);
  if (name !== "paper") return order(name).slice(0, Math.max(1, Math.round((element("percent").value / 100) * all)));
  sample(cover, LAW.map((each) => +element(each).value), luck, keep);
  return allDots().filter((i) => keep[i]);
}

// The dots that the controls ask for; the page without dots has none.
function chooseDots() {
  if (!dots) return;
  const name = asked(), chosen = chosenDots(), all = head.dots.stored;
  view.shown = name === "all" && chosen.length > MAX_DISCS && hasSurface() ? [] : Array.from(chosen);
  if (!view.shown.includes(view.picked)) pickDot(-1);
  element("law").hidden = name !== "paper";
  element("amount").hidden = ["paper", "all", "minimal", "none"].includes(name);
  element("again").hidden = !(name === "uniform" || name === "paper");
  element("size").parentElement.hidden = name === "none";
  for (const id of ["percent", "size", ...LAW]) element(id).parentElement.querySelector("output").textContent = element(id).value;
  element("percent-text").textContent += " %";
  const whole = name === "minimal" && chosen.length === head.dots.minimal ? head.dots.total : all;
  const told = name === "none" ? "" : `${chosen.length.toLocaleString("en")} of ${whole.toLocaleString("en")} dots (${((100 * chosen.length) / whole).toFixed(1)} %).`;
  element("shown").textContent = told;
  if (told && all < head.dots.total && whole !== head.dots.total) element("shown").textContent += ` The page holds the first ${all.toLocaleString("en")} of ${head.dots.total.toLocaleString("en")} dots.`;
  if (name === "paper") element("nearest").replaceChildren(...nearest());
}

// The row of the grid nearest to the sliders, value by value since the grid has all combinations, and what it says.
function nearest() {
  const { grid, readings } = head.dots, wish = LAW.map((name) => +element(name).value);
  if (!grid.length) return [];
  const gap = (row) => wish.reduce((sum, value, k) => sum + (value - row[k]) ** 2, 0);
  const row = grid.reduce((best, each) => (gap(each) < gap(best) ? each : best)), table = document.createElement("table"), words = document.createElement("p");
  words.append(...subscripts(`Nearest combination of the study: (${row.slice(0, 4).join(", ")}), n_S ${number(row[4], 1)} %.`));
  const line = (texts, kind) => {
    const tr = table.insertRow();
    texts.forEach((text) => tr.appendChild(document.createElement(kind)).append(...subscripts(text)));
  };
  line(["reading", "Z_tS", "Z_tR", "d"], "th");
  readings.forEach((name, r) => line([name, ...row.slice(5 + 3 * r, 8 + 3 * r).map((value) => number(value, 2))], "td"));
  const note = document.createElement("p");
  note.append(...subscripts("Z is the mean distance of the descriptors from those of the full surface (0 is best), for the sampled dots (Z_tS) and for a random subset of the same size (Z_tR). Where d = Z_tR − Z_tS is above 0, the sampling is better."));
  return [words, table, note];
}

function pickDot(i) {
  view.picked = i;
  element("picked").hidden = i < 0;
  if (i < 0) return;
  const words = [`Dot ${data.index[i]}`];
  if (data.residue?.[i] >= 0) words.push(head.labels[data.residue[i]]);
  if (data.kind?.[i] >= 0) words.push(head.kinds[data.kind[i]][0]);
  head.values.forEach((scale, k) => {
    const value = data[`value ${k}`][i], symbol = k ? scale.symbol.replaceAll("_", " ") : scale.symbol; // the name of a field has no subscript
    words.push(`${symbol} = ${value === UNKNOWN ? "unknown" : number(scale.low + ((scale.high - scale.low) * value) / 254, 2) + scale.unit}`);
  });
  element("picked").replaceChildren(...subscripts(`${words.join(", ")}.`));
}

function drawAgain() {
  if (element("again").hidden) return;
  seed += 1;
  newDraw();
  chooseDots();
  paint();
}

// Move a slider to a value, which its limits and steps may lack.
function slide(slider, value) {
  slider.min = Math.min(slider.min, value);
  slider.max = Math.max(slider.max, value);
  slider.value = value;
  if (Number(slider.value) !== value) slider.step = "any";
  slider.value = value;
}

function listenToLaw() {
  const again = () => (chooseDots(), paint());
  for (const id of ["sampler", "percent", "size", ...LAW]) element(id).addEventListener("input", again);
  element("presets").addEventListener("input", (event) => {
    if (event.target.value === "") return;
    LAW.forEach((name, k) => slide(element(name), head.dots.presets[event.target.value][1][k]));
    again();
  });
  element("again").addEventListener("click", drawAgain);
}
