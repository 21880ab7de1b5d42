// What can be played: a walk, the capture as it is, or one transition with the frames around it. All of them give
// frame(index): {frame} or {link, step}, and the world motion that it is shown at.
"use strict";
(function (umg) {
  const { STILL, after } = umg.motion;
  // Blocks of a walk that are kept to scrub back through; a block is a run of captured frames or a transition.
  const KEPT = 4096;

  // A walk from a captured frame, continued as it is asked for: at random, to a goal, or round and round.
  umg.WalkReel = class {
    constructor(graph, seed, start) {
      this.graph = graph;
      this.seed = seed;
      this.blocks = [{ at: 0, link: null, first: start, last: start, world: STILL }];
      this.ahead = graph.wander(seed, start);
      this.ended = false;
    }

    get first() { return this.blocks[0].at; }
    // Frames known so far; grows as frames are asked for.
    get known() { return stop(this.blocks[this.blocks.length - 1]); }

    frame(index) {
      while (index >= this.known && !this.ended) this.extend();
      const block = this.blocks[this.blockOf(index)];
      if (index < this.first || index >= stop(block)) return null;
      const offset = block.first + index - block.at;
      return block.link === null
        ? { frame: offset, world: block.world }
        : { link: block.link, step: offset, world: block.world };
    }

    // Go to captured frame `goal` the shortest way from what is shown at `index`, and on from there at random: as
    // `umg walk --start GOAL` with the same seed. Returns the index at which the goal is shown, or null without a way.
    goTo(index, goal) {
      const [turn, from] = this.turningPoint(index);
      const path = this.graph.shortest(from, goal);
      if (path === null) return null;
      const length = path.reduce((sum, part) => sum + part.last - part.first + 1, 0);
      this.continueAfter(turn, chain(path, this.graph, this.seed, goal));
      return turn + length;
    }

    // Repeat the shortest loop through what is shown at `index` for ever; false where no way leads back.
    loopFrom(index) {
      const [turn, from] = this.turningPoint(index);
      const loop = this.graph.shortestLoop(from);
      if (loop === null) return false;
      this.continueAfter(turn, forever(loop));
      return true;
    }

    // Walk on at random from what is shown at `index`.
    wanderFrom(index) {
      const [turn, from] = this.turningPoint(index);
      this.continueAfter(turn, this.graph.wander(this.seed, from));
    }

    // The first index, from `index` on, that shows a captured frame, and that frame: transitions are played to their end.
    turningPoint(index) {
      let shown = this.frame(index);
      while (shown.frame === undefined) shown = this.frame(++index);
      return [index, shown.frame];
    }

    continueAfter(index, segments) {
      const at = this.blockOf(index), block = this.blocks[at];
      this.blocks.length = at + 1;
      this.blocks[at] = { ...block, last: block.first + index - block.at };
      this.ahead = segments;
      this.ended = false;
    }

    extend() {
      const { done, value } = this.ahead.next();
      if (done) { this.ended = true; return; }
      const last = this.blocks[this.blocks.length - 1];
      // Steps lie in the source's place, the frames that follow in the target's.
      const world = last.link === null ? last.world : after(last.world, this.graph.links[last.link].alignment);
      this.blocks.push({ at: stop(last), link: value.link, first: value.first, last: value.last, world });
      if (this.blocks.length > KEPT) this.blocks.splice(0, this.blocks.length - KEPT);
    }

    blockOf(index) {
      let low = 0, high = this.blocks.length - 1;
      while (low < high) {
        const middle = (low + high + 1) >> 1;
        if (this.blocks[middle].at <= index) low = middle; else high = middle - 1;
      }
      return low;
    }
  };

  // The captured frames in order.
  umg.CaptureReel = class {
    constructor(count) { this.known = count; }
    get first() { return 0; }
    get ended() { return true; }
    frame(index) { return index >= 0 && index < this.known ? { frame: index, world: STILL } : null; }
  };

  // A transition between up to `context` captured frames before and after it.
  umg.TransitionReel = class {
    constructor(graph, link, runOf, context) {
      const { leaves, arrives, k, alignment } = graph.links[link];
      this.shown = [];
      for (let frame = Math.max(leaves - context + 1, runOf(leaves).first); frame <= leaves; frame++)
        this.shown.push({ frame, world: STILL });
      this.seams = [this.shown.length - 1, this.shown.length + 2 * k - 2];
      for (let step = 1 - k; step < k; step++) this.shown.push({ link, step, world: STILL });
      for (let frame = arrives; frame <= Math.min(arrives + context - 1, runOf(arrives).last); frame++)
        this.shown.push({ frame, world: alignment });
    }
    get first() { return 0; }
    get known() { return this.shown.length; }
    get ended() { return true; }
    frame(index) { return this.shown[index] || null; }
  };

  function stop(block) { return block.at + block.last - block.first + 1; }

  function* chain(segments, graph, seed, goal) {
    yield* segments;
    yield* graph.wander(seed, goal);
  }

  function* forever(segments) {
    for (;;) yield* segments;
  }
})((globalThis.umg = globalThis.umg || {}));
