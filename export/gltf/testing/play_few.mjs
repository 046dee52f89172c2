// Plays a GLB in three.js and compares every frame that shows with the frames that were exported.
//
//     node export/gltf/testing/play_few.mjs FILE.glb TRUTH
//
// TRUTH is a folder as of WriteTruth. Positions are what the AnimationMixer gives, blended by the
// rule of three.js's morph target shader: while a picture is held also just before the next one,
// else also halfway to the next.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { AnimationMixer, LoopOnce } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';

const [file, folder] = process.argv.slice(2);
const bytes = (path) => {
  const buffer = readFileSync(path);
  return buffer.buffer.slice(buffer.byteOffset, buffer.byteOffset + buffer.length);
};
const truth = JSON.parse(readFileSync(join(folder, 'truth.json')));
const points = new Float64Array(bytes(join(folder, 'points.f64')));
const normals = new Float64Array(bytes(join(folder, 'split_normals.f64')));
const source = new Int32Array(bytes(join(folder, 'split_source.i32')));

globalThis.self = globalThis;
const { scene, animations } = await new GLTFLoader().parseAsync(bytes(file), '');
let mesh = null;
scene.traverse((node) => {
  if (node.isMesh) mesh = node;
});

const influences = { least: Infinity, most: -Infinity };
function blended(kind) {
  const sum = Float64Array.from(mesh.geometry.getAttribute(kind).array);
  mesh.morphTargetInfluences.forEach((weight, t) => {
    influences.least = Math.min(influences.least, weight);
    influences.most = Math.max(influences.most, weight);
    const target = mesh.geometry.morphAttributes[kind][t].array;
    for (let i = 0; i < sum.length; ++i) sum[i] += weight * target[i];
  });
  return sum;
}

/** The largest distance to the place between two frames that show. */
function distance(frame, share) {
  const found = blended('position');
  const next = Math.min(frame + 1, truth.frames - 1);
  let worst = 0;
  source.forEach((vertex, v) => {
    const square = [0, 1, 2].reduce((sum, axis) => {
      const here = points[3 * (frame * truth.vertices + vertex) + axis];
      const there = points[3 * (next * truth.vertices + vertex) + axis];
      return sum + (found[3 * v + axis] - (1 - share) * here - share * there) ** 2;
    }, 0);
    worst = Math.max(worst, Math.sqrt(square));
  });
  return worst / truth.diagonal;
}

/** The root of the mean squared angle between normals. */
function turned(frame) {
  const found = blended('normal');
  let sum = 0;
  for (let v = 0; v < source.length; ++v) {
    const a = [0, 1, 2].map((axis) => found[3 * v + axis]);
    const b = [0, 1, 2].map((axis) => normals[3 * (frame * source.length + v) + axis]);
    const cross = Math.hypot(
      a[1] * b[2] - a[2] * b[1],
      a[2] * b[0] - a[0] * b[2],
      a[0] * b[1] - a[1] * b[0],
    );
    sum += Math.atan2(cross, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) ** 2;
  }
  return sum / source.length;
}

const atRest = distance(0, 0); // before anything is played
const mixer = new AnimationMixer(scene);
const action = mixer.clipAction(animations[0]);
action.setLoop(LoopOnce).clampWhenFinished = true;
action.play();
const worst = { shown: 0, between: 0, normal: 0 };
for (let i = 0; i < truth.frames; ++i) {
  mixer.setTime(Math.fround(i / truth.fps));
  worst.shown = Math.max(worst.shown, distance(i, 0));
  worst.normal += turned(i) / truth.frames;
  if (i + 1 === truth.frames) continue;
  const share = truth.stands[i] ? 0.99 : 0.5;
  mixer.setTime((i + share) / truth.fps);
  worst.between = Math.max(worst.between, distance(i, truth.stands[i] ? 0 : share));
}
console.log(
  `frames=${truth.frames} targets=${mesh.morphTargetInfluences.length} at_rest=${atRest}`,
);
console.log(
  `worst=${worst.shown} between=${worst.between} ` +
  `normal_deg=${(Math.sqrt(worst.normal) * 180) / Math.PI}`,
);
console.log(`least=${influences.least} most=${influences.most} seconds=${animations[0].duration}`);
