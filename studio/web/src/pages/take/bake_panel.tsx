// A take's frames, made from its curves.
import { useEffect, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { armatureApi } from '../armature/armature_api'
import { BakeChoice } from '../armature/bake_choice'
import type { TakeDesk } from './desk'

export function BakePanel({ desk }: { desk: TakeDesk }) {
  const { follow, tell, complain } = useStudio()
  const [between, setBetween] = useState('hold')
  const [baking, setBaking] = useState(false)
  const [baked, setBaked] = useState('')
  useEffect(
    () =>
      follow((event) => {
        if (event.type !== 'armature_baked') return
        setBaking(false)
        if (event.exit_code !== 0) return complain(event.message)
        setBaked(between)
        tell('The frames are baked.')
      }),
    [follow, tell, complain, between],
  )
  const bake = () => {
    setBaking(true)
    armatureApi.bake(between, desk.name).catch((error: unknown) => {
      setBaking(false)
      complain(error)
    })
  }
  const changed = desk.edits.done.length > 0
  const folder = `armature/${desk.name}`
  return (
    <div class="stack">
      <BakeChoice
        take={desk.name}
        between={between}
        setBetween={setBetween}
        baking={baking}
        disabled={changed}
        bake={bake}
      />
      {changed && <p class="small">Save the changes as a new take first; then it can be baked.</p>}
      {baked && (
        <p class="small soft" role="status">
          {baked === 'keys' ? (
            <>
              Keypose’s own in-betweens:{' '}
              <span class="mono">
                keypose interpolate $(printf -- '--keys %s ' {folder}/keys/frame_*.ply){' '}
                --timeline {folder}/timeline.json --frames {folder}/frames
              </span>
            </>
          ) : (
            <>
              To take them away:{' '}
              <span class="mono">
                keypose export --frames {folder}/frames --animation {folder}/animation
              </span>
            </>
          )}
        </p>
      )}
    </div>
  )
}
