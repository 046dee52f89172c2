// Reads PNG files with all their bits: browsers and three.js give only 8.
import { readFileSync } from 'node:fs';
import { inflateSync } from 'node:zlib';

/** The numbers of a PNG with three channels, top row first, and the kinds of its chunks. */
export function readPng(path) {
  const bytes = readFileSync(path);
  const view = new DataView(
    bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength),
  );
  const chunks = [];
  for (let at = 8; at < view.byteLength;) {
    const size = view.getUint32(at);
    const kind = String.fromCharCode(...new Uint8Array(view.buffer, at + 4, 4));
    chunks.push({ kind, data: new Uint8Array(view.buffer, at + 8, size) });
    at += size + 12;
  }
  const header = new DataView(chunks[0].data.buffer, chunks[0].data.byteOffset);
  const [width, height, bits, colour] = [
    header.getUint32(0),
    header.getUint32(4),
    header.getUint8(8),
    header.getUint8(9),
  ];
  if (colour !== 2 || header.getUint8(12) !== 0) throw new Error(`${path} is not plain RGB`);
  const packed = Buffer.concat(
    chunks.filter((chunk) => chunk.kind === 'IDAT').map((chunk) => chunk.data),
  );
  const kinds = new Set(chunks.map((chunk) => chunk.kind));
  return {
    width,
    height,
    bits,
    kinds,
    values: unfiltered(inflateSync(packed), width, height, bits),
  };
}

/** Undoes PNG's row filters (PNG specification, section 9). */
function unfiltered(raw, width, height, bits) {
  const step = (3 * bits) / 8;
  const stride = width * step;
  const out = new Uint8Array(height * stride);
  for (let y = 0; y < height; ++y) {
    const filter = raw[y * (stride + 1)];
    for (let i = 0; i < stride; ++i) {
      const left = i >= step ? out[y * stride + i - step] : 0;
      const up = y > 0 ? out[(y - 1) * stride + i] : 0;
      const corner = i >= step && y > 0 ? out[(y - 1) * stride + i - step] : 0;
      const guess = left + up - corner;
      const [a, b, c] = [Math.abs(guess - left), Math.abs(guess - up), Math.abs(guess - corner)];
      const paeth = a <= b && a <= c ? left : b <= c ? up : corner;
      const base = [0, left, up, (left + up) >> 1, paeth][filter];
      out[y * stride + i] = raw[y * (stride + 1) + 1 + i] + base;
    }
  }
  if (bits === 8) return out;
  const view = new DataView(out.buffer);
  return Uint16Array.from({ length: out.length / 2 }, (_, i) => view.getUint16(2 * i));
}
