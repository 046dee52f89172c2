// Colour scales for values on surfaces.

/** Viridis at ten places, read off its published table; [0, 1] each. */
const kStops = [
  [0.267, 0.005, 0.329],
  [0.283, 0.141, 0.458],
  [0.254, 0.265, 0.53],
  [0.207, 0.372, 0.553],
  [0.164, 0.471, 0.558],
  [0.128, 0.567, 0.551],
  [0.135, 0.659, 0.518],
  [0.267, 0.749, 0.441],
  [0.478, 0.821, 0.318],
  [0.741, 0.873, 0.15],
  [0.993, 0.906, 0.144],
]

/** The colour of a value in [0, 1], each channel in [0, 1]. */
export function scaleColor(value: number): [number, number, number] {
  const at = Math.min(1, Math.max(0, value)) * (kStops.length - 1)
  const i = Math.min(kStops.length - 2, Math.floor(at))
  const t = at - i
  const mix = (k: number) => (1 - t) * kStops[i][k] + t * kStops[i + 1][k]
  return [mix(0), mix(1), mix(2)]
}

/** For a legend: a CSS gradient from low to high. */
export const kScaleGradient = `linear-gradient(to right, ${kStops
  .map((stop) => `rgb(${stop.map((part) => Math.round(255 * part)).join(' ')})`)
  .join(', ')})`
