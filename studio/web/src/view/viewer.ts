// A view of meshes in 3D: turn, pick, paint. One per canvas; several can turn together.
import {
  DirectionalLight,
  Group,
  HemisphereLight,
  Mesh,
  PerspectiveCamera,
  Raycaster,
  Scene,
  SRGBColorSpace,
  Vector2,
  Vector3,
  WebGLRenderer,
} from 'three'
import type { Texture } from 'three'
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js'

import type { CameraView } from '../api'
import { drawnByProcessor } from './detail'
import { frustumsOf, ghostOf } from './extras'
import { Markers } from './markers'
import type { Marker, Screen } from './markers'
import { shownFront, turnedToFront } from './front'
import { boxOf } from './mesh_data'
import type { MeshData } from './mesh_data'
import { Pace } from './pace'
import { scalePicture } from './scale_picture'
import type { GreyPicture } from './scale_picture'
import { changePicture, decodedTexture, loadedTexture, Surface } from './surface'
import type { Hit, Look, Pictures } from './surface'
import { turnedByKey } from './turn'
import type { Turn } from './turn'

export type { Hit, Look, Marker, Turn }

/** Where a view begins: a little beside the figure's front, and above it. */
const fromTheFront = (): Turn =>
  turnedToFront({ direction: [0.35, -0.9, 0.28], distance: 1.75 }, shownFront.degrees)

export class Viewer {
  private readonly renderer: WebGLRenderer
  private readonly scene = new Scene()
  private readonly camera = new PerspectiveCamera(35, 1, 0.01, 100)
  private readonly controls: OrbitControls
  private readonly extras = new Group()
  private readonly markers = new Markers()
  private readonly sky = new HemisphereLight('#ffffff', '#8a8378', 1.6)
  private readonly key_light = new DirectionalLight('#ffffff', 1.7)
  private readonly resizes: ResizeObserver
  private shown: Surface | null = null
  private readonly pictures: Pictures = { texture: null, confidence: null }
  private blends = new Map<string, Texture>()
  private center = new Vector3()
  private size = 1
  private pressed: { x: number; y: number } | null = null
  private readonly pace: Pace

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
    const antialias = !drawnByProcessor()
    this.renderer = new WebGLRenderer({ antialias, alpha: true, powerPreference: 'default' })
    this.pace = new Pace(this.renderer, () => {
      this.markers.fit(this.screen())
      this.renderer.render(this.scene, this.camera)
    })
    this.renderer.outputColorSpace = SRGBColorSpace
    const canvas = this.renderer.domElement
    canvas.tabIndex = 0
    canvas.setAttribute('role', 'application')
    canvas.setAttribute('aria-label', '3D view: arrow keys turn it, plus and minus zoom')
    host.append(canvas)
    this.camera.up.set(0, 0, 1)
    this.scene.add(this.sky, this.extras, this.markers.group)
    this.key_light.position.set(-1, -1.5, 2)
    this.camera.add(this.key_light)
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
    this.pace.dispose()
    this.resizes.disconnect()
    this.controls.dispose()
    this.clear()
    this.markers.clear()
    for (const picture of Object.values(this.pictures)) picture?.dispose()
    for (const texture of this.blends.values()) texture.dispose()
    this.renderer.dispose()
    this.renderer.domElement.remove()
  }

  /**
   * Shows a mesh, or a cloud if it has no faces. Keeps the turn if `keep_turn`.
   * @param box  what the view is of; views of one box and turn have the same camera
   */
  show(data: MeshData, look: Look, keep_turn = false, box = boxOf(data.positions)): void {
    const first = this.shown === null
    // Read before the middle and the size change, as it is relative to them.
    const turn: Turn = first ? fromTheFront() : this.turn()
    this.clear()
    this.shown = new Surface(data, look, this.pictures)
    this.scene.add(this.shown.object)
    if (!keep_turn || first) {
      this.center.set((box[0] + box[3]) / 2, (box[1] + box[4]) / 2, (box[2] + box[5]) / 2)
      this.size = Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]) || 1
      this.camera.near = this.size / 200
      this.camera.far = this.size * 50
      this.setTurn(turn)
    }
    this.draw()
  }

  /** Light from the side, which shows dents and bumps. */
  rake(): void {
    this.sky.intensity = 0.7
    this.key_light.intensity = 2.6
    this.key_light.position.set(-2, 1.6, 0.9)
    this.draw()
  }

  /** The same mesh in another look; much faster than to show it again. */
  setLook(look: Look): void {
    this.shown?.setLook(look)
    this.draw()
  }

  /** Vertices become a colour each: [0, 1] from low to high, or `none` where not finite. */
  showValues(values: Float32Array, none = '#999999'): void {
    this.shown?.showValues(values, none)
    this.draw()
  }

  /**
   * The texture for the look 'texture', loaded from an address. What was asked for last is shown,
   * whichever comes last.
   */
  async loadTexture(url: string): Promise<void> {
    const asked = ++this.asked.texture
    const texture = await loadedTexture(url)
    if (asked === this.asked.texture) this.setPicture('texture', texture)
    else texture.dispose()
  }
  private readonly asked = { texture: 0, confidence: 0, blends: 0 }

  /**
   * A texture that the caller has decoded, upside down. It may be freed once another one was shown;
   * pictures of one size follow each other at the cost of a copy.
   */
  showTexture(picture: ImageBitmap): void {
    ++this.asked.texture
    if (changePicture(this.pictures.texture, picture)) this.draw()
    else this.setPicture('texture', decodedTexture(picture))
  }

  /** Textures by name, for blendTextures. */
  async loadBlends(urls: Map<string, string>): Promise<void> {
    const asked = ++this.asked.blends
    const load = async ([name, url]: [string, string]) => [name, await loadedTexture(url)] as const
    const loaded = await Promise.all([...urls].map(load))
    if (asked !== this.asked.blends) return loaded.forEach(([, texture]) => texture.dispose())
    for (const texture of this.blends.values()) texture.dispose()
    this.blends = new Map(loaded)
    // Now, and not with the first picture that shows them: that would come late.
    for (const texture of this.blends.values()) this.renderer.initTexture(texture)
  }

  /** Shows a share of the second texture over the first; one that is not loaded is left out. */
  blendTextures(first: string, second: string, share: number): void {
    const under = this.blends.get(first) ?? this.pictures.texture
    this.shown?.blend(under, this.blends.get(second) ?? this.pictures.texture, share)
    this.draw()
  }

  /**
   * A picture of values in the mesh's layout, for the look 'confidence', in the scale's colours.
   */
  async loadConfidence(url: string): Promise<GreyPicture> {
    const asked = ++this.asked.confidence
    const { texture, grey } = await scalePicture(url)
    if (asked === this.asked.confidence) this.setPicture('confidence', texture)
    else texture.dispose()
    return grey
  }

  private setPicture(name: keyof Pictures, texture: Pictures['texture']): void {
    this.pictures[name]?.dispose()
    this.pictures[name] = texture
    this.shown?.showPictures()
    this.draw()
  }

  /** Moves the vertices of the shown mesh; faces and layout stay. `normals`: shade again. */
  setPositions(positions: Float32Array, normals = true): void {
    this.shown?.setPositions(positions, normals)
    this.draw()
  }

  /**
   * Says that many pictures will follow, one each `budget_ms`, and draws the first; settles when it
   * is on the screen, so that a clock may begin.
   */
  runUp(budget_ms: number): Promise<void> {
    return this.pace.runUp(budget_ms)
  }

  /** The end of runUp: all pixels again. */
  comeToRest(): void {
    this.pace.comeToRest()
  }

  /** Other meshes over the first one, see-through: onion skin. */
  setGhosts(ghosts: { positions: Float32Array; color: string }[]): void {
    for (const old of [...this.extras.children].filter((one) => one.name === 'ghost')) {
      ;(old as Mesh).geometry.dispose()
      this.extras.remove(old)
    }
    for (const ghost of ghosts)
      if (this.shown)
        this.extras.add(ghostOf(ghost.positions, this.shown.data.indices, ghost.color))
    this.draw()
  }

  /** Small frustums where the photographs were taken. */
  showCameras(cameras: CameraView[], chosen = ''): void {
    const old = this.extras.getObjectByName('cameras')
    if (old) this.extras.remove(old)
    if (cameras.length > 0) this.extras.add(frustumsOf(cameras, chosen, 0.07 * this.size))
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
    // The principal point need not be the middle: the window moves off it, in the photograph's
    // pixels.
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
    this.setTurn(fromTheFront())
  }

  setMarkers(markers: Marker[]): void {
    this.markers.set(markers)
    this.draw()
  }

  /** Moves one marker, for a drag; the others stay as they are. */
  moveMarker(name: string, place: [number, number, number]): void {
    this.markers.move(name, place)
    this.draw()
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
    const start = performance.now()
    const hit = this.shown?.hit(this.rayAt(x, y))
    return hit ? { ...hit, ms: performance.now() - start } : null
  }

  /** The place of a pick on the shown mesh. */
  placeOf(face: number, barycentric: number[]): [number, number, number] {
    return this.shown?.placeOf(face, barycentric) ?? [0, 0, 0]
  }

  /** How long a share of the size is on the screen, at a place [px]. */
  pixelsOf(share: number, place: [number, number, number]): number {
    const away = this.camera.position.distanceTo(new Vector3(...place))
    const high = 2 * away * Math.tan((this.camera.fov * Math.PI) / 360)
    return (share * this.size * this.host.clientHeight) / high
  }

  /** Vertices within `radius` (share of the size) of a place, with their distance over it. */
  verticesNear(place: [number, number, number], radius: number): { vertex: number; at: number }[] {
    return this.shown?.verticesNear(place, radius * this.size) ?? []
  }

  draw(): void {
    // Also for the second change in a frame: a linked view must not stay behind.
    if (this.turning) this.onTurn?.(this.turn())
    this.pace.ask()
  }

  private screen(): Screen {
    return {
      camera: this.camera,
      width: this.host.clientWidth,
      height: this.host.clientHeight,
      isHidden: (place) => this.isHidden(place),
    }
  }

  /** True if the surface lies between the camera and the place. */
  isHidden(place: Vector3 | [number, number, number]): boolean {
    const surface = this.shown?.object
    if (!(surface instanceof Mesh)) return false
    const at = place instanceof Vector3 ? place : new Vector3(...place)
    const towards = at.clone().sub(this.camera.position)
    const away = towards.length()
    const ray = new Raycaster(this.camera.position, towards.normalize(), 0, away - 0.01 * this.size)
    ray.firstHitOnly = true
    return ray.intersectObject(surface, false).length > 0
  }

  private clear(): void {
    if (!this.shown) return
    this.scene.remove(this.shown.object)
    this.shown.dispose()
    this.shown = null
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

  private markerAt(x: number, y: number): string {
    const box = this.renderer.domElement.getBoundingClientRect()
    return this.markers.at(x - box.left, y - box.top, this.screen())
  }

  private readonly down = (event: PointerEvent) => {
    if (event.button !== 0) return
    this.pressed = { x: event.clientX, y: event.clientY }
    if (this.onMarkerDrag || this.onMarker)
      this.dragged = this.markerAt(event.clientX, event.clientY)
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
    const next = turnedByKey(this.turn(), event.key)
    if (!next) return
    event.preventDefault()
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
