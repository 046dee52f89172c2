// Where a place of a mesh is on the screen and in the truth: what an artist's eye does, for
// walk_test.mjs.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';

export const sub = (a, b) => a.map((value, k) => value - b[k]);
export const add = (a, b) => a.map((value, k) => value + b[k]);
export const scaled = (a, by) => a.map((value) => value * by);
export const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);
export const length = (a) => Math.sqrt(dot(a, a));
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const unit = (a) => scaled(a, 1 / length(a));
const turned = (m, p) => m.map((row) => dot(row, p));

/** The bytes of studio/meshes/mesh_bytes.h: positions and faces. */
export function meshOf(bytes) {
  const head = new DataView(bytes.buffer, bytes.byteOffset);
  const [vertices, faces] = [head.getUint32(4, true), head.getUint32(8, true)];
  const p = new Float32Array(
    bytes.buffer.slice(bytes.byteOffset + 16, bytes.byteOffset + 16 + 12 * vertices),
  );
  const start = bytes.byteOffset + 16 + 12 * vertices;
  const indices = new Uint32Array(bytes.buffer.slice(start, start + 12 * faces));
  const at = (vertex) => [p[3 * vertex], p[3 * vertex + 1], p[3 * vertex + 2]];
  const low = [0, 1, 2].map((k) =>
    Math.min(...Array.from({ length: vertices }, (_, v) => p[3 * v + k])),
  );
  const high = [0, 1, 2].map((k) =>
    Math.max(...Array.from({ length: vertices }, (_, v) => p[3 * v + k])),
  );
  const corners = (face) => [0, 1, 2].map((k) => at(indices[3 * face + k]));
  return {
    vertices,
    faces,
    corners,
    middle: scaled(add(low, high), 0.5),
    size: length(sub(high, low)),
  };
}

export const placeOn = (mesh, { face, barycentric }) =>
  mesh
    .corners(face)
    .reduce((sum, corner, k) => add(sum, scaled(corner, barycentric[k])), [0, 0, 0]);

/** The distance at which a ray meets the mesh first; Infinity: never. */
export function firstHit(mesh, from, towards) {
  let nearest = Infinity;
  for (let face = 0; face < mesh.faces; ++face) {
    const [a, b, c] = mesh.corners(face);
    const [u, v] = [sub(b, a), sub(c, a)];
    const n = cross(towards, v);
    const det = dot(u, n);
    if (Math.abs(det) < 1e-14) continue;
    const s = sub(from, a);
    const x = dot(s, n) / det;
    const q = cross(s, u);
    const y = dot(towards, q) / det;
    const t = dot(v, q) / det;
    if (x >= 0 && y >= 0 && x + y <= 1 && t > 0 && t < nearest) nearest = t;
  }
  return nearest;
}

const kFov = (35 * Math.PI) / 180;
const kWhole = { direction: unit([0.35, -0.9, 0.28]), distance: 1.62 };
const kTurn = 0.12;
/** Some pixels, of the figure's size: a click must not just miss. */
const kRound = 0.01;

const kSteepest = 1.5;

/**
 * A view of the page as it stands after `turns` presses of the right arrow key and `tilts` of the
 * one upwards.
 */
export class View {
  constructor(mesh, box, [turns, tilts]) {
    const [x, y, z] = kWhole.direction;
    const yaw = Math.atan2(y, x) + turns * kTurn;
    const tilt = Math.max(
      -kSteepest,
      Math.min(kSteepest, Math.atan2(z, Math.hypot(x, y)) + tilts * kTurn),
    );
    const away = [Math.cos(yaw) * Math.cos(tilt), Math.sin(yaw) * Math.cos(tilt), Math.sin(tilt)];
    this.mesh = mesh;
    this.box = box;
    this.eye = add(mesh.middle, scaled(away, kWhole.distance * mesh.size));
    this.forward = scaled(away, -1);
    this.right = unit(cross(this.forward, [0, 0, 1]));
    this.up = cross(this.right, this.forward);
  }

  /** The point of the window that shows a place. */
  pointOf(place) {
    const p = sub(place, this.eye);
    const scale = this.box.height / 2 / Math.tan(kFov / 2) / dot(p, this.forward);
    return {
      x: this.box.x + this.box.width / 2 + scale * dot(p, this.right),
      y: this.box.y + this.box.height / 2 - scale * dot(p, this.up),
    };
  }

  /**
   * Whether the place and what is round it is in front; `slack`: how far the surface may be from
   * it.
   */
  sees(place, slack) {
    const round = [
      [0, 0],
      [1, 0],
      [-1, 0],
      [0, 1],
      [0, -1],
    ].map(([x, y]) =>
      add(
        place,
        add(
          scaled(this.right, kRound * x * this.mesh.size),
          scaled(this.up, kRound * y * this.mesh.size),
        ),
      ),
    );
    return round.every((one) => {
      const p = sub(one, this.eye);
      return Math.abs(firstHit(this.mesh, this.eye, unit(p)) - length(p)) < slack;
    });
  }
}

/** Centres of the truth's cameras by photograph, from COLMAP's images.bin. */
export function trueCentres(data, pose) {
  const bytes = readFileSync(join(data, 'truth', pose, 'cameras/images.bin'));
  const centres = new Map();
  let at = 8;
  for (let left = Number(bytes.readBigUInt64LE(0)); left > 0; --left) {
    const [w, x, y, z, ...t] = Array.from({ length: 7 }, (_, k) =>
      bytes.readDoubleLE(at + 4 + 8 * k),
    );
    at += 4 + 56 + 4;
    const end = bytes.indexOf(0, at);
    const name = bytes.toString('utf8', at, end);
    at = end + 1 + 8 + 24 * Number(bytes.readBigUInt64LE(end + 1));
    const inverse = rotation(w, -x, -y, -z);
    centres.set(name, scaled(turned(inverse, t), -1));
  }
  return centres;
}

function rotation(w, x, y, z) {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
  ];
}

/** Horn's similarity that takes `from` to `to`, as a function of a place. */
export function similarity(from, to) {
  const mean = (points) => scaled(points.reduce(add), 1 / points.length);
  const [a, b] = [mean(from), mean(to)];
  const s = [0, 1, 2].map((i) =>
    [0, 1, 2].map((j) => from.reduce((sum, p, k) => sum + (p[i] - a[i]) * (to[k][j] - b[j]), 0)),
  );
  const n = [
    [s[0][0] + s[1][1] + s[2][2], s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]],
    [s[1][2] - s[2][1], s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]],
    [s[2][0] - s[0][2], s[0][1] + s[1][0], s[1][1] - s[0][0] - s[2][2], s[1][2] + s[2][1]],
    [s[0][1] - s[1][0], s[2][0] + s[0][2], s[1][2] + s[2][1], s[2][2] - s[0][0] - s[1][1]],
  ];
  // The largest eigenvalue by powers; the shift makes it the largest in size as well.
  const shift = Math.max(...n.map((row) => row.reduce((sum, value) => sum + Math.abs(value), 0)));
  let q = [1, 0.1, 0.2, 0.3];
  for (let i = 0; i < 2000; ++i) q = unit(add(turned(n, q), scaled(q, shift)));
  const r = rotation(...q);
  const spread = (points, middle) =>
    Math.sqrt(points.reduce((sum, p) => sum + dot(sub(p, middle), sub(p, middle)), 0));
  const scale = spread(to, b) / spread(from, a);
  return (p) => add(b, scaled(turned(r, sub(p, a)), scale));
}
