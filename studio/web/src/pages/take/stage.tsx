// The puppet at the playhead's frame, over its plate, and the frames before it as onion skin.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks'
import type { ComponentChildren } from 'preact'

import { armatureApi } from '../armature/armature_api'
import { PuppetStage } from '../armature/puppet_stage'
import type { PuppetView } from '../armature/puppet_view'
import { plateOf } from '../armature/sitting'
import { useFrame, usePlaying } from '../timeline/desk'
import { recordedAt } from './take_model'
import type { TakeDesk } from './desk'
import type { Opened } from './use_take'

const kMostOnion = 5

export interface Looks {
  free: boolean
  set: boolean
  onion: number
}

function LooksBar(props: { looks: Looks; setLooks: (looks: Looks) => void; hasSet: boolean }) {
  const { looks, setLooks } = props
  const onion = (by: number) =>
    setLooks({ ...looks, onion: Math.max(0, Math.min(kMostOnion, looks.onion + by)) })
  return (
    <div class="take-looks">
      <button
        aria-pressed={looks.free}
        onClick={() => setLooks({ ...looks, free: !looks.free })}
      >
        From the side <kbd>V</kbd>
      </button>
      {props.hasSet && (
        <button aria-pressed={looks.set} onClick={() => setLooks({ ...looks, set: !looks.set })}>
          Set
        </button>
      )}
      <div class="tl-stepper" role="group" aria-label="Onion skin">
        <button
          aria-label="Fewer frames of onion skin"
          disabled={looks.onion === 0}
          onClick={() => onion(-1)}
        >
          −
        </button>
        <span class="number" title="Frames before, as onion skin">
          {looks.onion}
        </span>
        <button
          aria-label="More frames of onion skin"
          disabled={looks.onion === kMostOnion}
          onClick={() => onion(1)}
        >
          +
        </button>
      </div>
    </div>
  )
}

export function TakeStage(props: {
  desk: TakeDesk
  opened: Opened
  looks: Looks
  setLooks: (looks: Looks) => void
  children?: ComponentChildren
}) {
  const { desk, opened, looks } = props
  const { loaded } = opened
  const { take, player } = desk
  const { poses, film: filmed } = opened.edits.draft!
  const puppet = useRef<PuppetView | null>(null)
  const shown = useRef<Float32Array | null>(null)
  const [plate, setPlate] = useState(0)
  const playing = usePlaying(player)
  useFrame(player, (film) => {
    const frame = recordedAt(take, film)
    const pose = take.film > 0 ? filmed[film] : poses[frame]
    if (pose && shown.current !== pose) puppet.current?.setPose(pose)
    shown.current = pose ?? null
    setPlate(plateOf(frame, take.step, loaded.view.plate_count))
  })
  const ghosts = useMemo(
    () => (playing ? [] : poses.slice(Math.max(0, desk.frame - looks.onion), desk.frame)),
    [poses, desk.frame, looks.onion, playing],
  )
  useEffect(() => puppet.current?.setGhosts(ghosts), [ghosts])
  useEffect(() => puppet.current?.setFree(looks.free), [looks.free])
  useEffect(() => puppet.current?.showSet(looks.set), [looks.set])
  return (
    <PuppetStage
      loaded={loaded}
      plate={plate}
      free={looks.free}
      plateUrl={(index) => armatureApi.plateUrl(index, 0, desk.name)}
      puppet={puppet}
    >
      <LooksBar looks={looks} setLooks={props.setLooks} hasSet={opened.hasSet} />
      {props.children}
    </PuppetStage>
  )
}
