// A page of run_in_browser.mjs: draws frames by the documented three.js code, and from the true
// points.
import {
  AmbientLight,
  Box3,
  BufferAttribute,
  Color,
  DirectionalLight,
  Mesh,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from 'three';

import { loadVat } from '/keypose-vat.js';

const name = new URLSearchParams(location.search).get('name');
const canvas = document.querySelector('canvas');

async function numbers(file, Type) {
  return new Type(await (await fetch(`/truth/${file}`)).arrayBuffer());
}

function findMesh(object) {
  let found = null;
  object.traverse((child) => {
    if (child.isMesh) found = child;
  });
  return found;
}

/** A mesh with the same material, before the code changes it, and the true points of a frame. */
function trueMesh(mesh, truth, frame) {
  const geometry = mesh.geometry.clone();
  const count = truth.source.length;
  const points = new Float32Array(3 * count);
  for (let v = 0; v < count; ++v)
    for (let axis = 0; axis < 3; ++axis)
      points[3 * v + axis] =
        truth.points[3 * (frame * truth.json.vertices + truth.source[v]) + axis];
  geometry.setAttribute('position', new BufferAttribute(points, 3));
  geometry.setAttribute(
    'normal',
    new BufferAttribute(
      new Float32Array(truth.normals.slice(3 * frame * count, 3 * (frame + 1) * count)),
      3,
    ),
  );
  const material = mesh.material.clone();
  material.onBeforeCompile = () => {};
  const made = new Mesh(geometry, material);
  made.frustumCulled = false;
  return made;
}

function makeStage(truth) {
  const renderer = new WebGLRenderer({ canvas, preserveDrawingBuffer: true });
  renderer.setSize(480, 480);
  const scene = new Scene();
  scene.background = new Color(0x6a7a8a);
  const sun = new DirectionalLight(0xffffff, 2.5);
  sun.position.set(2, 3, 4);
  scene.add(new AmbientLight(0xffffff, 0.7), sun);
  const box = new Box3().setFromArray(truth.points);
  const center = box.getCenter(new Vector3());
  const size = box.getSize(new Vector3()).length();
  const camera = new PerspectiveCamera(35, 1, size / 100, size * 10);
  camera.position.copy(center).add(new Vector3(0.6, 0.5, 1.2).multiplyScalar(1.1 * size));
  camera.lookAt(center);
  const pixels = () => {
    renderer.render(scene, camera);
    const gl = renderer.getContext();
    const out = new Uint8Array(4 * 480 * 480);
    gl.readPixels(0, 0, 480, 480, gl.RGBA, gl.UNSIGNED_BYTE, out);
    return out;
  };
  return { scene, pixels };
}

/** The share of pixels that differ by more than 16 of 255 in a channel. */
function share(a, b) {
  let count = 0;
  for (let i = 0; i < a.length; i += 4)
    count +=
      Math.max(
        Math.abs(a[i] - b[i]),
        Math.abs(a[i + 1] - b[i + 1]),
        Math.abs(a[i + 2] - b[i + 2]),
      ) > 16
        ? 1
        : 0;
  return (4 * count) / a.length;
}

async function run() {
  const truth = {
    json: await (await fetch('/truth/truth.json')).json(),
    points: await numbers('points.f64', Float64Array),
    normals: await numbers('split_normals.f64', Float64Array),
    source: await numbers('split_source.i32', Int32Array),
  };
  const character = await loadVat(`/vat/${name}.json`);
  const mesh = findMesh(character.object);
  const { scene, pixels } = makeStage(truth);
  const empty = pixels();
  const figures = { differs: 0, moves: 0, covers: 0 };
  let first = null;
  for (let frame = 0; frame < truth.json.frames; ++frame) {
    scene.add(character.object);
    character.show((frame + 0.5) / truth.json.fps);
    const drawn = pixels();
    scene.remove(character.object);
    const still = trueMesh(mesh, truth, frame);
    scene.add(still);
    const expected = pixels();
    scene.remove(still);
    first ??= drawn;
    figures.differs = Math.max(figures.differs, share(drawn, expected));
    figures.moves = Math.max(figures.moves, share(drawn, first));
    figures.covers = Math.max(figures.covers, share(drawn, empty));
  }
  scene.add(character.object);
  character.show((truth.json.frames - 0.5) / truth.json.fps);
  pixels();
  globalThis.figures = figures;
}

run().catch((error) => {
  globalThis.fault = error.stack ?? String(error);
});
