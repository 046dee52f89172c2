// The character over its plate: seen by the shot's camera, or from anywhere.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  Group,
  HemisphereLight,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  PerspectiveCamera,
  Quaternion,
  Scene,
  SRGBColorSpace,
  TextureLoader,
  Vector3,
  Vector4,
  WebGLRenderer,
} from 'three'
import type { Material, Texture } from 'three'
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js'

import { boxOf } from '../../view/mesh_data'
import type { MeshData } from '../../view/mesh_data'
import type { PlateCamera } from './armature_api'
import { Skin } from './skin'
import type { Weights } from './skin'

const kMostGhosts = 5
const kGlass = 0.35
const kGhost = 0.5
const kGhostColor = '#e8743b'
const kPlain = '#cfc4b2'
// What is drawn later lies over what was drawn before, whatever the depth.
const kPuppetOrder = 10
const kSetOrder = 20

/** Numbers w x y z of a turn, then a shift, as three.js wants them. */
function motionOf(numbers: number[], scale = 1): Matrix4 {
  const [w, x, y, z, a, b, c] = numbers
  const turn = new Quaternion(x, y, z, w)
  return new Matrix4().compose(new Vector3(a, b, c), turn, new Vector3(scale, scale, scale))
}

/** The lens bends each vertex as core/values/camera.h does; far outside of the picture no further. */
const kLensCode = `#include <project_vertex>
{
  float lens_u = mvPosition.x / -mvPosition.z, lens_v = -mvPosition.y / -mvPosition.z;
  float lens_r2 = min(lens_u * lens_u + lens_v * lens_v, lens_reach);
  float lens_radial = 1.0 + lens_r2 * (lens.x + lens_r2 * lens.y);
  float bent_u = lens_u * lens_radial + 2.0 * lens.z * lens_u * lens_v
    + lens.w * (lens_r2 + 2.0 * lens_u * lens_u);
  float bent_v = lens_v * lens_radial + 2.0 * lens.w * lens_u * lens_v
    + lens.z * (lens_r2 + 2.0 * lens_v * lens_v);
  if (lens_on > 0.5) gl_Position = projectionMatrix
    * vec4(bent_u * -mvPosition.z, -bent_v * -mvPosition.z, mvPosition.z, 1.0);
}`

/** What the lens code reads. */
interface Lens {
  lens: { value: Vector4 }
  lens_reach: { value: number }
  lens_on: { value: number }
}

function throughLens<M extends Material>(material: M, lens: Lens): M {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, lens)
    shader.vertexShader =
      'uniform vec4 lens;\nuniform float lens_reach;\nuniform float lens_on;\n' +
      shader.vertexShader.replace('#include <project_vertex>', kLensCode)
  }
  return material
}

/** A mesh whose vertices are posed; corners of their own where texture coordinates need them. */
class Body {
  readonly geometry = new BufferGeometry()
  private readonly positions: Float32Array
  private readonly normals: Float32Array
  /** posed vertices, if the drawn ones are corners */
  private readonly posed: [Float32Array, Float32Array] | null

  constructor(
    private readonly data: MeshData,
    private readonly skin: Skin,
  ) {
    const corners = data.uvs !== null
    const drawn = corners ? data.indices.length : data.vertices
    this.positions = new Float32Array(3 * drawn)
    this.normals = new Float32Array(3 * drawn)
    this.posed = corners
      ? [new Float32Array(3 * data.vertices), new Float32Array(3 * data.vertices)]
      : null
    this.geometry.setAttribute('position', new BufferAttribute(this.positions, 3))
    this.geometry.setAttribute('normal', new BufferAttribute(this.normals, 3))
    if (data.uvs) this.geometry.setAttribute('uv', new BufferAttribute(data.uvs, 2))
    else this.geometry.setIndex(new BufferAttribute(data.indices, 1))
    if (data.colors && !corners)
      this.geometry.setAttribute('color', new BufferAttribute(linear(data.colors), 3))
  }

  pose(bones: ArrayLike<number>): void {
    const [places, normals] = this.posed ?? [this.positions, this.normals]
    this.skin.pose(bones, places, normals)
    if (this.posed)
      this.data.indices.forEach((vertex, corner) => {
        for (let k = 0; k < 3; ++k) {
          this.positions[3 * corner + k] = places[3 * vertex + k]
          this.normals[3 * corner + k] = normals[3 * vertex + k]
        }
      })
    this.geometry.getAttribute('position').needsUpdate = true
    this.geometry.getAttribute('normal').needsUpdate = true
  }
}

function linear(colors: Uint8Array): Float32Array {
  const out = new Float32Array((3 * colors.length) / 4)
  const one = new Color()
  for (let v = 0; v < colors.length / 4; ++v) {
    one.setRGB(
      colors[4 * v] / 255,
      colors[4 * v + 1] / 255,
      colors[4 * v + 2] / 255,
      SRGBColorSpace,
    )
    one.toArray(out, 3 * v)
  }
  return out
}

export interface Character {
  mesh: MeshData
  weights: Weights
  set: MeshData | null
  textureUrl: string
}

export class PuppetView {
  private readonly renderer: WebGLRenderer
  private readonly scene = new Scene()
  private readonly world = new Group()
  private readonly placed = new Group()
  private readonly shotCamera = new PerspectiveCamera()
  private readonly freeCamera = new PerspectiveCamera(35, 1, 0.01, 100)
  private readonly controls: OrbitControls
  private readonly resizes: ResizeObserver
  private readonly lens: Lens = {
    lens: { value: new Vector4() },
    lens_reach: { value: 1e9 },
    lens_on: { value: 0 },
  }
  private readonly body: Body
  private readonly puppet: Mesh
  private readonly set: Mesh | null
  private readonly ghosts: { body: Body; meshes: Mesh[] }[] = []
  private texture: Texture | null = null
  private free = false
  private wanted = false
  /** poses drawn so far */
  drawn = 0

  constructor(
    private readonly host: HTMLElement,
    private readonly character: Character,
  ) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true })
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio))
    const canvas = this.renderer.domElement
    canvas.tabIndex = -1
    canvas.setAttribute('role', 'img')
    canvas.setAttribute('aria-label', 'The puppet over the plate')
    host.append(canvas)
    const sun = new DirectionalLight('#ffffff', 1.8)
    sun.position.set(-1, -1.5, 2)
    this.scene.add(new HemisphereLight('#ffffff', '#8a8378', 1.5), sun, this.world)
    this.world.add(this.placed)
    this.body = this.newBody()
    this.puppet = new Mesh(this.body.geometry, this.bodyMaterial())
    this.puppet.renderOrder = kPuppetOrder
    // Ghosts never hide the puppet.
    this.puppet.onBeforeRender = (renderer) => renderer.clearDepth()
    this.placed.add(this.prepared(this.puppet))
    this.set = character.set ? this.glass(character.set) : null
    if (this.set) this.world.add(this.set)
    if (character.textureUrl) void this.loadTexture(character.textureUrl)
    this.shotCamera.matrixAutoUpdate = false
    this.shotCamera.matrixWorldAutoUpdate = false
    this.freeCamera.up.set(0, 0, 1)
    this.controls = new OrbitControls(this.freeCamera, canvas)
    this.controls.enabled = false
    this.controls.addEventListener('change', () => this.draw())
    this.lookFromTheSide()
    this.resizes = new ResizeObserver(() => this.resize())
    this.resizes.observe(host)
    this.resize()
  }

  dispose(): void {
    this.resizes.disconnect()
    this.controls.dispose()
    for (const body of [this.body, ...this.ghosts.map((one) => one.body)]) body.geometry.dispose()
    this.set?.geometry.dispose()
    this.texture?.dispose()
    this.renderer.dispose()
    this.renderer.domElement.remove()
  }

  /** The camera of a plate, and where the character stands before it. */
  setCamera(camera: PlateCamera): void {
    const { width, height, fx, fy, cx, cy } = camera
    // three.js looks along -z, with y up.
    const flip = new Matrix4().makeScale(1, -1, -1)
    const view = flip.multiply(motionOf(camera.camera_from_world))
    this.shotCamera.matrixWorldInverse.copy(view)
    this.shotCamera.matrixWorld.copy(view).invert()
    const away = this.size()
    const [near, far] = [away / 500, away * 500]
    const depth = [-(far + near) / (far - near), (-2 * far * near) / (far - near)]
    // prettier-ignore
    this.shotCamera.projectionMatrix.set(
      (2 * fx) / width, 0, 1 - (2 * cx) / width, 0,
      0, (2 * fy) / height, (2 * cy) / height - 1, 0,
      0, 0, depth[0], depth[1],
      0, 0, -1, 0)
    this.shotCamera.projectionMatrixInverse.copy(this.shotCamera.projectionMatrix).invert()
    this.lens.lens.value.set(camera.k1, camera.k2, camera.p1, camera.p2)
    const corner = Math.max(cx, width - cx) / fx
    this.lens.lens_reach.value = 1.4 * (corner ** 2 + (Math.max(cy, height - cy) / fy) ** 2)
    motionOf(camera.world_from_character, camera.scale).decompose(
      this.placed.position,
      this.placed.quaternion,
      this.placed.scale,
    )
    this.draw()
  }

  setPose(bones: ArrayLike<number>): void {
    this.body.pose(bones)
    ++this.drawn
    this.draw()
  }

  /** Earlier poses, oldest first, the oldest faintest. */
  setGhosts(poses: ArrayLike<number>[]): void {
    const shown = poses.slice(-kMostGhosts)
    while (this.ghosts.length < shown.length) this.ghosts.push(this.newGhost(this.ghosts.length))
    this.ghosts.forEach((ghost, g) => {
      for (const mesh of ghost.meshes) mesh.visible = g < shown.length
      if (g >= shown.length) return
      ghost.body.pose(shown[g])
      const material = ghost.meshes[1].material as MeshLambertMaterial
      material.opacity = (kGhost * (g + 1)) / shown.length
    })
    this.draw()
  }

  showSet(shown: boolean): void {
    if (this.set) this.set.visible = shown
    this.draw()
  }

  /** From anywhere, turned by the mouse; else by the shot's camera. */
  setFree(free: boolean): void {
    this.free = free
    this.controls.enabled = free
    this.draw()
  }

  draw(): void {
    if (this.wanted) return
    this.wanted = true
    requestAnimationFrame(() => {
      this.wanted = false
      const bends = this.lens.lens.value.lengthSq() > 0
      this.lens.lens_on.value = bends && !this.free ? 1 : 0
      this.renderer.render(this.scene, this.free ? this.freeCamera : this.shotCamera)
    })
  }

  private size(): number {
    const box = boxOf(this.character.mesh.positions)
    return Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]) || 1
  }

  private lookFromTheSide(): void {
    const box = boxOf(this.character.mesh.positions)
    const middle = [0, 1, 2].map((k) => (box[k] + box[k + 3]) / 2)
    const size = this.size()
    this.controls.target.set(middle[0], middle[1], middle[2])
    this.freeCamera.position.set(middle[0] + 1.6 * size, middle[1], middle[2] + 0.05 * size)
    this.freeCamera.near = size / 100
    this.freeCamera.far = size * 50
    this.controls.update()
  }

  private newBody(): Body {
    const { mesh, weights } = this.character
    return new Body(mesh, new Skin(mesh.positions, mesh.indices, weights))
  }

  private bodyMaterial(): MeshLambertMaterial {
    const colors = this.character.mesh.colors !== null && this.character.mesh.uvs === null
    const color = colors ? '#ffffff' : kPlain
    // 'transparent' makes three.js keep the order of drawing; it is opaque.
    const material = { color, vertexColors: colors, side: DoubleSide, transparent: true }
    return throughLens(new MeshLambertMaterial(material), this.lens)
  }

  /** First its depth, then its colour: the far side of a ghost does not shine through. */
  private newGhost(order: number): { body: Body; meshes: Mesh[] } {
    const body = this.newBody()
    const depth = new MeshLambertMaterial({ colorWrite: false, transparent: true })
    const skin = new MeshLambertMaterial({ color: kGhostColor, transparent: true })
    const meshes = [depth, skin].map((material, pass) => {
      const mesh = new Mesh(body.geometry, throughLens(material, this.lens))
      mesh.renderOrder = order + 0.5 * pass
      return this.prepared(mesh)
    })
    meshes[0].onBeforeRender = (renderer) => renderer.clearDepth()
    this.placed.add(...meshes)
    return { body, meshes }
  }

  private glass(data: MeshData): Mesh {
    const geometry = new BufferGeometry()
    geometry.setAttribute('position', new BufferAttribute(data.positions, 3))
    geometry.setIndex(new BufferAttribute(data.indices, 1))
    if (data.colors) geometry.setAttribute('color', new BufferAttribute(linear(data.colors), 3))
    geometry.computeVertexNormals()
    const material = new MeshLambertMaterial({
      color: data.colors ? '#ffffff' : '#9db4c0',
      vertexColors: data.colors !== null,
      transparent: true,
      opacity: kGlass,
      side: DoubleSide,
    })
    const mesh = new Mesh(geometry, throughLens(material, this.lens))
    mesh.renderOrder = kSetOrder
    return this.prepared(mesh)
  }

  /** Nothing is left out by three.js, whose boxes are those of the mesh at rest. */
  private prepared(mesh: Mesh): Mesh {
    mesh.frustumCulled = false
    return mesh
  }

  private async loadTexture(url: string): Promise<void> {
    if (!this.character.mesh.uvs) return
    this.texture = await new TextureLoader().loadAsync(url)
    this.texture.colorSpace = SRGBColorSpace
    const material = this.puppet.material as MeshLambertMaterial
    material.map = this.texture
    material.color.set('#ffffff')
    material.needsUpdate = true
    this.draw()
  }

  private resize(): void {
    const width = Math.max(1, this.host.clientWidth)
    const height = Math.max(1, this.host.clientHeight)
    this.renderer.setSize(width, height)
    this.freeCamera.aspect = width / height
    this.freeCamera.updateProjectionMatrix()
    this.draw()
  }
}
