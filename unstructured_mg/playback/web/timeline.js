// The captured frames along a line, transitions as arcs over it coloured by cost; frames and arcs can be chosen.
"use strict";
(function (umg) {
  const WIDTH = 1000, SIDE = 14, HIGH = 84, LOW = 14;

  umg.Timeline = class {
    // `chosen.frame(index)` and `chosen.link(index)` are told what was clicked.
    constructor(host, site, graph, chosen) {
      this.host = host;
      this.graph = graph;
      this.site = site;
      this.layOut(site.frames);
      this.drawn = this.draw(chosen);
      this.head = document.createElement("div");
      this.head.className = "head";
      this.head.style.setProperty("--ground", this.ground / this.drawn.viewBox.baseVal.height);
      const frame = document.createElement("div");
      frame.className = "frame";
      frame.append(this.drawn, this.head);
      host.append(frame);
    }

    layOut(frames) {
      const count = frames.length;
      let position = -1;
      const positions = frames.map((frame, i) => {
        const last = frames[i - 1];
        const apart = last && (last.clip !== frame.clip ? Math.max(0.03 * count, 2)
          : last.number + 1 !== frame.number ? Math.max(0.006 * count, 1) : 0);
        return (position += 1 + (apart || 0));
      });
      this.pitch = (WIDTH - 2 * SIDE) / (position + 1);
      this.x = positions.map((at) => SIDE + this.pitch * (at + 0.5));
      this.runs = [];
      frames.forEach((frame, i) => {
        const last = frames[i - 1];
        if (last && last.clip === frame.clip && last.number + 1 === frame.number) this.runs[this.runs.length - 1][1] = i;
        else this.runs.push([i, i]);
      });
    }

    runOf(frame) {
      const [first, last] = this.runs.find(([from, to]) => from <= frame && frame <= to);
      return { first, last };
    }

    draw(chosen) {
      const { graph, x } = this;
      const ways = graph.links.map((link, index) => ({ link, index, from: x[link.leaves], to: x[link.arrives] }))
        .filter((way) => way.link.played);
      const longest = Math.max(1, ...ways.map((way) => Math.abs(way.to - way.from)));
      const heightOf = (way) => LOW + (HIGH - LOW) * Math.sqrt(Math.abs(way.to - way.from) / longest);
      const above = Math.max(0, ...ways.filter((way) => way.to > way.from).map(heightOf));
      const below = Math.max(0, ...ways.filter((way) => way.to <= way.from).map(heightOf));
      this.ground = above + 10;
      const height = this.ground + below + 26;
      const svg = element("svg", { viewBox: `0 0 ${WIDTH} ${height}`, role: "group",
        "aria-label": "Captured frames, and transitions between them" });
      const bar = ([a, b], kind) => svg.append(element("rect", { class: kind, y: this.ground - 4, height: 8, rx: 2,
        x: x[a] - this.pitch / 2, width: Math.max(x[b] - x[a] + this.pitch, 1.5) }));
      this.runs.forEach((run) => bar(run, "run"));
      this.runs.forEach(([a, b]) => {
        for (let i = a, from = null; i <= b + 1; i++) {
          const inside = i <= b && graph.inside.has(i);
          if (inside && from === null) from = i;
          if (!inside && from !== null) { bar([from, i - 1], "run inside"); from = null; }
        }
      });
      this.drawTicks(svg, height);
      const cover = element("rect", { class: "cover", x: 0, width: WIDTH, y: this.ground - 12, height: 24 });
      cover.addEventListener("click", (event) => chosen.frame(this.frameAt(event)));
      cover.addEventListener("pointermove", (event) => this.point(this.frameAt(event)));
      cover.addEventListener("pointerleave", () => this.point(null));
      svg.append(cover);
      this.arcs = new Map();
      ways.sort((a, b) => Math.abs(b.to - b.from) - Math.abs(a.to - a.from)).forEach((way) => {
        const top = this.ground + ((way.to > way.from ? -4 : 4) / 3) * heightOf(way);
        const start = this.ground + (way.to > way.from ? -6 : 6);
        const d = `M${way.from} ${start}C${way.from} ${top} ${way.to} ${top} ${way.to} ${start}`;
        const ids = graph.ids, { link } = way;
        const group = element("g", { class: "arc", tabindex: 0, role: "button", style: `--cost:${this.site.colors[way.index]}`,
          "aria-label": `Transition from frame ${ids[link.leaves]} to frame ${ids[link.arrives]}` });
        const title = element("title", {});
        title.textContent = `frame ${ids[link.leaves]} to frame ${ids[link.arrives]}, cost ${link.cost.toPrecision(2)}`;
        group.append(title, element("path", { class: "reach", d }), element("path", { class: "line", d }));
        group.addEventListener("click", () => chosen.link(way.index));
        group.addEventListener("keydown", (event) => {
          if (event.key === "Enter") { event.stopPropagation(); chosen.link(way.index); }
        });
        svg.append(group);
        this.arcs.set(way.index, group);
      });
      this.pointer = element("line", { class: "pointer", y1: this.ground - 11, y2: this.ground + 11, visibility: "hidden" });
      this.goal = element("path", { class: "goal", visibility: "hidden" });
      svg.append(this.pointer, this.goal);
      return svg;
    }

    drawTicks(svg, height) {
      const { frames } = this.site, least = frames.length / 12;
      let step = 1;
      for (let size = 1; step < least; size *= 10) step = [1, 2, 5].map((m) => m * size).find((s) => s >= least) || step;
      let free = -Infinity;
      frames.forEach((frame, i) => {
        if (frame.number % step || this.x[i] < free) return;
        free = this.x[i] + 24;
        const text = element("text", { x: this.x[i], y: height - 6 });
        text.textContent = frame.number;
        svg.append(element("line", { class: "tick", x1: this.x[i], x2: this.x[i], y1: this.ground + 5, y2: this.ground + 9 }));
        svg.append(text);
      });
    }

    // The captured frame nearest to a click.
    frameAt(event) {
      const box = this.drawn.getBoundingClientRect();
      const at = ((event.clientX - box.left) / box.width) * WIDTH;
      return this.x.reduce((best, x, i) => (Math.abs(x - at) < Math.abs(this.x[best] - at) ? i : best), 0);
    }

    // Where a captured frame lies on the screen.
    screenX(frame) {
      const box = this.drawn.getBoundingClientRect();
      return { x: box.left + (this.x[frame] / WIDTH) * box.width,
        y: box.top + (this.ground / this.drawn.viewBox.baseVal.height) * box.height };
    }

    point(frame) { place(this.pointer, frame === null ? null : this.x[frame]); }

    setGoal(frame) {
      if (frame === null) { this.goal.setAttribute("visibility", "hidden"); return; }
      const x = this.x[frame], y = this.ground - 6;
      this.goal.setAttribute("d", `M${x} ${y}l-6 -10h12z`);
      this.goal.setAttribute("visibility", "visible");
    }

    // Mark what is shown: a captured frame, or a step of a transition. The mark is moved by the compositor, so that the
    // timeline is not drawn again with every frame.
    show(item) {
      const link = item.link === undefined ? null : this.graph.links[item.link];
      const share = link && (item.step + link.k) / (2 * link.k);
      const x = link ? this.x[link.leaves] + share * (this.x[link.arrives] - this.x[link.leaves]) : this.x[item.frame];
      this.head.style.transform = `translateX(${(100 * x) / WIDTH}%)`;
      this.mark("now", item.link);
      this.head.classList.toggle("between", link !== null);
    }

    select(link) { this.mark("selected", link ?? undefined); }

    mark(kind, link) {
      if (this[kind] === link) return;
      this.arcs.get(this[kind])?.classList.remove(kind);
      this.arcs.get(link)?.classList.add(kind);
      this[kind] = link;
    }
  };

  function place(line, x) {
    line.setAttribute("visibility", x === null ? "hidden" : "visible");
    if (x !== null) { line.setAttribute("x1", x); line.setAttribute("x2", x); }
  }

  function element(name, attributes) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return made;
  }
})((globalThis.umg = globalThis.umg || {}));
