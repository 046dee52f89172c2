// PNG files for the tests of the page: plain ones are written, those of the browser are read.
import { crc32, deflateSync, inflateSync } from 'node:zlib';

const kMark = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
const kChannels = { 0: 1, 2: 3, 6: 4 };

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type), data]);
  const ends = [Buffer.alloc(4), Buffer.alloc(4)];
  ends[0].writeUInt32BE(data.length);
  ends[1].writeUInt32BE(crc32(body));
  return Buffer.concat([ends[0], body, ends[1]]);
}

/** A picture whose rows have a colour each, [red, green, blue]. @param colourOf  of a row */
export function rowsPng(width, height, colourOf) {
  const row = (colour) =>
    Buffer.concat([Buffer.from([0]), Buffer.from(Array(width).fill(colour).flat())]);
  const head = Buffer.from([0, 0, 0, 0, 0, 0, 0, 0, 8, 2, 0, 0, 0]);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  const rows = Array.from({ length: height }, (_, y) => row(colourOf(y)));
  const data = deflateSync(Buffer.concat(rows));
  return Buffer.concat([
    kMark,
    chunk('IHDR', head),
    chunk('IDAT', data),
    chunk('IEND', Buffer.alloc(0)),
  ]);
}

/** A picture of one colour. */
export const plainPng = (size, colour) => rowsPng(size, size, () => colour);

/** What a PNG's filter of a row adds: of the values left, above, and above left. */
const kFilters = [
  () => 0,
  (left) => left,
  (_, above) => above,
  (left, above) => (left + above) >> 1,
  (left, above, corner) => {
    const far = [above - corner, left - corner, left + above - 2 * corner].map(Math.abs);
    if (far[0] <= far[1] && far[0] <= far[2]) return left;
    return far[1] <= far[2] ? above : corner;
  },
];

/** 8 bits a channel, not interlaced, as browsers write them: {width, height, rgb}. */
export function readPng(bytes) {
  const parts = [];
  for (let at = 8; at < bytes.length; at += 12 + bytes.readUInt32BE(at))
    if (bytes.toString('latin1', at + 4, at + 8) === 'IDAT')
      parts.push(bytes.subarray(at + 8, at + 8 + bytes.readUInt32BE(at)));
  const [width, height] = [bytes.readUInt32BE(16), bytes.readUInt32BE(20)];
  const channels = kChannels[bytes[25]];
  if (bytes[24] !== 8 || !channels || bytes[28]) throw new Error('a PNG of an unexpected kind');
  const raw = inflateSync(Buffer.concat(parts));
  const line = width * channels;
  const all = Buffer.alloc(line * height);
  for (let y = 0; y < height; ++y) {
    const filter = kFilters[raw[y * (line + 1)]];
    for (let x = 0; x < line; ++x) {
      const before = (dx, dy) =>
        x - dx < 0 || y - dy < 0 ? 0 : all[(y - dy) * line + x - dx];
      const added = filter(before(channels, 0), before(0, 1), before(channels, 1));
      all[y * line + x] = raw[y * (line + 1) + 1 + x] + added;
    }
  }
  const rgb = [];
  const [green, blue] = channels === 1 ? [0, 0] : [1, 2];
  for (let i = 0; i < all.length; i += channels)
    rgb.push([all[i], all[i + green], all[i + blue]]);
  return { width, height, rgb };
}
