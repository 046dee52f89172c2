// Masks as they come from the server: decoded for the brush, and small for the contact sheet.
import { api, ApiError } from '../../api'

interface Fetched {
  picture: ImageBitmap
  /** sent back with a change of it */
  revision: string
}

/** The mask's picture, or null where there is none yet. */
async function fetchMask(pose: string, name: string): Promise<Fetched | null> {
  // The address stays the same when the mask changes, so the browser has to ask each time.
  const answer = await fetch(api.maskUrl(pose, name), {
    cache: 'no-cache',
    headers: { 'X-Keypose': '1' },
  })
  if (answer.status === 404) return null
  if (!answer.ok) throw new ApiError(answer.status, `The mask of ${name} cannot be read`)
  const picture = await createImageBitmap(await answer.blob(), {
    colorSpaceConversion: 'none',
    premultiplyAlpha: 'none',
  })
  return { picture, revision: answer.headers.get('ETag') ?? '' }
}

function pixelsOf(picture: ImageBitmap, width: number, height: number): ImageData {
  const canvas = new OffscreenCanvas(width, height)
  const context = canvas.getContext('2d', { willReadFrequently: true })!
  context.drawImage(picture, 0, 0, width, height)
  return context.getImageData(0, 0, width, height)
}

/** The mask’s values in the photograph’s pixels, and its revision; null: there is none yet. */
export async function loadMask(
  pose: string,
  name: string,
  width: number,
  height: number,
): Promise<{ values: Uint8Array; revision: string } | null> {
  const fetched = await fetchMask(pose, name)
  if (!fetched) return null
  const { picture, revision } = fetched
  const pixels = pixelsOf(picture, width, height).data
  picture.close()
  const values = new Uint8Array(width * height)
  for (let i = 0; i < values.length; ++i) values[i] = pixels[4 * i]
  return { values, revision }
}

/** Few at a time: each is decoded at its full size before it becomes small. */
const kAtOnce = 2
let busy = 0
const waiting: (() => void)[] = []

async function inTurn<T>(work: () => Promise<T>): Promise<T> {
  if (busy >= kAtOnce) await new Promise<void>((go) => waiting.push(go))
  ++busy
  try {
    return await work()
  } finally {
    --busy
    waiting.shift()?.()
  }
}

/** Draws a veil over all that is not the figure. `wanted` says whether it is still on the page. */
export async function drawVeil(
  canvas: HTMLCanvasElement,
  pose: string,
  name: string,
  wanted: () => boolean,
): Promise<void> {
  await inTurn(async () => {
    if (!wanted()) return
    const fetched = await fetchMask(pose, name).catch(() => null)
    if (!fetched || !wanted()) return
    const { picture } = fetched
    const width = 320
    const height = Math.max(1, Math.round((width * picture.height) / picture.width))
    const pixels = pixelsOf(picture, width, height)
    picture.close()
    for (let i = 0; i < pixels.data.length; i += 4) {
      pixels.data[i + 3] = 255 - pixels.data[i]
      pixels.data[i] = pixels.data[i + 1] = pixels.data[i + 2] = 0
    }
    canvas.width = width
    canvas.height = height
    canvas.getContext('2d')!.putImageData(pixels, 0, 0)
  })
}

/** The photograph at its full size. */
export async function loadPhotograph(
  pose: string,
  name: string,
  version: string,
): Promise<ImageBitmap> {
  const answer = await fetch(api.photoUrl(pose, name, 0, false, version), { headers: { 'X-Keypose': '1' } })
  if (!answer.ok) throw new ApiError(answer.status, `${name} cannot be read`)
  return createImageBitmap(await answer.blob())
}
