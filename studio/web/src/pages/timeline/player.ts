// Plays frames against a clock: which frame is due now is asked at each repaint, so that a slow
// repaint skips frames and never slows the animation down.
import type { Sound } from './sound'

export class Player {
  frame = 0
  playing = false
  /** start again at the end */
  repeat = true
  /** frames that were due and not shown since the last start */
  dropped = 0
  fps = 24
  /** frames that are played */
  length = 1
  /** frames at which the playhead may stand */
  range = 1
  /** Awaited before the clock begins: what shows the frames may get ready. */
  beforeStart: (() => Promise<unknown>) | null = null
  private readonly onFrame = new Set<(frame: number) => void>()
  private readonly onState = new Set<() => void>()
  private anchorTime = 0
  private anchorFrame = 0
  private shown = 0
  private byEar = false

  constructor(private readonly sound: Sound) {}

  /** Calls back at each new frame; returns the way to end that. */
  watch(callback: (frame: number) => void): () => void {
    this.onFrame.add(callback)
    return () => this.onFrame.delete(callback)
  }

  /** Calls back when playing begins or ends, and when frames drop. */
  watchState(callback: () => void): () => void {
    this.onState.add(callback)
    return () => this.onState.delete(callback)
  }

  /** Puts the playhead somewhere; `listen` lets a moment of the sound be heard. */
  seek(frame: number, listen = false): void {
    const target = Math.min(this.range - 1, Math.max(0, Math.round(frame)))
    if (this.playing) {
      this.set(target)
      return this.anchor(target)
    }
    if (target === this.frame) return
    this.set(target)
    if (listen) this.sound.snippet(target / this.fps)
  }

  async play(): Promise<void> {
    if (this.playing || this.length < 2) return
    this.playing = true
    this.dropped = 0
    this.tellState()
    // From the end there is nothing to play.
    if (this.frame >= this.length - 1) this.set(0)
    await Promise.all([this.sound.wake(), this.beforeStart?.()])
    if (!this.playing) return
    this.anchor(this.frame)
    requestAnimationFrame(this.tick)
  }

  pause(): void {
    if (!this.playing) return
    this.playing = false
    this.sound.stop()
    this.tellState()
  }

  toggle(): void {
    if (this.playing) this.pause()
    else void this.play()
  }

  /** Time counts from here on; with sound, the sound is the clock. */
  private anchor(frame: number): void {
    const began = this.sound.start(frame / this.fps)
    this.byEar = began !== null
    this.anchorTime = began ?? this.now()
    this.anchorFrame = frame
    this.shown = frame
  }

  private now(): number {
    return this.byEar ? this.sound.now() : performance.now() / 1000
  }

  private readonly tick = () => {
    if (!this.playing) return
    requestAnimationFrame(this.tick)
    const passed = Math.max(0, this.now() - this.anchorTime)
    const due = this.anchorFrame + Math.floor(passed * this.fps + 1e-4)
    if (due <= this.shown) return
    if (due > this.shown + 1) {
      this.dropped += due - this.shown - 1
      this.tellState()
    }
    this.shown = due
    if (due < this.length) return this.set(due)
    if (this.repeat) {
      const over = (due - this.anchorFrame) / this.fps
      const frame = due % this.length
      this.set(frame)
      const began = this.anchorTime + over
      this.anchor(frame)
      // The part of the first frame that has passed already counts, or each round would be longer.
      if (!this.byEar) this.anchorTime = began
    } else {
      this.set(this.length - 1)
      this.pause()
    }
  }

  private set(frame: number): void {
    this.frame = frame
    for (const callback of this.onFrame) callback(frame)
  }

  private tellState(): void {
    for (const callback of this.onState) callback()
  }
}
