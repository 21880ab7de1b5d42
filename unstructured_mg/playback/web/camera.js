// The camera: turns around a figure that it follows over the floor. Metres, z up, angles in radians.
"use strict";
(function (umg) {
  const FIELD = 0.5, LOWEST = -0.2, HIGHEST = 1.5, NEAREST = 0.3, FARTHEST = 30;
  // Seconds in which the camera makes up for two thirds of the figure's lead; metres at which it jumps after it.
  const LAG = 0.35, JUMP = 1.5;

  umg.Camera = class {
    constructor(azimuth) {
      this.home = azimuth;
      this.target = null;
      this.reset();
    }

    reset() {
      this.azimuth = this.home;
      this.elevation = 0.18;
      this.zoom = 1;
      this.shift = [0, 0];
      this.moved = true;
    }

    // Follow a figure of so many metres whose middle is at `centre`; `seconds` since the last call.
    follow(centre, size, seconds) {
      const far = this.target === null || Math.hypot(centre[0] - this.target[0], centre[1] - this.target[1]) > JUMP;
      const share = far ? 1 : 1 - Math.exp(-seconds / LAG);
      const from = far ? centre : this.target;
      this.target = from.map((value, axis) => value + share * (centre[axis] - value));
      if (far) this.size = size;
      else this.size += share * (size - this.size);
    }

    orbit(right, up) {
      this.azimuth -= right;
      this.elevation = Math.min(Math.max(this.elevation + up, LOWEST), HIGHEST);
      this.moved = true;
    }

    dolly(factor) {
      this.zoom = Math.min(Math.max(this.zoom * factor, 0.15), 8);
      this.moved = true;
    }

    // Move the picture by shares of its height.
    pan(right, up) {
      this.shift[0] += right;
      this.shift[1] += up;
      this.moved = true;
    }

    // {eye, rows: right, up, back, focal: pixels of height 2 at depth 1} for a picture of this shape.
    view(aspect) {
      const { azimuth, elevation } = this;
      const back = [Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation)];
      const right = [-Math.sin(azimuth), Math.cos(azimuth), 0];
      const up = [
        back[1] * right[2] - back[2] * right[1],
        back[2] * right[0] - back[0] * right[2],
        back[0] * right[1] - back[1] * right[0],
      ];
      const focal = 1 / Math.tan(FIELD / 2);
      // The figure fills four fifths of the picture's height, or of its width where that is less.
      const fit = (0.6 * this.size * focal) / Math.min(1, 1.6 * aspect);
      const distance = Math.min(Math.max(fit * this.zoom, NEAREST), FARTHEST + this.size);
      const scale = (2 * distance) / focal;
      const eye = this.target.map((value, axis) =>
        value + distance * back[axis] - scale * (this.shift[0] * right[axis] + this.shift[1] * up[axis]));
      return { eye, rows: [right, up, back], focal, aspect, distance };
    }
  };

  // Column-major clip matrix of points that are turned by `yaw` and stand at `from` (metres beside the eye).
  umg.clipMatrix = function ({ rows, focal, aspect, distance }, yaw, from) {
    const near = distance / 50, far = distance * 40;
    const c = Math.cos(yaw), s = Math.sin(yaw);
    const turned = rows.map(([x, y, z]) => [c * x + s * y, -s * x + c * y, z]);
    const moved = rows.map((row) => row[0] * from[0] + row[1] * from[1] + row[2] * from[2]);
    const depth = [-(far + near) / (far - near), (-2 * far * near) / (far - near)];
    const matrix = new Float32Array(16);
    for (let column = 0; column < 4; column++) {
      const [right, up, back] = column < 3 ? turned.map((row) => row[column]) : moved;
      matrix[4 * column] = (focal / aspect) * right;
      matrix[4 * column + 1] = focal * up;
      matrix[4 * column + 2] = depth[0] * back + (column === 3 ? depth[1] : 0);
      matrix[4 * column + 3] = -back;
    }
    return matrix;
  };
})((globalThis.umg = globalThis.umg || {}));
