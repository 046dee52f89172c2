// A view of meshes in 3D: turn, pick, paint. One per canvas; several can turn together.
import {
  BackSide,
  BufferAttribute,
  BufferGeometry,
  CanvasTexture,
  Color,
  DirectionalLight,
  DoubleSide,
  Group,
  HemisphereLight,
  LinearFilter,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  PerspectiveCamera,
  Points,
  PointsMaterial,
  Raycaster,
  Scene,
  SphereGeometry,
  Sprite,
  SpriteMaterial,
  SRGBColorSpace,
  Texture,
  TextureLoader,
  Vector2,
  Vector3,
  WebGLRenderer,
} from 'three'
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js'
import { acceleratedRaycast, MeshBVH } from 'three-mesh-bvh'

import type { CameraView } from '../api'
import { scaleColor } from './colors'
import { boxOf } from './mesh_data'
import type { MeshData } from './mesh_data'

Mesh.prototype.raycast = acceleratedRaycast

export type Look = 'plain' | 'texture' | 'colors' | 'values'

/** A place on the surface under the pointer. */
export interface Hit {
  face: number
  barycentric: [number, number, number]
  place: [number, number, number]
  /** time that the search took [ms] */
  ms: number
}

export interface Marker {
  name: string
  place: [number, number, number]
  kind: 'landmark' | 'chosen' | 'suggested' | 'advice' | 'problem'
}

const kMarkerColors: Record<Marker['kind'], string> = {
  landmark: '#f08a5d',
  chosen: '#ffffff',
  suggested: '#7bb7e8',
  advice: '#c79bf2',
  problem: '#e5484d',
}

/** The camera's place relative to the shown thing, in its sizes: the same for meshes of any size. */
export interface Turn {
  direction: [number, number, number]
  distance: number
  /** where the camera looks, from the middle of the thing; none: at the middle */
  offset?: [number, number, number]
}

/** A ball of a marker on the screen [px], and how far beside it a press still takes it. */
const kBall_px = 5
const kChosenBall_px = 7
const kLabel_px = 20
const kGrasp_px = 5
const kBall = new SphereGeometry(1, 16, 12)
/** A dark rim, as the clay may have the marker's colour. */
const kRim = new MeshBasicMaterial({ color: '#14120f', side: BackSide })

/** The scale's colours as the renderer takes them: 256 levels, then that of 'no value'. */
const kLinearScale = new Float32Array(
  Array.from({ length: 257 }, (_, level) => {
    const [r, g, b] = level < 256 ? scaleColor(level / 255) : [0.6, 0.6, 0.6]
    return new Color().setRGB(r, g, b, SRGBColorSpace).toArray()
  }).flat(),
)

export class Viewer {
  private readonly renderer: WebGLRenderer
  private readonly scene = new Scene()
  private readonly camera = new PerspectiveCamera(35, 1, 0.01, 100)
  private readonly controls: OrbitControls
  private readonly extras = new Group()
  private readonly markers = new Group()
  private readonly resizes: ResizeObserver
  private surface: Mesh | null = null
  private cloud: Points | null = null
  private data: MeshData | null = null
  private center = new Vector3()
  private size = 1
  private wanted = false
  private pressed: { x: number; y: number } | null = null
  private texture: Texture | null = null
  /** true if pixels are dear, as there is no graphics card */
  readonly slow: boolean

  /** Called with the place on the surface that was clicked; null: beside it. */
  onPick: ((hit: Hit | null, event: PointerEvent) => void) | null = null
  /** While set, dragging on the surface calls it and does not turn the view. */
  onBrush: ((hit: Hit, phase: 'begin' | 'move' | 'end') => void) | null = null
  /** Called when the person has turned the view. */
  onTurn: ((turn: Turn) => void) | null = null
  /** Called when a marker is clicked; it then gets no pick. */
  onMarker: ((name: string) => void) | null = null
  /** Called while a marker is dragged over the surface, at last with done. */
  onMarkerDrag: ((name: string, hit: Hit, done: boolean) => void) | null = null
  private dragged = ''
  private brushing = false
  private lastHit: Hit | null = null

  constructor(private readonly host: HTMLElement) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, powerPreference: 'default' })
    this.slow = drawnByProcessor(this.renderer)
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio))
    this.renderer.outputColorSpace = SRGBColorSpace
    const canvas = this.renderer.domElement
    canvas.tabIndex = 0
    canvas.setAttribute('role', 'application')
    canvas.setAttribute('aria-label', '3D view: arrow keys turn it, plus and minus zoom')
    host.append(canvas)
    this.camera.up.set(0, 0, 1)
    this.scene.add(new HemisphereLight('#ffffff', '#8a8378', 1.6), this.extras, this.markers)
    const key = new DirectionalLight('#ffffff', 1.7)
    key.position.set(-1, -1.5, 2)
    this.camera.add(key)
    this.scene.add(this.camera)
    this.controls = new OrbitControls(this.camera, canvas)
    this.controls.enableDamping = false
    this.controls.addEventListener('change', () => this.draw())
    this.controls.addEventListener('start', () => (this.turning = true))
    this.controls.addEventListener('end', () => (this.turning = false))
    this.resizes = new ResizeObserver(() => this.resize())
    this.resizes.observe(host)
    canvas.addEventListener('pointerdown', this.down, { capture: true })
    canvas.addEventListener('pointermove', this.move)
    canvas.addEventListener('pointerup', this.up)
    canvas.addEventListener('pointercancel', this.up)
    canvas.addEventListener('keydown', this.key)
    this.resize()
  }
  private turning = false

  /** The canvas, for listeners of the page's own. */
  get element(): HTMLCanvasElement {
    return this.renderer.domElement
  }

  dispose(): void {
    this.resizes.disconnect()
    this.controls.dispose()
    this.clear()
    this.clearMarkers()
    this.renderer.dispose()
    this.renderer.domElement.remove()
  }

  /** Shows a mesh, or a cloud if it has no faces. Keeps the turn if `keep_turn`. */
  show(data: MeshData, look: Look, keep_turn = false): void {
    const first = this.data === null
    // Read before the middle and the size change, as it is relative to them.
    const turn: Turn = first ? { direction: [0.35, -0.9, 0.28], distance: 1.75 } : this.turn()
    this.clear()
    this.data = data
    if (data.faces > 0) this.surface = this.makeSurface(data, look)
    else this.cloud = this.makeCloud(data)
    this.scene.add((this.surface ?? this.cloud)!)
    const box = boxOf(data.positions)
    if (!keep_turn || first) {
      this.center.set((box[0] + box[3]) / 2, (box[1] + box[4]) / 2, (box[2] + box[5]) / 2)
      this.size = Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]) || 1
      this.camera.near = this.size / 200
      this.camera.far = this.size * 50
      this.setTurn(turn)
    }
    this.draw()
  }

  /** The same mesh in another look; much faster than to show it again. */
  setLook(look: Look): void {
    if (!this.surface || !this.data) return
    this.surface.material = this.materialOf(this.surface.geometry, this.data, look)
    this.draw()
  }

  /** Vertices become a colour each: [0, 1] from low to high, or `none` where not finite. */
  showValues(values: Float32Array, none = '#999999'): void {
    if (!this.surface || !this.data) return
    new Color(none).toArray(kLinearScale, 3 * 256)
    const corners = 3 * this.data.faces
    const old = this.surface.geometry.getAttribute('color') as BufferAttribute | undefined
    const colors = (old?.array as Float32Array) ?? new Float32Array(3 * corners)
    for (let corner = 0; corner < corners; ++corner) {
      const value = values[this.data.indices[corner]]
      const level = Math.round(255 * Math.min(1, Math.max(0, value)))
      const from = Number.isFinite(value) ? 3 * level : 3 * 256
      colors[3 * corner] = kLinearScale[from]
      colors[3 * corner + 1] = kLinearScale[from + 1]
      colors[3 * corner + 2] = kLinearScale[from + 2]
    }
    if (old) old.needsUpdate = true
    else this.surface.geometry.setAttribute('color', new BufferAttribute(colors, 3))
    const material = this.surface.material
    // A brush calls this many times a second; the material is compiled only once.
    if (!(material instanceof MeshStandardMaterial && material.vertexColors))
      this.surface.material = new MeshStandardMaterial({
        vertexColors: true,
        roughness: 0.9,
        side: DoubleSide,
      })
    this.draw()
  }

  /** The texture for the look 'texture', loaded from an address. */
  async loadTexture(url: string): Promise<void> {
    const texture = await new TextureLoader().loadAsync(url)
    texture.colorSpace = SRGBColorSpace
    texture.anisotropy = 4
    this.texture?.dispose()
    this.texture = texture
    const shown = this.surface?.material
    if (shown instanceof MeshBasicMaterial && !shown.vertexColors) {
      shown.map = texture
      shown.needsUpdate = true
    }
    this.draw()
  }

  /** Moves the vertices of the shown mesh; faces and layout stay. `normals`: shade again. */
  setPositions(positions: Float32Array, normals = true): void {
    if (!this.surface || !this.data) return
    const target = this.surface.geometry.getAttribute('position') as BufferAttribute
    const out = target.array as Float32Array
    const indices = this.data.indices
    for (let corner = 0; corner < indices.length; ++corner) {
      const from = 3 * indices[corner]
      out[3 * corner] = positions[from]
      out[3 * corner + 1] = positions[from + 1]
      out[3 * corner + 2] = positions[from + 2]
    }
    target.needsUpdate = true
    this.data = { ...this.data, positions }
    if (normals && this.surface.material instanceof MeshStandardMaterial)
      this.setSmoothNormals(this.surface.geometry, this.data)
    this.draw()
  }

  /** Draws fewer pixels, in both directions; for playing on a slow machine. 1: all. */
  setDetail(share: number): void {
    this.renderer.setPixelRatio(share * Math.min(2, window.devicePixelRatio))
    this.draw()
  }

  /** Other meshes over the first one, see-through: onion skin. */
  setGhosts(ghosts: { positions: Float32Array; color: string }[]): void {
    for (const old of [...this.extras.children].filter((one) => one.name === 'ghost')) {
      ;(old as Mesh).geometry.dispose()
      this.extras.remove(old)
    }
    for (const ghost of ghosts) {
      if (!this.data) break
      const geometry = new BufferGeometry()
      geometry.setAttribute('position', new BufferAttribute(ghost.positions, 3))
      geometry.setIndex(new BufferAttribute(this.data.indices, 1))
      const mesh = new Mesh(
        geometry,
        new MeshBasicMaterial({
          color: ghost.color,
          transparent: true,
          opacity: 0.3,
          depthWrite: false,
          // About a hundredth of the size behind the shown surface: where both nearly coincide they
          // would fight for the pixel.
          polygonOffset: true,
          polygonOffsetFactor: 4,
          polygonOffsetUnits: 300,
        }),
      )
      mesh.name = 'ghost'
      mesh.raycast = () => undefined
      this.extras.add(mesh)
    }
    this.draw()
  }

  /** Small frustums where the photographs were taken. */
  showCameras(cameras: CameraView[], chosen = ''): void {
    const old = this.extras.getObjectByName('cameras')
    if (old) this.extras.remove(old)
    if (cameras.length === 0) return this.draw()
    const places: number[] = []
    const colors: number[] = []
    const depth = 0.07 * this.size
    for (const camera of cameras) {
      const m = camera.pose
      const at = (x: number, y: number, z: number) => [
        m[0] * x + m[1] * y + m[2] * z + m[3],
        m[4] * x + m[5] * y + m[6] * z + m[7],
        m[8] * x + m[9] * y + m[10] * z + m[11],
      ]
      const corner = (u: number, v: number) =>
        at(
          (depth * (u * camera.width - camera.cx)) / camera.focal_px,
          (depth * (v * camera.height - camera.cy)) / camera.focal_px,
          depth,
        )
      const corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]
      const middle = at(0, 0, 0)
      const color = new Color(camera.name === chosen ? '#f08a5d' : '#7d776b')
      for (let i = 0; i < 4; ++i) {
        places.push(...middle, ...corners[i], ...corners[i], ...corners[(i + 1) % 4])
        for (let k = 0; k < 4; ++k) colors.push(color.r, color.g, color.b)
      }
    }
    const geometry = new BufferGeometry()
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(places), 3))
    geometry.setAttribute('color', new BufferAttribute(new Float32Array(colors), 3))
    const lines = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }))
    lines.name = 'cameras'
    this.extras.add(lines)
    this.draw()
  }

  /** Looks through one camera of a photograph; the view then lies over the photograph. */
  lookThrough(camera: CameraView): void {
    const m = camera.pose
    const eye = new Vector3(m[3], m[7], m[11])
    const forward = new Vector3(m[2], m[6], m[10])
    const down = new Vector3(m[1], m[5], m[9])
    const along = Math.max(this.size * 0.1, this.center.clone().sub(eye).dot(forward))
    this.camera.up.copy(down.negate())
    this.camera.position.copy(eye)
    this.controls.target.copy(eye.clone().addScaledVector(forward, along))
    this.camera.fov = (2 * Math.atan(camera.height / 2 / camera.focal_px) * 180) / Math.PI
    // The principal point need not be the middle: the window moves off it, in the photograph's pixels.
    const across = camera.width / 2 - camera.cx
    const down_px = camera.height / 2 - camera.cy
    const wide = camera.height * this.camera.aspect
    this.camera.setViewOffset(wide, camera.height, across, down_px, wide, camera.height)
    this.camera.lookAt(this.controls.target)
    this.draw()
  }

  /** Undoes lookThrough. */
  lookFreely(): void {
    this.camera.up.set(0, 0, 1)
    this.camera.fov = 35
    this.camera.clearViewOffset()
    this.camera.updateProjectionMatrix()
    this.setTurn({ direction: [0.35, -0.9, 0.28], distance: 1.75 })
  }

  setMarkers(markers: Marker[]): void {
    this.clearMarkers()
    for (const marker of markers) {
      const color = kMarkerColors[marker.kind]
      const ball = new Mesh(kBall, new MeshBasicMaterial({ color }))
      ball.name = marker.name
      ball.add(new Mesh(kBall, kRim))
      ball.children[0].scale.setScalar(1.3)
      ball.userData.px = marker.kind === 'chosen' ? kChosenBall_px : kBall_px
      const label = labelOf(marker.name, color)
      for (const one of [ball, label]) {
        one.position.set(...marker.place)
        one.userData.marker = marker.name
        one.userData.chosen = marker.kind === 'chosen'
        this.markers.add(one)
      }
    }
    this.draw()
  }

  /** Moves one marker, for a drag; the others stay as they are. */
  moveMarker(name: string, place: [number, number, number]): void {
    for (const one of this.markers.children)
      if (one.userData.marker === name) one.position.set(...place)
    this.draw()
  }

  private clearMarkers(): void {
    for (const one of this.markers.children as (Mesh | Sprite)[]) {
      const material = one.material as MeshBasicMaterial | SpriteMaterial
      material.map?.dispose()
      material.dispose()
    }
    this.markers.clear()
  }

  turn(): Turn {
    const away = this.camera.position.clone().sub(this.controls.target)
    const distance = away.length() / this.size
    away.normalize()
    const aside = this.controls.target.clone().sub(this.center).divideScalar(this.size)
    return {
      direction: [away.x, away.y, away.z],
      distance,
      offset: [aside.x, aside.y, aside.z],
    }
  }

  setTurn(turn: Turn): void {
    const far = turn.distance * this.size
    const away = new Vector3(...turn.direction).normalize().multiplyScalar(far)
    const aside = new Vector3(...(turn.offset ?? [0, 0, 0])).multiplyScalar(this.size)
    this.controls.target.copy(this.center).add(aside)
    this.camera.position.copy(this.controls.target).add(away)
    this.controls.update()
    // A click may come before the next frame is drawn, and must meet what will be shown.
    this.camera.updateMatrixWorld()
    this.draw()
  }

  /** Looks at a place from a direction, both in the mesh's space; distance in its sizes. */
  focusOn(
    place: [number, number, number],
    direction: [number, number, number],
    distance: number,
  ): void {
    const aside = new Vector3(...place).sub(this.center).divideScalar(this.size)
    this.setTurn({ direction, distance, offset: [aside.x, aside.y, aside.z] })
  }

  /** The place under a point of the window, or null. */
  hitAt(x: number, y: number): Hit | null {
    if (!this.surface || !this.data) return null
    const start = performance.now()
    const ray = this.rayAt(x, y)
    ray.firstHitOnly = true
    const found = ray.intersectObject(this.surface, false)[0]
    if (!found || found.faceIndex == null) return null
    return {
      face: found.faceIndex,
      barycentric: this.barycentricOf(found.faceIndex, found.point),
      place: [found.point.x, found.point.y, found.point.z],
      ms: performance.now() - start,
    }
  }

  /** The place of a pick on the shown mesh. */
  placeOf(face: number, barycentric: number[]): [number, number, number] {
    const place: [number, number, number] = [0, 0, 0]
    if (!this.data || face < 0 || face >= this.data.faces) return place
    for (let corner = 0; corner < 3; ++corner) {
      const vertex = this.data.indices[3 * face + corner]
      for (let k = 0; k < 3; ++k)
        place[k] += barycentric[corner] * this.data.positions[3 * vertex + k]
    }
    return place
  }

  /** How long a share of the size is on the screen, at a place [px]. */
  pixelsOf(share: number, place: [number, number, number]): number {
    const away = this.camera.position.distanceTo(new Vector3(...place))
    const high = 2 * away * Math.tan((this.camera.fov * Math.PI) / 360)
    return (share * this.size * this.host.clientHeight) / high
  }

  /** Vertices within `radius` (share of the size) of a place, with their distance over it. */
  verticesNear(place: [number, number, number], radius: number): { vertex: number; at: number }[] {
    const found: { vertex: number; at: number }[] = []
    if (!this.data) return found
    const reach = radius * this.size
    const p = this.data.positions
    for (let v = 0; v < this.data.vertices; ++v) {
      const d = Math.hypot(p[3 * v] - place[0], p[3 * v + 1] - place[1], p[3 * v + 2] - place[2])
      if (d < reach) found.push({ vertex: v, at: d / reach })
    }
    return found
  }

  draw(): void {
    // Also for the second change in a frame: a linked view must not stay behind.
    if (this.turning) this.onTurn?.(this.turn())
    if (this.wanted) return
    this.wanted = true
    requestAnimationFrame(() => {
      this.wanted = false
      this.fitMarkers()
      this.renderer.render(this.scene, this.camera)
    })
  }

  /** Markers keep their size on the screen; names behind the surface go, but for the chosen one. */
  private fitMarkers(): void {
    const tall = Math.max(1, this.host.clientHeight)
    const pixel = (2 * Math.tan((this.camera.fov * Math.PI) / 360)) / tall
    for (const one of this.markers.children as (Mesh | Sprite)[]) {
      const scale = pixel * one.position.distanceTo(this.camera.position)
      if (one instanceof Sprite) {
        const hidden = this.isHidden(one.position)
        one.visible = !hidden || one.userData.chosen
        one.scale.set(one.userData.ratio * kLabel_px * scale, kLabel_px * scale, 1)
        one.material.opacity = hidden ? 0.5 : 1
      } else {
        one.scale.setScalar(one.userData.px * scale)
      }
    }
  }

  /** True if the surface lies between the camera and the place. */
  isHidden(place: Vector3 | [number, number, number]): boolean {
    if (!this.surface) return false
    const at = place instanceof Vector3 ? place : new Vector3(...place)
    const towards = at.clone().sub(this.camera.position)
    const away = towards.length()
    const ray = new Raycaster(this.camera.position, towards.normalize(), 0, away - 0.01 * this.size)
    ray.firstHitOnly = true
    return ray.intersectObject(this.surface, false).length > 0
  }

  private clear(): void {
    for (const old of [this.surface, this.cloud]) {
      if (!old) continue
      this.scene.remove(old)
      old.geometry.dispose()
    }
    this.surface = null
    this.cloud = null
    this.data = null
  }

  /** A vertex for each corner, so that the layout's seams need no splitting. */
  private makeSurface(data: MeshData, look: Look): Mesh {
    const geometry = new BufferGeometry()
    const corners = data.indices.length
    const positions = new Float32Array(3 * corners)
    for (let corner = 0; corner < corners; ++corner) {
      const from = 3 * data.indices[corner]
      positions[3 * corner] = data.positions[from]
      positions[3 * corner + 1] = data.positions[from + 1]
      positions[3 * corner + 2] = data.positions[from + 2]
    }
    geometry.setAttribute('position', new BufferAttribute(positions, 3))
    if (data.uvs) geometry.setAttribute('uv', new BufferAttribute(data.uvs, 2))
    this.setSmoothNormals(geometry, data)
    geometry.boundsTree = new MeshBVH(geometry, { indirect: true })
    const mesh = new Mesh(geometry, this.materialOf(geometry, data, look))
    // setPositions may move it out of the ball that three.js remembers.
    mesh.frustumCulled = false
    return mesh
  }

  private materialOf(geometry: BufferGeometry, data: MeshData, look: Look) {
    if (look === 'texture' && data.uvs)
      return new MeshBasicMaterial({ map: this.texture, side: DoubleSide })
    if (look === 'colors' && data.colors) {
      const colors = new Float32Array(3 * data.indices.length)
      const color = new Color()
      for (let corner = 0; corner < data.indices.length; ++corner) {
        const from = 4 * data.indices[corner]
        color.setRGB(
          data.colors[from] / 255,
          data.colors[from + 1] / 255,
          data.colors[from + 2] / 255,
          SRGBColorSpace,
        )
        colors.set([color.r, color.g, color.b], 3 * corner)
      }
      geometry.setAttribute('color', new BufferAttribute(colors, 3))
      return new MeshBasicMaterial({ vertexColors: true, side: DoubleSide })
    }
    return new MeshStandardMaterial({ color: '#c9bfae', roughness: 0.85, side: DoubleSide })
  }

  private setSmoothNormals(geometry: BufferGeometry, data: MeshData): void {
    const { indices, positions: p } = data
    const sums = new Float32Array(3 * data.vertices)
    for (let f = 0; f < indices.length; f += 3) {
      const a = 3 * indices[f]
      const b = 3 * indices[f + 1]
      const c = 3 * indices[f + 2]
      const ux = p[b] - p[a]
      const uy = p[b + 1] - p[a + 1]
      const uz = p[b + 2] - p[a + 2]
      const vx = p[c] - p[a]
      const vy = p[c + 1] - p[a + 1]
      const vz = p[c + 2] - p[a + 2]
      const nx = uy * vz - uz * vy
      const ny = uz * vx - ux * vz
      const nz = ux * vy - uy * vx
      for (const at of [a, b, c]) {
        sums[at] += nx
        sums[at + 1] += ny
        sums[at + 2] += nz
      }
    }
    const normals = new Float32Array(3 * indices.length)
    for (let corner = 0; corner < indices.length; ++corner) {
      const from = 3 * indices[corner]
      const length = Math.hypot(sums[from], sums[from + 1], sums[from + 2]) || 1
      normals[3 * corner] = sums[from] / length
      normals[3 * corner + 1] = sums[from + 1] / length
      normals[3 * corner + 2] = sums[from + 2] / length
    }
    geometry.setAttribute('normal', new BufferAttribute(normals, 3))
  }

  private makeCloud(data: MeshData): Points {
    const geometry = new BufferGeometry()
    geometry.setAttribute('position', new BufferAttribute(data.positions, 3))
    if (data.colors) geometry.setAttribute('color', new BufferAttribute(data.colors, 4, true))
    const material = new PointsMaterial({
      size: 1.6,
      sizeAttenuation: false,
      vertexColors: data.colors !== null,
      color: data.colors ? '#ffffff' : '#8d8574',
    })
    // The colours of a cloud are sRGB bytes; the renderer takes vertex colours for linear ones.
    material.onBeforeCompile = (shader) => {
      shader.vertexShader = shader.vertexShader.replace(
        '#include <color_vertex>',
        '#include <color_vertex>\n#ifdef USE_COLOR_ALPHA\n vColor = vec4(pow(vColor.rgb, vec3(2.2)), 1.0);\n#elif defined(USE_COLOR)\n vColor = pow(vColor, vec3(2.2));\n#endif',
      )
    }
    return new Points(geometry, material)
  }

  private rayAt(x: number, y: number): Raycaster {
    const box = this.renderer.domElement.getBoundingClientRect()
    const ray = new Raycaster()
    this.camera.updateMatrixWorld()
    ray.setFromCamera(
      new Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2),
      this.camera,
    )
    return ray
  }

  private barycentricOf(face: number, point: Vector3): [number, number, number] {
    const corner = (k: number) => {
      const vertex = 3 * this.data!.indices[3 * face + k]
      const p = this.data!.positions
      return new Vector3(p[vertex], p[vertex + 1], p[vertex + 2])
    }
    const [a, b, c] = [corner(0), corner(1), corner(2)]
    const normal = b.clone().sub(a).cross(c.clone().sub(a))
    const area = normal.lengthSq() || 1
    const share = (u: Vector3, v: Vector3) =>
      u.clone().sub(point).cross(v.clone().sub(point)).dot(normal) / area
    const first = Math.min(1, Math.max(0, share(b, c)))
    const second = Math.min(1 - first, Math.max(0, share(c, a)))
    return [first, second, 1 - first - second]
  }

  /** The nearest marker on the screen that is not behind the surface, or ''. */
  private markerAt(x: number, y: number): string {
    const box = this.renderer.domElement.getBoundingClientRect()
    let best = ''
    let least = Infinity
    for (const ball of this.markers.children) {
      if (ball.name === '') continue
      const seen = ball.position.clone().project(this.camera)
      const aside = x - box.left - ((1 + seen.x) / 2) * box.width
      const above = y - box.top - ((1 - seen.y) / 2) * box.height
      const away = Math.hypot(aside, above)
      if (away > ball.userData.px + kGrasp_px || away >= least || this.isHidden(ball.position))
        continue
      best = ball.name
      least = away
    }
    return best
  }

  private readonly down = (event: PointerEvent) => {
    if (event.button !== 0) return
    this.pressed = { x: event.clientX, y: event.clientY }
    if (this.onMarkerDrag || this.onMarker) this.dragged = this.markerAt(event.clientX, event.clientY)
    const hit = this.onBrush && !event.altKey ? this.hitAt(event.clientX, event.clientY) : null
    this.brushing = hit !== null
    this.controls.enabled = !this.brushing && !(this.dragged && this.onMarkerDrag)
    // Without this, a release outside of the view would leave the drag going on.
    if (!this.controls.enabled) this.renderer.domElement.setPointerCapture(event.pointerId)
    if (hit) this.onBrush?.(hit, 'begin')
    this.lastHit = hit
  }

  private readonly move = (event: PointerEvent) => {
    if (!this.brushing && !(this.dragged && this.pressed && this.onMarkerDrag)) return
    const hit = this.hitAt(event.clientX, event.clientY)
    if (!hit) return
    this.lastHit = hit
    if (this.brushing) this.onBrush?.(hit, 'move')
    else this.onMarkerDrag?.(this.dragged, hit, false)
  }

  private readonly up = (event: PointerEvent) => {
    const pressed = this.pressed
    this.pressed = null
    this.controls.enabled = true
    const still =
      pressed !== null && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < 4
    if (this.brushing) {
      if (this.lastHit) this.onBrush?.(this.lastHit, 'end')
    } else if (this.dragged && !still) {
      if (this.lastHit) this.onMarkerDrag?.(this.dragged, this.lastHit, true)
    } else if (this.dragged) {
      this.onMarker?.(this.dragged)
    } else if (still) {
      this.onPick?.(this.hitAt(event.clientX, event.clientY), event)
    }
    this.brushing = false
    this.dragged = ''
    this.lastHit = null
  }

  private readonly key = (event: KeyboardEvent) => {
    const turn = this.turn()
    const around = { ArrowLeft: -0.12, ArrowRight: 0.12 }[event.key] ?? 0
    const over = { ArrowUp: 0.12, ArrowDown: -0.12 }[event.key] ?? 0
    const closer = { '+': 0.9, '=': 0.9, '-': 1.1 }[event.key] ?? 1
    if (!around && !over && closer === 1) return
    event.preventDefault()
    const [x, y, z] = turn.direction
    const level = Math.hypot(x, y) || 1e-6
    const tilt = Math.min(1.5, Math.max(-1.5, Math.atan2(z, level) + over))
    const yaw = Math.atan2(y, x) + around
    const next: Turn = {
      direction: [Math.cos(yaw) * Math.cos(tilt), Math.sin(yaw) * Math.cos(tilt), Math.sin(tilt)],
      distance: turn.distance * closer,
    }
    this.setTurn(next)
    this.onTurn?.(next)
  }

  private resize(): void {
    const width = Math.max(1, this.host.clientWidth)
    const height = Math.max(1, this.host.clientHeight)
    this.renderer.setSize(width, height)
    this.camera.aspect = width / height
    this.camera.updateProjectionMatrix()
    this.draw()
  }
}

/** True without a graphics card: each pixel then costs the processor's time. */
function drawnByProcessor(renderer: WebGLRenderer): boolean {
  const context = renderer.getContext()
  const names = context.getExtension('WEBGL_debug_renderer_info')
  const name = names ? String(context.getParameter(names.UNMASKED_RENDERER_WEBGL)) : ''
  return /swiftshader|llvmpipe|softpipe|basic render/i.test(name)
}

/** A name beside its marker, as a picture that always faces the person. */
function labelOf(text: string, color: string): Sprite {
  const canvas = document.createElement('canvas')
  const context = canvas.getContext('2d')!
  const font = '600 26px sans-serif'
  context.font = font
  canvas.width = Math.ceil(context.measureText(text).width) + 40
  canvas.height = 40
  context.font = font
  context.fillStyle = 'rgba(20,18,15,0.78)'
  context.beginPath()
  context.roundRect(20, 2, canvas.width - 20, 36, 8)
  context.fill()
  context.fillStyle = color
  context.fillText(text, 30, 30)
  const picture = new CanvasTexture(canvas)
  picture.colorSpace = SRGBColorSpace
  picture.minFilter = LinearFilter
  picture.generateMipmaps = false
  const label = new Sprite(new SpriteMaterial({ map: picture, depthTest: false }))
  label.center.set(-0.02, 0.5)
  label.userData.ratio = canvas.width / canvas.height
  label.raycast = () => undefined
  return label
}
