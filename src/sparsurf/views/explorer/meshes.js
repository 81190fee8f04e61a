// Triangles of the surface, and of the chain and sticks inside of it; WebGL 2, parallel projection, z towards the viewer.

const LIT_CORNER = `#version 300 es
uniform mat3 turn; uniform vec2 scale, shift; uniform float reach;
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 colour;
out vec3 facing, ink; out float depth;
void main() {
  facing = turn * normal;
  ink = colour;
  vec3 at = turn * place;
  depth = at.z;
  gl_Position = vec4((at.xy + shift) * scale, -at.z / reach, 1);
}`;

const LIT = `#version 300 es
precision highp float;
uniform float reach, opacity; uniform vec3 behind;
in vec3 facing, ink; in float depth;
out vec4 light;
void main() {
  float lit = .45 + .55 * max(0., dot(normalize(facing), normalize(vec3(-.3, .4, .85))));
  light = vec4(mix(ink * lit, behind, .3 * clamp(.5 - .5 * depth / reach, 0., 1.)), opacity);
}`;

const NAMED_CORNER = `#version 300 es
uniform mat3 turn; uniform vec2 scale, shift; uniform float reach;
layout(location = 0) in vec3 place;
layout(location = 2) in vec3 colour;
flat out vec3 name;
void main() {
  name = colour;
  vec3 at = turn * place;
  gl_Position = vec4((at.xy + shift) * scale, -at.z / reach, 1);
}`;

const NAMED = `#version 300 es
precision highp float;
flat in vec3 name;
out vec4 light;
void main() { light = vec4(name, 1); }`;

const ATTRIBUTES = { place: 0, normal: 1, colour: 2 };

// Throws where there is no WebGL 2. Places are in Å from the middle, `reach` of which all of them lie.
function makeMeshes(canvas, reach) {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
  if (!gl) throw new Error("this browser offers no WebGL 2");
  const lit = linked(gl, LIT_CORNER, LIT), named = linked(gl, NAMED_CORNER, NAMED);
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  const solids = { surface: made(), inside: made(), names: made() };

  function made() {
    const solid = { array: gl.createVertexArray(), buffers: {}, n: 0 };
    for (const name of ["place", "normal", "colour", "triangles"]) solid.buffers[name] = gl.createBuffer();
    return solid;
  }

  function fill(solid, name, values, type, scaled) {
    const at = ATTRIBUTES[name];
    gl.bindVertexArray(solid.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, solid.buffers[name]);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, 3, type, scaled, 0, 0);
  }

  function list(solid, triangles) {
    gl.bindVertexArray(solid.array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, solid.buffers.triangles);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.DYNAMIC_DRAW);
    solid.n = triangles.length;
  }

  const frame = (view) => {
    const half = Math.min(canvas.width, canvas.height) / 2;
    const pixels = (view.zoom * half) / (1.05 * reach); // per Å
    return { pixels, scale: [(2 * pixels) / canvas.width, (2 * pixels) / canvas.height] };
  };

  function prepare(view, behind, { program, uniform } = lit) {
    const { scale } = frame(view), t = view.turn;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.useProgram(program);
    gl.uniformMatrix3fv(uniform.turn, false, [t[0], t[3], t[6], t[1], t[4], t[7], t[2], t[5], t[8]]);
    gl.uniform2fv(uniform.scale, scale);
    gl.uniform2fv(uniform.shift, view.shift);
    gl.uniform1f(uniform.reach, 1.2 * reach);
    if (program === lit.program) {
      gl.uniform3fv(uniform.behind, behind);
      gl.uniform1f(uniform.opacity, 1);
    }
    gl.clearColor(...behind, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  function paint(solid) {
    gl.bindVertexArray(solid.array);
    gl.drawElements(gl.TRIANGLES, solid.n, gl.UNSIGNED_INT, 0);
  }

  return {
    surface(places, triangles, residues, normals) {
      for (const solid of [solids.surface, solids.names]) {
        fill(solid, "place", places, gl.FLOAT, false);
        fill(solid, "normal", normals, gl.FLOAT, false);
        list(solid, triangles);
      }
      const names = new Uint8Array(3 * residues.length); // the number of each residue as a colour; 0 is none
      residues.forEach((residue, i) => names.set([(residue + 1) & 255, ((residue + 1) >> 8) & 255, (residue + 1) >> 16], 3 * i));
      fill(solids.names, "colour", names, gl.UNSIGNED_BYTE, true);
    },
    colour(values) {
      fill(solids.surface, "colour", values, gl.UNSIGNED_BYTE, true);
    },
    inside(solid) {
      fill(solids.inside, "place", new Float32Array(solid.places), gl.FLOAT, false);
      fill(solids.inside, "normal", new Float32Array(solid.normals), gl.FLOAT, false);
      fill(solids.inside, "colour", new Uint8Array(solid.colours), gl.UNSIGNED_BYTE, true);
      list(solids.inside, new Uint32Array(solid.triangles));
    },
    // The surface, or, with an opacity below 1, what lies inside and its nearest layer above that.
    draw(view, behind, opacity) {
      prepare(view, behind);
      if (opacity < 1) paint(solids.inside);
      if (opacity < 1) {
        gl.colorMask(false, false, false, false);
        paint(solids.surface);
        gl.colorMask(true, true, true, true);
        gl.enable(gl.BLEND);
        gl.uniform1f(lit.uniform.opacity, opacity);
      }
      paint(solids.surface);
      gl.disable(gl.BLEND);
    },
    // The residue in front at a place of the canvas, in its pixels; -1 where there is none. Corners of one triangle may be of several.
    pick(view, left, top) {
      const target = gl.createFramebuffer(), colours = gl.createRenderbuffer(), depths = gl.createRenderbuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, target);
      for (const [buffer, format, place] of [[colours, gl.RGBA8, gl.COLOR_ATTACHMENT0], [depths, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
        gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
        gl.renderbufferStorage(gl.RENDERBUFFER, format, canvas.width, canvas.height);
        gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
      }
      prepare(view, [0, 0, 0], named);
      paint(solids.names);
      const pixel = new Uint8Array(4);
      gl.readPixels(Math.floor(left), canvas.height - 1 - Math.floor(top), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      gl.deleteFramebuffer(target);
      for (const buffer of [colours, depths]) gl.deleteRenderbuffer(buffer);
      return pixel[0] + 256 * pixel[1] + 65536 * pixel[2] - 1;
    },
    perPixel: (view) => 1 / frame(view).pixels,
  };
}
