// Time to frames: what of a reel is shown now, and what has to be read for it.
"use strict";
(function (umg) {
  // Frames that are read ahead, frames that are shown late rather than never; seconds of a stalled page (hidden, asleep)
  // that count at most, and seconds after which time waits for what is on its way.
  const AHEAD = 120, LATE = 8, STALL = 0.25, PATIENCE = 0.3;

  const keyOf = (shown) => (shown.link === undefined ? `f${shown.frame}` : `t${shown.link}`);

  umg.Player = class {
    // `clock` gives seconds; `loader` the decoded files by key.
    constructor(reel, fps, loader, clock) {
      this.fps = fps;
      this.loader = loader;
      this.clock = clock;
      this.speed = 1;
      this.loop = true;
      this.playing = false;
      this.put(reel, 0);
    }

    put(reel, index) {
      this.reel = reel;
      this.seek(index);
    }

    // Show what is at `index`, now or as soon as it is there.
    seek(index) {
      this.position = Math.max(index, this.reel.first);
      this.time = this.clock();
      this.last = this.index - 1;
      this.stalled = 0;
    }

    play(on) {
      this.playing = on;
      this.time = this.clock();
    }

    get index() { return Math.floor(this.position); }

    // Move on by the time that has passed. Returns {index, item, decoded} to be shown, or null where nothing new is there.
    tick() {
      const now = this.clock(), passed = Math.min(Math.max(now - this.time, 0), STALL);
      this.time = now;
      if (this.playing && this.stalled < PATIENCE) this.position += passed * this.fps * this.speed;
      this.stayInside();
      this.skipUnusable();
      this.readAhead();
      const earliest = this.playing ? Math.max(Math.min(this.last + 1, this.index), this.index - LATE, this.reel.first) : this.index;
      for (let index = this.index; index >= earliest; index--) {
        const item = this.reel.frame(index), decoded = item && this.loader.get(keyOf(item));
        if (decoded) {
          this.last = this.index;
          this.stalled = 0;
          return { index, item, decoded };
        }
      }
      if (this.last !== this.index) this.stalled += passed;
      return null;
    }

    // The end of a reel: from the beginning again, or stop there.
    stayInside() {
      if (this.reel.frame(this.index) !== null) return;
      const stop = this.reel.known;
      if (this.loop) this.position = this.reel.first + ((this.position - this.reel.first) % (stop - this.reel.first));
      else {
        this.position = stop - 1;
        this.playing = false;
      }
    }

    // Go past what is known to be unusable, mesh and texture together.
    skipUnusable() {
      for (let tried = 0; tried < this.reel.known - this.reel.first; tried++) {
        const item = this.reel.frame(this.index);
        if (item === null || !this.loader.failed.has(keyOf(item))) return;
        this.position = this.index + 1;
        this.stayInside();
      }
    }

    // What comes next, each file once; a reel that starts again is read ahead over its end.
    readAhead() {
      const keys = new Set(), { reel } = this;
      for (let index = this.index, left = AHEAD; left > 0; index++, left--) {
        let item = reel.frame(index);
        if (item === null) {
          if (!reel.ended || !this.loop) break;
          item = reel.frame((index = reel.first));
        }
        keys.add(keyOf(item));
      }
      this.loader.want([...keys]);
    }

    // The frame at `index` of the reel once it has been read; {item, decoded}, or null where its file is unusable.
    async frameAt(index) {
      this.seek(index);
      this.readAhead();
      const item = this.reel.frame(index);
      if (item === null || !(await this.loader.until(keyOf(item)))) return null;
      return { index, item, decoded: this.loader.get(keyOf(item)) };
    }
  };
})((globalThis.umg = globalThis.umg || {}));
