// What the page says of a registered template's distance to the scan.

/** Both over the diagonal of the pose. */
export interface FitFigures {
  median: number
  most: number
  /** mean distance of the landmarks' pairs; null: no pair */
  pairs?: number | null
}

/** How far the pairs are apart after registration, in the mean; null: there is none. */
export function pairsApart(pairs: { distance: number }[]): number | null {
  const sum = pairs.reduce((all, pair) => all + pair.distance, 0)
  return pairs.length > 0 ? sum / pairs.length : null
}

/** null: no finite distance at all. `most` is the 95 % quantile. */
export function figuresOf(distances: Float32Array): FitFigures | null {
  const sorted = distances.filter(Number.isFinite).sort()
  if (sorted.length === 0) return null
  const last = sorted.length - 1
  const at = (share: number) => sorted[Math.min(last, Math.floor(share * sorted.length))]
  return { median: at(0.5), most: at(0.95) }
}
