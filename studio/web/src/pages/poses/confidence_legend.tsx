// What the colours of the look 'confidence' mean, and how much of the surface is seen how well.
import { kScaleGradient } from '../../view/colors'
import { percent } from '../../words'

export const kConfidenceBins = 64
/** Up to here a texel is a guess rather than an observation, as a share of the scale. */
const kPoor = 0.25

/** "8 % of the surface is seen badly, 2 % not at all: its colour is made up." */
export function confidenceWords(bins: number[]): string {
  const none = bins[0]
  const poor = bins.slice(1, Math.round(kPoor * bins.length)).reduce((sum, one) => sum + one, 0)
  if (none < 0.0005 && poor < 0.0005) return 'Photographs show all of the surface well.'
  const parts = [`Photographs show ${percent(poor, 1)} of the surface badly`]
  if (none >= 0.0005) parts.push(`${percent(none, 1)} not at all: its colour is made up`)
  return `${parts.join(', ')}.`
}

export function ConfidenceLegend({ bins }: { bins: number[] }) {
  const highest = Math.max(...bins) || 1
  return (
    <figure class="legend card">
      <figcaption>How well photographs show it</figcaption>
      <svg viewBox={`0 0 ${bins.length} 20`} preserveAspectRatio="none" aria-hidden="true">
        {bins.map((share, i) => {
          const height = (20 * share) / highest
          return <rect key={i} x={i} width={0.9} y={20 - height} height={height} />
        })}
      </svg>
      <div class="scale" style={{ background: kScaleGradient }} />
      <div class="ends small soft">
        <span>made up</span>
        <span>badly</span>
        <span>well</span>
      </div>
      <p class="small">{confidenceWords(bins)}</p>
    </figure>
  )
}
