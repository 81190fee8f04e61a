// The colours of corners and dots, and the key that tells what they mean.

const UNKNOWN = 255;
const number = (value, digits) => (value === null || value === undefined ? "–" : value.toFixed(digits).replace("-", "−"));
// Text with subscripts, as nodes: R_i becomes R<sub>i</sub>; where a text has no room for nodes, in letters.
const subscripts = (text) => text.split(/_(\w+)/).map((part, k) => (k % 2 ? Object.assign(document.createElement("sub"), { textContent: part }) : part));
const inLetters = (text) => text.replaceAll("_i", "ᵢ");
let coloured = "";

// The colour of a value between those of stops, [value, colour] in ascending order; bands have two stops at one value.
function between(stops, value) {
  const k = stops.findLastIndex(([low]) => low <= value), [low, from] = stops[Math.max(0, k)], [high, to] = stops[Math.min(stops.length - 1, k + 1)];
  return from.map((channel, c) => channel + (high > low ? (value - low) / (high - low) : 0) * (to[c] - channel));
}

// A number of a residue in a frame; null where it has none.
function numberOf(k, residue, frame = view.frame) {
  const table = head.numbers[k], steps = residue < 0 ? undefined : data[`number ${k}`][(table.frames > 1 ? frame * table.count : 0) + residue];
  return steps === undefined || steps < 0 || residue >= table.count ? null : table.low + table.step * steps;
}

// What the menu asks for, of `n` corners or dots: the colour of each, in words, and a bar or boxes for the key.
function scheme(prefix, residues, kinds) {
  const [what, k] = element("colour").value.split(" ");
  if (what === "kind") {
    const kindOf = (i) => (kinds[i] < 0 ? 3 : kinds[i]), found = new Set(kinds);
    return { colour: (i) => head.kinds[kindOf(i)][1], words: "kind of dot", boxes: head.kinds.filter((_, kind) => found.has(kind === 3 ? -1 : kind)) };
  }
  if (what === "chain") return byResidue(residues, "chain", (r) => head.chains[data.chain[r]][1], head.chains);
  if (what === "type") return byResidue(residues, "residue type", (r) => head.types[data.type[r]][1], head.types);
  if (what === "b") return byB(residues);
  if (what === "plain") return { colour: () => PLAIN, words: "", boxes: [] };
  const scale = what === "number" ? head.numbers[k] : head.values[k], steps = data[`${prefix} ${k}`];
  const valueAt = what === "number" ? (i) => numberOf(k, residues[i]) : (i) => (steps[i] === UNKNOWN ? null : scale.low + ((scale.high - scale.low) * steps[i]) / 254);
  const { stops } = scale, [low, high] = [stops[0][0], stops.at(-1)[0]];
  const digits = high - low >= 100 ? 0 : 2, unit = scale.unit ? ` ${scale.unit.trim()}` : "", end = (value, which) => `${number(value, digits)}${unit} ${scale[`${which} is`]}`.trim();
  const ends = [end(low, "low"), end(high, "high")];
  const all = what === "number" ? Array.from({ length: scale.count }, (_, r) => numberOf(k, r)) : Array.from(steps, (step) => (step === UNKNOWN ? null : step));
  return {
    colour: (i) => ((value) => (value === null ? GREY : between(stops, value)))(valueAt(i)),
    words: inLetters(scale.name), bar: !scale.boxes.length && all.some((value) => value !== null) && stops, ends, boxes: [...scale.boxes, ...(all.includes(null) ? [[scale["unknown is"], GREY]] : [])],
  };
}

function byResidue(residues, words, colourOf, boxes) {
  return { colour: (i) => (residues[i] < 0 ? GREY : colourOf(residues[i])), words, boxes };
}

// B factors, or the confidence of a prediction in the bands of the AlphaFold database; of each residue.
function byB(residues) {
  head.meanB ??= head.labels.map((_, r) => (atomsOf[r] ?? []).reduce((sum, atom) => sum + data.b[atom] / 100, 0) / (atomsOf[r]?.length || NaN));
  if (head.plddt.length) return byResidue(residues, "pLDDT", (r) => head.plddt[[50, 70, 90].filter((bound) => head.meanB[r] >= bound).length][1], head.plddt);
  const sorted = head.meanB.filter((value, r) => value > 0 && data.kinds[r] < 2).sort((a, b) => a - b), [low, high] = [0.02, 0.98].map((share) => sorted[Math.floor(share * sorted.length)] ?? 0);
  return { ...byResidue(residues, "B factor (Å²), mean of each residue", (r) => between(head.stops, (head.meanB[r] - low) / (high - low || 1)), []), bar: head.stops, ends: [number(low, 0), number(high, 0)] };
}

function coloursOfSurface() {
  const { residues, corners } = meshes[view.frame], dotted = view.shown.length > 0 && asked() !== "all";
  const made = dotted ? { colour: () => PLAIN } : scheme("corner", residues, data["corner kind"]);
  if (!view.shown.length) key(made);
  return corners.map((_, i) => rgb(residues && view.chosen >= 0 && view.members.has(residues[i]) ? CHOSEN : made.colour(i)));
}

function coloursOfDots() {
  const made = scheme("value", data.residue, data.kind);
  key(made);
  return made.colour;
}

function key({ words, bar, ends, boxes }) {
  const nodes = [...subscripts(words)], tag = (name, more, ...inner) => {
    const node = Object.assign(document.createElement(name), more);
    node.append(...inner);
    return node;
  };
  if (bar) {
    const strip = tag("div", { className: "bar" });
    const [low, high] = [bar[0][0], bar.at(-1)[0]];
    strip.style.background = `linear-gradient(to right, ${bar.map(([value, c]) => `rgb(${c}) ${(100 * (value - low)) / (high - low || 1)}%`)})`;
    nodes.push(strip, tag("div", { className: "ends" }, ...ends.map((text) => tag("span", { textContent: text }))));
  }
  for (const [name, c] of [...boxes, ...(view.chosen < 0 ? [] : [[nameOfChosen(), CHOSEN]])]) {
    const box = tag("i", {});
    box.style.background = `rgb(${c})`;
    nodes.push(tag("span", { className: "box" }, box, name || "–"));
  }
  element("legend").replaceChildren(...nodes);
  coloured = [words, bar && `from ${ends[0]} to ${ends[1]}`, ...boxes.map(([name]) => (bar ? `grey ${name}` : name))].filter(Boolean).join(", ");
}
