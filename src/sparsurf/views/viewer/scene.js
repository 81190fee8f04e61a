// Dots drawn as lit discs that lie in the surface, on its triangles; WebGL 2, parallel projection, z towards the viewer.

const LIFT = 0.3; // Å towards the viewer, by which dots hide the faint surface that they lie on

const CORNER = `#version 300 es
uniform mat3 turn; uniform vec2 scale; uniform vec2 shift; uniform float pixels, radius; uniform bool pale; uniform vec3 faint;
in vec3 place, normal, colour;
out vec3 facing, ink; out float depth;
void main() {
  facing = turn * normal;
  vec3 at = turn * place;
  ink = pale ? faint : colour;
  depth = at.z;
  gl_Position = facing.z < .1 ? vec4(2, 2, 2, 1) : vec4((at.xy + shift) * scale, 0, 1);
  gl_PointSize = 2. * radius * pixels;
}`;

const DISC = `#version 300 es
precision highp float;
uniform float radius, reach, lift; uniform bool ring; uniform vec3 behind;
in vec3 facing, ink; in float depth;
out vec4 light;
void main() {
  vec2 from = 2. * vec2(gl_PointCoord.x, 1. - gl_PointCoord.y) - 1.;
  vec3 n = normalize(facing);
  float rise = ring ? 0. : -dot(n.xy, from) / n.z, far = dot(from, from) + rise * rise;
  if (far > 1. || (ring && far < .5)) discard;
  float z = depth + rise * radius, lit = .5 + .5 * max(0., dot(n, normalize(vec3(-.3, .4, .85))));
  gl_FragDepth = ring ? 0. : clamp(.5 - .5 * (z + lift) / reach, 0., 1.);
  light = vec4(mix(ink * lit, behind, .35 * clamp(.5 - .5 * z / reach, 0., 1.)), 1);
  if (ring) light = vec4(vec3(1) - behind, 1);
}`;

const SHEET_CORNER = `#version 300 es
uniform mat3 turn; uniform vec2 scale; uniform vec2 shift; uniform float reach;
in vec3 place, normal;
out vec3 facing; out float depth;
void main() {
  facing = turn * normal;
  vec3 at = turn * place;
  depth = at.z;
  gl_Position = vec4((at.xy + shift) * scale, -at.z / reach, 1);
}`;

const SHEET = `#version 300 es
precision highp float;
uniform float reach; uniform vec3 behind, faint;
in vec3 facing; in float depth;
out vec4 light;
void main() {
  float lit = .5 + .5 * max(0., dot(normalize(facing), normalize(vec3(-.3, .4, .85))));
  light = vec4(mix(faint * lit, behind, .35 * clamp(.5 - .5 * depth / reach, 0., 1.)), 1);
}`;

// `places` and `facing` are (3 n) float arrays, Å from the middle of the surface, and `corners` those of `triangles`, of which there may
// be none. Throws where there is no WebGL 2.
function makeScene(canvas, places, facing, corners, triangles) {
  const gl = canvas.getContext("webgl2", { antialias: true });
  if (!gl) throw new Error("this browser offers no WebGL 2");
  let reach = 1; // Å, from the middle to the farthest dot
  for (let i = 0; i < places.length; i += 3) reach = Math.max(reach, Math.hypot(places[i], places[i + 1], places[i + 2]));
  const discs = linked(gl, CORNER, DISC), sheet = linked(gl, SHEET_CORNER, SHEET);
  gl.enable(gl.DEPTH_TEST);
  const buffer = ({ program }, name, values, type, scaled) => {
    const own = gl.createBuffer(), place = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, own);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, type, scaled, 0, 0);
    return own;
  };
  const below = gl.createVertexArray(), ofDots = gl.createVertexArray();
  gl.bindVertexArray(below);
  buffer(sheet, "place", corners, gl.FLOAT, false);
  buffer(sheet, "normal", cornerNormals(corners, triangles), gl.FLOAT, false);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
  gl.bindVertexArray(ofDots);
  buffer(discs, "place", places, gl.FLOAT, false);
  buffer(discs, "normal", facing, gl.FLOAT, false);
  const total = places.length / 3, ink = buffer(discs, "colour", new Uint8Array(places.length), gl.UNSIGNED_BYTE, true);
  const listed = gl.createBuffer();
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, listed);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, 4 * (total + 1), gl.DYNAMIC_DRAW);

  const frame = (view) => {
    const half = Math.min(canvas.width, canvas.height) / 2;
    const pixels = (view.zoom * half) / (1.05 * reach); // per Å
    return { pixels, scale: [(2 * pixels) / canvas.width, (2 * pixels) / canvas.height] };
  };
  return {
    colour(values) {
      gl.bindBuffer(gl.ARRAY_BUFFER, ink);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, values);
    },
    // view: turn (9 numbers, row by row), shift (Å), zoom; shown: dots; radius: Å of a disc; pale: the others, faintly;
    // behind: colour of the page.
    draw(view, shown, radius, pale, picked, behind) {
      const { pixels, scale } = frame(view), t = view.turn;
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(...behind, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      const use = ({ program, uniform }) => {
        gl.useProgram(program);
        gl.uniformMatrix3fv(uniform.turn, false, [t[0], t[3], t[6], t[1], t[4], t[7], t[2], t[5], t[8]]);
        gl.uniform2fv(uniform.scale, scale);
        gl.uniform2fv(uniform.shift, view.shift);
        gl.uniform1f(uniform.reach, 1.1 * reach);
        gl.uniform3fv(uniform.behind, behind);
        gl.uniform3fv(uniform.faint, Array(3).fill(behind[0] > 0.5 ? 0.9 : 0.72)); // dark dots stand out on both
      };
      const { uniform } = discs, isBelow = pale && shown.length < total;
      if (isBelow && triangles.length) {
        use(sheet);
        gl.bindVertexArray(below);
        gl.drawElements(gl.TRIANGLES, triangles.length, gl.UNSIGNED_INT, 0);
        gl.bindVertexArray(ofDots);
      }
      use(discs);
      gl.uniform1f(uniform.pixels, pixels);
      const points = (lift, size, faint, ring) => {
        gl.uniform1f(uniform.lift, lift);
        gl.uniform1f(uniform.radius, size);
        gl.uniform1i(uniform.pale, faint);
        gl.uniform1i(uniform.ring, ring);
      };
      if (isBelow && !triangles.length) {
        points(0, pale, 1, 0);
        gl.drawArrays(gl.POINTS, 0, total);
      }
      gl.bufferSubData(gl.ELEMENT_ARRAY_BUFFER, 0, shown);
      points(isBelow ? LIFT : 0, radius, 0, 0);
      gl.drawElements(gl.POINTS, shown.length, gl.UNSIGNED_INT, 0);
      if (picked >= 0) {
        points(0, Math.max(2 * radius, 8 / pixels), 0, 1);
        gl.depthFunc(gl.ALWAYS);
        gl.drawArrays(gl.POINTS, picked, 1);
        gl.depthFunc(gl.LESS);
      }
    },
    // The shown dot in front at a place of the canvas, in its pixels; -1 where there is none.
    pick(view, shown, radius, left, top) {
      const { pixels } = frame(view), t = view.turn;
      const a = (left - canvas.width / 2) / pixels - view.shift[0], b = (canvas.height / 2 - top) / pixels - view.shift[1];
      const near2 = Math.max(radius, 7 / pixels) ** 2;
      let best = -1, front = -Infinity;
      for (const i of shown) {
        const [x, y, z] = places.subarray(3 * i, 3 * i + 3), [u, v, w] = facing.subarray(3 * i, 3 * i + 3);
        const gap2 = (t[0] * x + t[1] * y + t[2] * z - a) ** 2 + (t[3] * x + t[4] * y + t[5] * z - b) ** 2;
        if (gap2 > near2 || t[6] * u + t[7] * v + t[8] * w < 0.1) continue;
        const height = t[6] * x + t[7] * y + t[8] * z - Math.sqrt(gap2); // the nearer one of two at like heights
        if (height > front) [best, front] = [i, height];
      }
      return best;
    },
    perPixel: (view) => 1 / frame(view).pixels,
  };
}
