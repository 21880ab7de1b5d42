// Frames on their way: read ahead of what is played, decoded into a ring of a fixed size, forgotten behind it.
"use strict";
(function (umg) {
  // Decoded captured frames and transitions: read ahead, and kept in all. Bytes of files that are kept, files read at a
  // time.
  const AHEAD = { f: 16, t: 2 }, KEPT = { f: 24, t: 4 }, BYTES = 48 << 20, AT_A_TIME = 4;

  const handed = new Map();
  // What every data file calls.
  umg.take = (name, content) => handed.set(name, content);

  async function fetched(name) {
    const answer = await fetch(`${name}.js`);
    if (!answer.ok) throw new Error(`${answer.status} ${answer.statusText}`);
    return umg.stringBytes(new Uint8Array(await answer.arrayBuffer()));
  }

  // A page that was opened from a disk may not fetch, but it may run scripts.
  function run(name) {
    return new Promise((resolve, reject) => {
      const script = document.createElement("script");
      script.charset = "windows-1252";
      script.src = `${name}.js`;
      script.onload = () => {
        const text = handed.get(name);
        handed.delete(name);
        script.remove();
        if (text === undefined) reject(new Error("damaged")); else resolve(umg.characterBytes(text));
      };
      script.onerror = () => { script.remove(); reject(new Error("missing")); };
      document.head.append(script);
    });
  }

  umg.Loader = class {
    // `pathOf` gives the file of a key ("f12", "t3"); `report` is told of each file that cannot be used.
    constructor(pathOf, report) {
      this.pathOf = pathOf;
      this.report = report;
      this.read = location.protocol === "file:" ? run : fetched;
      this.files = new Map();
      this.bytes = 0;
      this.ready = new Map();
      this.failed = new Map();
      this.loading = new Map();
      this.wanted = [];
      this.later = [];
    }

    get(key) { return this.ready.get(key); }

    // Which keys are needed next, the first first: the first ones are decoded, of the others the bytes are read.
    want(keys) {
      const room = { ...AHEAD };
      this.wanted = keys.filter((key) => room[key[0]]-- > 0);
      this.later = keys.filter((key) => !this.wanted.includes(key));
      this.evict(new Set(this.wanted));
      this.pump();
    }

    // Resolves when `key` is ready (true) or known to be unusable (false).
    async until(key) {
      while (!this.ready.has(key) && !this.failed.has(key)) {
        if (!this.loading.has(key)) this.start(key);
        await this.loading.get(key);
      }
      return this.ready.has(key);
    }

    pump() {
      const idle = (key) => !this.failed.has(key) && !this.loading.has(key);
      for (const key of this.wanted) {
        if (this.loading.size >= AT_A_TIME) return;
        if (idle(key) && !this.ready.has(key)) this.start(key);
      }
      for (const key of this.later) {
        if (this.loading.size >= AT_A_TIME) return;
        if (idle(key) && !this.ready.has(key) && !this.files.has(key)) this.run(key, this.data(key));
      }
    }

    start(key) {
      this.run(key, this.load(key).then((decoded) => this.ready.set(key, decoded)));
    }

    run(key, work) {
      const done = work
        .catch((error) => {
          this.failed.set(key, error);
          this.report(key, `${this.pathOf(key)}.js`, error);
        })
        .finally(() => { this.loading.delete(key); this.pump(); });
      this.loading.set(key, done);
    }

    async load(key) {
      const decoded = await umg.decodeArrays(await this.data(key));
      decoded.key = key;
      decoded.bitmaps = await Promise.all(decoded.images.map((blob) =>
        createImageBitmap(blob, { premultiplyAlpha: "none", colorSpaceConversion: "none" })));
      decoded.images = null;
      return decoded;
    }

    // The file's bytes, out of memory where they were needed not long ago.
    async data(key) {
      let data = this.files.get(key);
      if (data === undefined) {
        data = await this.read(this.pathOf(key));
        this.bytes += data.length;
      }
      this.files.delete(key);
      this.files.set(key, data);
      for (const [oldest, bytes] of this.files) {
        if (this.bytes <= BYTES) break;
        this.files.delete(oldest);
        this.bytes -= bytes.length;
      }
      return data;
    }

    // Forget the longest ready of what is not wanted, where more is ready than is kept.
    evict(wanted) {
      for (const kind of ["f", "t"]) {
        const mine = [...this.ready.keys()].filter((key) => key[0] === kind);
        const others = mine.filter((key) => !wanted.has(key));
        for (const key of others.slice(0, Math.max(mine.length - KEPT[kind], 0))) {
          this.ready.get(key).bitmaps.forEach((bitmap) => bitmap.close());
          this.ready.delete(key);
        }
      }
    }
  };
})((globalThis.umg = globalThis.umg || {}));
