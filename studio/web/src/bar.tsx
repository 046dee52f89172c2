// How far something is.
import { cssShare } from './words'

/** `label`: for those who do not see it; '' where words beside it say the same. */
export function Bar({ share, label = '' }: { share: number; label?: string }) {
  const fill = <div style={{ width: cssShare(share) }} />
  if (!label)
    return (
      <div class="bar" aria-hidden="true">
        {fill}
      </div>
    )
  return (
    <div
      class="bar"
      role="progressbar"
      aria-label={label}
      aria-valuemin={0}
      aria-valuemax={100}
      aria-valuenow={Math.round(100 * share)}
    >
      {fill}
    </div>
  )
}
