// Reads a USDA file by its grammar, and by three.js's loader, without the code that wrote it, and
// compares every frame.   node read_usda.mjs FOLDER NAME
// FOLDER has NAME.usda, textures/ and truth/, which WriteTruth made. Prints figures as name=number.
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';

import { strToU8, zipSync } from 'three/addons/libs/fflate.module.js';
import { USDZLoader } from 'three/addons/loaders/USDZLoader.js';

const [folder, name] = process.argv.slice(2);

function check(condition, words) {
  if (!condition) throw new Error(words);
}

function read(...path) {
  const bytes = readFileSync(join(folder, ...path));
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
}

/** The grammar of USDA, as far as meshes need it (OpenUSD, "USDA file format"). */
class UsdaReader {
  static token =
    /\s*(?:("(?:[^"\\\n]|\\.)*")|(@[^@\n]*@)|(<[^>\n]*>)|(-?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|([A-Za-z_][\w:.]*(?:\[\])?)|([()[\]{}=,:]))/y;

  constructor(text) {
    check(text.startsWith('#usda 1.0\n'), 'no line #usda 1.0');
    this.text = text;
    this.at = 10;
    this.next();
  }

  next() {
    UsdaReader.token.lastIndex = this.at;
    const match = UsdaReader.token.exec(this.text);
    if (!match)
      check(
        this.text.slice(this.at).trim() === '',
        `cannot read: ${this.text.slice(this.at, this.at + 60)}`,
      );
    this.at = match ? UsdaReader.token.lastIndex : this.text.length;
    const kinds = ['string', 'asset', 'path', 'number', 'word', 'sign'];
    const kind = match ? kinds[match.slice(1).findIndex((group) => group !== undefined)] : 'end';
    this.now = { kind, text: match ? match[0].trim() : '' };
  }

  take(kind, text) {
    const { now } = this;
    check(
      now.kind === kind && (text === undefined || now.text === text),
      `${text ?? kind} expected, found ${now.text} before: ` +
      `${this.text.slice(this.at, this.at + 40)}`,
    );
    this.next();
    return now.text;
  }

  is(text) {
    return this.now.text === text && this.now.kind !== 'string';
  }

  layer() {
    const root = { meta: this.metadata(), prims: {} };
    while (this.now.kind !== 'end') this.prim(root);
    return root;
  }

  metadata() {
    const meta = {};
    if (!this.is('(')) return meta;
    this.take('sign', '(');
    while (!this.is(')')) {
      if (this.is('prepend')) this.next();
      const key = this.take('word');
      this.take('sign', '=');
      meta[key] = this.value();
    }
    this.take('sign', ')');
    return meta;
  }

  prim(parent) {
    this.take('word', 'def');
    const type = this.take('word');
    const called = JSON.parse(this.take('string'));
    check(/^[A-Za-z_]\w*$/.test(called), `${called} is no name of a prim`);
    check(!(called in parent.prims), `two prims ${called}`);
    const prim = { type, meta: this.metadata(), prims: {}, properties: {} };
    parent.prims[called] = prim;
    this.take('sign', '{');
    while (!this.is('}')) {
      if (this.is('def')) this.prim(prim);
      else this.property(prim);
    }
    this.take('sign', '}');
  }

  property(prim) {
    const uniform = this.is('uniform');
    if (uniform) this.next();
    const type = this.take('word');
    const key = this.take('word');
    check(!(key in prim.properties), `two properties ${key}`);
    const property = { type, uniform };
    if (this.is('=')) {
      this.next();
      property.value = key.endsWith('.timeSamples') ? this.samples() : this.value();
    }
    property.meta = this.metadata();
    prim.properties[key] = property;
  }

  samples() {
    const samples = [];
    this.take('sign', '{');
    while (!this.is('}')) {
      const time = Number(this.take('number'));
      this.take('sign', ':');
      samples.push({ time, value: this.value() });
      if (!this.is('}')) this.take('sign', ',');
    }
    this.take('sign', '}');
    return samples;
  }

  value() {
    if (this.is('[')) return this.list('[', ']');
    if (this.is('(')) return this.list('(', ')');
    const { kind, text } = this.now;
    this.next();
    if (kind === 'number') return Number(text);
    if (kind === 'string') return JSON.parse(text);
    check(kind === 'asset' || kind === 'path', `a value expected, found ${text}`);
    return text.slice(1, -1);
  }

  list(open, close) {
    const items = [];
    this.take('sign', open);
    while (!this.is(close)) {
      items.push(this.value());
      if (!this.is(close)) this.take('sign', ',');
    }
    this.take('sign', close);
    return items;
  }
}

const truth = JSON.parse(Buffer.from(read('truth', 'truth.json')).toString());
const truePoints = new Float64Array(read('truth', 'points.f64'));
const faces = new Int32Array(read('truth', 'faces.i32'));
const uvs = new Float64Array(read('truth', 'corner_uvs.f64'));
const source = new Int32Array(read('truth', 'split_source.i32'));
const splitNormals = new Float64Array(read('truth', 'split_normals.f64'));

const text = Buffer.from(read(`${name}.usda`)).toString();
const layer = new UsdaReader(text).layer();

function primAt(path) {
  return path
    .split('/')
    .slice(1)
    .reduce((prim, part) => {
      check(part in prim.prims, `no prim ${path}`);
      return prim.prims[part];
    }, layer);
}

/** What usdchecker asks of any stage. */
function checkStage() {
  const { meta } = layer;
  check(meta.upAxis === 'Y' && meta.metersPerUnit === 1, 'wrong axis or unit');
  check(
    meta.timeCodesPerSecond === truth.fps && meta.framesPerSecond === truth.fps,
    'wrong frame rate',
  );
  check(
    meta.startTimeCode === 0 && Math.abs(meta.endTimeCode - (truth.frames - 1)) < 1.001,
    `wrong range: to ${meta.endTimeCode}`,
  );
  check(layer.prims[meta.defaultPrim]?.type === 'Xform', 'the default prim is no Xform');
  return `/${meta.defaultPrim}`;
}

/** The texture's path, through all connections. */
function checkMaterial(path) {
  const connected = (prim, key) => {
    const [target, output] = prim.properties[key].value.split('.');
    const found = primAt(target);
    check(output in found.properties, `${prim.properties[key].value} is no output`);
    return found;
  };
  const identify = (prim, id) =>
    check(
      prim.type === 'Shader' &&
        prim.properties['info:id'].uniform &&
        prim.properties['info:id'].value === id,
      `no ${id}`,
    );
  const material = primAt(path);
  check(material.type === 'Material', 'the mesh is bound to no material');
  const surface = connected(material, 'outputs:surface.connect');
  identify(surface, 'UsdPreviewSurface');
  if (!('inputs:diffuseColor.connect' in surface.properties)) return '';
  const texture = connected(surface, 'inputs:diffuseColor.connect');
  identify(texture, 'UsdUVTexture');
  const reader = connected(texture, 'inputs:st.connect');
  identify(reader, 'UsdPrimvarReader_float2');
  check(reader.properties['inputs:varname'].value === 'st', 'the texture is not shown by st');
  const file = texture.properties['inputs:file'];
  check(
    file.type === 'asset' && existsSync(join(folder, file.value)),
    `${file.value} is not there`,
  );
  return file.value;
}

function checkMesh(mesh) {
  const value = (key, type) => {
    check(mesh.properties[key]?.type === type, `${key} is no ${type}`);
    return mesh.properties[key].value;
  };
  check(
    mesh.type === 'Mesh' && mesh.meta.apiSchemas.includes('MaterialBindingAPI'),
    'the mesh may not be bound to a material',
  );
  check(value('subdivisionScheme', 'token') === 'none', 'the mesh would be subdivided');
  check(
    value('faceVertexCounts', 'int[]').every((count) => count === 3) &&
      value('faceVertexCounts', 'int[]').length === truth.faces,
    'wrong face counts',
  );
  const indices = value('faceVertexIndices', 'int[]');
  check(
    indices.length === faces.length && indices.every((vertex, i) => vertex === faces[i]),
    'wrong faces',
  );
  check(mesh.properties.normals.meta.interpolation === 'vertex', 'normals are not per vertex');
  if (uvs.length === 0) return 0;
  check(
    mesh.properties['primvars:st'].meta.interpolation === 'faceVarying',
    'st is not per corner',
  );
  const st = value('primvars:st', 'texCoord2f[]');
  const corners = value('primvars:st:indices', 'int[]');
  check(corners.length === faces.length, 'wrong number of corners');
  return Math.max(
    ...corners.map((corner, i) =>
      Math.hypot(st[corner][0] - uvs[2 * i], st[corner][1] - uvs[2 * i + 1]),
    ),
  );
}

/**
 * The tuples at a time code, interpolated as USD does: linearly, held before the first and after
 * the last.
 */
function valueAt(samples, time) {
  const after = samples.findIndex((sample) => sample.time > time);
  if (after < 0) return samples.at(-1).value;
  if (after === 0) return samples[0].value;
  const [a, b] = [samples[after - 1], samples[after]];
  const share = (time - a.time) / (b.time - a.time);
  return a.value.map((tuple, i) => tuple.map((x, axis) => x + share * (b.value[i][axis] - x)));
}

function distances(points, frame) {
  check(points.length === truth.vertices, `${points.length} points instead of ${truth.vertices}`);
  let worst = 0;
  points.forEach((point, v) => {
    const at = 3 * (frame * truth.vertices + v);
    worst = Math.max(
      worst,
      Math.hypot(
        point[0] - truePoints[at],
        point[1] - truePoints[at + 1],
        point[2] - truePoints[at + 2],
      ),
    );
  });
  return worst;
}

function normalError(normals, frame) {
  let worst = 0;
  source.forEach((vertex, i) => {
    for (let axis = 0; axis < 3; ++axis)
      worst = Math.max(
        worst,
        Math.abs(normals[vertex][axis] - splitNormals[3 * (frame * source.length + i) + axis]),
      );
  });
  return worst;
}

function extentError(extent, points) {
  let worst = 0;
  for (let axis = 0; axis < 3; ++axis) {
    const along = points.map((point) => point[axis]);
    worst = Math.max(
      worst,
      Math.abs(extent[0][axis] - Math.min(...along)),
      Math.abs(extent[1][axis] - Math.max(...along)),
    );
  }
  return worst;
}

function samplesOf(mesh, key) {
  const samples = mesh.properties[`${key}.timeSamples`]?.value ?? [
    { time: 0, value: mesh.properties[key].value },
  ];
  samples.forEach((sample, i) =>
    check(i === 0 || sample.time > samples[i - 1].time, `${key}: times do not rise`),
  );
  return samples;
}

/** The stage in three.js: its loader reads what does not change in time. */
function checkThree(texture) {
  let shown = '';
  const image = {
    addEventListener() {},
    removeEventListener() {},
    set src(url) {
      shown = url;
    },
  };
  globalThis.document = { createElementNS: () => image };
  const entries = { [`${name}.usda`]: strToU8(text) };
  if (texture) entries[texture] = new Uint8Array(read(texture));
  const group = new USDZLoader().parse(zipSync(entries, { level: 0 }).buffer);
  const meshes = [];
  group.traverse((object) => {
    if (object.isMesh) meshes.push(object);
  });
  check(meshes.length === 1, `three.js finds ${meshes.length} meshes`);
  const { position, uv } = meshes[0].geometry.attributes;
  let worst = 0;
  faces.forEach((vertex, corner) => {
    const at = 3 * vertex;
    worst = Math.max(
      worst,
      Math.hypot(
        position.getX(corner) - truePoints[at],
        position.getY(corner) - truePoints[at + 1],
        position.getZ(corner) - truePoints[at + 2],
      ),
    );
    if (uvs.length > 0)
      check(
        Math.hypot(uv.getX(corner) - uvs[2 * corner], uv.getY(corner) - uvs[2 * corner + 1]) < 1e-6,
        'three.js shows another place of the texture',
      );
  });
  if (texture)
    check(
      shown.startsWith('blob:') && meshes[0].material.map,
      'three.js does not find the texture',
    );
  check(Math.abs(meshes[0].material.roughness - 0.9) < 1e-9, 'three.js does not find the material');
  return worst;
}

const root = checkStage();
const mesh = primAt(root).prims.mesh;
const texture = checkMaterial(mesh.properties['material:binding'].value);
const uvError = checkMesh(mesh);
const [points, normals, extent] = ['points', 'normals', 'extent'].map((key) =>
  samplesOf(mesh, key),
);
const worst = { points: 0, normals: 0, extent: 0, held: 0, moved: 0 };
for (let frame = 0; frame < truth.frames; ++frame) {
  const here = valueAt(points, frame);
  worst.points = Math.max(worst.points, distances(here, frame));
  worst.moved = Math.max(worst.moved, distances(here, 0));
  worst.normals = Math.max(worst.normals, normalError(valueAt(normals, frame), frame));
  worst.extent = Math.max(worst.extent, extentError(valueAt(extent, frame), here));
  // Where a picture is held, it stands until just before the next frame.
  if (truth.stands[frame])
    worst.held = Math.max(worst.held, distances(valueAt(points, frame + 0.998), frame));
}
console.log(
  `frames=${truth.frames} samples=${points.length} ` +
  `held_frames=${truth.stands.filter(Boolean).length}`,
);
console.log(`error_over_diagonal=${worst.points / truth.diagonal}`);
console.log(`held_error_over_diagonal=${worst.held / truth.diagonal}`);
console.log(`moved_over_diagonal=${worst.moved / truth.diagonal}`);
console.log(`extent_error_over_diagonal=${worst.extent / truth.diagonal}`);
console.log(`normal_error=${worst.normals}`);
console.log(`uv_error=${uvError}`);
console.log(`three_error_over_diagonal=${checkThree(texture) / truth.diagonal}`);
