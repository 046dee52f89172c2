// What a live picture tells of light and focus: histogram, clipped places, sharpness. No drawing on
// the page here, so it can be tested alone. Pixels are RGBA, 8 bits, as a canvas gives them.

export const kBins = 64
/** From here on nothing is told apart any more. */
export const kWhite = 253
export const kBlack = 2

export interface Histogram {
  /** of each channel, the share of the pixels in each of kBins, dark to light */
  channels: [number[], number[], number[]]
  /** share of the pixels with a channel at its end */
  white: number
  /** share of the pixels with all channels at their beginning */
  black: number
}

const isWhite = (r: number, g: number, b: number) => Math.max(r, g, b) >= kWhite
const isBlack = (r: number, g: number, b: number) => Math.max(r, g, b) <= kBlack

/** @param step  only each of so many pixels is counted */
export function histogramOf(pixels: ArrayLike<number>, step = 1): Histogram {
  const counts = [0, 1, 2].map(() => new Array<number>(kBins).fill(0))
  let white = 0
  let black = 0
  let all = 0
  for (let i = 0; i + 3 < pixels.length; i += 4 * step) {
    const [r, g, b] = [pixels[i], pixels[i + 1], pixels[i + 2]]
    ++counts[0][(r * kBins) >> 8]
    ++counts[1][(g * kBins) >> 8]
    ++counts[2][(b * kBins) >> 8]
    if (isWhite(r, g, b)) ++white
    if (isBlack(r, g, b)) ++black
    ++all
  }
  const shares = counts.map((channel) => channel.map((count) => count / Math.max(1, all)))
  return {
    channels: shares as Histogram['channels'],
    white: white / Math.max(1, all),
    black: black / Math.max(1, all),
  }
}

/** Stripes over what is clipped: red where too light, blue where too dark; the rest is clear. */
export function clippingOf(pixels: ArrayLike<number>, width: number): Uint8ClampedArray<ArrayBuffer> {
  const veil = new Uint8ClampedArray(pixels.length)
  for (let i = 0; i + 3 < pixels.length; i += 4) {
    const [r, g, b] = [pixels[i], pixels[i + 1], pixels[i + 2]]
    const light = isWhite(r, g, b)
    if (!light && !isBlack(r, g, b)) continue
    const x = (i / 4) % width
    const y = Math.floor(i / 4 / width)
    const stripe = (x + y) % 12 < 6
    veil[i] = light ? 230 : 40
    veil[i + 1] = light ? 30 : 90
    veil[i + 2] = light ? 40 : 240
    veil[i + 3] = stripe ? 235 : 90
  }
  return veil
}

/**
 * How sharp a part is: the mean square of the Laplacian of its brightness, over its variance, so that
 * more light or contrast alone changes nothing. 0 where nothing is to be seen.
 */
export function sharpnessOf(pixels: ArrayLike<number>, width: number, height: number): number {
  const at = (x: number, y: number) => {
    const i = 4 * (y * width + x)
    return 0.299 * pixels[i] + 0.587 * pixels[i + 1] + 0.114 * pixels[i + 2]
  }
  let sum = 0
  let squares = 0
  let edges = 0
  let all = 0
  for (let y = 1; y + 1 < height; ++y)
    for (let x = 1; x + 1 < width; ++x) {
      const here = at(x, y)
      const laplacian = 4 * here - at(x - 1, y) - at(x + 1, y) - at(x, y - 1) - at(x, y + 1)
      sum += here
      squares += here * here
      edges += laplacian * laplacian
      ++all
    }
  if (all === 0) return 0
  const variance = squares / all - (sum / all) ** 2
  return variance < 1 ? 0 : edges / all / variance
}

export type Aid = 'guides' | 'safe' | 'clipping' | 'histogram' | 'loupe'
/** In the order of their buttons: words, key, what it shows. */
export const kAids: [Aid, string, string, string][] = [
  ['guides', 'Guides', 'g', 'Thirds and the middle'],
  ['safe', 'Safe frame', 'f', 'What every screen shows: 93 % for what happens, 90 % for words'],
  ['clipping', 'Clipping', 'c', 'Stripes: red is too light, blue too dark to tell anything apart'],
  ['histogram', 'Histogram', 'h', 'How much of the picture is dark and light'],
  ['loupe', 'Loupe', 'z', 'Four times larger under the pointer, with how sharp that is'],
]
