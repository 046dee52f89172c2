// A take's frames, made from its curves.
import { useEffect, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { armatureApi, bakedWords } from '../armature/armature_api'
import { BakeChoice } from '../armature/bake_choice'
import type { TakeDesk } from './desk'
import { ProjectUses } from './project_uses'
import type { Between } from './take_model'

export function BakePanel({ desk }: { desk: TakeDesk }) {
  const { follow, tell, complain } = useStudio()
  const { between } = desk.edits
  const [baking, setBaking] = useState(false)
  const [baked, setBaked] = useState('')
  const [bakes, setBakes] = useState(0)
  useEffect(
    () =>
      follow((event) => {
        if (event.type !== 'armature_baked') return
        setBaking(false)
        if (event.exit_code !== 0) return complain(event.message)
        setBaked(between)
        setBakes((old) => old + 1)
        tell(bakedWords(event.message))
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
        setBetween={(chosen) => desk.edits.play(chosen as Between)}
        baking={baking}
        disabled={changed}
        bake={bake}
      />
      {changed && <p class="small">Save the changes as a new take first; then it can be baked.</p>}
      {baked === 'keys' && (
        <p class="small soft" role="status">
          Keypose’s own in-betweens:{' '}
          <span class="mono">
            keypose interpolate $(printf -- '--keys %s ' {folder}/keys/frame_*.ply) --timeline{' '}
            {folder}/timeline.json --frames {folder}/frames --overwrite
          </span>
        </p>
      )}
      <ProjectUses take={desk.name} bakes={bakes} />
    </div>
  )
}
