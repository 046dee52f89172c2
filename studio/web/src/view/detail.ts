// How many pixels are drawn while the picture moves: as many as the time between two pictures
// allows. What stands still is drawn with all of them.

/** Shares of the pixels along each side, from which one is taken. */
const kShares = [1, 0.75, 0.5, 0.35, 0.25]
/** Where the processor draws: the share to begin with, and the most that is tried. */
const kFirstByProcessor = 2
const kMostByProcessor = 1
/**
 * Of the time between two pictures: more is too slow, less is quick. At 24 pictures a second and 60
 * repaints, a picture that was there for the next repaint is quick, for the one after that slow.
 */
const kSlow = 0.7
const kQuick = 0.45
/** So many slow pictures one after another lower it; so many quick ones raise it. */
const kSlowPictures = 2
const kQuickPictures = 36
/** Pictures after a change that tell nothing: buffers are made anew. */
const kSettling = 2

/**
 * Where the processor draws (no graphics card), pixels are dear from the first picture on. Such a
 * machine also draws without multisampling, which costs it four times as much: a picture at rest
 * gets more pixels instead.
 */
export class Detail {
  private at: number
  private slow = 0
  private quick = 0
  private settling = kSettling
  /** the largest share that was found too slow, as an index; none again until `forget` */
  private failed: number
  private readonly barred: number

  constructor(drawnByProcessor: boolean) {
    this.at = drawnByProcessor ? kFirstByProcessor : 0
    this.barred = drawnByProcessor ? kMostByProcessor - 1 : -1
    this.failed = this.barred
  }

  get share(): number {
    return kShares[this.at]
  }

  /** Takes what a picture cost, and the time that there is for one [ms]. */
  note(cost_ms: number, budget_ms: number): void {
    if (this.settling > 0) {
      --this.settling
      return
    }
    this.slow = cost_ms > kSlow * budget_ms ? this.slow + 1 : 0
    this.quick = cost_ms < kQuick * budget_ms ? this.quick + 1 : 0
    if (this.slow >= kSlowPictures && this.at + 1 < kShares.length) {
      this.failed = this.at
      this.take(this.at + 1)
    }
    if (this.quick >= kQuickPictures && this.at - 1 > this.failed) this.take(this.at - 1)
  }

  /** After a rest, what was too slow once may be tried again. */
  forget(): void {
    this.failed = this.barred
    this.slow = 0
    this.quick = 0
    this.settling = kSettling
  }

  private take(at: number): void {
    this.at = at
    this.slow = 0
    this.quick = 0
    this.settling = kSettling
  }
}

let known: boolean | null = null

/** True without a graphics card: each pixel then costs the processor's time. */
export function drawnByProcessor(): boolean {
  if (known !== null) return known
  const context = document.createElement('canvas').getContext('webgl2')
  const names = context?.getExtension('WEBGL_debug_renderer_info')
  const name = names ? String(context!.getParameter(names.UNMASKED_RENDERER_WEBGL)) : ''
  context?.getExtension('WEBGL_lose_context')?.loseContext()
  known = /swiftshader|llvmpipe|softpipe|basic render/i.test(name)
  return known
}
