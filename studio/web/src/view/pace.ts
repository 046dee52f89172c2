// When a view is drawn, and with how many pixels: at most once for each repaint, with fewer while it
// moves, with all of them once it rests.
import type { WebGLRenderer } from 'three'

import { Detail, drawnByProcessor } from './detail'

/** Pictures that follow each other faster than this are a movement; it ends after a rest [ms]. */
const kMoving_ms = 120
const kRest_ms = 220
/** There is so much time for a picture while the view is turned [ms]. */
const kTurning_ms = 1000 / 24
/** Pixels for one of the screen, along each side, where the processor draws what stands still. */
const kStill = 1.5
/** Pictures before a clock begins: buffers of another size are made with the first. */
const kRunUpPictures = 3

export class Pace {
  private readonly byProcessor = drawnByProcessor()
  private readonly detail = new Detail(this.byProcessor)
  /** time that there is for a picture while it moves [ms]; playing sets it */
  private budget_ms = kTurning_ms
  private wanted = false
  private moves = false
  private lastDrawn = -Infinity
  private drawing = 0
  private resting = 0

  /** @param paint  draws, now */
  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly paint: () => void,
  ) {
    this.usePixels()
  }

  dispose(): void {
    clearTimeout(this.resting)
    cancelAnimationFrame(this.drawing)
  }

  /** Draws with the next repaint. */
  ask(): void {
    if (this.wanted) return
    this.wanted = true
    this.drawing = requestAnimationFrame((now) => {
      this.wanted = false
      if (now - this.lastDrawn < kMoving_ms) this.moves = true
      this.lastDrawn = now
      this.drawNow()
      if (!this.moves) return
      clearTimeout(this.resting)
      this.resting = window.setTimeout(() => this.rest(), kRest_ms)
      requestAnimationFrame((next) => this.note(next - now))
    })
  }

  /** As Viewer.runUp. */
  async runUp(budget_ms: number): Promise<void> {
    this.budget_ms = budget_ms
    this.moves = true
    for (let i = 0; i < kRunUpPictures; ++i) {
      this.ask()
      await new Promise(requestAnimationFrame)
    }
  }

  comeToRest(): void {
    this.budget_ms = kTurning_ms
    this.rest()
  }

  private drawNow(): void {
    // Here and not before: the canvas is empty once its size has changed.
    this.usePixels()
    this.paint()
  }

  /** A slow picture keeps the next repaint waiting: that is what it cost. */
  private note(cost_ms: number): void {
    if (this.moves) this.detail.note(cost_ms, this.budget_ms)
  }

  private rest(): void {
    clearTimeout(this.resting)
    if (!this.moves) return
    this.moves = false
    this.detail.forget()
    // Not by ask(), which would take it for a movement that goes on.
    this.drawNow()
  }

  /** Without multisampling, what stands still gets more pixels than the screen has. */
  private usePixels(): void {
    const screen = Math.min(2, window.devicePixelRatio)
    const whole = this.byProcessor ? Math.max(kStill, screen) : screen
    const ratio = this.moves ? this.detail.share * screen : whole
    if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio)
  }
}
