// A frame's file to arrays and images (docs/files.md, "A web page").
"use strict";
(function (umg) {
  // Where the data is: a script's only string, in windows-1252, as bytes.
  const characters = new TextDecoder("windows-1252").decode(Uint8Array.from({ length: 256 }, (_, byte) => byte));
  const byteOf = new Map([...characters].map((character, byte) => [character.charCodeAt(0), byte]));

  // The deflated bytes out of a file that was fetched: what the script's string would have been.
  umg.stringBytes = function (file) {
    const COMMA = 0x2c, QUOTE = 0x22, BACKSLASH = 0x5c;
    let at = file.indexOf(COMMA) + 2, length = 0;
    const data = new Uint8Array(file.length);
    for (; at < file.length && file[at] !== QUOTE; at++) {
      let byte = file[at];
      if (byte === BACKSLASH) {
        byte = file[++at];
        if (byte === 0x6e) byte = 10;
        else if (byte === 0x72) byte = 13;
        else if (byte === 0x78) { byte = parseInt(String.fromCharCode(file[at + 1], file[at + 2]), 16); at += 2; }
      }
      data[length++] = byte;
    }
    return data.subarray(0, length);
  };

  // The same out of the string that a script handed over.
  umg.characterBytes = function (text) {
    const data = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) data[i] = byteOf.get(text.charCodeAt(i));
    return data;
  };

  async function inflated(data) {
    const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  // Reads columns of differences one after the other.
  class Sections {
    constructor(bytes, at) { this.bytes = bytes; this.at = at; }

    column(count, Type) {
      const values = new Type(count), size = Type.BYTES_PER_ELEMENT, { bytes, at } = this;
      let value = 0;
      for (let i = 0; i < count; i++) {
        let folded = bytes[at + i];
        for (let plane = 1; plane < size; plane++) folded |= bytes[at + plane * count + i] << (8 * plane);
        value += (folded >>> 1) ^ -(folded & 1);
        values[i] = value;
      }
      this.at += count * size;
      return values;
    }

    columns(count, number, Type) {
      return Array.from({ length: number }, () => this.column(count, Type));
    }

    take(length) { return this.bytes.subarray(this.at, (this.at += length)); }
  }

  // Everything in a file but its images' pixels: positions (steps x corners x 4 uint16, the last unused), faces, uv,
  // flow, colors, and the images as they are stored.
  umg.decodeArrays = async function (data) {
    const bytes = await inflated(data);
    const length = new DataView(bytes.buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
    const sections = new Sections(bytes, 4 + length), { corners, faces, steps } = header;
    const positions = new Uint16Array(4 * corners * steps), stride = 4 * corners;
    for (let step = 0, at = 0; step < steps; step++, at += stride) {
      const parts = sections.columns(corners, 3, Uint16Array);
      for (let axis = 0; axis < 3; axis++) {
        for (let i = 0, to = at + axis; i < corners; i++, to += 4) {
          let value = parts[axis][i];
          if (step > 1) value += 2 * positions[to - stride] - positions[to - 2 * stride];
          else if (step > 0) value += positions[to - stride];
          positions[to] = value;
        }
      }
    }
    const Index = corners <= 65535 ? Uint16Array : Uint32Array;
    const [first, second, third] = sections.columns(faces, 3, Index);
    const index = new Index(3 * faces);
    for (let i = 0; i < faces; i++) {
      index[3 * i] = first[i];
      index[3 * i + 1] = index[3 * i] + second[i];
      index[3 * i + 2] = index[3 * i + 1] + third[i];
    }
    const pairs = (present) => present ? interleaved(sections.columns(corners, 2, Uint16Array)) : null;
    const uv = pairs(header.uv), flow = pairs(header.flow);
    const colors = Array.from({ length: header.colors }, () =>
      interleaved([...sections.columns(corners, 3, Uint8Array), new Uint8Array(corners)]));
    const images = header.images.map((image) => new Blob([sections.take(image.bytes)], { type: image.type }));
    return { header, positions, index, uv, flow, colors, images };
  };

  function interleaved(columns) {
    const count = columns[0].length, width = columns.length, values = new columns[0].constructor(count * width);
    columns.forEach((column, at) => { for (let i = 0; i < count; i++) values[i * width + at] = column[i]; });
    return values;
  }
})((globalThis.umg = globalThis.umg || {}));
