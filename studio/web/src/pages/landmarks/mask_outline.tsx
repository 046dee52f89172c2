// The outline of a photograph's mask as a path, to be drawn over the photograph.
import { useEffect, useState } from 'preact/hooks'

import { loadMask } from '../poses/mask_picture'

/** Masks are read at most this wide: an outline over a photograph need not be finer. */
const kWidest = 900

/** Sides of pixels between inside (128 and more) and outside, in pixels of `scale`, as an SVG path. */
export function outlinePath(mask: Uint8Array, width: number, height: number, scale: number): string {
  const parts: string[] = []
  const inside = (x: number, y: number) =>
    x >= 0 && y >= 0 && x < width && y < height && mask[y * width + x] >= 128
  const at = (value: number) => (scale * value).toFixed(1)
  for (let y = 0; y <= height; ++y) {
    let from = -1
    for (let x = 0; x <= width; ++x) {
      const edge = x < width && inside(x, y) !== inside(x, y - 1)
      if (edge && from < 0) from = x
      if (edge || from < 0) continue
      parts.push(`M${at(from)} ${at(y)}H${at(x)}`)
      from = -1
    }
  }
  for (let x = 0; x <= width; ++x) {
    let from = -1
    for (let y = 0; y <= height; ++y) {
      const edge = y < height && inside(x, y) !== inside(x - 1, y)
      if (edge && from < 0) from = y
      if (edge || from < 0) continue
      parts.push(`M${at(x)} ${at(from)}V${at(y)}`)
      from = -1
    }
  }
  return parts.join('')
}

/** '' while it is loaded, and where there is no mask. */
export function useMaskOutline(
  pose: string,
  image: string,
  width: number,
  height: number,
  wanted: boolean,
): string {
  const [path, setPath] = useState({ key: '', path: '' })
  const key = `${pose}/${image}`
  useEffect(() => {
    if (!wanted || width === 0) return
    let current = true
    const small = Math.min(1, kWidest / width)
    const [w, h] = [Math.round(small * width), Math.max(1, Math.round(small * height))]
    loadMask(pose, image, w, h).then(
      (mask) =>
        current && mask && setPath({ key, path: outlinePath(mask.values, w, h, width / w) }),
      () => undefined, // there is nothing to show
    )
    return () => {
      current = false
    }
  }, [key, width, height, wanted])
  return wanted && path.key === key ? path.path : ''
}
