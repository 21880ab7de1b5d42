// The motion graph of site.js, frames by index in place of ids; shortest ways as `umg path` finds them.
"use strict";
(function (umg) {
  umg.Graph = class {
    constructor(site) {
      const graph = site.graph;
      this.index = new Map(site.frames.map((frame, index) => [frame.id, index]));
      const at = (id) => this.index.get(id);
      this.ids = site.frames.map((frame) => frame.id);
      this.fps = graph.fps;
      this.cyclic = graph.cyclic;
      this.start = at(site.start);
      this.inside = new Set(graph.frames.map(at));
      this.links = graph.transitions.map((t, link) => ({
        source: at(t.source), target: at(t.target), k: t.k, leaves: at(t.leaves), arrives: at(t.arrives),
        alignment: t.alignment, cost: t.cost, played: t.in_graph, file: site.files[link],
      }));
      const segment = (play) => "transition" in play
        ? { link: play.transition, first: 1 - this.links[play.transition].k, last: this.links[play.transition].k - 1 }
        : { link: null, first: at(play.first), last: at(play.last) };
      this.nodes = graph.nodes.map(at);
      this.edges = graph.edges.map((edge) => ({
        source: edge.source, target: edge.target, length: edge.length, threshold: edge.threshold,
        segments: edge.plays.map(segment),
      }));
      this.ways = this.nodes.map(() => []);
      this.edges.forEach((edge, index) => this.ways[edge.source].push(index));
    }

    // {node} of a node's frame, or {edge, place}: after which of the edge's frames it comes.
    locate(frame) {
      const node = this.nodes.indexOf(frame);
      if (node >= 0) return { node, edge: null, place: 0 };
      for (let edge = 0; edge < this.edges.length; edge++) {
        let place = 0;
        for (const part of this.edges[edge].segments) {
          if (part.link === null && part.first <= frame && frame <= part.last)
            return { node: null, edge, place: place + frame - part.first };
          place += part.last - part.first + 1;
        }
      }
      return null;
    }

    // The segments from `start` (not played) to `goal`, fewest frames first, then fewest transitions; null without a way.
    shortest(start, goal) {
      const from = this.locate(start), to = this.locate(goal);
      if (from === null || to === null) return null;
      if (start === goal) return [];
      if (from.edge !== null && from.edge === to.edge && from.place < to.place)
        return cut(this.edges[from.edge].segments, from.place + 1, to.place + 1);
      return this.between(from, to);
    }

    // The segments of the shortest way from `frame` back to it, at least one frame long; null where there is none.
    shortestLoop(frame) {
      const at = this.locate(frame);
      if (at === null) return null;
      if (at.edge !== null) return this.between(at, at);
      let best = null;
      for (const edge of this.ways[at.node]) {
        const back = this.dijkstra(this.edges[edge].target, at.node);
        if (back === null) continue;
        const whole = [edge, ...back];
        const length = whole.reduce((sum, index) => sum + this.edges[index].length, 0);
        if (best === null || length < best.length) best = { length, whole };
      }
      return best && merged(best.whole.flatMap((edge) => this.edges[edge].segments));
    }

    between(from, to) {
      let lead = [], out = [], first = from.node, last = to.node;
      if (from.edge !== null) {
        const edge = this.edges[from.edge];
        lead = cut(edge.segments, from.place + 1, edge.length);
        first = edge.target;
      }
      if (to.edge !== null) {
        const edge = this.edges[to.edge];
        out = cut(edge.segments, 0, to.place + 1);
        last = edge.source;
      }
      const middle = this.dijkstra(first, last);
      return middle && merged([...lead, ...middle.flatMap((edge) => this.edges[edge].segments), ...out]);
    }

    // Edges from node to node, or null; ties go to fewer transitions, then to lower nodes and edges.
    dijkstra(start, goal) {
      const best = new Map([[start, [0, 0]]]), cameBy = new Map(), open = new Set([start]);
      while (open.size) {
        const node = [...open].reduce((a, b) => (before([...best.get(a), a], [...best.get(b), b]) ? a : b));
        open.delete(node);
        if (node === goal) break;
        const [length, transitions] = best.get(node);
        for (const index of this.ways[node]) {
          const edge = this.edges[index];
          const used = edge.segments.filter((part) => part.link !== null).length;
          const reached = [length + edge.length, transitions + used];
          if (!best.has(edge.target) || before(reached, best.get(edge.target))) {
            best.set(edge.target, reached);
            cameBy.set(edge.target, index);
            open.add(edge.target);
          }
        }
      }
      if (!best.has(goal)) return null;
      const path = [];
      for (let node = goal; node !== start; node = this.edges[path[path.length - 1]].source) path.push(cameBy.get(node));
      return path.reverse();
    }

    // The segments of a random walk after captured frame `start`, for as long as there is a way on.
    *wander(seed, start) {
      const generator = new umg.RandomGenerator(seed), at = this.locate(start);
      let node = at.node;
      if (at.edge !== null) {
        const edge = this.edges[at.edge];
        yield* cut(edge.segments, at.place + 1, edge.length);
        node = edge.target;
      }
      while (this.ways[node].length) {
        let edge = this.edges[this.ways[node][0]];
        if (this.ways[node].length > 1) {
          const drawn = generator.draw();
          edge = this.edges[this.ways[node].find((way) => drawn <= this.edges[way].threshold)];
        }
        yield* edge.segments;
        node = edge.target;
      }
    }
  };

  function before(a, b) {
    const at = a.findIndex((value, i) => value !== b[i]);
    return at >= 0 && a[at] < b[at];
  }

  // Frames start .. stop - 1 of what the segments play.
  function cut(segments, start, stop) {
    const part = [];
    let place = 0;
    for (const segment of segments) {
      const length = segment.last - segment.first + 1;
      const first = Math.max(start - place, 0), last = Math.min(stop - place, length) - 1;
      if (first <= last) part.push({ link: segment.link, first: segment.first + first, last: segment.first + last });
      place += length;
    }
    return part;
  }

  // Captured segments that follow each other without a break as one.
  function merged(segments) {
    const whole = [];
    for (const segment of segments) {
      const last = whole[whole.length - 1];
      if (last && last.link === null && segment.link === null && last.last + 1 === segment.first)
        whole[whole.length - 1] = { link: null, first: last.first, last: segment.last };
      else whole.push(segment);
    }
    return whole;
  }
})((globalThis.umg = globalThis.umg || {}));
