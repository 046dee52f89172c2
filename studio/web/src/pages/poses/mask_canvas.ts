// Draws a photograph and its mask, zoomed and moved. Two canvases lie on each other: the photograph
// is drawn when the view moves, the mask over it in the part that a stroke has touched.
import { cssColor } from '../../css_color'
import type { MaskModel, Point, Rect } from './mask_model'
import { union } from './mask_model'

export type MaskLook = 'tint' | 'outline' | 'figure'

const kTint = 'rgb(196 58 24 / 52%)'
const kOutline = '#ff6a2b'
const kMostZoom = 32

export class MaskCanvas {
  look: MaskLook = 'tint'
  /** Called when the zoom has changed. */
  onView: (() => void) | null = null

  /** CSS pixels for a photograph's pixel, and where its corner lies */
  private scale = 1
  private corner: Point = { x: 0, y: 0 }
  private fitted = true
  /** the mask as opacity: what the drawing cuts out */
  private readonly shape = document.createElement('canvas')
  private readonly scratch = document.createElement('canvas')
  /** the photograph, then each half the size of the one before */
  private readonly pyramid: ImageBitmap[]
  private stale: Rect | null = null
  private staleAll = true
  private staleShape: Rect | null = null
  private wanted = 0
  private gone = false

  constructor(
    private readonly below: HTMLCanvasElement,
    private readonly above: HTMLCanvasElement,
    private readonly model: MaskModel,
    photograph: ImageBitmap,
  ) {
    this.pyramid = [photograph]
    this.shape.width = model.width
    this.shape.height = model.height
    this.staleShape = { x: 0, y: 0, width: model.width, height: model.height }
    void this.makePyramid()
  }

  dispose(): void {
    this.gone = true
    cancelAnimationFrame(this.wanted)
    for (const level of this.pyramid) level.close()
    // Gives the memory back at once, not when the collector comes.
    this.shape.width = this.scratch.width = 0
  }

  resize(width: number, height: number): void {
    const ratio = this.ratio()
    for (const canvas of [this.below, this.above, this.scratch]) {
      canvas.width = Math.max(1, Math.round(width * ratio))
      canvas.height = Math.max(1, Math.round(height * ratio))
    }
    if (this.fitted) this.fit()
    this.redraw()
  }

  /** The whole photograph in the window. */
  fit(): void {
    const { width, height } = this.window()
    this.scale = 0.96 * Math.min(width / this.model.width, height / this.model.height)
    this.corner = {
      x: (width - this.scale * this.model.width) / 2,
      y: (height - this.scale * this.model.height) / 2,
    }
    this.fitted = true
    this.redraw()
  }

  zoom(): number {
    return this.scale * this.ratio()
  }

  /** `zoom` 1: a pixel of the photograph is a pixel of the screen. */
  zoomTo(zoom: number, at?: Point): void {
    const { width, height } = this.window()
    const { x, y } = at ?? { x: width / 2, y: height / 2 }
    const least = 0.5 * Math.min(width / this.model.width, height / this.model.height)
    const scale = Math.min(kMostZoom, Math.max(least, zoom / this.ratio()))
    const factor = scale / this.scale
    this.corner = { x: x - factor * (x - this.corner.x), y: y - factor * (y - this.corner.y) }
    this.scale = scale
    this.fitted = false
    this.redraw()
  }

  pan(dx: number, dy: number): void {
    this.corner = { x: this.corner.x + dx, y: this.corner.y + dy }
    this.fitted = false
    this.redraw()
  }

  /** From CSS pixels of the window to pixels of the photograph, and back. */
  toPhotograph(point: Point): Point {
    return { x: (point.x - this.corner.x) / this.scale, y: (point.y - this.corner.y) / this.scale }
  }
  toWindow(point: Point): Point {
    return { x: this.corner.x + this.scale * point.x, y: this.corner.y + this.scale * point.y }
  }
  /** CSS pixels of a length in photograph pixels. */
  length(pixels: number): number {
    return this.scale * pixels
  }

  redraw(): void {
    this.staleAll = true
    this.ask()
    this.onView?.()
  }

  /** The mask has changed in this part. */
  maskChanged(part: Rect | null): void {
    if (!part) return
    this.staleShape = union(this.staleShape, part)
    this.stale = union(this.stale, part)
    this.ask()
  }

  private ratio(): number {
    return Math.min(2, devicePixelRatio)
  }

  private window(): { width: number; height: number } {
    return { width: this.above.width / this.ratio(), height: this.above.height / this.ratio() }
  }

  private ask(): void {
    if (this.wanted || this.gone) return
    this.wanted = requestAnimationFrame(() => {
      this.wanted = 0
      this.draw()
    })
  }

  private draw(): void {
    this.updateShape()
    const whole = { x: 0, y: 0, width: this.above.width, height: this.above.height }
    if (this.staleAll) {
      this.drawPhotograph()
      this.drawMask(whole)
    } else if (this.stale) {
      this.drawMask(this.onScreen(this.stale))
    }
    this.staleAll = false
    this.stale = null
  }

  /** Half-size copies, so that a zoomed-out view reads few pixels and does not flicker. */
  private async makePyramid(): Promise<void> {
    for (let level = this.pyramid[0]; level.width > 1024; ) {
      const half = await createImageBitmap(level, {
        resizeWidth: level.width >> 1,
        resizeHeight: level.height >> 1,
        resizeQuality: 'medium',
      }).catch(() => null)
      if (!half || this.gone) return half?.close()
      this.pyramid.push(half)
      level = half
    }
    this.redraw()
  }

  private updateShape(): void {
    const part = this.staleShape
    this.staleShape = null
    if (!part) return
    const pixels = new ImageData(part.width, part.height)
    const words = new Uint32Array(pixels.data.buffer)
    for (let y = 0; y < part.height; ++y) {
      const from = (part.y + y) * this.model.width + part.x
      const to = y * part.width
      // Little-endian: the highest byte is the opacity.
      for (let x = 0; x < part.width; ++x) words[to + x] = this.model.values[from + x] << 24
    }
    this.shape.getContext('2d')!.putImageData(pixels, part.x, part.y)
  }

  /** Where a part of the photograph lies in the canvas, in whole pixels round it. */
  private onScreen(part: Rect): Rect {
    const ratio = this.ratio()
    const from = this.toWindow(part)
    const margin = 4 * ratio
    const x = Math.max(0, Math.floor(from.x * ratio - margin))
    const y = Math.max(0, Math.floor(from.y * ratio - margin))
    const right = Math.ceil((from.x + this.scale * part.width) * ratio + margin)
    const bottom = Math.ceil((from.y + this.scale * part.height) * ratio + margin)
    return {
      x,
      y,
      width: Math.max(0, Math.min(this.above.width, right) - x),
      height: Math.max(0, Math.min(this.above.height, bottom) - y),
    }
  }

  /** The part of the photograph that a part of the canvas shows, with pixels to smooth with. */
  private source(part: Rect): Rect {
    const ratio = this.ratio()
    const from = this.toPhotograph({ x: part.x / ratio, y: part.y / ratio })
    const step = 2 + 2 / (this.scale * ratio)
    const x = Math.max(0, Math.floor(from.x - step))
    const y = Math.max(0, Math.floor(from.y - step))
    const right = Math.ceil(from.x + part.width / this.scale / ratio + step)
    const bottom = Math.ceil(from.y + part.height / this.scale / ratio + step)
    return {
      x,
      y,
      width: Math.max(0, Math.min(this.model.width, right) - x),
      height: Math.max(0, Math.min(this.model.height, bottom) - y),
    }
  }

  /** Draws what `part` of the canvas shows of a picture of the photograph, of any size. */
  private place(
    context: CanvasRenderingContext2D,
    picture: ImageBitmap | HTMLCanvasElement,
    part: Rect,
  ): void {
    const from = this.source(part)
    if (from.width === 0 || from.height === 0) return
    const ratio = this.ratio()
    const to = this.toWindow(from)
    const across = picture.width / this.model.width
    const down = picture.height / this.model.height
    context.imageSmoothingEnabled = this.zoom() < 3
    context.drawImage(
      picture,
      from.x * across,
      from.y * down,
      from.width * across,
      from.height * down,
      to.x * ratio,
      to.y * ratio,
      from.width * this.scale * ratio,
      from.height * this.scale * ratio,
    )
  }

  private drawPhotograph(): void {
    const context = this.below.getContext('2d')!
    const whole = { x: 0, y: 0, width: this.below.width, height: this.below.height }
    context.clearRect(0, 0, whole.width, whole.height)
    const wanted = this.zoom() * this.model.width
    const enough = this.pyramid.filter((level) => level.width >= wanted)
    this.place(context, enough[enough.length - 1] ?? this.pyramid[0], whole)
  }

  private drawMask(part: Rect): void {
    if (part.width === 0 || part.height === 0) return
    const context = this.above.getContext('2d')!
    context.save()
    context.beginPath()
    context.rect(part.x, part.y, part.width, part.height)
    context.clip()
    context.clearRect(part.x, part.y, part.width, part.height)
    if (this.look === 'outline') this.drawOutline(context, part)
    else this.drawVeil(context, part)
    context.restore()
  }

  /** Colour over the photograph, cut out where the figure is. */
  private drawVeil(context: CanvasRenderingContext2D, part: Rect): void {
    const ratio = this.ratio()
    const paper = cssColor('--sunk')
    context.fillStyle = this.look === 'tint' ? kTint : paper
    context.fillRect(
      this.corner.x * ratio,
      this.corner.y * ratio,
      this.model.width * this.scale * ratio,
      this.model.height * this.scale * ratio,
    )
    context.globalCompositeOperation = 'destination-out'
    this.place(context, this.shape, part)
  }

  /** The shape moved round by a line's width, less the shape: as wide at any zoom. */
  private drawOutline(context: CanvasRenderingContext2D, part: Rect): void {
    const wide = 2 * this.ratio()
    const round = { x: part.x - wide, y: part.y - wide }
    const more = { ...round, width: part.width + 2 * wide, height: part.height + 2 * wide }
    const scratch = this.scratch.getContext('2d')!
    scratch.clearRect(more.x, more.y, more.width, more.height)
    this.place(scratch, this.shape, more)
    for (let k = 0; k < 8; ++k) {
      const angle = (k * Math.PI) / 4
      context.drawImage(this.scratch, wide * Math.cos(angle), wide * Math.sin(angle))
    }
    context.globalCompositeOperation = 'destination-out'
    context.drawImage(this.scratch, 0, 0)
    context.globalCompositeOperation = 'source-in'
    context.fillStyle = kOutline
    context.fillRect(part.x, part.y, part.width, part.height)
  }
}
