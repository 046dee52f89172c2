// Loads an FBX file with three.js and compares every frame that its animation shows with the truth.
//
//   node export/fbx/testing/check_fbx.mjs FILE.fbx TRUTH
//
// TRUTH is a folder that WriteTruth made. Prints figures as name=NUMBER.
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';

// The loader hands embedded images to the page; here there is none, so they are only counted.
let images = 0;
globalThis.window = { URL: { createObjectURL: (blob) => `blob:${(images += 1)}:${blob.size}` } };
globalThis.document = {
  createElementNS: () => ({ addEventListener() {}, removeEventListener() {} }),
};

const { AnimationMixer, LoopOnce, Vector3 } = await import('three');
const { FBXLoader } = await import('three/examples/jsm/loaders/FBXLoader.js');

const [path, truthFolder] = process.argv.slice(2);
const file = await readFile(path);
const scene = new FBXLoader().parse(
  file.buffer.slice(file.byteOffset, file.byteOffset + file.length),
  '',
);
const meshes = [];
scene.traverse((node) => node.isMesh && meshes.push(node));
if (meshes.length !== 1) throw new Error(`expected one mesh, found ${meshes.length}`);
const [mesh] = meshes;
const truth = JSON.parse(await readFile(join(truthFolder, 'truth.json'), 'utf8'));
const raw = async (name, Type) => {
  const bytes = await readFile(join(truthFolder, name));
  return new Type(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
};
const points = await raw('points.f64', Float64Array);
const faces = await raw('faces.i32', Int32Array);
const uvs = await raw('corner_uvs.f64', Float64Array);

const mixer = new AnimationMixer(scene);
for (const clip of scene.animations) mixer.clipAction(clip).setLoop(LoopOnce).play();
const action = scene.animations.length ? mixer.clipAction(scene.animations[0]) : null;
if (action) action.clampWhenFinished = true;

// three.js has a vertex for each corner, in the order of the faces.
const cornerAt = (i) => {
  const { position } = mesh.geometry.attributes;
  const corner = new Vector3().fromBufferAttribute(position, i);
  const targets = mesh.geometry.morphAttributes.position ?? [];
  mesh.morphTargetInfluences?.forEach((weight, k) => {
    if (weight !== 0)
      corner.addScaledVector(new Vector3().fromBufferAttribute(targets[k], i), weight);
  });
  return corner.applyMatrix4(mesh.matrixWorld);
};

scene.updateMatrixWorld(true);
let error = 0;
for (let frame = 0; frame < truth.frames; frame += 1) {
  // three.js keeps the times of keys in single precision.
  if (action) mixer.setTime(Math.fround(frame / truth.fps));
  for (let i = 0; i < faces.length; i += 1) {
    const at = 3 * (frame * truth.vertices + faces[i]);
    error = Math.max(
      error,
      cornerAt(i).distanceTo(new Vector3(points[at], points[at + 1], points[at + 2])),
    );
  }
}
let uvError = 0;
for (let i = 0; i < uvs.length; i += 1)
  uvError = Math.max(uvError, Math.abs(mesh.geometry.attributes.uv.array[i] - uvs[i]));
console.log(
  `corners=${mesh.geometry.attributes.position.count} ` +
  `targets=${mesh.morphTargetInfluences?.length ?? 0}`,
);
console.log(
  `frames=${truth.frames} error_over_diagonal=${(error / truth.diagonal).toPrecision(3)} ` +
  `uv_error=${uvError.toPrecision(3)}`,
);
console.log(
  `clips=${scene.animations.length} seconds=${scene.animations[0]?.duration ?? 0} ` +
  `images=${images} map=${mesh.material.map ? 1 : 0}`,
);
console.log(`unit=${scene.userData.unitScaleFactor} name=${mesh.name}`);
