// Reads one format with three.js and compares every frame that shows with the frames that were
// exported.
//
//     node export/testing/read_in_three.mjs FORMAT FILE TRUTH RESULT
//
// FILE is what a person opens; TRUTH.json and TRUTH.bin are what formats_test.py wrote, with z up.
// RESULT is JSON as of read_in_blender.py, and corners are compared as there. three.js draws
// nothing here: positions are what its loaders and its AnimationMixer give, blended by the rule of
// its morph target shader.
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { inflateSync } from 'node:zlib';
import { strToU8, zipSync } from 'three/addons/libs/fflate.module.js';
import { AnimationMixer, Vector3 } from 'three';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MDDLoader } from 'three/addons/loaders/MDDLoader.js';
import { OBJLoader } from 'three/addons/loaders/OBJLoader.js';
import { USDZLoader } from 'three/addons/loaders/USDZLoader.js';

const [format, file, truthName, resultName] = process.argv.slice(2);
const truth = readTruth(truthName);

// What the loaders ask of a browser for textures; a picture's content plays no part here.
globalThis.self = globalThis;
globalThis.createImageBitmap = async (blob) => ({
  width: 1,
  height: 1,
  bytes: blob.size,
  close() {},
});
globalThis.document = {
  createElementNS: () => ({ addEventListener() {}, removeEventListener() {}, set src(_) {} }),
};

function readTruth(name) {
  const head = JSON.parse(readFileSync(`${name}.json`, 'utf8'));
  const bytes = readFileSync(`${name}.bin`).buffer;
  let at = 0;
  const take = (Kind, count) => {
    const values = new Kind(bytes.slice(at, at + count * Kind.BYTES_PER_ELEMENT));
    at += count * Kind.BYTES_PER_ELEMENT;
    return values;
  };
  head.positions = take(Float64Array, 3 * head.shown * head.vertices);
  head.faces = take(Int32Array, 3 * head.faceCount);
  head.uvs = take(Float32Array, 6 * head.faceCount);
  return head;
}

/// The largest distance of a corner, over the diagonal. `corner(c)` gives a place with y up.
function distance(frame, corner) {
  let worst = 0;
  for (let c = 0; c < truth.faces.length; ++c) {
    const at = 3 * (frame * truth.vertices + truth.faces[c]);
    const [x, y, z] = corner(c);
    worst = Math.max(
      worst,
      Math.hypot(
        x - truth.positions[at],
        -z - truth.positions[at + 1],
        y - truth.positions[at + 2],
      ),
    );
  }
  return worst / truth.diagonal;
}

/// The largest difference of a corner's texture coordinate; `v_down` as in glTF. `vertexOf(c)` is
/// where the geometry has corner c.
function uvDifference(
  geometry,
  vDown,
  vertexOf = (c) => (geometry.index ? geometry.index.getX(c) : c),
) {
  const uv = geometry.getAttribute('uv');
  if (!uv) return null;
  let worst = 0;
  for (let c = 0; c < truth.faces.length; ++c) {
    const at = vertexOf(c);
    const v = vDown ? 1 - uv.getY(at) : uv.getY(at);
    worst = Math.max(
      worst,
      Math.abs(uv.getX(at) - truth.uvs[2 * c]),
      Math.abs(v - truth.uvs[2 * c + 1]),
    );
  }
  return worst;
}

function onlyMesh(scene) {
  const meshes = [];
  scene.updateMatrixWorld(true);
  scene.traverse((node) => node.isMesh && meshes.push(node));
  if (meshes.length !== 1) throw new Error(`expected one mesh, found ${meshes.length}`);
  const corners = meshes[0].geometry.index
    ? meshes[0].geometry.index.count
    : meshes[0].geometry.getAttribute('position').count;
  if (corners !== truth.faces.length)
    throw new Error(`${corners} corners, but the frames have ${truth.faces.length}`);
  return meshes[0];
}

async function loadGltf(path) {
  const bytes = readFileSync(path);
  return new GLTFLoader().parseAsync(
    bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length),
    '',
  );
}

/// base + sum of weight times target, as in three.js's morphtarget_vertex, where the mesh's node
/// puts it.
function morphed(mesh) {
  const base = mesh.geometry.getAttribute('position');
  const targets = mesh.geometry.morphAttributes.position;
  const points = Float64Array.from(base.array);
  mesh.morphTargetInfluences.forEach((weight, t) => {
    if (weight === 0) return;
    for (let i = 0; i < points.length; ++i) points[i] += weight * targets[t].array[i];
  });
  const place = new Vector3();
  for (let i = 0; i < points.length; i += 3)
    place.fromArray(points, i).applyMatrix4(mesh.matrixWorld).toArray(points, i);
  return points;
}

/// Which of these points, with y up, is at each vertex of the first frame; -1: none is there.
function nearestVertices(points) {
  const nearest = new Int32Array(points.length / 3).fill(-1);
  const close = (1e-5 * truth.diagonal) ** 2;
  for (let p = 0; p < nearest.length; ++p) {
    const [x, y, z] = points.subarray(3 * p, 3 * p + 3);
    for (let v = 0; v < truth.vertices && nearest[p] < 0; ++v) {
      const [a, b, c] = truth.positions.subarray(3 * v, 3 * v + 3);
      if ((x - a) ** 2 + (-z - b) ** 2 + (y - c) ** 2 < close) nearest[p] = v;
    }
  }
  return nearest;
}

/// For a program that gives the faces in an order of its own: the mesh's vertex of each corner of
/// the frames' faces, found by where the first frame has them. Winding counts, the first corner not.
function cornersInOrder(mesh) {
  const vertexOf = nearestVertices(morphed(mesh));
  const turned = (corners, key) => {
    const first = corners.indexOf(corners.reduce((a, b) => (key(a) < key(b) ? a : b)));
    return [0, 1, 2].map((k) => corners[(first + k) % 3]);
  };
  const found = new Map();
  for (let f = 0; f < mesh.geometry.index.count; f += 3) {
    const corners = [0, 1, 2].map((k) => mesh.geometry.index.getX(f + k));
    const face = turned(corners, (c) => vertexOf[c]);
    found.set(face.map((c) => vertexOf[c]).join(), face);
  }
  const order = new Int32Array(truth.faces.length);
  for (let f = 0; f < truth.faces.length; f += 3) {
    const face = turned([0, 1, 2], (k) => truth.faces[f + k]);
    const corners = found.get(face.map((k) => truth.faces[f + k]).join());
    if (!corners) throw new Error(`face ${f / 3} of the frames is not there`);
    face.forEach((k, i) => (order[f + k] = corners[i]));
  }
  return order;
}

/// @param keepsOrder  whether corner k of face f is the frames' corner k of face f
async function gltf(keepsOrder = true) {
  const loaded = await loadGltf(file);
  const mesh = onlyMesh(loaded.scene);
  const order = keepsOrder ? mesh.geometry.index.array : cornersInOrder(mesh);
  const mixer = new AnimationMixer(loaded.scene);
  mixer.clipAction(loaded.animations[0]).play();
  let worst = 0;
  for (let i = 0; i < truth.shown; ++i) {
    // Times are in single precision in the file.
    mixer.setTime(Math.min(Math.fround(i / truth.fps), loaded.animations[0].duration * (1 - 1e-9)));
    const points = morphed(mesh);
    worst = Math.max(
      worst,
      distance(i, (c) => points.subarray(3 * order[c], 3 * order[c] + 3)),
    );
  }
  return {
    frames: truth.shown,
    worst,
    uv: uvDifference(mesh.geometry, true, (c) => order[c]),
    texture: Boolean(mesh.material.map),
    targets: mesh.morphTargetInfluences.length,
    last: loaded.animations[0].duration * truth.fps,
  };
}

/// A PNG without interlacing as 16-bit numbers. three.js leaves PNG to the browser, which gives a
/// page only 8 bits.
function readPng16(path) {
  const bytes = readFileSync(path);
  const parts = [];
  let [width, height, channels] = [0, 0, 0];
  for (let at = 8; at < bytes.length;) {
    const size = bytes.readUInt32BE(at);
    const kind = bytes.toString('latin1', at + 4, at + 8);
    if (kind === 'IHDR') {
      [width, height, channels] = [
        bytes.readUInt32BE(at + 8),
        bytes.readUInt32BE(at + 12),
        { 2: 3, 6: 4 }[bytes[at + 17]],
      ];
      if (bytes[at + 16] !== 16 || bytes[at + 20] !== 0)
        throw new Error(`${path} is not a plain PNG of 16 bits`);
    }
    if (kind === 'IDAT') parts.push(bytes.subarray(at + 8, at + 8 + size));
    at += size + 12;
  }
  const raw = unfiltered(
    inflateSync(Buffer.concat(parts)),
    2 * channels * width,
    height,
    2 * channels,
  );
  return {
    width,
    height,
    channels,
    at: (x, y, c) => raw.readUInt16BE(2 * ((y * width + x) * channels + c)),
  };
}

/// PNG's five filters. Source: PNG specification, section 9.
function unfiltered(data, stride, height, step) {
  const out = Buffer.alloc(stride * height);
  for (let y = 0; y < height; ++y) {
    const filter = data[y * (stride + 1)];
    for (let x = 0; x < stride; ++x) {
      const left = x >= step ? out[y * stride + x - step] : 0;
      const up = y > 0 ? out[(y - 1) * stride + x] : 0;
      const corner = y > 0 && x >= step ? out[(y - 1) * stride + x - step] : 0;
      const nearest = [left, up, corner].reduce((a, b) =>
        Math.abs(left + up - corner - b) < Math.abs(left + up - corner - a) ? b : a,
      );
      const predicted = [0, left, up, (left + up) >> 1, nearest][filter];
      out[y * stride + x] = data[y * (stride + 1) + 1 + x] + predicted;
    }
  }
  return out;
}

async function vat() {
  const told = JSON.parse(readFileSync(file.replace(/glb$/, 'json'), 'utf8'));
  const mesh = onlyMesh((await loadGltf(join(dirname(file), told.mesh))).scene);
  const address = mesh.geometry.getAttribute('uv1');
  const png = readPng16(join(dirname(file), told.positions.png));
  const exrBytes = readFileSync(join(dirname(file), told.positions.exr));
  const exr = new EXRLoader()
    .setDataType(1015 /* FloatType */)
    .parse(exrBytes.buffer.slice(exrBytes.byteOffset, exrBytes.byteOffset + exrBytes.length));
  const { minimum, maximum } = told.positions;
  let [worst, worstExr] = [0, 0];
  for (let i = 0; i < told.frames; ++i) {
    const texel = (c) => {
      const vertex = mesh.geometry.index.getX(c);
      return [
        Math.floor(address.getX(vertex) * told.columns),
        Math.floor(address.getY(vertex) * told.rows_per_frame) + i * told.rows_per_frame,
      ];
    };
    worst = Math.max(
      worst,
      distance(i, (c) => {
        const [x, y] = texel(c);
        return [0, 1, 2].map(
          (axis) => minimum[axis] + (maximum[axis] - minimum[axis]) * (png.at(x, y, axis) / 65535),
        );
      }),
    );
    worstExr = Math.max(
      worstExr,
      distance(i, (c) => {
        const [x, y] = texel(c);
        // three.js has the bottom row first.
        const at =
          ((told.rows - 1 - y) * told.columns + x) * (exr.data.length / (told.rows * told.columns));
        return exr.data.subarray(at, at + 3);
      }),
    );
  }
  return {
    frames: told.frames,
    fps: told.fps,
    worst,
    worst_exr: worstExr,
    uv: uvDifference(mesh.geometry, true),
    texture: Boolean(mesh.material.map),
    quantum: Math.hypot(...maximum.map((m, a) => m - minimum[a])) / 65535 / 2 / truth.diagonal,
  };
}

/// The points of a time sample, as three.js's loader sees them: it reads only points that do not
/// change, so each sample is
/// given to it in their place.
function usdaPoints(text, sample) {
  const still = text
    .replace(/point3f\[\] points\.timeSamples = \{[^}]*\}/, '')
    .replace(/^\s*point3f\[\] points = .*$/m, '')
    .replace(/(int\[\] faceVertexIndices = )/, `point3f[] points = ${sample}\n        $1`);
  const zip = zipSync({ 'character.usda': strToU8(still) }, { level: 0 });
  return onlyMesh(new USDZLoader().parse(zip.buffer));
}

function usda() {
  const text = readFileSync(file, 'utf8');
  const head = (name) => Number(text.match(new RegExp(`${name} = ([-0-9.e]+)`))[1]);
  if (!/upAxis = "Y"/.test(text) || head('metersPerUnit') !== 1)
    throw new Error('not y up in metres');
  const block = text.match(/point3f\[\] points\.timeSamples = \{([^}]*)\}/)[1];
  const samples = [...block.matchAll(/([-0-9.e]+): (\[[^\]]*\])/g)].map(([, time, points]) => ({
    time: Number(time),
    points,
  }));
  const perFrame = head('timeCodesPerSecond') / truth.fps;
  let [worst, uv, last] = [0, null, {}];
  const meshAt = (sample) =>
    sample === last.sample
      ? last.mesh
      : (last = { sample, mesh: usdaPoints(text, sample.points) }).mesh;
  for (let i = 0; i < truth.shown; ++i) {
    const sample = samples.filter((s) => s.time <= i * perFrame + 1e-9).at(-1);
    const next = samples.find((s) => s.time > i * perFrame + 1e-9);
    const share = next ? (i * perFrame - sample.time) / (next.time - sample.time) : 0;
    const mesh = meshAt(sample);
    const here = mesh.geometry.getAttribute('position');
    const there =
      share > 1e-9 ? usdaPoints(text, next.points).geometry.getAttribute('position') : here;
    const blend = (a, b) => a + share * (b - a);
    worst = Math.max(
      worst,
      distance(i, (c) => [
        blend(here.getX(c), there.getX(c)),
        blend(here.getY(c), there.getY(c)),
        blend(here.getZ(c), there.getZ(c)),
      ]),
    );
    uv = uvDifference(mesh.geometry, false);
  }
  return {
    frames: truth.shown,
    fps: head('timeCodesPerSecond'),
    worst,
    uv,
    last: head('endTimeCode') / perFrame,
  };
}

/// three.js binds the cache to a geometry with one vertex for each of the cache's.
function mdd() {
  const bytes = readFileSync(file);
  const loaded = new MDDLoader().parse(
    bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length),
  );
  const object = new OBJLoader().parse(readFileSync(file.replace(/mdd$/, 'obj'), 'utf8'));
  const corners = onlyMesh(object).geometry;
  // The cache numbers vertices by their first use in the faces.
  const place = new Map();
  for (const vertex of truth.faces) if (!place.has(vertex)) place.set(vertex, place.size);
  let worst = 0;
  loaded.morphTargets.forEach((target, i) => {
    worst = Math.max(
      worst,
      distance(i, (c) => {
        const at = 3 * place.get(truth.faces[c]);
        return target.array.subarray(at, at + 3);
      }),
    );
  });
  const times = loaded.clip.tracks[0].times;
  return {
    frames: loaded.morphTargets.length,
    fps: 1 / (times[1] - times[0]),
    worst,
    uv: uvDifference(corners, false),
  };
}

const readers = {
  glb: gltf,
  'glb-full': gltf,
  'glb-few': gltf,
  fbx2gltf: () => gltf(false),
  vat,
  usda,
  mdd,
};
writeFileSync(resultName, JSON.stringify(await readers[format]()));
process.exit(0);
