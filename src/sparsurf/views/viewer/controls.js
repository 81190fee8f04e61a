// What links the picture, the list, the profile, the search and the frames: each shows the residue that any of them chooses.

const FRAMES_PER_SECOND = 5;
const CURVE = { width: 380, height: 110, left: 58, right: 10, top: 10, bottom: 22 }; // px, of a drawing over time and its margins
let playing = null;

const written = ({ unit, digits }, value) => `${number(value, digits)}${value !== null && unit ? ` ${unit}` : ""}`;
const rows = () => [...element("list").children];

function fillMenus() {
  const menu = element("colour"), hasKinds = dots ? data.kind : data["corner kind"];
  head.values.forEach((scale, k) => menu.add(new Option(inLetters(scale.name), `value ${k}`)));
  if (head.kinds.length && hasKinds) menu.add(new Option("kind of dot", "kind"));
  head.numbers.forEach((table, k) => table.colours && menu.add(new Option(table.name, `number ${k}`)));
  if (head.parts.length) {
    if (head.chains.length > 1) menu.add(new Option("chain", "chain"));
    menu.add(new Option("residue type", "type"));
    if (head.plddt.length || new Set(data.b).size > 1) menu.add(new Option(head.plddt.length ? "pLDDT" : "B factor", "b"));
  }
  menu.add(new Option("one colour", "plain"));
  if ([...menu.options].some((option) => option.value === head.colour)) menu.value = head.colour;
  element("inside").parentElement.hidden = !atoms.length;
  element("opacity").parentElement.hidden = !hasSurface();
  const lists = element("which");
  if (head.regions.length) lists.add(new Option("regions (Å²; mean)", "regions"));
  if (head.touching.length) lists.add(new Option(nFrames() > 1 ? "what touches what (% of frames; buried Å²)" : "what touches what (buried Å²)", "touching"));
  if (head.order.length) lists.add(new Option(`${head.orders} residues`, "ranked"));
  head.numbers.forEach((table, k) => k && table.frames < 2 && lists.add(new Option(`by ${table.name}`, `number ${k}`)));
  if (head.labels.length) lists.add(new Option("residues in order", "order"));
  for (const part of [element("find"), element("listing"), element("list"), element("none")]) part.hidden = !head.labels.length;
  fillList();
  for (const part of document.querySelectorAll(".dotted")) part.hidden = !dots;
  if (dots) fillLaw();
  if (nFrames() > 1) element("frame").max = nFrames() - 1;
}

// The residues of a region of a field.
const inRegion = ([, , names]) => names.split("; ").map((name) => head.labels.indexOf(name)).filter((residue) => residue >= 0);
const ofRegion = ([area, mean]) => `${number(area, 1)} Å²; ${number(mean, 2)}`;

// The rows of the list: [residue, words, number], and of a region its name and all of its residues.
function listed() {
  const which = element("which").value, [, k] = which.split(" ");
  if (which === "touching") return head.touching.map(([residue, unit, area, share]) => [residue, `with ${head.units[unit]}`, nFrames() > 1 ? `${share} %; ${number(area, 1)}` : number(area, 1)]);
  if (which === "regions") return head.regions.map((each, k) => [inRegion(each)[0] ?? -1, each[2].replaceAll(";", ","), ofRegion(each), `region ${k + 1}`, inRegion(each)]);
  const residues = [...head.labels.keys()];
  if (which === "order" || which === "") return residues.map((residue) => [residue, "", ""]);
  if (k) return residues.map((residue) => [residue, numberOf(k, residue)]).filter(([, value]) => value !== null).sort((a, b) => b[1] - a[1]).map(([residue, value]) => [residue, "", written(head.numbers[k], value)]);
  return head.order.map((residue, place) => [residue, place < head.ranked ? "" : "not ranked", written(head.numbers[0], numberOf(0, residue, 0))]);
}

function fillList() {
  element("list").replaceChildren(...listed().map(([residue, words, amount, name = head.labels[residue], members = [residue]], k) => {
    const row = document.createElement("div");
    [row.id, row.dataset.residue, row.members] = [`row-${k}`, residue, members];
    row.setAttribute("role", "option");
    row.append(...[name, words, amount].map((text) => Object.assign(document.createElement("span"), { textContent: text })));
    return row;
  }));
  search(false);
  mark();
}

// Every part of the page shows a residue, or none of them if it is -1. `moves`: the picture turns it to the front. `members`: the
// residues of a region, all of which the picture shows.
function choose(residue, moves = true, members = [residue]) {
  [view.chosen, view.members] = [residue, new Set(members)];
  if (!view.touched) setOpacity(opacityAtStart());
  mark();
  describe();
  curves();
  if (!home) return; // nothing can be drawn
  atOnce(() => {
    style();
    if (residue >= 0 && moves) go();
    paint();
  });
}

function mark() {
  const list = element("list");
  let first = null;
  for (const row of rows()) {
    const isChosen = view.chosen >= 0 && row.members.includes(view.chosen);
    row.setAttribute("aria-selected", String(isChosen));
    if (isChosen) first ??= row;
  }
  if (first) {
    first.hidden = false;
    list.setAttribute("aria-activedescendant", first.id);
    list.scrollTop = first.offsetTop - list.offsetTop - list.clientHeight / 2;
  } else list.removeAttribute("aria-activedescendant");
  for (const dot of document.querySelectorAll(".profile [data-residue]")) {
    dot.classList.toggle("chosen", view.members.has(+dot.dataset.residue));
    if (+dot.dataset.residue === view.chosen) {
      const box = dot.closest(".wide"), place = dot.getBoundingClientRect(), frame = box.getBoundingClientRect();
      if (place.left < frame.left || place.right > frame.right) box.scrollLeft += place.left - frame.left - frame.width / 2;
    }
  }
  for (const button of document.querySelectorAll("button.residue")) button.setAttribute("aria-pressed", String(+button.dataset.residue === view.chosen));
}

function describe() {
  const r = view.chosen;
  if (r < 0) return (element("chosen").textContent = head.labels.length ? "Click a residue in the picture, in the list or in the profile, or search for one." : "");
  if (view.members.size > 1) return (element("chosen").textContent = `${nameOfChosen()}: ${[...view.members].map((residue) => head.labels[residue]).join(", ")}.`);
  const said = head.numbers.map((table, k) => [table, numberOf(k, r)]).filter(([, value]) => value !== null).map(([table, value]) => `${table.name} ${written(table, value)}`);
  for (const [residue, unit, area] of head.touching) if (residue === r) said.push(`${number(area, 1)} Å² buried by ${head.units[unit]}`);
  head.regions.forEach((each, k) => inRegion(each).includes(r) && said.push(`in region ${k + 1} of ${number(each[0], 1)} Å²`));
  const isOn = meshes[view.frame].residues?.includes(r), isPart = data.kinds ? data.kinds[r] >= 0 && r < head.surfaced : true;
  const why = !hasSurface() || isOn ? "" : isPart ? " It has no surface here: it is buried." : " The surface leaves it out.";
  element("chosen").textContent = `${head.labels[r]}${said.length ? `: ${said.join("; ")}` : ""}.${why}`;
}

// Shows the rows whose residue, or whose partner or region, has parts that begin with all words of the search. Chooses the residue
// of which all words are whole parts, or when Enter was pressed the first one.
function search(enters, chooses = false) {
  const words = element("search").value.trim().toUpperCase().replace(/([A-Z]{3})(\d)/, "$1 $2").split(/[\s:,]+/).filter(Boolean);
  const fits = (text, how) => words.every((word) => text.toUpperCase().split(/[\s,]+/).some((part) => how(part, word)));
  const fitting = (how) => [...head.labels.keys()].filter((residue) => fits(head.labels[residue], how)), begins = (part, word) => part.startsWith(word);
  const same = fitting((part, word) => part === word), all = [...new Set([...same, ...fitting(begins)])];
  for (const row of rows()) row.hidden = ![0, 1].some((k) => fits(row.children[k].textContent, begins));
  const shown = rows().filter((row) => !row.hidden).length;
  element("found").textContent = words.length ? `${all.length} residue${all.length === 1 ? "" : "s"} found; the list shows ${shown} row${shown === 1 ? "" : "s"}.` : "";
  if (words.length && (enters ? all.length : chooses && words.length > 1 && same.length === 1)) choose(enters ? all[0] : same[0]);
}

// The next row of the list that is shown, by steps, and the next residue along the chain.
function step(by) {
  const shown = rows().filter((row) => !row.hidden), now = shown.findIndex((row) => row.members.includes(view.chosen));
  if (shown.length) chooseRow(shown[Math.min(shown.length - 1, Math.max(0, now < 0 ? 0 : now + by))]);
}

const chooseRow = (row) => choose(+row.dataset.residue, true, row.members);

function along(by) {
  if (head.labels.length) choose(Math.min(head.labels.length - 1, Math.max(0, view.chosen < 0 ? 0 : view.chosen + by)));
}

function setOpacity(percent) {
  element("opacity").value = percent;
  element("opacity-text").textContent = `${percent} %`;
  element("opacity").setAttribute("aria-valuetext", `${percent} %`);
}

function toFrame(frame) {
  if (nFrames() < 2) return;
  view.frame = Math.min(nFrames() - 1, Math.max(0, frame));
  [element("frame").value, element("frame-text").textContent] = [view.frame, head.frames[view.frame]];
  element("frame").setAttribute("aria-valuetext", head.frames[view.frame]);
  atOnce(() => {
    viewer.setFrame(view.frame);
    drawSurface();
    style();
  });
  describe();
  curves();
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
    drawn.push(curve(`${table.name} of ${head.labels[view.chosen]}${table.unit ? ` (${table.unit})` : ""}`, values, table.digits));
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

// Saves the picture on white, above a line that says what it shows.
async function picture() {
  const image = new Image();
  image.src = onWhite();
  await image.decode();
  const out = document.createElement("canvas"), line = Math.max(14, image.width / 60), pen = out.getContext("2d");
  [out.width, out.height] = [image.width, image.height + 3.2 * line];
  Object.assign(pen, { fillStyle: "white" }).fillRect(0, 0, out.width, out.height);
  pen.drawImage(image, 0, 0);
  Object.assign(pen, { fillStyle: "black", font: `${line}px sans-serif` });
  caption().forEach((text, k) => pen.fillText(text, line / 2, image.height + (1 + 1.4 * k) * line));
  return out;
}

function caption() {
  const law = dots && asked() === "paper" ? ` (${LAW.map((each) => element(each).value).join(", ")})` : "", kept = dots && asked() !== "none" ? `${element("shown").textContent} ${element("sampler").selectedOptions[0].text}${law}; ` : "";
  return [[document.title, head.frames[view.frame]].filter(Boolean).join(", "), `${kept}colour: ${coloured}${view.chosen < 0 ? "" : `; ${nameOfChosen()} in orange`}`];
}

async function save() {
  const out = await picture();
  Object.assign(document.createElement("a"), { download: `${[document.title, head.frames[view.frame]].filter(Boolean).join(" ").replace(/\W+/g, "_")}.png`, href: out.toDataURL() }).click();
}

// What a key does, where it is typed on a part of the page.
function onKeys(part, keys) {
  part.addEventListener("keydown", (event) => {
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
  });
}

const chooseNone = () => {
  if (dots) pickDot(-1);
  choose(-1);
};

// The list, the search and the profiles, which need no picture.
function listen() {
  element("which").addEventListener("input", fillList);
  element("search").addEventListener("input", () => search(false, true));
  onKeys(element("search"), { Enter: () => search(true), ArrowDown: () => element("list").focus() });
  element("none").addEventListener("click", chooseNone);
  document.querySelector("#controls details").addEventListener("toggle", (event) => event.target.scrollIntoView({ block: "nearest" }));
  onKeys(element("list"), {
    ArrowDown: () => step(1), ArrowUp: () => step(-1), PageDown: () => step(10), PageUp: () => step(-10), Home: () => step(-Infinity), End: () => step(Infinity), Escape: chooseNone,
  });
  document.addEventListener("click", (event) => {
    const button = event.target.closest("#list [data-residue], button.residue");
    if (!button) return;
    if (button.members) chooseRow(button);
    else choose(+button.dataset.residue);
    if (button.tagName === "BUTTON") element("stage").scrollIntoView({ block: "nearest" });
  });
  for (const profile of document.querySelectorAll(".profile .wide")) {
    onKeys(profile, { ArrowRight: () => along(1), ArrowLeft: () => along(-1), Escape: chooseNone });
    profile.addEventListener("click", (event) => {
      const marks = [...profile.querySelectorAll("[data-residue]")], away = (mark) => Math.abs(mark.getBoundingClientRect().left + mark.getBoundingClientRect().width / 2 - event.clientX);
      if (marks.length) choose(+marks.reduce((a, b) => (away(b) < away(a) ? b : a)).dataset.residue);
    });
  }
}

function listenToPicture() {
  const stage = element("stage"), reset = () => viewer.setView(home);
  element("colour").addEventListener("input", () => (style(), paint()));
  element("opacity").addEventListener("input", () => {
    view.touched = true;
    setOpacity(element("opacity").value);
    paint();
  });
  element("inside").addEventListener("input", () => (style(), viewer.render()));
  for (const [id, action] of [["reset", reset], ["save", save], ["play", play]]) element(id)?.addEventListener("click", action);
  onKeys(stage, {
    ArrowLeft: () => viewer.rotate(-8, "vy"), ArrowRight: () => viewer.rotate(8, "vy"), ArrowUp: () => viewer.rotate(-8, "vx"), ArrowDown: () => viewer.rotate(8, "vx"),
    "+": () => viewer.zoom(1.15), "=": () => viewer.zoom(1.15), "-": () => viewer.zoom(1 / 1.15), 0: reset, s: save, Escape: chooseNone,
    n: () => (dots && !element("again").hidden ? drawAgain() : along(1)), p: () => along(-1), ".": () => toFrame(view.frame + 1), ",": () => toFrame(view.frame - 1),
  });
  element("frame")?.addEventListener("input", () => toFrame(+element("frame").value));
  if (dots) listenToLaw();
  let down = null, waiting = null;
  stage.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]), true);
  stage.addEventListener("pointerup", (event) => {
    const moved = !down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4;
    down = null;
    if (moved || event.button) return;
    const { residue, dot } = pick(event.pageX, event.pageY);
    if (dots) pickDot(dot);
    choose(residue, false);
  }, true);
  stage.addEventListener("pointermove", (event) => {
    clearTimeout(waiting);
    if (!event.buttons) waiting = setTimeout(() => {
      const { residue } = pick(event.pageX, event.pageY);
      element("hover").hidden = residue < 0;
      if (residue >= 0) element("hover").textContent = head.labels[residue];
    }, 60);
  });
  new ResizeObserver(() => stage.clientWidth === viewer.WIDTH && stage.clientHeight === viewer.HEIGHT || viewer.resize()).observe(stage);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (background(), viewer.render()));
  addEventListener("beforeprint", () => (element("printed").src = onWhite()));
  toFrame(0);
}

start().catch((error) => {
  element("chosen").textContent = `Nothing can be drawn: ${error.message}.`;
  document.body.dataset.failed = "yes";
  console.error(error);
});
