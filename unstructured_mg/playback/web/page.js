// The page: puts reels, player, picture and timeline together, and tells them what is asked for.
"use strict";
(function (umg) {
  const SPEEDS = [0.1, 0.25, 0.5, 1, 1.5, 2], CONTEXT = 15, SCRUBBED = 1800, MESSAGES = 6, TOLD = 0.1;
  // Seconds over which pictures are counted; how coarse they may get.
  const PACE = 1, COARSEST = 0.5;
  const MOST_SEED = 4294967295;
  const at = (id) => document.getElementById(id);

  umg.Page = class {
    constructor(site) {
      this.site = site;
      this.graph = new umg.Graph(site);
      this.fps = this.graph.fps;
      this.playedAtAll = this.graph.links.some((link) => link.played);
      this.picture = new umg.Picture(at("picture"));
      this.camera = new umg.Camera(site.facing);
      this.loader = new umg.Loader((key) => this.pathOf(key), (key, file) => this.skipped(key, file));
      this.seed = 1;
      this.selected = null;
      this.goal = null;
      this.mode = null;
      this.drawnAt = 0;
      this.pictures = 0;
      this.player = new umg.Player(new umg.CaptureReel(site.frames.length), this.fps, this.loader,
        () => performance.now() / 1000);
      at("title").textContent = document.title = site.title;
      this.timeline = new umg.Timeline(at("timeline"), site, this.graph,
        { frame: (frame) => this.goTo(frame), link: (link) => this.select(link) });
      this.connect();
      if (this.playedAtAll) this.walk();
      else {
        for (const id of ["walk", "seed", "another"]) at(id).disabled = true;
        this.say("This capture has no transitions that join up: it plays as it was captured.");
        this.capture();
      }
      this.player.play(true);
      this.watchColors();
      this.frame = () => { this.tick(); requestAnimationFrame(this.frame); };
      requestAnimationFrame(this.frame);
    }

    pathOf(key) {
      const index = Number(key.slice(1));
      return key[0] === "f" ? this.site.frames[index].file : this.graph.links[index].file;
    }

    nameOf(item) {
      const { ids, links } = this.graph;
      if (item.link === undefined) return ids[item.frame];
      const { source, target } = links[item.link];
      return `${ids[source]}>${ids[target]}:${item.step}`;
    }

    // ---- what is played ----

    walk(start = this.graph.start) {
      this.begin("walk", new umg.WalkReel(this.graph, this.seed, start), 0);
      if (at("loop").getAttribute("aria-pressed") === "true") this.loop(true);
    }

    capture(frame = 0) {
      this.begin("capture", new umg.CaptureReel(this.site.frames.length), frame);
    }

    select(link) {
      const reel = new umg.TransitionReel(this.graph, link, (frame) => this.timeline.runOf(frame), CONTEXT);
      this.begin("transition", reel, 0);
      this.selected = link;
      this.timeline.select(link);
      this.seam = null;
      const { leaves, arrives, cost } = this.graph.links[link], { ids } = this.graph;
      at("seam").hidden = false;
      at("seam-name").textContent = `Frame ${ids[leaves]} to frame ${ids[arrives]}`;
      at("seam-cost").textContent = `cost ${cost.toPrecision(2)}`;
      this.markSeam();
      this.player.play(true);
    }

    begin(mode, reel, index) {
      this.mode = mode;
      this.selected = null;
      this.timeline.select(null);
      this.setGoal(null);
      at("seam").hidden = true;
      this.player.loop = mode !== "capture" || at("loop").getAttribute("aria-pressed") === "true" || !this.playedAtAll;
      this.player.put(reel, index);
      at("walk").setAttribute("aria-pressed", mode === "walk");
      at("capture").setAttribute("aria-pressed", mode === "capture");
      this.hint();
    }

    // A frame of the timeline was chosen: in a walk, walk there; else show it.
    goTo(frame) {
      if (this.mode === "capture") { this.player.seek(frame); return; }
      if (this.mode === "transition") this.walk(this.walkable(this.last));
      const { graph, player } = this, id = graph.ids[frame];
      if (!graph.inside.has(frame)) {
        this.say(`Frame ${id} is not in the motion graph: no walk leads there. Switch to the capture to see it.`);
        return;
      }
      const index = player.reel.goTo(player.index, frame);
      if (index === null) { this.say(`Frame ${id} cannot be reached from here.`); return; }
      at("loop").setAttribute("aria-pressed", false);
      this.setGoal({ frame, index });
      player.play(true);
    }

    setGoal(goal) {
      this.goal = goal;
      this.timeline.setGoal(goal && goal.frame);
    }

    loop(on) {
      at("loop").setAttribute("aria-pressed", on);
      if (this.mode === "capture") this.player.loop = on;
      if (this.mode !== "walk") return;
      const { reel, index } = this.player;
      this.setGoal(null);
      if (!on) reel.wanderFrom(index);
      else if (!reel.loopFrom(index)) {
        at("loop").setAttribute("aria-pressed", false);
        this.say("No way leads back to this frame: it cannot be looped.");
      }
    }

    // Stand still on one side of a seam of the selected transition ("start" or "end"), or go to the other side.
    showSeam(which) {
      if (this.mode !== "transition") return;
      const [start, end] = this.player.reel.seams;
      this.seam = { which, before: true, index: which === "start" ? start : end };
      this.player.play(false);
      this.player.seek(this.seam.index);
      this.markSeam();
    }

    flip() {
      if (this.mode !== "transition") return;
      if (this.seam === null) { this.showSeam("start"); return; }
      this.seam.before = !this.seam.before;
      this.player.seek(this.seam.index + (this.seam.before ? 0 : 1));
      this.markSeam();
    }

    markSeam() {
      const seam = this.seam;
      at("seam-start").setAttribute("aria-pressed", seam?.which === "start");
      at("seam-end").setAttribute("aria-pressed", seam?.which === "end");
      at("seam-flip").disabled = seam === null;
      at("seam-flip").textContent = seam === null ? "Before / after" : seam.before ? "Before ▸ after" : "After ▸ before";
    }

    // ---- time ----

    tick() {
      const shown = this.player.tick();
      if (shown !== null && !this.isDrawn(shown)) this.draw(shown);
      else if (this.last && (this.camera.moved || this.picture.resized())) this.redraw();
      this.keepPace();
      this.tell();
    }

    isDrawn({ index, item, decoded }) {
      const { last } = this;
      return last !== undefined && last.index === index && last.decoded === decoded && last.item.step === item.step
        && last.reel === this.player.reel;
    }

    // Without a graphics card large pictures take too long: where fewer are drawn than should be, they get coarser.
    keepPace() {
      const now = this.player.clock(), { playing, speed, stalled } = this.player;
      const pace = { at: now, pictures: this.pictures, steady: playing && stalled === 0 && speed <= 1 };
      this.pace ??= pace;
      if (!pace.steady) this.pace = pace;
      const passed = now - this.pace.at;
      if (passed < PACE) return;
      const due = passed * this.fps * speed, drawn = this.pictures - this.pace.pictures;
      if (passed < 2 * PACE && drawn < 0.9 * due && this.picture.fineness > COARSEST)
        this.picture.fineness = Math.max(this.picture.fineness * 0.75, COARSEST);
      this.pace = pace;
    }

    // Show the frame at an index of the reel as soon as it is read; what was drawn, or null where it is unusable.
    async show(index) {
      const shown = await this.player.frameAt(index);
      return shown && this.draw(shown);
    }

    draw({ index, item, decoded }) {
      const now = this.player.clock(), step = item.link === undefined ? 0 : item.step + this.graph.links[item.link].k - 1;
      this.last = { index, item, decoded, step, reel: this.player.reel };
      const { centre, size } = umg.bounds(decoded, step, item.world);
      this.camera.follow(centre, size, now - this.drawnAt);
      this.drawnAt = now;
      this.pictures++;
      this.redraw();
      if (this.goal !== null && index >= this.goal.index) this.setGoal(null);
      this.drawn = { index, name: this.nameOf(item), ...this.picture.shown };
      this.timeline.show(item);
      return this.drawn;
    }

    // The camera may move while the picture stands.
    redraw() {
      const { item, decoded, step } = this.last;
      this.picture.draw(decoded, step, item.world, this.camera, this.colors);
      this.camera.moved = false;
    }

    // What is written about the picture, a few times a second: nobody reads faster.
    tell() {
      if (this.last === undefined) return;
      const { item, index } = this.last, { reel } = this.player, { ids, links } = this.graph;
      const now = this.player.clock(), { playing } = this.player;
      if (this.told && this.told.playing === playing && (this.told.last === this.last || (playing && now - this.told.at < TOLD)))
        return;
      this.told = { last: this.last, playing, at: now };
      const count = this.site.frames.length, time = clock(index / this.fps);
      const of = this.mode === "walk" ? "" : ` of ${reel.known}`;
      const what = { walk: `Walk with seed ${this.seed}`, capture: "Capture", transition: "Transition" }[this.mode];
      at("status").textContent = `${what} · frame ${index + 1}${of} · ${time}`;
      at("origin").textContent = item.link === undefined
        ? `captured frame ${ids[item.frame]} (${item.frame + 1} of ${count})`
        : `synthesized: ${ids[links[item.link].leaves]} to ${ids[links[item.link].arrives]}, step ${item.step}`;
      at("play").textContent = this.player.playing ? "❚❚" : "▶";
      const scrub = at("scrub"), furthest = Math.max(this.furthest(), index);
      scrub.min = Math.max(reel.first, furthest - SCRUBBED);
      scrub.max = furthest;
      scrub.value = index;
    }

    // Of a walk, what has been shown so far can be scrubbed; of other reels everything.
    furthest() {
      if (this.mode !== "walk") return this.player.reel.known - 1;
      if (this.seen?.reel !== this.player.reel) this.seen = { reel: this.player.reel, index: 0 };
      this.seen.index = Math.max(this.seen.index, this.last.index);
      return this.seen.index;
    }

    // The captured frame of the graph to walk from where something else was shown.
    walkable(last) {
      const frame = last && (last.item.link === undefined ? last.item.frame : this.graph.links[last.item.link].arrives);
      return this.graph.inside.has(frame) ? frame : this.graph.start;
    }

    skipped(key, file) {
      const index = Number(key.slice(1)), { ids, links } = this.graph;
      const name = key[0] === "f" ? `Frame ${ids[index]}`
        : `The transition from frame ${ids[links[index].leaves]} to ${ids[links[index].arrives]}`;
      this.say(`${name} is missing or damaged (${file}): it is skipped with its texture.`);
    }

    say(sentence) {
      const line = document.createElement("li");
      line.textContent = sentence;
      at("messages").append(line);
      while (at("messages").children.length > MESSAGES) at("messages").firstChild.remove();
      setTimeout(() => line.remove(), 15000);
    }

    hint() {
      at("hint").textContent = !this.playedAtAll ? "Click a frame to see it."
        : this.mode === "capture" ? "Click a frame to see it. Switch to Walk to go on for ever."
        : "Click a frame to walk there, or an arc to look at that transition.";
    }

    // ---- what the user does ----

    connect() {
      const { player, camera } = this;
      const on = (id, act) => at(id).addEventListener("click", act);
      const speed = at("speed");
      for (const value of SPEEDS) speed.add(new Option(`${value}×`, value, value === 1, value === 1));
      speed.addEventListener("change", () => { player.speed = Number(speed.value); });
      const faster = (by) => {
        speed.selectedIndex = Math.min(Math.max(speed.selectedIndex + by, 0), SPEEDS.length - 1);
        player.speed = Number(speed.value);
      };
      const toggle = () => {
        const stopped = player.reel.ended && !player.loop && player.index >= player.reel.known - 1;
        if (!player.playing && stopped) player.seek(player.reel.first);
        player.play(!player.playing);
      };
      const stepBy = (by) => {
        player.play(false);
        if (player.reel.frame(player.index + by) !== null) player.seek(player.index + by);
      };
      const toWalk = () => { if (this.playedAtAll && this.mode !== "walk") this.walk(this.walkable(this.last)); };
      const toCapture = () => { if (this.mode !== "capture") this.capture(this.last?.item.frame ?? 0); };
      const another = (seed) => {
        this.seed = Math.min(Math.max(Math.floor(seed) || 0, 0), MOST_SEED);
        at("seed").value = this.seed;
        this.walk();
        player.play(true);
      };
      const nextLink = () => {
        const links = [...this.timeline.arcs.keys()].sort((a, b) => a - b);
        if (links.length) this.select(links[(links.indexOf(this.selected) + 1) % links.length]);
      };
      const loop = () => this.loop(at("loop").getAttribute("aria-pressed") !== "true");
      const close = () => { if (this.mode === "transition") toWalk(); };
      on("play", toggle);
      on("back", () => stepBy(-1));
      on("on", () => stepBy(1));
      on("walk", toWalk);
      on("capture", toCapture);
      on("loop", loop);
      on("another", () => another((this.seed + 1) % (MOST_SEED + 1)));
      on("reset", () => camera.reset());
      on("help", () => at("keys").showModal());
      on("seam-play", () => { this.seam = null; this.markSeam(); player.seek(0); player.play(true); });
      on("seam-start", () => this.showSeam("start"));
      on("seam-end", () => this.showSeam("end"));
      on("seam-flip", () => this.flip());
      on("seam-close", close);
      at("seed").value = this.seed;
      at("seed").addEventListener("change", () => another(Number(at("seed").value)));
      at("scrub").addEventListener("input", () => {
        player.play(false);
        player.seek(Number(at("scrub").value));
      });
      const keys = {
        " ": toggle, ",": () => stepBy(-1), ".": () => stepBy(1), w: toWalk, c: toCapture, l: loop,
        "[": () => faster(-1), "]": () => faster(1), n: () => another((this.seed + 1) % (MOST_SEED + 1)), t: nextLink,
        b: () => this.flip(), Escape: close, r: () => camera.reset(), "?": () => at("keys").showModal(),
        ArrowLeft: () => camera.orbit(-0.1, 0), ArrowRight: () => camera.orbit(0.1, 0),
        ArrowUp: () => camera.orbit(0, 0.1), ArrowDown: () => camera.orbit(0, -0.1),
        "+": () => camera.dolly(1 / 1.15), "=": () => camera.dolly(1 / 1.15), "-": () => camera.dolly(1.15),
      };
      document.addEventListener("keydown", (event) => {
        const typing = event.target.closest("input[type=number], select, dialog[open]");
        const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
        if (typing || !act || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        act();
      });
      umg.gestures(at("picture"), camera);
      const canvas = at("picture");
      canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
      canvas.addEventListener("webglcontextrestored", () => {
        this.picture.setUp();
        this.camera.moved = true;
      });
    }

    watchColors() {
      const dark = matchMedia("(prefers-color-scheme: dark)");
      const read = () => {
        this.colors = dark.matches
          ? { backdrop: [0.10, 0.115, 0.14], floor: [0.62, 0.68, 0.78] }
          : { backdrop: [0.88, 0.89, 0.906], floor: [0.25, 0.28, 0.33] };
        this.camera.moved = true;
      };
      dark.addEventListener("change", read);
      read();
    }
  };

  function clock(seconds) {
    const whole = Math.floor(seconds);
    return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}.${Math.floor((seconds - whole) * 10)}`;
  }

  // site.js is a script like the frames' and comes last.
  const take = umg.take;
  umg.take = (name, content) => {
    if (name !== "site") { take(name, content); return; }
    try {
      umg.page = new umg.Page(content);
    } catch (error) {
      document.body.classList.add("stuck");
      at("sentence").textContent = /WebGL/.test(error.message)
        ? "This page draws with WebGL 2, which this browser does not offer: try a current Firefox, Chrome, Edge or Safari, "
          + "or switch hardware acceleration on."
        : `This page cannot be shown: ${error.message}.`;
    }
  };
})((globalThis.umg = globalThis.umg || {}));
