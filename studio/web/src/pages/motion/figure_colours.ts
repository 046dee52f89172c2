// Keeps the figure's colours in step with the frames: a smaller texture while it plays, the whole one
// once it rests. Draws through what the viewer offers, so that it can be tested without one.
import type { FrameColours } from '../../api'
import type { Look } from '../../view/surface'
import { otherWords, playedTextures, restedTexture, videoWords } from './colours'
import type { Colours, Size } from './colours'
import { TextureTrack } from './texture_track'
import type { Found } from './texture_track'

/** What is asked of the viewer. */
export interface Canvas<Picture> {
  setLook(look: Look): void
  loadTexture(url: string): Promise<void>
  /** Shows a decoded texture; the caller keeps it until it has shown the next. */
  showTexture(picture: Picture): void
}

export interface TextureSource<Picture> {
  colours: FrameColours
  frames: number
  byProcessor: boolean
  ownUrl: string
  /** One texture of the video, decoded. */
  load: (frame: number, size: Size) => Promise<Picture>
  free: (picture: Picture) => void
  complain: (error: unknown) => void
  /** Tells in words what is shown. */
  tell: (words: string) => void
}

/** While it plays, a texture that is so late is shown rather than none [frames]. */
const kLate = 12
/** Textures that are there before a clock begins, and how long that may take [ms]. */
const kBefore = 8
const kBefore_ms = 2000
/** Where the playhead stands so long, it rests [ms]. */
const kRest_ms = 300

const wait = (ms: number) => new Promise((go) => setTimeout(go, ms))

export class FigureColours<Picture> {
  private kind: Colours = 'grey'
  private track: TextureTrack<Picture> | null = null
  private played: Size = { width: 0, height: 0 }
  private whole: Found<Picture> | null = null
  private frame = 0
  private playing = false
  private texture = -1
  private size: Size = { width: 0, height: 0 }
  private resting: ReturnType<typeof setTimeout> | undefined
  private ended = false

  constructor(
    private readonly canvas: Canvas<Picture>,
    private readonly source: TextureSource<Picture>,
  ) {}

  /** Grey stays until the first colours are there. */
  async choose(kind: Colours): Promise<void> {
    this.kind = kind
    this.texture = -1
    if (kind === 'video') return this.showVideo()
    const { colours, ownUrl } = this.source
    if (kind === 'own' && colours.own === 'texture') await this.canvas.loadTexture(ownUrl)
    if (this.ended) return
    // Another choice came meanwhile; what was loaded lies on the figure now.
    if (this.kind === 'video') return this.choose('video')
    if (this.kind !== kind) return
    this.dropWhole()
    const own = colours.own === 'texture' ? 'texture' : 'colors'
    this.canvas.setLook(kind === 'own' ? own : 'plain')
    this.tell()
  }

  /** The playhead is at a frame now. */
  show(frame: number, playing: boolean): void {
    this.frame = frame
    this.playing = playing
    if (this.kind === 'video') this.showVideo()
  }

  /** Settles when playing can begin with colours in step, or when waiting takes too long. */
  async beforeStart(): Promise<void> {
    if (this.kind !== 'video' || !this.track) return
    await Promise.race([this.track.ready(this.frame, kBefore), wait(kBefore_ms)])
  }

  end(): void {
    this.ended = true
    clearTimeout(this.resting)
    this.track?.end()
    this.dropWhole()
  }

  private showVideo(): void {
    clearTimeout(this.resting)
    if (!this.playing) this.resting = setTimeout(() => void this.rest(), kRest_ms)
    if (this.whole?.frame === this.frame && this.texture === this.frame && !this.playing) return
    const found = this.textures().want(this.frame, this.playing ? kLate : 0)
    if (found) this.put(found, this.played)
    this.tell()
  }

  private textures(): TextureTrack<Picture> {
    if (this.track) return this.track
    const { colours, frames, byProcessor, load, free, complain } = this.source
    const played = playedTextures(colours.video!, frames, byProcessor)
    this.played = { width: played.width, height: played.height }
    this.track = new TextureTrack(
      frames,
      (frame) => load(frame, this.played),
      free,
      { most: played.most, atOnce: 3 },
      (frame) => {
        const waited = frame === this.frame && this.texture !== frame
        if (this.kind === 'video' && waited) this.showVideo()
      },
      complain,
    )
    return this.track
  }

  private put(found: Found<Picture>, size: Size): void {
    const first = this.texture < 0
    this.texture = found.frame
    this.size = size
    this.canvas.showTexture(found.picture)
    if (first) this.canvas.setLook('texture')
    if (found !== this.whole) this.dropWhole()
  }

  /** All pixels of the frame at which the playhead rests. */
  private async rest(): Promise<void> {
    const { frame } = this
    const asked = () => !this.ended && !this.playing && this.kind === 'video' && this.frame === frame
    if (!asked() || this.whole?.frame === frame) return
    const size = restedTexture(this.source.colours.video!)
    if (size.width <= this.played.width) return
    try {
      const picture = await this.source.load(frame, size)
      if (!asked()) return this.source.free(picture)
      const before = this.whole
      this.whole = { frame, picture }
      this.put(this.whole, size)
      if (before) this.source.free(before.picture)
      this.tell()
    } catch (error) {
      if (!this.ended) this.source.complain(error)
    }
  }

  private dropWhole(): void {
    if (this.whole) this.source.free(this.whole.picture)
    this.whole = null
  }

  private tell(): void {
    const { kind, texture, playing, size, frame } = this
    const { colours, tell } = this.source
    if (kind !== 'video') return tell(otherWords(colours, kind))
    tell(videoWords({ texture, playing, ...size }, frame))
  }
}
