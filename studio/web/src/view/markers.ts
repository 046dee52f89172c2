// Markers on a surface: balls with their names, of one size on the screen.
import {
  BackSide,
  CanvasTexture,
  Group,
  LinearFilter,
  Mesh,
  MeshBasicMaterial,
  SphereGeometry,
  Sprite,
  SpriteMaterial,
  SRGBColorSpace,
} from 'three'
import type { PerspectiveCamera, Vector3 } from 'three'

export interface Marker {
  name: string
  place: [number, number, number]
  kind: 'landmark' | 'chosen' | 'suggested' | 'advice' | 'problem'
  /** instead of its kind's */
  color?: string
}

const kMarkerColors: Record<Marker['kind'], string> = {
  landmark: '#f08a5d',
  chosen: '#ffffff',
  suggested: '#7bb7e8',
  advice: '#c79bf2',
  problem: '#e5484d',
}

/** A ball of a marker on the screen [px], and how far beside it a press still takes it. */
const kBall_px = 5
const kChosenBall_px = 7
const kLabel_px = 20
const kGrasp_px = 5
const kBall = new SphereGeometry(1, 16, 12)
/** A dark rim, as the clay may have the marker's colour. */
const kRim = new MeshBasicMaterial({ color: '#14120f', side: BackSide })

/** Where markers are seen. */
export interface Screen {
  camera: PerspectiveCamera
  width: number
  height: number
  /** whether the surface lies between the camera and the place */
  isHidden: (place: Vector3) => boolean
}

/**
 * Which part of a label lies on its marker, as three.js wants it: from its lower left corner. The
 * label is beside the marker, where there is room, and within the view. All lengths in pixels.
 */
export function anchorOf(
  at: { x: number; y: number },
  label: { width: number; height: number },
  view: { width: number; height: number },
): { x: number; y: number } {
  const within = (value: number, most: number) => Math.min(Math.max(value, 0), Math.max(0, most))
  const roomy = at.x + label.width <= view.width
  const left = within(roomy ? at.x : at.x - label.width, view.width - label.width)
  const top = within(at.y - label.height / 2, view.height - label.height)
  return { x: (at.x - left) / label.width, y: 1 - (at.y - top) / label.height }
}

export class Markers {
  readonly group = new Group()

  set(markers: Marker[]): void {
    this.clear()
    for (const marker of markers) {
      const color = marker.color ?? kMarkerColors[marker.kind]
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
        this.group.add(one)
      }
    }
  }

  move(name: string, place: [number, number, number]): void {
    for (const one of this.group.children)
      if (one.userData.marker === name) one.position.set(...place)
  }

  clear(): void {
    for (const one of this.group.children as (Mesh | Sprite)[]) {
      const material = one.material as MeshBasicMaterial | SpriteMaterial
      material.map?.dispose()
      material.dispose()
    }
    this.group.clear()
  }

  /** Before each picture: sizes, and names that are hidden or would be cut at the view's edge. */
  fit(screen: Screen): void {
    const { camera } = screen
    const pixel = (2 * Math.tan((camera.fov * Math.PI) / 360)) / Math.max(1, screen.height)
    for (const one of this.group.children as (Mesh | Sprite)[]) {
      const scale = pixel * one.position.distanceTo(camera.position)
      if (one instanceof Sprite) fitLabel(one, scale, screen)
      else one.scale.setScalar(one.userData.px * scale)
    }
  }

  /** The nearest marker to a point of the view that is not behind the surface, or ''. */
  at(x: number, y: number, screen: Screen): string {
    let best = ''
    let least = Infinity
    for (const ball of this.group.children) {
      if (ball.name === '') continue
      const seen = pixelOf(ball.position, screen)
      const away = Math.hypot(x - seen.x, y - seen.y)
      const within = away <= ball.userData.px + kGrasp_px && away < least
      if (!within || screen.isHidden(ball.position)) continue
      best = ball.name
      least = away
    }
    return best
  }
}

function pixelOf(place: Vector3, screen: Screen): { x: number; y: number } {
  const seen = place.clone().project(screen.camera)
  return { x: ((1 + seen.x) / 2) * screen.width, y: ((1 - seen.y) / 2) * screen.height }
}

/** Names behind the surface go, but for the chosen one. */
function fitLabel(label: Sprite, scale: number, screen: Screen): void {
  const hidden = screen.isHidden(label.position)
  label.visible = !hidden || label.userData.chosen
  label.material.opacity = hidden ? 0.5 : 1
  const width = label.userData.ratio * kLabel_px
  label.scale.set(width * scale, kLabel_px * scale, 1)
  const size = { width, height: kLabel_px }
  const anchor = anchorOf(pixelOf(label.position, screen), size, screen)
  label.center.set(anchor.x, anchor.y)
}

/** A name beside its marker, as a picture that always faces the person. */
function labelOf(text: string, color: string): Sprite {
  const kMargin = 22
  const kFont = '600 26px sans-serif'
  const canvas = document.createElement('canvas')
  const context = canvas.getContext('2d')!
  context.font = kFont
  canvas.width = Math.ceil(context.measureText(text).width) + 2 * kMargin + 20
  canvas.height = 40
  context.font = kFont
  context.fillStyle = 'rgba(20,18,15,0.78)'
  context.beginPath()
  context.roundRect(kMargin, 2, canvas.width - 2 * kMargin, 36, 8)
  context.fill()
  context.fillStyle = color
  context.fillText(text, kMargin + 10, 30)
  const picture = new CanvasTexture(canvas)
  picture.colorSpace = SRGBColorSpace
  picture.minFilter = LinearFilter
  picture.generateMipmaps = false
  const label = new Sprite(new SpriteMaterial({ map: picture, depthTest: false }))
  label.userData.ratio = canvas.width / canvas.height
  label.raycast = () => undefined
  return label
}
