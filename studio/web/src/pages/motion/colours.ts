// Which colours a moving mesh can be shown in, in words, and at what size its textures play.
import type { FrameColours } from '../../api'

export type Colours = 'video' | 'own' | 'grey'

/** In the order in which the first that is there is shown. */
export const kColours: Colours[] = ['video', 'own', 'grey']

export const kNames: Record<Colours, string> = {
  video: 'From the video',
  own: 'Scan’s own',
  grey: 'Grey',
}

export function problemOf(colours: FrameColours, kind: Colours): string {
  if (kind === 'video') return colours.video_problem
  return kind === 'own' ? colours.own_problem : ''
}

const isThere = (colours: FrameColours, kind: Colours): boolean =>
  kind === 'grey' || (kind === 'video' ? colours.video !== null : colours.own !== '')

/** What was asked for, if it is there; else the best that is. */
export function shownColours(colours: FrameColours, wanted: Colours | null): Colours {
  if (wanted && isThere(colours, wanted)) return wanted
  return kColours.find((kind) => isThere(colours, kind))!
}

/** The next that is there, round the end. */
export function nextColours(colours: FrameColours, now: Colours): Colours {
  const there = kColours.filter((kind) => isThere(colours, kind))
  return there[(there.indexOf(now) + 1) % there.length]
}

/** Room for textures that wait decoded [bytes]. */
export const kTextureRoom = 192 * 2 ** 20
/** Widths at which textures play: the first at which all frames fit, else the last [px]. */
const kPlayWidths = [1024, 512]
/** Where the processor draws, a larger one only costs time. */
const kByProcessor = [512]
/** A texture at rest is as large as it was painted, up to this [px]. */
const kRestWidth = 4096

export interface Size {
  width: number
  height: number
}

const bytesOf = ({ width, height }: Size): number => 4 * width * height

function narrowed(size: Size, width: number): Size {
  if (width >= size.width) return size
  return { width, height: Math.max(1, Math.floor((size.height * width) / size.width)) }
}

/** The size at which textures of a performance play, and how many of them are kept. */
export function playedTextures(
  painted: Size,
  frames: number,
  byProcessor: boolean,
): Size & { most: number } {
  const widths = byProcessor ? kByProcessor : kPlayWidths
  const sizes = widths.map((width) => narrowed(painted, width))
  const size = sizes.find((one) => frames * bytesOf(one) <= kTextureRoom) ?? sizes.at(-1)!
  const room = Math.max(2, Math.floor(kTextureRoom / bytesOf(size)))
  return { ...size, most: Math.min(Math.max(2, frames), room) }
}

export const restedTexture = (painted: Size): Size => narrowed(painted, kRestWidth)

/** What of the video is on the figure. */
export interface Showing extends Size {
  /** the frame whose texture it is; -1: none yet */
  texture: number
  playing: boolean
}

/** "From the video: the texture of frame 12, 2048 × 2048" */
export function videoWords(showing: Showing, frame: number): string {
  const { texture, width, height, playing } = showing
  if (texture < 0) return 'From the video: loading…'
  const size = `${width} × ${height}`
  if (texture !== frame)
    return `From the video, ${size}: the texture of frame ${texture}, that of ${frame} is loading`
  if (playing) return `From the video, ${size} while it plays: a texture for each frame`
  return `From the video: the texture of frame ${texture}, ${size}`
}

export function otherWords(colours: FrameColours, kind: Colours): string {
  if (kind === 'grey') return 'Grey: no colours are shown'
  return colours.own === 'texture'
    ? 'The scan’s own texture: the same in all frames'
    : 'The colours of the scan’s vertices: the same in all frames'
}
