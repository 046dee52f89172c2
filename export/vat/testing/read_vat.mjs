// Decodes a vertex animation texture as a shader does, without the code that wrote it, and compares
// every frame.   node read_vat.mjs FOLDER NAME
// FOLDER has vat/NAME.json and truth/, which WriteTruth made. Prints figures as name=number.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';

import { FloatType } from 'three';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';

import { readPng } from './read_png.mjs';

const [folder, name] = process.argv.slice(2);

function check(condition, words) {
  if (!condition) throw new Error(words);
}

function read(...path) {
  const bytes = readFileSync(join(folder, ...path));
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
}

/** The attributes of the only mesh of a GLB. */
function readGlb(path) {
  const bytes = read('vat', path);
  const jsonSize = new DataView(bytes).getUint32(12, true);
  const json = JSON.parse(Buffer.from(bytes, 20, jsonSize).toString());
  const accessor = (number) => {
    const { bufferView, count, type, componentType } = json.accessors[number];
    const at = 28 + jsonSize + (json.bufferViews[bufferView].byteOffset ?? 0);
    const size = count * { SCALAR: 1, VEC2: 2, VEC3: 3 }[type];
    return componentType === 5126
      ? new Float32Array(bytes.slice(at, at + 4 * size))
      : new Uint32Array(bytes.slice(at, at + 4 * size));
  };
  const primitive = json.meshes[0].primitives[0];
  return {
    texels: accessor(primitive.attributes.TEXCOORD_1),
    points: accessor(primitive.attributes.POSITION),
    faces: accessor(primitive.indices),
  };
}

const vat = JSON.parse(Buffer.from(read('vat', `${name}.json`)).toString());
const truth = JSON.parse(Buffer.from(read('truth', 'truth.json')).toString());
const points = new Float64Array(read('truth', 'points.f64'));
const normals = new Float64Array(read('truth', 'split_normals.f64'));
const source = new Int32Array(read('truth', 'split_source.i32'));
const faces = new Int32Array(read('truth', 'faces.i32'));

// The last frame of a loop is the first of the next round.
const wanted = truth.frames - (vat.loop ? 1 : 0);
check(vat.frames === wanted, `${vat.frames} frames instead of ${wanted}`);
check(vat.fps === truth.fps, `${vat.fps} frames a second instead of ${truth.fps}`);
check(
  vat.vertices === truth.split_vertices,
  `${vat.vertices} vertices instead of ${truth.split_vertices}`,
);

const glb = readGlb(vat.mesh);
check(glb.faces.length === faces.length, 'the mesh has another number of faces');
check(
  glb.faces.every((vertex, i) => source[vertex] === faces[i]),
  'the faces of the mesh differ',
);

const png = readPng(join(folder, 'vat', vat.positions.png));
const normalPng = readPng(join(folder, 'vat', vat.normals.png));
check(png.bits === 16 && normalPng.bits === 8, 'wrong number of bits');
for (const { kinds } of [png, normalPng])
  for (const kind of ['gAMA', 'sRGB', 'cHRM', 'iCCP'])
    check(!kinds.has(kind), `a browser would change the numbers, because of ${kind}`);
for (const { width, height } of [png, normalPng])
  check(width === vat.columns && height === vat.rows, `a picture has ${width} x ${height} pixels`);

const exrBytes = read('vat', vat.positions.exr);
const exr = new EXRLoader().setDataType(FloatType).parse(exrBytes);
check(
  exr.width === vat.columns && exr.height === vat.rows,
  `the EXR has ${exr.width} x ${exr.height} pixels`,
);
const exrChannels = exr.data.length / (exr.width * exr.height);

// The shaders' arithmetic, in single precision.
const single = Math.fround;
const { minimum, maximum } = vat.positions;
const decode = (code, axis) =>
  single(
    single(minimum[axis]) + single(single(maximum[axis] - minimum[axis]) * single(code / 65535)),
  );

const worst = { error: 0, exr: 0, normal: 0, moved: 0 };
for (let frame = 0; frame < vat.frames; ++frame) {
  for (let v = 0; v < vat.vertices; ++v) {
    const column = Math.floor(single(glb.texels[2 * v] * vat.columns));
    const row =
      Math.floor(single(glb.texels[2 * v + 1] * vat.rows_per_frame)) + frame * vat.rows_per_frame;
    const at = row * vat.columns + column;
    const fromBottom = (vat.rows - 1 - row) * vat.columns + column;
    const sums = [0, 0, 0];
    let along = 0,
      length = 0;
    for (let axis = 0; axis < 3; ++axis) {
      const expected = points[3 * (frame * truth.vertices + source[v]) + axis];
      const first = points[3 * source[v] + axis];
      sums[0] += (decode(png.values[3 * at + axis], axis) - expected) ** 2;
      sums[1] += (exr.data[exrChannels * fromBottom + axis] - expected) ** 2;
      sums[2] += (expected - first) ** 2;
      const part = (normalPng.values[3 * at + axis] / 255) * 2 - 1;
      along += part * normals[3 * (frame * vat.vertices + v) + axis];
      length += part * part;
    }
    worst.error = Math.max(worst.error, Math.sqrt(sums[0]));
    worst.exr = Math.max(worst.exr, Math.sqrt(sums[1]));
    worst.moved = Math.max(worst.moved, Math.sqrt(sums[2]));
    worst.normal = Math.max(worst.normal, Math.acos(Math.min(1, along / Math.sqrt(length))));
  }
}
console.log(`frames=${vat.frames} rows_per_frame=${vat.rows_per_frame}`);
console.log(`error_over_diagonal=${worst.error / truth.diagonal}`);
console.log(`exr_error_over_diagonal=${worst.exr / truth.diagonal}`);
console.log(`normal_error_deg=${(worst.normal * 180) / Math.PI}`);
console.log(`moved_over_diagonal=${worst.moved / truth.diagonal}`);
