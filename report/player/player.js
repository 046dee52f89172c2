// The animation player in the page: orbit, play, scrub, speed, texture, edges, onion skin.
import { PerspectiveCamera, Scene, Sphere, Vector3, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { unpack } from './data.js';
import { Figure } from './figure.js';

const kSecondsATurn = 24;
/** Seconds that the first and last picture are held if the animation is not a loop. */
const kRest = 0.7;

function startRenderer() {
  try {
    const renderer = new WebGLRenderer({ antialias: true, alpha: true });
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    return renderer;
  } catch {
    return null; // no WebGL: keep the poster
  }
}

/** A camera that holds all frames, in front of the figure and a little above it. */
function aim(camera, controls, data) {
  const points = [];
  for (let f = 0; f < data.frames.count; ++f) {
    const at = data.frames.at(f);
    for (let i = 0; i < at.length; i += 3 * Math.ceil(at.length / 6000))
      points.push(new Vector3(at[i], at[i + 1], at[i + 2]));
  }
  const ball = new Sphere().setFromPoints(points);
  const up = new Vector3(...data.up);
  const side = Math.abs(up.x) > 0.5 ? new Vector3(0, -1, 0) : new Vector3(1, 0, 0);
  const front = new Vector3().crossVectors(side, up).negate();
  if (Math.abs(up.z) > 0.5) front.set(0, -1, 0);
  const away = (1.02 * ball.radius) / Math.sin((camera.fov * Math.PI) / 360);
  camera.up.copy(up);
  camera.near = away / 100;
  camera.far = 10 * away;
  camera.position
    .copy(ball.center)
    .addScaledVector(front, away)
    .addScaledVector(up, 0.25 * away);
  camera.updateProjectionMatrix();
  controls.target.copy(ball.center);
  controls.minDistance = 0.3 * away;
  controls.maxDistance = 3 * away;
  controls.update();
}

class Player {
  constructor(host, data, renderer) {
    this.host = host;
    this.data = data;
    this.renderer = renderer;
    this.moment = 0;
    const first = data.moments[0],
      last = data.moments[data.moments.length - 1];
    this.rest = first.a === last.b ? 0 : kRest;
    this.clock = this.rest;
    this.playing = data.moments.length > 1;
    this.speed = 1;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(26, 1.6, 0.01, 100);
    this.controls = new OrbitControls(this.camera, renderer.domElement);
    this.controls.enableDamping = true;
    this.controls.autoRotate = true;
    this.controls.autoRotateSpeed = 60 / kSecondsATurn;
    this.controls.addEventListener('start', () => {
      this.turn(false);
    });
    this.figure = new Figure(data, () => {});
    this.scene.add(this.figure);
    this.stage = host.querySelector('.stage');
    this.stage.append(renderer.domElement);
    this.stage.classList.add('live');
    aim(this.camera, this.controls, data);
    this.wire();
    this.show(0);
    new ResizeObserver(() => this.fit()).observe(this.stage);
    this.fit();
    this.visible = true;
    new IntersectionObserver((seen) => {
      this.visible = seen[seen.length - 1].isIntersecting;
    }).observe(host);
    this.last = performance.now();
    renderer.render(this.scene, this.camera);
    renderer.setAnimationLoop((now) => this.tick(now));
    host.dataset.state = 'live';
  }

  control(name) {
    return this.host.querySelector(`[data-control=${name}]`);
  }

  wire() {
    const on = (name, event, act) =>
      this.control(name)?.addEventListener(event, (e) => act(e.target));
    on('play', 'click', () => this.play(!this.playing));
    on('scrub', 'input', (input) => {
      this.play(false);
      this.show(Number(input.value));
    });
    on('speed', 'change', (select) => {
      this.speed = Number(select.value);
    });
    on('turn', 'change', (box) => this.turn(box.checked));
    on('texture', 'change', (box) => {
      this.figure.textured = box.checked;
    });
    on('edges', 'change', (box) => {
      this.figure.wireframe = box.checked;
    });
    on('skins', 'change', (box) => this.figure.showSkins(box.checked));
    this.play(this.playing);
    this.host.querySelector('.controls').hidden = false;
  }

  turn(on) {
    this.controls.autoRotate = on;
    const box = this.control('turn');
    if (box) box.checked = on;
  }

  play(on) {
    this.playing = on;
    this.clock = this.rest + this.moment / this.data.fps;
    const button = this.control('play');
    if (!button) return;
    button.textContent = on ? 'Pause' : 'Play';
  }

  show(index) {
    this.moment = index;
    this.figure.show(this.data.moments[index]);
    const scrub = this.control('scrub'),
      time = this.control('time');
    if (scrub) scrub.value = String(index);
    if (time) {
      const seconds = (index / this.data.fps).toFixed(2);
      time.textContent = `${seconds} s, picture ${index + 1} of ${this.data.moments.length}`;
    }
    this.host.dataset.moment = String(index);
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  tick(now) {
    // A frame's time may be earlier than the time at which its callback was requested.
    const seconds = Math.min(0.1, Math.max(0, (now - this.last) / 1000));
    this.last = now;
    if (!this.visible) return;
    if (this.playing) {
      const count = this.data.moments.length;
      this.clock = (this.clock + seconds * this.speed) % (count / this.data.fps + 2 * this.rest);
      // Each picture is held as long as in the film, without interpolation between two.
      const next = Math.min(
        count - 1,
        Math.max(0, Math.floor((this.clock - this.rest) * this.data.fps + 1e-6)),
      );
      if (next !== this.moment) this.show(next);
    }
    this.controls.update(seconds);
    this.renderer.render(this.scene, this.camera);
  }
}

const host = document.getElementById('player');
const data = document.getElementById('player-data');
if (host && data) {
  const renderer = startRenderer();
  if (renderer) new Player(host, unpack(JSON.parse(data.textContent)), renderer);
  else host.dataset.state = 'poster';
}
