// The random numbers of walks, as docs/files.md describes them ("The random generator").
"use strict";
(function (umg) {
  umg.RandomGenerator = class {
    constructor(seed) {
      const filled = [];
      for (let word = 0, state = seed >>> 0; word < 3; word++) {
        state = (state + 0x9e3779b9) >>> 0;
        let mixed = Math.imul(state ^ (state >>> 16), 0x21f0aaad);
        mixed = Math.imul(mixed ^ (mixed >>> 15), 0x735a2d97);
        filled.push((mixed ^ (mixed >>> 15)) >>> 0);
      }
      [this.a, this.b, this.c] = filled;
      this.counter = 1;
      for (let i = 0; i < 12; i++) this.draw();
    }

    draw() {
      const drawn = (this.a + this.b + this.counter) >>> 0;
      this.counter = (this.counter + 1) >>> 0;
      this.a = (this.b ^ (this.b >>> 9)) >>> 0;
      this.b = (this.c + (this.c << 3)) >>> 0;
      this.c = (((this.c << 21) | (this.c >>> 11)) + drawn) >>> 0;
      return drawn;
    }
  };
})((globalThis.umg = globalThis.umg || {}));
