// Masks of one's own that were painted over older photographs of the same names.
import { useState } from 'preact/hooks'

import { api } from '../../api'
import { useStudio } from '../../state'

/** `decided`: what was asked for is done. */
export function OlderMasks(props: {
  pose: string
  names: string[]
  disabled?: boolean
  decided?: () => void
}) {
  const { pose, names } = props
  const { tell, complain, reload } = useStudio()
  const [busy, setBusy] = useState(false)
  if (names.length === 0) return null
  const one = names.length === 1
  const decide = async (hold: boolean) => {
    setBusy(true)
    try {
      await api.holdMasks(pose, names, hold)
      const words = one ? `The mask of ${names[0]}` : `${names.length} masks`
      tell(hold ? `${words} will be used.` : `Set aside: ${words}, as .old beside the masks.`)
      await reload()
      props.decided?.()
    } catch (error) {
      complain(error)
    } finally {
      setBusy(false)
    }
  }
  const disabled = busy || (props.disabled ?? false)
  return (
    <section class="older stack" aria-label="Masks of older photographs">
      <p class="small">
        {one
          ? `${names[0]} was shot again after you painted its mask. The mask is not used.`
          : `${names.length} photographs were shot again after you painted their masks. These masks are not used: ${names.join(', ')}.`}
      </p>
      <div class="row">
        <button
          disabled={disabled}
          title="The figure and the camera stand as before"
          onClick={() => void decide(true)}
        >
          {one ? 'It still holds' : 'They still hold'}
        </button>
        <button
          disabled={disabled}
          title="Renamed to .old, nothing is deleted"
          onClick={() => void decide(false)}
        >
          Set aside
        </button>
      </div>
    </section>
  )
}
