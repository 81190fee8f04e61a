// What the pages of dots and of triangles share: how a drawing is turned, drawn again and saved, and what its numbers look like.
// The page defines `view`, `scene`, `head` and `drawNow`.

const GREY = [160, 160, 160], WHITE = [1, 1, 1];
const element = (id) => document.getElementById(id);
const number = (value, digits) => (value === null ? "–" : value.toFixed(digits).replace("-", "−"));
// Text with subscripts, as nodes: R_i becomes R<sub>i</sub>; where a text has no room for nodes, in letters.
const subscripts = (text) => text.split(/_(\w+)/).map((part, k) => (k % 2 ? Object.assign(document.createElement("sub"), { textContent: part }) : part));
const inLetters = (text) => text.replaceAll("_i", "ᵢ");

// The colour of the page, as numbers from 0 to 1.
const ofPage = () => getComputedStyle(document.body).backgroundColor.match(/[\d.]+/g).slice(0, 3).map((value) => value / 255);

function shade(share) {
  const stops = head.stops, place = share * (stops.length - 1), k = Math.min(stops.length - 2, Math.floor(place));
  return stops[k].map((value, c) => value + (place - k) * (stops[k + 1][c] - value));
}

// One drawing for all changes of a moment.
let asked = false;

function redraw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => drawNow());
}

// The canvas, with as many pixels as the screen has there; what was asked for is drawn on it next.
function cleared() {
  const canvas = element("canvas"), sharp = Math.min(2, window.devicePixelRatio || 1);
  asked = false;
  [canvas.width, canvas.height] = [Math.max(1, canvas.clientWidth * sharp), Math.max(1, canvas.clientHeight * sharp)];
  return canvas;
}

function redrawWhereNeeded() {
  new ResizeObserver(redraw).observe(element("canvas"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  addEventListener("beforeprint", () => {
    drawNow(WHITE);
    element("printed").src = element("canvas").toDataURL("image/png");
    redraw();
  });
}

function putBack() {
  Object.assign(view, { turn: [...head.turn], shift: [0, 0], zoom: 1 });
  redraw();
}

// The picture, on white, above two lines that say what it shows.
function pictureAbove(lines) {
  drawNow(WHITE);
  const canvas = element("canvas"), out = document.createElement("canvas"), line = Math.max(14, canvas.width / 60);
  [out.width, out.height] = [canvas.width, canvas.height + 3.2 * line];
  const pen = out.getContext("2d");
  pen.fillStyle = "white";
  pen.fillRect(0, 0, out.width, out.height);
  pen.drawImage(canvas, 0, 0);
  pen.fillStyle = "black";
  pen.font = `${line}px sans-serif`;
  lines.forEach((text, k) => pen.fillText(text, line / 2, canvas.height + (1 + 1.4 * k) * line));
  redraw();
  return out;
}

function saveAs(name, drawn) {
  const link = document.createElement("a");
  link.download = `${name.replace(/\W+/g, "_")}.png`;
  link.href = drawn.toDataURL("image/png");
  link.click();
}

// The colours of a scale with its ends, as nodes of a legend, and the same in words.
function legendOf(scale, unit) {
  const bar = document.createElement("div"), ends = document.createElement("div"), digits = scale.bright - scale.dark >= 100 ? 0 : 2;
  bar.className = "bar";
  bar.style.background = `linear-gradient(to right, ${head.stops.map((rgb) => `rgb(${rgb})`)})`;
  ends.className = "ends";
  for (const [end, colour] of [["low", "dark"], ["high", "bright"]]) {
    ends.appendChild(document.createElement("span")).append(`${number(scale[colour], digits)}${unit} ${scale[`${end} is`]}`);
  }
  return { nodes: [bar, ends], words: `, dark ${number(scale.dark, digits)}${unit}, bright ${number(scale.bright, digits)}${unit}` };
}

// A box of each colour and its name, for the legend.
function boxed(pairs) {
  return pairs.flatMap(([name, rgb]) => {
    const box = document.createElement("i");
    box.style.background = `rgb(${rgb})`;
    return [box, name];
  });
}

// What a key does, where it is typed on a part of the page.
function onKeys(part, keys) {
  part.addEventListener("keydown", (event) => {
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
  });
}

// Turns by radians about the upright and the level axis of the screen.
function turn(across, down) {
  const t = view.turn, [c, s, e, f] = [Math.cos(across), Math.sin(across), Math.cos(down), Math.sin(down)];
  const rows = [[c, 0, s], [f * s, e, -f * c], [-e * s, f, e * c]];
  view.turn = rows.flatMap((row) => [0, 1, 2].map((k) => row[0] * t[k] + row[1] * t[3 + k] + row[2] * t[6 + k]));
  redraw();
}

function zoom(factor) {
  view.zoom = Math.min(40, Math.max(0.3, view.zoom * factor));
  redraw();
}

// One finger or the mouse turns, two fingers zoom and move, a press without a move calls `press` with its place, in pixels of the canvas.
function follow(canvas, press) {
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-0.0015 * event.deltaY));
  }, { passive: false });
  const fingers = new Map();
  let moved = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    moved = fingers.size ? Infinity : 0;
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const [across, down] = [event.clientX - before[0], event.clientY - before[1]];
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    moved += Math.abs(across) + Math.abs(down);
    if (other) zoom(Math.hypot(event.clientX - other[0], event.clientY - other[1]) / Math.max(1, Math.hypot(before[0] - other[0], before[1] - other[1])));
    if (other || event.shiftKey) {
      const perPixel = (scene.perPixel(view) * canvas.width) / canvas.clientWidth / fingers.size;
      view.shift = [view.shift[0] + across * perPixel, view.shift[1] - down * perPixel];
      redraw();
    } else turn(0.01 * across, 0.01 * down);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  for (const kind of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(kind, (event) => {
      if (fingers.delete(event.pointerId) && kind === "pointerup" && moved < 5) {
        const box = canvas.getBoundingClientRect(), sharp = canvas.width / box.width;
        press((event.clientX - box.left) * sharp, (event.clientY - box.top) * sharp);
      }
    });
  }
}
