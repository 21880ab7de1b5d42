// Draws one frame: the floor, the figure's shadow on it, the figure. WebGL 2.
"use strict";
(function (umg) {
  const { apply } = umg.motion;

  const FIGURE = {
    vertex: `#version 300 es
      uniform mat4 clip;
      uniform vec3 low, from;
      uniform vec2 uvLow, flowLow;
      uniform float size, uvSize, flowSize;
      uniform bool flat_;
      layout(location = 0) in vec4 position;
      layout(location = 1) in vec2 uv;
      layout(location = 2) in vec2 flow;
      layout(location = 3) in vec4 color;
      out vec2 place, move;
      out vec3 tint, spot;
      void main() {
        spot = low + size * position.xyz;
        if (flat_) spot.z = 0.0;
        place = uvLow + uvSize * uv;
        move = flowLow + flowSize * flow;
        tint = color.rgb;
        gl_Position = clip * vec4(spot, 1.0);
      }`,
    // A transition's two ends are met by the flow on the way and fade into each other.
    fragment: `#version 300 es
      precision highp float;
      uniform sampler2D start, end;
      uniform float share;
      uniform int mode;
      uniform vec3 light;
      in vec2 place, move;
      in vec3 tint, spot;
      out vec4 shown;
      void main() {
        vec3 color;
        if (mode == 1) color = texture(start, place).rgb;
        else if (mode == 2)
          color = mix(texture(start, place - share * move).rgb, texture(end, place + (1.0 - share) * move).rgb, share);
        else if (mode == 3) color = tint;
        else {
          vec3 normal = normalize(cross(dFdx(spot), dFdy(spot)));
          color = vec3(0.78) * (0.35 + 0.65 * abs(dot(normal, light)));
        }
        shown = vec4(color, 1.0);
      }`,
  };
  const SHADOW = {
    vertex: FIGURE.vertex,
    fragment: `#version 300 es
      precision mediump float;
      out vec4 shown;
      void main() { shown = vec4(0.0, 0.0, 0.0, 0.16); }`,
  };
  const FLOOR = {
    vertex: `#version 300 es
      uniform mat4 clip;
      uniform float radius;
      in vec2 position;
      out vec2 spot;
      void main() {
        spot = radius * position;
        gl_Position = clip * vec4(spot, 0.0, 1.0);
      }`,
    // Lines every half metre of the world, fading out around the figure.
    fragment: `#version 300 es
      precision highp float;
      uniform vec2 phase;
      uniform float radius;
      uniform vec3 color;
      in vec2 spot;
      out vec4 shown;
      vec2 covered(vec2 cell) {
        vec2 width = fwidth(cell);
        vec2 share = 0.5 + (0.012 - abs(cell - round(cell))) / max(width, 0.001);
        return clamp(share, 0.0, 1.0) * clamp(0.024 / width, 0.0, 1.0);
      }
      void main() {
        vec2 line = covered((spot + phase) / 0.5);
        float fade = clamp(1.0 - length(spot) / radius, 0.0, 1.0);
        shown = vec4(color, fade * max(0.05, 0.5 * max(line.x, line.y)));
      }`,
  };
  // Numbers of 16 bits reach the shader as shares of the largest, in fours or twos: what every card reads as it is. Others
  // are converted first, which costs more than drawing where there is no card.
  const WHOLE = 65535;
  const NAMES = ["position", "uv", "flow", "color"];

  umg.Picture = class {
    constructor(canvas) {
      this.canvas = canvas;
      // Drawn pixels a pixel of the page, each way; less where drawing them all would take too long.
      this.fineness = 1;
      const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, stencil: true, powerPreference: "high-performance" });
      if (gl === null) throw new Error("WebGL 2 is missing");
      this.gl = gl;
      this.setUp();
    }

    // Also after the graphics driver has lost everything.
    setUp() {
      const gl = this.gl;
      this.figure = program(gl, FIGURE);
      this.shadow = program(gl, SHADOW);
      this.floor = program(gl, FLOOR);
      this.square = gl.createVertexArray();
      gl.bindVertexArray(this.square);
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, Float32Array.of(-1, -1, 1, -1, -1, 1, 1, 1), gl.STATIC_DRAW);
      const at = gl.getAttribLocation(this.floor.program, "position");
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, 2, gl.FLOAT, false, 0, 0);
      // Captured frames come and go, one a picture; a transition stays for all its steps.
      this.slots = { f: [new Slot(gl), new Slot(gl)], t: [new Slot(gl), new Slot(gl)] };
      this.turn = 0;
      this.shown = null;
    }

    // Pixels that the canvas should have.
    size() {
      const ratio = Math.min(globalThis.devicePixelRatio || 1, 2) * this.fineness;
      return [this.canvas.clientWidth, this.canvas.clientHeight].map((side) => Math.max(Math.round(side * ratio), 1));
    }

    resized() {
      const [width, height] = this.size();
      return this.canvas.width !== width || this.canvas.height !== height;
    }

    resize() {
      const [width, height] = this.size();
      if (this.resized()) Object.assign(this.canvas, { width, height });
      return width / height;
    }

    // The slot that holds a decoded file; what was not shown for longest makes room for it.
    slotOf(decoded) {
      const slots = this.slots[decoded.key[0]];
      let slot = slots.find((each) => each.decoded === decoded);
      if (slot === undefined) {
        slot = slots.reduce((a, b) => (a.turn <= b.turn ? a : b));
        slot.fill(decoded);
      }
      slot.turn = ++this.turn;
      return slot;
    }

    // Draw a decoded file (of a transition: its step 0 .. steps - 1) at a world motion. What is drawn is in `shown`.
    draw(decoded, step, world, camera, colors) {
      const gl = this.gl, slot = this.slotOf(decoded), { header } = decoded;
      const view = camera.view(this.resize());
      gl.viewport(0, 0, this.canvas.width, this.canvas.height);
      gl.clearColor(...colors.backdrop, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);

      this.drawFloor(view, camera.target, colors);
      const middle = [world.x - view.eye[0], world.y - view.eye[1], -view.eye[2]];
      const clip = umg.clipMatrix(view, world.yaw, middle);
      gl.bindVertexArray(slot.array);
      slot.useStep(step);
      // Where pictures are coarse, time is short: the shadow is the first to go.
      if (view.eye[2] > 0 && this.fineness === 1) this.drawShadow(slot, clip, header);
      const own = this.useFigure(this.figure, clip, header, false);
      const c = Math.cos(-world.yaw), s = Math.sin(-world.yaw), [x, y, z] = view.rows[2];
      gl.uniform3f(own.light, c * x - s * y, s * x + c * y, z);
      gl.uniform1f(own.share, header.steps > 1 ? (step + 1) / (header.steps + 1) : 0);
      const kind = header.flow ? 2 : decoded.bitmaps.length ? 1 : header.colors ? 3 : 0;
      gl.uniform1i(own.mode, kind);
      gl.uniform1i(own.start, 0);
      gl.uniform1i(own.end, 1);
      if (kind === 1) slot.drawMaterials(); else slot.drawWarped();
      // Of one file and put on the card together: the mesh and its texture are always of the same frame.
      this.shown = { mesh: slot.mesh, texture: slot.texture, step };
    }

    // The figure flattened onto the floor; each pixel is darkened once, however many faces cover it.
    drawShadow(slot, clip, header) {
      const gl = this.gl;
      gl.enable(gl.BLEND);
      gl.enable(gl.STENCIL_TEST);
      gl.disable(gl.DEPTH_TEST);
      gl.stencilFunc(gl.EQUAL, 0, 255);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
      this.useFigure(this.shadow, clip, header, true);
      slot.drawAll();
      gl.enable(gl.DEPTH_TEST);
      gl.disable(gl.STENCIL_TEST);
      gl.disable(gl.BLEND);
    }

    useFigure(own, clip, header, flat) {
      const gl = this.gl;
      gl.useProgram(own.program);
      gl.uniformMatrix4fv(own.clip, false, clip);
      gl.uniform3fv(own.low, header.low);
      gl.uniform1f(own.size, header.step * WHOLE);
      gl.uniform1i(own.flat_, flat);
      gl.uniform2fv(own.uvLow, header.uv ? header.uv.low : [0, 0]);
      gl.uniform1f(own.uvSize, header.uv ? header.uv.step * WHOLE : 0);
      gl.uniform2fv(own.flowLow, header.flow ? header.flow.low : [0, 0]);
      gl.uniform1f(own.flowSize, header.flow ? header.flow.step * WHOLE : 0);
      return own;
    }

    drawFloor(view, target, colors) {
      const gl = this.gl, own = this.floor;
      if (view.eye[2] <= 0) return;
      gl.useProgram(own.program);
      const from = [target[0] - view.eye[0], target[1] - view.eye[1], -view.eye[2]];
      gl.uniformMatrix4fv(own.clip, false, umg.clipMatrix(view, 0, from));
      // Far from the origin the lines' places would not fit into the shader's numbers: only what is left of a cell goes.
      gl.uniform2f(own.phase, target[0] % 0.5, target[1] % 0.5);
      gl.uniform1f(own.radius, 3);
      gl.uniform3fv(own.color, colors.floor);
      gl.enable(gl.BLEND);
      gl.depthMask(false);
      gl.bindVertexArray(this.square);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
      gl.depthMask(true);
      gl.disable(gl.BLEND);
    }
  };

  // Buffers and textures of one decoded file on the card, used again for the next one.
  class Slot {
    constructor(gl) {
      this.gl = gl;
      this.array = gl.createVertexArray();
      this.buffers = Object.fromEntries([...NAMES, "index"].map((name) => [name, gl.createBuffer()]));
      this.textures = [];
      this.decoded = null;
      this.turn = 0;
    }

    fill(decoded) {
      const gl = this.gl, { header } = decoded;
      gl.bindVertexArray(this.array);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.buffers.index);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, decoded.index, gl.DYNAMIC_DRAW);
      this.store("position", decoded.positions);
      this.attribute("uv", 1, decoded.uv, 2, gl.UNSIGNED_SHORT);
      this.attribute("flow", 2, decoded.flow, 2, gl.UNSIGNED_SHORT);
      if (header.colors) {
        const all = new Uint8Array(4 * header.corners * header.colors);
        decoded.colors.forEach((colors, step) => all.set(colors, 4 * header.corners * step));
        this.store("color", all);
      } else gl.disableVertexAttribArray(3);
      this.mesh = header.frame ?? header.transition.join(">");
      this.texture = null;
      decoded.bitmaps.forEach((bitmap, unit) => this.upload(unit, bitmap));
      if (decoded.bitmaps.length) this.texture = this.mesh;
      this.decoded = decoded;
    }

    store(name, values) {
      const gl = this.gl;
      gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    }

    attribute(name, at, values, size, type) {
      const gl = this.gl;
      if (values === null) { gl.disableVertexAttribArray(at); return; }
      this.store(name, values);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, type, true, 0, 0);
    }

    upload(unit, bitmap) {
      const gl = this.gl;
      const had = this.textures[unit];
      if (!had) this.textures[unit] = { texture: gl.createTexture(), width: 0, height: 0 };
      const own = this.textures[unit];
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, own.texture);
      if (own.width !== bitmap.width || own.height !== bitmap.height) {
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
        [own.width, own.height] = [bitmap.width, bitmap.height];
      } else gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
      for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
        gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
    }

    useStep(step) {
      const gl = this.gl, { corners, colors } = this.decoded.header;
      gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.position);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 4, gl.UNSIGNED_SHORT, true, 8, 8 * corners * step);
      if (colors) {
        gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.color);
        gl.enableVertexAttribArray(3);
        gl.vertexAttribPointer(3, 4, gl.UNSIGNED_BYTE, true, 4, 4 * corners * step);
      }
    }

    drawAll() { this.drawFaces(0, this.decoded.header.faces); }

    drawMaterials() {
      let first = 0;
      this.decoded.header.images.forEach((image, unit) => {
        this.bind(0, unit);
        this.drawFaces(first, image.faces);
        first += image.faces;
      });
    }

    drawWarped() {
      for (let unit = 0; unit < this.decoded.bitmaps.length; unit++) this.bind(unit, unit);
      this.drawAll();
    }

    bind(unit, texture) {
      this.gl.activeTexture(this.gl.TEXTURE0 + unit);
      this.gl.bindTexture(this.gl.TEXTURE_2D, this.textures[texture].texture);
    }

    drawFaces(first, count) {
      const gl = this.gl, { index } = this.decoded;
      const type = index instanceof Uint16Array ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT;
      gl.drawElements(gl.TRIANGLES, 3 * count, type, 3 * first * index.BYTES_PER_ELEMENT);
    }
  }

  function program(gl, sources) {
    const made = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, sources.vertex], [gl.FRAGMENT_SHADER, sources.fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error(`a shader does not link: ${gl.getProgramInfoLog(made)}`);
    const places = { program: made };
    for (let i = gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS) - 1; i >= 0; i--) {
      const { name } = gl.getActiveUniform(made, i);
      places[name] = gl.getUniformLocation(made, name);
    }
    return places;
  }

  // The middle of a decoded step's box in the world, and its longest side; metres.
  umg.bounds = function (decoded, step, world) {
    const { corners, low, step: size } = decoded.header, { positions } = decoded;
    const least = [65535, 65535, 65535], most = [0, 0, 0];
    for (let at = 4 * corners * step, stop = at + 4 * corners; at < stop; at += 4) {
      for (let axis = 0; axis < 3; axis++) {
        const value = positions[at + axis];
        if (value < least[axis]) least[axis] = value;
        if (value > most[axis]) most[axis] = value;
      }
    }
    const middle = low.map((value, axis) => value + (size * (least[axis] + most[axis])) / 2);
    return { centre: apply(world, middle), size: size * Math.max(...most.map((value, axis) => value - least[axis])) };
  };
})((globalThis.umg = globalThis.umg || {}));
