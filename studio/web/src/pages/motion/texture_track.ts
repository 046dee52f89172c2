// Textures of frames, fetched ahead of the playhead, of which a bounded number is kept. Knows
// nothing of the page: what a texture is, and how one is loaded, the caller says.

export interface TrackLimits {
  /** textures that are kept at once, at least 2 */
  most: number
  /** loaded at the same time */
  atOnce: number
}

export interface Found<Picture> {
  frame: number
  picture: Picture
}

export class TextureTrack<Picture> {
  private readonly kept = new Map<number, Picture>()
  private readonly loading = new Map<number, Promise<void>>()
  private readonly failed = new Set<number>()
  private at = 0
  /** the one that was given out last; never freed before the next */
  private shown = -1
  /** frames by which the playhead was faster than the last load; fetching begins so far ahead */
  private lead = 0
  private playing = false
  private ended = false

  constructor(
    readonly count: number,
    private readonly load: (frame: number) => Promise<Picture>,
    private readonly free: (picture: Picture) => void,
    private readonly limits: TrackLimits,
    /** a texture came; it may be the one that is waited for */
    private readonly came: (frame: number) => void,
    private readonly complain: (error: unknown) => void,
  ) {}

  get size(): number {
    return this.kept.size
  }

  /**
   * The texture of a frame. While it is not there, while it plays the nearest one of up to `late`
   * frames before it, else null. It and those that follow are fetched.
   */
  want(frame: number, late = 0): Found<Picture> | null {
    this.at = frame
    this.playing = late > 0
    if (!this.playing) this.lead = 0
    this.fetch()
    for (let back = 0; back <= Math.min(late, this.count - 1); ++back) {
      const near = (frame - back + this.count) % this.count
      const picture = this.kept.get(near)
      if (picture === undefined) continue
      this.shown = near
      return { frame: near, picture }
    }
    return null
  }

  /** Settles when a frame and the `more` after it are there, or cannot be had. */
  async ready(frame: number, more: number): Promise<void> {
    this.at = frame
    this.lead = 0
    const wanted = this.order().slice(0, Math.min(more + 1, this.limits.most))
    const missing = () => wanted.filter((one) => !this.kept.has(one) && !this.failed.has(one))
    while (!this.ended && missing().length > 0) {
      this.fetch()
      if (this.loading.size === 0) return
      await Promise.race(this.loading.values())
    }
  }

  end(): void {
    this.ended = true
    for (const picture of this.kept.values()) this.free(picture)
    this.kept.clear()
  }

  private ahead(frame: number, at = this.at): number {
    return (frame - at + this.count) % this.count
  }

  /** From the playhead on, round the end, as many as may be kept. */
  private order(): number[] {
    const from = this.at + this.lead
    const many = Math.min(this.count, this.limits.most - (this.lead > 0 ? 1 : 0))
    return Array.from({ length: many }, (_, i) => (from + i) % this.count)
  }

  private fetch(): void {
    for (const frame of this.order()) {
      if (this.ended || this.loading.size >= this.limits.atOnce) return
      if (this.kept.has(frame) || this.loading.has(frame) || this.failed.has(frame)) continue
      this.loading.set(frame, this.take(frame))
    }
  }

  private async take(frame: number): Promise<void> {
    const asked = this.at
    try {
      const picture = await this.load(frame)
      if (this.ended) return this.free(picture)
      this.kept.set(frame, picture)
      this.measure(this.ahead(this.at, asked) - this.ahead(frame, asked))
      this.tidy()
    } catch (error) {
      this.failed.add(frame)
      if (!this.ended) this.complain(error)
    } finally {
      this.loading.delete(frame)
    }
    if (this.ended) return
    this.came(frame)
    this.fetch()
  }

  /** One that came when the playhead had passed says how far ahead to begin. */
  private measure(late: number): void {
    if (!this.playing) return
    if (late > 0) this.lead = Math.min(late, Math.floor(this.limits.most / 2))
    else if (this.lead > 0) --this.lead
  }

  /** Those go first that the playhead will reach last: it has just passed them. */
  private tidy(): void {
    const byNeed = [...this.kept.keys()].sort((one, two) => this.ahead(one) - this.ahead(two))
    while (this.kept.size > Math.max(2, this.limits.most)) {
      const last = byNeed.pop()!
      if (last === this.shown || last === this.at) continue
      this.free(this.kept.get(last)!)
      this.kept.delete(last)
    }
  }
}
