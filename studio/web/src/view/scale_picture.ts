// Pictures of values in a mesh's layout, in the colours of the scale.
import { CanvasTexture, SRGBColorSpace } from 'three'

import { scaleColor } from './colors'
import type { MeshData } from './mesh_data'

export interface GreyPicture {
  width: number
  height: number
  /** row by row from the top, 0 to 255 */
  values: Uint8Array
}

/** The levels of RGBA bytes; the bytes become the scale's colours. */
export function inScaleColors(pixels: Uint8ClampedArray): Uint8Array {
  const colors = Array.from({ length: 256 }, (_, level) =>
    scaleColor(level / 255).map((part) => Math.round(255 * part)),
  )
  const levels = new Uint8Array(pixels.length / 4)
  for (let i = 0; i < levels.length; ++i) {
    levels[i] = pixels[4 * i]
    for (let k = 0; k < 3; ++k) pixels[4 * i + k] = colors[levels[i]][k]
  }
  return levels
}

/** The picture at an address; black becomes the low end of the scale, white the high one. */
export async function scalePicture(url: string) {
  const image = new Image()
  image.src = url
  await image.decode()
  const canvas = document.createElement('canvas')
  const { naturalWidth: width, naturalHeight: height } = image
  canvas.width = width
  canvas.height = height
  const context = canvas.getContext('2d', { willReadFrequently: true })!
  context.drawImage(image, 0, 0)
  const picture = context.getImageData(0, 0, width, height)
  const grey: GreyPicture = { width, height, values: inScaleColors(picture.data) }
  context.putImageData(picture, 0, 0)
  const texture = new CanvasTexture(canvas)
  texture.colorSpace = SRGBColorSpace
  texture.anisotropy = 4
  return { texture, grey }
}

/** The share of the surface in each of `bins` equal parts of the scale, by the faces' middles. */
export function areaByLevel(data: MeshData, grey: GreyPicture, bins: number): number[] {
  const areas = new Array<number>(bins).fill(0)
  const { positions: p, indices, uvs } = data
  for (let face = 0; uvs && face < data.faces; ++face) {
    const [a, b, c] = [0, 1, 2].map((k) => 3 * indices[3 * face + k])
    const side = (to: number, k: number) => p[to + k] - p[a + k]
    const area = Math.hypot(
      side(b, 1) * side(c, 2) - side(b, 2) * side(c, 1),
      side(b, 2) * side(c, 0) - side(b, 0) * side(c, 2),
      side(b, 0) * side(c, 1) - side(b, 1) * side(c, 0),
    )
    const uv = (corner: number, k: number) => uvs[6 * face + 2 * corner + k]
    const middle = (k: number) => (uv(0, k) + uv(1, k) + uv(2, k)) / 3
    const column = Math.min(grey.width - 1, Math.max(0, Math.floor(middle(0) * grey.width)))
    const row = Math.min(grey.height - 1, Math.max(0, Math.floor((1 - middle(1)) * grey.height)))
    const level = grey.values[row * grey.width + column]
    areas[Math.min(bins - 1, Math.floor((level * bins) / 256))] += area
  }
  const all = areas.reduce((sum, one) => sum + one, 0) || 1
  return areas.map((area) => area / all)
}
