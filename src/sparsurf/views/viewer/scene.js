// Dots drawn as lit discs that lie in the surface; WebGL 2, parallel projection, z towards the viewer.

const CORNER = `#version 300 es
uniform mat3 turn; uniform vec2 scale; uniform vec2 shift; uniform float pixels, radius, reach, sink; uniform bool pale;
in vec3 place, normal, colour;
out vec3 facing, ink; out float depth;
void main() {
  facing = turn * normal;
  vec3 at = turn * (place - sink * normal);
  ink = pale ? vec3(.9) : colour;
  depth = at.z;
  gl_Position = facing.z < .1 ? vec4(2, 2, 2, 1) : vec4((at.xy + shift) * scale, 0, 1);
  gl_PointSize = 2. * radius * pixels;
}`;

const DISC = `#version 300 es
precision highp float;
uniform float radius, reach; uniform bool ring;
in vec3 facing, ink; in float depth;
out vec4 light;
void main() {
  vec2 from = 2. * vec2(gl_PointCoord.x, 1. - gl_PointCoord.y) - 1.;
  vec3 n = normalize(facing);
  float rise = ring ? 0. : -dot(n.xy, from) / n.z, far = dot(from, from) + rise * rise;
  if (far > 1. || (ring && far < .5)) discard;
  float z = depth + rise * radius, lit = .5 + .5 * max(0., dot(n, normalize(vec3(-.3, .4, .85))));
  gl_FragDepth = ring ? 0. : clamp(.5 - .5 * z / reach, 0., 1.);
  light = vec4(mix(ink * lit, vec3(1), .35 * clamp(.5 - .5 * z / reach, 0., 1.)), 1);
  if (ring) light = vec4(0, 0, 0, 1);
}`;

// `places` and `facing` are (3 n) float arrays, Å from the middle of the surface; throws where there is no WebGL 2.
function makeScene(canvas, places, facing) {
  const gl = canvas.getContext("webgl2", { antialias: true });
  if (!gl) throw new Error("this browser offers no WebGL 2");
  let reach = 1; // Å, from the middle to the farthest dot
  for (let i = 0; i < places.length; i += 3) reach = Math.max(reach, Math.hypot(places[i], places[i + 1], places[i + 2]));
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, CORNER], [gl.FRAGMENT_SHADER, DISC]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error("the graphics driver refuses the page's program");
  gl.useProgram(program);
  gl.enable(gl.DEPTH_TEST);
  gl.clearColor(1, 1, 1, 1);
  const uniform = {};
  for (const name of ["turn", "scale", "shift", "pixels", "radius", "reach", "sink", "pale", "ring"]) {
    uniform[name] = gl.getUniformLocation(program, name);
  }
  const buffer = (name, values, type, scaled) => {
    const own = gl.createBuffer(), place = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, own);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, type, scaled, 0, 0);
    return own;
  };
  buffer("place", places, gl.FLOAT, false);
  buffer("normal", facing, gl.FLOAT, false);
  const total = places.length / 3, ink = buffer("colour", new Uint8Array(places.length), gl.UNSIGNED_BYTE, true);
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
    // view: turn (9 numbers, row by row), shift (Å), zoom; shown: dots; radius: Å of a disc; pale: the others, faintly.
    draw(view, shown, radius, pale, picked) {
      const { pixels, scale } = frame(view), t = view.turn;
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.uniformMatrix3fv(uniform.turn, false, [t[0], t[3], t[6], t[1], t[4], t[7], t[2], t[5], t[8]]);
      gl.uniform2fv(uniform.scale, scale);
      gl.uniform2fv(uniform.shift, view.shift);
      gl.uniform1f(uniform.pixels, pixels);
      gl.uniform1f(uniform.reach, 1.1 * reach);
      const points = (sink, size, faint, ring) => {
        gl.uniform1f(uniform.sink, sink);
        gl.uniform1f(uniform.radius, size);
        gl.uniform1i(uniform.pale, faint);
        gl.uniform1i(uniform.ring, ring);
      };
      if (pale && shown.length < total) {
        points(0.25, pale, 1, 0);
        gl.drawArrays(gl.POINTS, 0, total);
      }
      gl.bufferSubData(gl.ELEMENT_ARRAY_BUFFER, 0, shown);
      points(0, radius, 0, 0);
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
