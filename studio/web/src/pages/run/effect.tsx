// What a change of an option has set off, and the way back.
import { useState } from 'preact/hooks'

import { Icon } from './icons'
import { useSetOption } from './option_form'
import type { Change } from './option_form'

/** What the last change of an option has set off; stays in view below the options. */
export function Effect(props: { change: Change; text: string; dismiss: () => void }) {
  const { change, dismiss } = props
  const [busy, setBusy] = useState(false)
  const setOption = useSetOption()
  const undo = async () => {
    const { step, pose, option, before } = change
    setBusy(true)
    if (await setOption({ step, pose, option, value: before })) dismiss()
    setBusy(false)
  }
  return (
    <div class="run-effect" role="status">
      <p>
        <b>{change.option.replaceAll('_', ' ')}</b> <s>{change.from || 'empty'}</s>{' '}
        <Icon name="arrow" /> <b>{change.to || 'empty'}</b>
        {change.pose && <span class="soft"> for {change.pose}</span>}
      </p>
      <p>{props.text}.</p>
      <div class="row">
        <button disabled={busy} onClick={() => void undo()}>
          Undo
        </button>
        <button class="quiet" onClick={dismiss}>
          Keep
        </button>
      </div>
    </div>
  )
}
